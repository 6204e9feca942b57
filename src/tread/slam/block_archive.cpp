#include "tread/slam/block_archive.hpp"

#include <algorithm>
#include <tuple>

namespace tread {

BlockArchive::BlockArchive(std::size_t most, bool on_disk) : most_(most) {
  if (on_disk) file_.reset(std::tmpfile());
}

void BlockArchive::clear() {
  records_.clear();
  free_.clear();
  memory_.clear();
  next_ = 0;
  dropped_ = 0;
}

bool BlockArchive::write_record(std::size_t record, const BlockVoxels& voxels) {
  if (file_ == nullptr) {
    if (record >= memory_.size()) memory_.resize(record + 1);
    if (memory_[record] == nullptr) memory_[record] = std::make_unique<BlockVoxels>();
    *memory_[record] = voxels;
    return true;
  }
  return fseeko(file_.get(), static_cast<off_t>(record * sizeof(BlockVoxels)), SEEK_SET) == 0 &&
         std::fwrite(&voxels, sizeof(BlockVoxels), 1, file_.get()) == 1;
}

bool BlockArchive::read_record(std::size_t record, BlockVoxels& voxels) const {
  if (file_ == nullptr) {
    voxels = *memory_[record];
    return true;
  }
  return fseeko(file_.get(), static_cast<off_t>(record * sizeof(BlockVoxels)), SEEK_SET) == 0 &&
         std::fread(&voxels, sizeof(BlockVoxels), 1, file_.get()) == 1;
}

// Many at once, since to find them takes a look at all. Of equally far ones those of the lowest
// place.
void BlockArchive::drop_farthest(std::size_t count, const BlockPlace& centre) {
  std::vector<BlockPlace> all = places();
  const auto rank = [&](const BlockPlace& p) {
    const auto away = (p - centre).cast<std::int64_t>().squaredNorm();
    return std::tuple(-away, p.z(), p.y(), p.x());
  };
  std::sort(all.begin(), all.end(),
            [&](const BlockPlace& a, const BlockPlace& b) { return rank(a) < rank(b); });
  all.resize(std::min(all.size(), count));
  for (const BlockPlace& place : all) {
    const auto record = records_.find(place);
    release(record->second);
    records_.erase(record);
    ++dropped_;
  }
}

void BlockArchive::put(const BlockPlace& place, const BlockVoxels& voxels,
                       const BlockPlace& centre) {
  if (most_ == 0) {
    ++dropped_;
    return;
  }
  if (records_.size() >= most_ && !records_.contains(place)) {
    drop_farthest(std::max<std::size_t>(1, most_ / 8), centre);
  }
  std::size_t record = next_;
  if (const auto known = records_.find(place); known != records_.end()) {
    record = known->second;
  } else if (!free_.empty()) {
    record = free_.back();
    free_.pop_back();
  } else {
    ++next_;
  }
  if (write_record(record, voxels)) {
    records_[place] = record;
  } else {
    records_.erase(place);
    release(record);
    ++dropped_;
  }
}

bool BlockArchive::read(const BlockPlace& place, BlockVoxels& voxels) const {
  const auto record = records_.find(place);
  return record != records_.end() && read_record(record->second, voxels);
}

bool BlockArchive::take(const BlockPlace& place, BlockVoxels& voxels) {
  const auto record = records_.find(place);
  if (record == records_.end()) return false;
  const bool good = read_record(record->second, voxels);
  if (!good) ++dropped_;
  release(record->second);
  records_.erase(record);
  return good;
}

void BlockArchive::drop_beyond(const BlockPlace& centre, double blocks) {
  std::vector<std::size_t> gone;
  std::erase_if(records_, [&](const auto& entry) {
    const bool far = (entry.first - centre).template cast<double>().norm() > blocks;
    if (far) gone.push_back(entry.second);
    return far;
  });
  std::sort(gone.begin(), gone.end());  // the order of the table is no order
  for (const std::size_t record : gone) release(record);
}

std::vector<BlockPlace> BlockArchive::places() const {
  std::vector<BlockPlace> all;
  all.reserve(records_.size());
  for (const auto& [place, record] : records_) all.push_back(place);
  return all;
}

}  // namespace tread
