// The voxels of a VoxelVolume as plain pointers: all that integration, ray casting and meshing need
// to know of it, on a processor or, copied there, on a GPU.
#pragma once

#include <cmath>
#include <cstdint>

#include "tread/core/image.hpp"

namespace tread {

// Space is cut into voxels of `voxel_m`; voxel (i, j, k) stands for the point (i, j, k) * voxel_m.
// Blocks of 8 x 8 x 8 of them exist only near surfaces. Of all blocks, those in a cube of 2^n each
// way can be looked up, by their coordinates modulo 2^n: the window, which moves with the camera.
inline constexpr int kBlockSide = 8;
inline constexpr int kBlockVoxels = kBlockSide * kBlockSide * kBlockSide;
// Distances are stored in this part of a voxel.
inline constexpr int kDistanceUnits = 1024;
// The largest distance that is stored, voxels.
inline constexpr float kLargestDistance = 31.0F;

struct VolumeView {
  const std::int32_t* slots = nullptr;  // of the window: index of a block, -1 if there is none
  int log2_side = 0;
  std::int32_t origin[3] = {0, 0, 0};  // the lowest block of the window
  std::int16_t* distance = nullptr;    // by block index, then z, y, x
  std::uint8_t* weight = nullptr;
  Rgb* colour = nullptr;
  float voxel_m = 0.0F;

  // Index of the block, -1 if it does not exist or lies outside the window.
  [[nodiscard]] std::int32_t block_at(int x, int y, int z) const {
    const auto side = 1U << log2_side;
    if (static_cast<std::uint32_t>(x - origin[0]) >= side ||
        static_cast<std::uint32_t>(y - origin[1]) >= side ||
        static_cast<std::uint32_t>(z - origin[2]) >= side) {
      return -1;
    }
    return slots[slot_of(x, y, z)];
  }
  [[nodiscard]] std::size_t slot_of(int x, int y, int z) const {
    const auto mask = (1U << log2_side) - 1U;
    const auto wrapped = [mask](int i) { return static_cast<std::size_t>(i) & mask; };
    return (wrapped(z) << log2_side | wrapped(y)) << log2_side | wrapped(x);
  }
  // Where voxel (x, y, z) of the block is among all voxels.
  [[nodiscard]] static std::size_t voxel_of(std::int32_t block, int x, int y, int z) {
    return static_cast<std::size_t>(block) * kBlockVoxels +
           static_cast<std::size_t>((z * kBlockSide + y) * kBlockSide + x);
  }
};

}  // namespace tread
