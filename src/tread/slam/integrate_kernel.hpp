// Taking a depth image into voxels, written for one voxel (the definition, and what a GPU runs) and
// vectorised for a block of them.
#pragma once

#include <algorithm>
#include <cmath>

#include "tread/slam/depth_level.hpp"
#include "tread/slam/volume_view.hpp"

namespace tread {

// What integration needs to know of one frame. Voxels are moved into camera axes: p_c = R p + t,
// p in voxels, p_c in metres.
struct IntegrateFrame {
  ImageView<const float> depth;        // metres, NaN where unknown
  ImageView<const Rgb> rgb;            // empty, or of the same size
  ImageView<const std::uint8_t> grey;  // empty, or of the same size, where there is no rgb
  Pinhole camera;
  float R[9];  // row-major, times the side of a voxel
  float t[3];
  float voxel_m = 0.0F;
  float constant_m = 0.0F, quadratic_per_m = 0.0F;  // DepthNoise
  float truncation_m = 0.0F;                        // at least; three sigma where that is more
  float reference_m = 0.0F;  // up to here a measurement counts full_weight, beyond 1 / z^2 of it
  float full_weight = 1.0F;
  float most_weight = 255.0F;
  bool along_ray = false;  // distances along the ray, else along the optical axis
};

// How far behind the surface a measurement at depth d says anything, metres.
inline float truncation_at(const IntegrateFrame& frame, float d) {
  const float three_sigma = 3.0F * (frame.constant_m + frame.quadratic_per_m * d * d);
  return std::min(std::max(frame.truncation_m, three_sigma), kLargestDistance * frame.voxel_m);
}

inline float weight_at(const IntegrateFrame& frame, float d) {
  const float share = frame.reference_m / d;
  return std::max(1.0F, std::round(frame.full_weight * std::min(1.0F, share * share)));
}

// One voxel at p_c (camera axes, metres). Nothing happens where the frame says nothing: outside the
// image, where depth is unknown, and farther behind the surface than the truncation.
//   F <- (F W + w min(sdf, mu)) / (W + w), W <- min(W + w, most)       (Newcombe 2011, Eq. 6 to 13)
inline void integrate_voxel(const IntegrateFrame& frame, const float* p_c, std::int16_t& distance,
                            std::uint8_t& weight) {
  if (!(p_c[2] > 0.0F)) return;
  const float u = std::nearbyint(frame.camera.fx * p_c[0] / p_c[2] + frame.camera.cx);
  const float v = std::nearbyint(frame.camera.fy * p_c[1] / p_c[2] + frame.camera.cy);
  if (!(u >= 0.0F && v >= 0.0F && u < static_cast<float>(frame.depth.width) &&
        v < static_cast<float>(frame.depth.height))) {
    return;
  }
  const float d = frame.depth.row(static_cast<int>(v))[static_cast<int>(u)];
  const float mu = truncation_at(frame, d);
  float sdf = d - p_c[2];
  if (frame.along_ray) {
    const float x = p_c[0] / p_c[2], y = p_c[1] / p_c[2];
    sdf *= std::sqrt(1.0F + x * x + y * y);
  }
  if (!(sdf >= -mu)) return;
  const float scale = kDistanceUnits / frame.voxel_m;
  const float w = weight_at(frame, d), W = weight;
  const float F = (static_cast<float>(distance) * W + std::min(sdf, mu) * scale * w) / (W + w);
  distance = static_cast<std::int16_t>(std::nearbyint(F));
  weight = static_cast<std::uint8_t>(std::min(W + w, frame.most_weight));
}

// All voxels of a block, which begins at voxel (x, y, z); with colour, also that of those within a
// voxel and a half, or three sigma, of the surface. Arrays begin on 64-byte boundaries.
void integrate_block(const IntegrateFrame& frame, int x, int y, int z, std::int16_t* distance,
                     std::uint8_t* weight, Rgb* colour);

}  // namespace tread
