// A truncated signed distance field in sparse blocks (Curless and Levoy 1996; Niessner et al.
// 2013): memory goes with the surface, not with the space. The blocks around the camera are at
// hand; those that it leaves behind go to an archive and come back unchanged when it returns.
//
//   VoxelVolume volume({.voxel_m = 0.01});
//   volume.centre_on(camera_position);
//   const int block = volume.touch({3, -1, 12});   // its index; made if there is none
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "tread/core/options.hpp"
#include "tread/slam/block_archive.hpp"
#include "tread/slam/volume_view.hpp"

namespace tread {

struct VolumeOptions {
  double voxel_m = 0.01;
  int window_log2 = 7;          // the window is 2^n blocks each way: 10.24 m at 10 mm and n = 7
  int memory_mb = 1024;         // of the blocks at hand; as much again for the archive
  bool archive_on_disk = true;  // in an unnamed file for temporary data; else in memory
  double shift_m = 0.0;  // the window moves when its middle is off by more; 0: by an eighth of it
  double keep_radius_m = 0.0;  // archived blocks farther away than this are dropped; 0: none is
  [[nodiscard]] bool operator==(const VolumeOptions&) const = default;
};
[[nodiscard]] OptionSet describe(VolumeOptions& options);

class VoxelVolume {
 public:
  explicit VoxelVolume(const VolumeOptions& options = {});
  ~VoxelVolume();
  VoxelVolume(VoxelVolume&&) noexcept;
  VoxelVolume& operator=(VoxelVolume&&) noexcept;
  VoxelVolume(const VoxelVolume&) = delete;
  VoxelVolume& operator=(const VoxelVolume&) = delete;

  // Empties it.
  void clear();
  // Moves the window so that `position` (metres) lies in its middle, if it is more than an eighth
  // of the window away from there. Whether it moved.
  bool centre_on(const Eigen::Vector3d& position);

  // Index of the block, -1 if there is none at hand: none outside the window is.
  [[nodiscard]] int find(const BlockPlace& block) const {
    return view_.block_at(block.x(), block.y(), block.z());
  }
  // The same; a block that is not there is made, its voxels of weight 0. -1 outside the window and
  // where the memory allowed is used up (see refused()).
  int touch(const BlockPlace& block);
  [[nodiscard]] BlockPlace block_of(const Eigen::Vector3d& position) const;

  // Indices are below size(); those in between that are not used do not exist.
  [[nodiscard]] int size() const { return static_cast<int>(places_.size()); }
  [[nodiscard]] bool exists(int index) const { return used_[static_cast<std::size_t>(index)] != 0; }
  [[nodiscard]] const BlockPlace& place(int index) const {
    return places_[static_cast<std::size_t>(index)];
  }
  [[nodiscard]] int at_hand() const { return at_hand_; }
  [[nodiscard]] std::size_t archived() const { return archive_->size(); }
  // Blocks that were not made, and such that the archive dropped, for lack of memory.
  [[nodiscard]] std::int64_t refused() const { return refused_; }
  [[nodiscard]] std::int64_t dropped() const { return archive_->dropped(); }
  // Of the voxels at hand; memory, not disk.
  [[nodiscard]] std::size_t bytes() const;
  [[nodiscard]] const VolumeOptions& options() const { return options_; }
  [[nodiscard]] const VolumeView& view() const { return view_; }

  // All blocks, at hand and archived, by z, then y, then x.
  [[nodiscard]] std::vector<BlockPlace> all_blocks() const;
  // The voxels of a block, wherever it is; false if there is none.
  [[nodiscard]] bool read(const BlockPlace& block, BlockVoxels& voxels) const;

 private:
  // Arrays of fixed size that never move: pages that are not used cost nothing.
  struct Pool;

  int take();
  void load(int index, const BlockVoxels& voxels);
  void save(int index, BlockVoxels& voxels) const;

  VolumeOptions options_;
  std::unique_ptr<Pool> pool_;
  std::unique_ptr<BlockArchive> archive_;
  VolumeView view_;
  std::vector<std::int32_t> slots_;
  std::vector<BlockPlace> places_;
  std::vector<std::uint8_t> used_;
  std::vector<int> free_;
  int at_hand_ = 0;
  std::int64_t refused_ = 0;
};

}  // namespace tread
