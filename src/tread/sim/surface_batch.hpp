// The rays of a piece of an image and what they met, each value in a row of its own, as loops over
// many points want it.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

namespace tread {

// Many rays of a camera, those of sixteen in a row close together. World axes, metres.
struct RayBatch {
  static constexpr int kMost = 256;
  int count = 0;                                               // a multiple of 16
  std::array<std::array<double, kMost>, 3> origin, direction;  // unit length
  std::array<float, kMost> spread_rad;  // between it and its neighbours; NaN: no ray
};

// What these rays met, as far as looks need it.
struct SurfaceBatch {
  template <class T>
  using Row = std::array<T, RayBatch::kMost>;
  int count = 0;
  alignas(64) Row<double> distance_m;          // NaN: nothing was met
  alignas(64) Row<std::int32_t> material;      // Scene::materials(); -1: nothing was met
  alignas(64) Row<float> u, v, w;              // place on the thing, metres: texture.hpp
  alignas(64) Row<float> sun_u, sun_v, sun_w;  // towards the sun, in the same axes
  alignas(64) Row<float> footprint_m;          // side of a square as large as the pixel there
  alignas(64) Row<float> normal_x, normal_y, normal_z;  // unit; smoothed on the ground
  alignas(64) std::array<Row<float>, 3> from;           // where a ray to the sun starts, scene axes
  alignas(64) Row<float> clear_m;                       // how far it goes before it may be blocked
  alignas(64) Row<float> through;  // share of the sun behind it that shines through
};

}  // namespace tread
