// Where blocks of voxels wait until the camera comes back: a file for temporary data, or memory.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <unordered_map>
#include <vector>

#include "tread/slam/volume_view.hpp"

namespace tread {

using BlockPlace = Eigen::Vector3i;  // coordinates of a block, in blocks

struct BlockVoxels {
  std::int16_t distance[kBlockVoxels];
  std::uint8_t weight[kBlockVoxels];
  Rgb colour[kBlockVoxels];
  [[nodiscard]] bool operator==(const BlockVoxels&) const = default;
};

struct BlockPlaceHash {
  std::size_t operator()(const BlockPlace& b) const {
    const auto mix = [](int v, std::uint64_t by) { return static_cast<std::uint64_t>(v) * by; };
    return mix(b.x(), 0x9E3779B97F4A7C15U) ^ mix(b.y(), 0xC2B2AE3D27D4EB4FU) ^
           mix(b.z(), 0x165667B19E3779F9U);
  }
};

class BlockArchive {
 public:
  // Holds at most `most` blocks. With on_disk they lie in an unnamed temporary file; where none can
  // be had or written, in memory.
  BlockArchive(std::size_t most, bool on_disk);

  // Keeps a block. When all places are taken, the eighth farthest from `centre` is dropped for it.
  void put(const BlockPlace& place, const BlockVoxels& voxels, const BlockPlace& centre);
  // Hands a block out and forgets it; false if it is not here, or cannot be read back (dropped).
  [[nodiscard]] bool take(const BlockPlace& place, BlockVoxels& voxels);
  [[nodiscard]] bool read(const BlockPlace& place, BlockVoxels& voxels) const;
  void drop_beyond(const BlockPlace& centre, double blocks);
  void clear();

  [[nodiscard]] std::size_t size() const { return records_.size(); }
  [[nodiscard]] bool on_disk() const { return file_ != nullptr; }
  // Blocks lost for want of room or by a disk that failed.
  [[nodiscard]] std::int64_t dropped() const { return dropped_; }
  [[nodiscard]] std::vector<BlockPlace> places() const;

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  [[nodiscard]] bool write_record(std::size_t record, const BlockVoxels& voxels);
  [[nodiscard]] bool read_record(std::size_t record, BlockVoxels& voxels) const;
  void drop_farthest(std::size_t count, const BlockPlace& centre);
  void release(std::size_t record) { free_.push_back(record); }

  std::size_t most_;
  std::unique_ptr<std::FILE, Close> file_;
  std::vector<std::unique_ptr<BlockVoxels>> memory_;
  std::unordered_map<BlockPlace, std::size_t, BlockPlaceHash> records_;
  std::vector<std::size_t> free_;
  std::size_t next_ = 0;
  std::int64_t dropped_ = 0;
};

}  // namespace tread
