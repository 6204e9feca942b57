// One ray against the volume: what runs for each pixel, on a processor or a GPU.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "tread/slam/volume_view.hpp"

namespace tread {

// Distance to the surface at p, in voxels, p in voxels from the first one of the window: trilinear
// between the eight voxels around it; NaN if one of those has never been seen.
inline float sample_distance(const VolumeView& volume, const float* p) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const auto side = static_cast<float>(kBlockSide << volume.log2_side);
  if (!(p[0] >= 0.0F && p[1] >= 0.0F && p[2] >= 0.0F && p[0] < side - 1.0F && p[1] < side - 1.0F &&
        p[2] < side - 1.0F)) {
    return kNan;
  }
  const int x = static_cast<int>(p[0]), y = static_cast<int>(p[1]), z = static_cast<int>(p[2]);
  const float u = p[0] - static_cast<float>(x), v = p[1] - static_cast<float>(y),
              w = p[2] - static_cast<float>(z);
  const int lx = x % kBlockSide, ly = y % kBlockSide, lz = z % kBlockSide;
  const int bx = volume.origin[0] + x / kBlockSide, by = volume.origin[1] + y / kBlockSide,
            bz = volume.origin[2] + z / kBlockSide;
  float corner[8];
  if (lx < kBlockSide - 1 && ly < kBlockSide - 1 && lz < kBlockSide - 1) {
    const std::int32_t block = volume.slots[volume.slot_of(bx, by, bz)];
    if (block < 0) return kNan;
    const std::size_t at = VolumeView::voxel_of(block, lx, ly, lz);
    const std::int16_t* d = volume.distance + at;
    const std::uint8_t* s = volume.weight + at;
    constexpr int kRow = kBlockSide, kLayer = kBlockSide * kBlockSide;
    if (s[0] == 0 || s[1] == 0 || s[kRow] == 0 || s[kRow + 1] == 0 || s[kLayer] == 0 ||
        s[kLayer + 1] == 0 || s[kLayer + kRow] == 0 || s[kLayer + kRow + 1] == 0) {
      return kNan;
    }
    corner[0] = d[0];
    corner[1] = d[1];
    corner[2] = d[kRow];
    corner[3] = d[kRow + 1];
    corner[4] = d[kLayer];
    corner[5] = d[kLayer + 1];
    corner[6] = d[kLayer + kRow];
    corner[7] = d[kLayer + kRow + 1];
  } else {
    for (int i = 0; i < 8; ++i) {
      const int cx = lx + (i & 1), cy = ly + (i >> 1 & 1), cz = lz + (i >> 2);
      const std::int32_t block = volume.slots[volume.slot_of(
          bx + cx / kBlockSide, by + cy / kBlockSide, bz + cz / kBlockSide)];
      if (block < 0) return kNan;
      const std::size_t at =
          VolumeView::voxel_of(block, cx % kBlockSide, cy % kBlockSide, cz % kBlockSide);
      if (volume.weight[at] == 0) return kNan;
      corner[i] = volume.distance[at];
    }
  }
  const auto mix = [](float a, float b, float f) { return a + (b - a) * f; };
  const float near = mix(mix(corner[0], corner[1], u), mix(corner[2], corner[3], u), v);
  const float far = mix(mix(corner[4], corner[5], u), mix(corner[6], corner[7], u), v);
  return mix(near, far, w) * (1.0F / kDistanceUnits);
}

// A ray in the volume: the point at depth z is origin + z * direction, in voxels from the first one
// of the window.
struct Ray {
  float origin[3];
  float direction[3];
};

// Depth at which the ray meets the surface from its front, near `seed` (no farther than `band`),
// NaN if it does not. The first guess is the seed; distances tell where to look next, two samples
// on both sides of the surface bracket it.
inline float cast_ray(const VolumeView& volume, const Ray& ray, float seed, float band) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr int kSteps = 6;
  constexpr float kNear = 0.01F;  // voxels
  const auto sample = [&](float z) {
    const float p[3] = {ray.origin[0] + z * ray.direction[0], ray.origin[1] + z * ray.direction[1],
                        ray.origin[2] + z * ray.direction[2]};
    return sample_distance(volume, p);
  };
  float z = seed, s = sample(z);
  if (!(s == s)) {  // nothing known there: from the front, voxel by voxel
    const float step = volume.voxel_m;
    float before = kNan;
    for (z = seed - band; z <= seed + band; z += step) {
      s = sample(z);
      if (before > 0.0F && s <= 0.0F) return z - step * s / (s - before);
      before = s;
    }
    return kNan;
  }
  // On the surface already, another sample still has to say from which side.
  float step = (std::abs(s) < 0.1F ? 0.5F : s) * volume.voxel_m;
  for (int i = 0; i < kSteps; ++i) {
    const float next_z = z + step, next = sample(next_z);
    if (!(next == next) || std::abs(next_z - seed) > band) return kNan;
    const float slope = (next - s) / (next_z - z);  // voxels a metre
    if (std::abs(next) < kNear) return slope < 0.0F ? next_z - next / slope : kNan;
    if ((next > 0.0F) != (s > 0.0F)) {
      if (slope >= 0.0F) return kNan;  // from behind
      const float between = next_z - next / slope;
      const float last = sample(between);
      if (!(last == last)) return between;
      // Once more, with whichever of both ends is on the other side.
      const bool with_next = (last > 0.0F) != (next > 0.0F);
      const float end_z = with_next ? next_z : z, end = with_next ? next : s;
      return between - last * (end_z - between) / (end - last);
    }
    z = next_z;
    s = next;
    step = slope < 0.0F ? std::clamp(-s / slope, -4.0F * volume.voxel_m, 4.0F * volume.voxel_m)
                        : s * volume.voxel_m;
  }
  return kNan;
}

// The rays of one row of pixels: of pixel x, direction = first + x * step.
struct RayRow {
  float origin[3];
  float first[3];
  float step[3];
};
// cast_ray for all pixels of a row that have a seed, NaN for the others. Vectorised; differs from
// cast_ray by rounding, and where that decides.
void cast_row(const VolumeView& volume, const RayRow& rays, const float* seeds, int width,
              float band, float* out);

}  // namespace tread
