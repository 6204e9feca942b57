// How surfaces look close by: what the texture of a Material makes of its mean albedo at a place,
// seen through a pixel of a certain size. Sums of hashed noise (hash_noise_kernel.hpp) from a metre
// down to 2 mm with about as much contrast in every octave (a spectrum like 1/f, as natural
// surfaces have), and what is particular to each: stones, ripples, blades, boards. Octaves finer
// than two pixels are faded out before they would shimmer: what is left is the same from near and
// far and in both eyes of a stereo pair.
//
// Axes of a texture are u, v, w, metres on the thing itself: solids carry theirs with them.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "tread/sim/surface.hpp"

namespace tread {

// Where a point of a thing lies in its texture.
struct TexturePlace {
  Eigen::Vector3d place;  // u, v, w
  Eigen::Vector3d sun;    // towards the sun in the same axes
};

// Flat textures (stones, ripples, blades, boards) lie on the side that the normal is nearest to,
// boards along the longest of the `sides`; the others fill space. All in the axes of the thing.
[[nodiscard]] TexturePlace texture_place(Surface surface, const Eigen::Vector3d& sides_m,
                                         const Eigen::Vector3d& point,
                                         const Eigen::Vector3d& normal, const Eigen::Vector3d& sun);

// Points of one material, each value in one row; rows of a whole number of sixteens.
struct TextureRows {
  int count = 0;
  const float* u = nullptr;
  const float* v = nullptr;
  const float* w = nullptr;
  const float* sun_u = nullptr;
  const float* sun_v = nullptr;
  const float* sun_w = nullptr;
  const float* footprint_m = nullptr;
  float* value = nullptr;   // out: albedo / mean albedo, above 0
  float* hue = nullptr;     // out: -1 to 1: share of tint_of(surface)
  float* relief = nullptr;  // out: light of the sun / that on a smooth surface, 0 to 2
};
void texture(Surface surface, float contrast, std::uint32_t seed, const TextureRows& rows);

// What hue 1 adds to the albedo, as a share of it: red, green, blue.
[[nodiscard]] Eigen::Vector3f tint_of(Surface surface);

// The albedo of one place: for tests and pictures.
[[nodiscard]] Eigen::Vector3f albedo_at(const Material& material, const Eigen::Vector3d& place,
                                        double footprint_m);

}  // namespace tread
