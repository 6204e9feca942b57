// Rays against triangles, quadrilaterals and exact round shapes: the part of a scene that Embree 3
// does, and all that knows of Embree. Single precision: what was hit is certain, how far away it
// is only to about 1e-6 of the size of the scene; scene.hpp works that out anew.
//
// Two layers: what stands still is built once (0.3 s of CPU for a million triangles), what moves
// is built anew each time, in microseconds. Embree builds with the threads of oneTBB; to limit them
// for one device would limit them for the whole program. Rays may be cast by many threads at once.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "tread/core/result.hpp"

namespace tread {

// An upright cylinder or an ellipsoid in its own axes.
struct RoundShape {
  bool cylinder = false;
  Eigen::Matrix3d R_scene_shape = Eigen::Matrix3d::Identity();
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  // in the scene
  Eigen::Vector3d half_m = Eigen::Vector3d::Ones();
};

struct RoundHit {
  double distance = 0.0;   // in lengths of the direction
  Eigen::Vector3d normal;  // outwards, unit length, axes of the scene
};
// Where a ray first goes through the surface beyond `nearest`, from outside or from inside.
[[nodiscard]] std::optional<RoundHit> intersect(const RoundShape& shape,
                                                const Eigen::Vector3d& origin,
                                                const Eigen::Vector3d& direction, double nearest);

// Sixteen rays that go about the same way, each value in one row.
struct RayBlock {
  static constexpr int kRays = 16;
  template <class T>
  using Row = std::array<T, kRays>;
  alignas(64) Row<float> origin[3];
  alignas(64) Row<float> direction[3];
  alignas(64) Row<float> nearest;
  alignas(64) Row<float> distance;      // in: how far to look; out: of the hit, if there is one
  alignas(64) Row<std::int32_t> on;     // -1: cast, 0: not
  alignas(64) Row<std::uint32_t> id;    // out: of what was hit, or kMissed
  alignas(64) Row<std::uint32_t> part;  // out: which of its triangles, quadrilaterals, shapes
  static constexpr std::uint32_t kMissed = 0xFFFFFFFFU;
};

class RayTracer {
 public:
  enum Layer { kStill, kMoving };
  using Vertices = std::vector<Eigen::Vector3f>;

  RayTracer();
  ~RayTracer();
  RayTracer(RayTracer&&) noexcept;
  RayTracer& operator=(RayTracer&&) noexcept;
  RayTracer(const RayTracer&) = delete;
  RayTracer& operator=(const RayTracer&) = delete;

  // Adds shapes under an id that no other has, in either layer. A ray meets them if its mask and
  // theirs have a bit in common. Quadrilaterals a b c d are cut from b to d. Nothing for no shapes.
  void add_quads(Layer layer, std::uint32_t id, std::uint32_t mask, const Vertices& vertices,
                 const std::vector<std::array<std::uint32_t, 4>>& quads);
  void add_triangles(Layer layer, std::uint32_t id, std::uint32_t mask, const Vertices& vertices,
                     const std::vector<std::array<std::uint32_t, 3>>& triangles);
  void add_rounds(Layer layer, std::uint32_t id, std::uint32_t mask,
                  std::vector<RoundShape> shapes);
  // Makes the layer ready for rays. An error if there is not enough memory for it.
  [[nodiscard]] Status commit(Layer layer);
  // Takes all shapes out of a layer.
  void clear(Layer layer);

  // The nearest hit of each ray.
  void cast(RayBlock& rays, std::uint32_t mask) const;
  // Whether anything is in the way of each ray: `id` is then anything but kMissed.
  void test(RayBlock& rays, std::uint32_t mask) const;

 private:
  struct Embree;
  std::unique_ptr<Embree> embree_;
};

}  // namespace tread
