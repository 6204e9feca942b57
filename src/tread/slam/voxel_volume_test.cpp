#include "tread/slam/voxel_volume.hpp"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <tuple>

namespace tread {
namespace {

// Writes random voxels into the block.
void scribble(VoxelVolume& volume, int index, std::mt19937& random) {
  const VolumeView& view = volume.view();
  const std::size_t first = VolumeView::voxel_of(index, 0, 0, 0);
  for (std::size_t i = first; i < first + kBlockVoxels; ++i) {
    view.distance[i] = static_cast<std::int16_t>(random());
    view.weight[i] = static_cast<std::uint8_t>(random());
    view.colour[i] = {static_cast<std::uint8_t>(random()), static_cast<std::uint8_t>(random()), 7};
  }
}

using Places = std::map<std::tuple<int, int, int>, BlockVoxels>;

Places contents(const VoxelVolume& volume) {
  Places all;
  for (const BlockPlace& place : volume.all_blocks()) {
    BlockVoxels voxels;
    EXPECT_TRUE(volume.read(place, voxels));
    all[{place.x(), place.y(), place.z()}] = voxels;
  }
  return all;
}

TEST(VoxelVolume, BlocksAreMadeOnceAndFoundAgain) {
  VoxelVolume volume({.voxel_m = 0.02, .window_log2 = 4, .memory_mb = 16});
  EXPECT_EQ(volume.find({1, -2, 3}), -1);
  const int index = volume.touch({1, -2, 3});
  ASSERT_GE(index, 0);
  EXPECT_EQ(volume.touch({1, -2, 3}), index);
  EXPECT_EQ(volume.find({1, -2, 3}), index);
  EXPECT_EQ(volume.at_hand(), 1);
  EXPECT_EQ(volume.view().weight[VolumeView::voxel_of(index, 3, 4, 5)], 0);
  EXPECT_EQ(volume.touch({8, 0, 0}), -1) << "outside the window of -8 to 7";
  EXPECT_EQ(volume.find({17, -2, 3}), -1) << "the same slot, another place";
}

TEST(VoxelVolume, BlockOfAPosition) {
  const VoxelVolume volume({.voxel_m = 0.01});
  EXPECT_EQ(volume.block_of({0.0, 0.079, -0.001}), BlockPlace(0, 0, -1));
  EXPECT_EQ(volume.block_of({0.081, -0.081, 0.16}), BlockPlace(1, -2, 2));
}

// The shift test of KinFu large scale: 200 voxels out and back, each way, and every stored value is
// as it was. On disk and in memory.
TEST(VoxelVolume, WhatIsLeftBehindComesBackUnchanged) {
  for (const bool on_disk : {true, false}) {
    VoxelVolume volume(
        {.voxel_m = 0.01, .window_log2 = 4, .memory_mb = 16, .archive_on_disk = on_disk});
    std::mt19937 random(5);
    for (int i = 0; i < 300; ++i) {
      const auto coordinate = [&] { return static_cast<int>(random() % 16) - 8; };
      const int index = volume.touch({coordinate(), coordinate(), coordinate()});
      ASSERT_GE(index, 0);
      scribble(volume, index, random);
    }
    const Places before = contents(volume);
    const int at_hand = volume.at_hand();
    for (const Eigen::Vector3d& way : {Eigen::Vector3d(2.0, 0, 0), Eigen::Vector3d(0, -2.0, 0),
                                       Eigen::Vector3d(1.3, 2.0, -2.0)}) {
      for (int step = 0; step <= 10; ++step) volume.centre_on(way * step / 10.0);
      EXPECT_EQ(volume.at_hand(), 0);
      EXPECT_EQ(volume.archived(), before.size());
      EXPECT_EQ(contents(volume), before);
      for (int step = 10; step >= 0; --step) volume.centre_on(way * step / 10.0);
      // The window has some slack: blocks at its border may still be away, but none is changed.
      EXPECT_GE(volume.at_hand(), at_hand / 2);
      EXPECT_EQ(contents(volume), before);
    }
    EXPECT_EQ(volume.dropped(), 0);
  }
}

TEST(VoxelVolume, MemoryIsBoundedAndWhatIsDroppedIsCounted) {
  VoxelVolume volume({.voxel_m = 0.01, .window_log2 = 5, .memory_mb = 16});
  const auto most = 16 * (1 << 20) / static_cast<int>(sizeof(BlockVoxels));
  int made = 0;
  for (int z = -16; z < 16; ++z) {
    for (int y = -16; y < 16; ++y) {
      for (int x = -16; x < 16; ++x) made += volume.touch({x, y, z}) >= 0 ? 1 : 0;
    }
  }
  EXPECT_EQ(made, most);
  EXPECT_EQ(volume.refused(), 32 * 32 * 32 - most);
  EXPECT_LE(volume.bytes(), (16U << 20U) + (1U << 17U) + sizeof(BlockVoxels));
}

TEST(VoxelVolume, ALoopDrivenTenTimesTakesNoMoreMemory) {
  VoxelVolume volume({.voxel_m = 0.05, .window_log2 = 4, .memory_mb = 16});
  std::size_t bytes = 0, archived = 0;
  for (int lap = 0; lap < 10; ++lap) {
    for (int i = 0; i < 40; ++i) {
      const Eigen::Vector3d at(8.0 * std::cos(i * 0.157), 8.0 * std::sin(i * 0.157), 0.0);
      volume.centre_on(at);
      const BlockPlace middle = volume.block_of(at);
      for (int k = -3; k <= 3; ++k) volume.touch(middle + BlockPlace(k, k / 2, 0));
    }
    if (lap == 1) {
      bytes = volume.bytes();
      archived = volume.archived();
    }
  }
  EXPECT_EQ(volume.bytes(), bytes);
  EXPECT_EQ(volume.archived(), archived);
}

TEST(VoxelVolume, WhatIsFarIsDroppedByRadius) {
  VoxelVolume volume({.voxel_m = 0.1, .window_log2 = 4, .memory_mb = 16, .keep_radius_m = 20.0});
  ASSERT_GE(volume.touch({0, 0, 0}), 0);
  volume.centre_on({15.0, 0, 0});
  EXPECT_EQ(volume.archived(), 1U);
  volume.centre_on({40.0, 0, 0});
  EXPECT_EQ(volume.archived(), 0U);
}

TEST(BlockArchive, DropsTheFarthestWhenFull) {
  BlockArchive archive(2, false);
  BlockVoxels voxels{};
  archive.put({0, 0, 0}, voxels, {0, 0, 0});
  archive.put({9, 0, 0}, voxels, {0, 0, 0});
  archive.put({1, 0, 0}, voxels, {0, 0, 0});
  EXPECT_EQ(archive.size(), 2U);
  EXPECT_EQ(archive.dropped(), 1);
  EXPECT_FALSE(archive.read({9, 0, 0}, voxels));
  EXPECT_TRUE(archive.take({1, 0, 0}, voxels));
  EXPECT_FALSE(archive.take({1, 0, 0}, voxels));
}

}  // namespace
}  // namespace tread
