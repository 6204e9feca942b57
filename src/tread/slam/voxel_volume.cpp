#include "tread/slam/voxel_volume.hpp"

#include <sys/mman.h>

#include <algorithm>
#include <cstring>
#include <new>
#include <tuple>

namespace tread {
namespace {

constexpr std::size_t kBytesOfBlock = sizeof(BlockVoxels);

std::size_t most_blocks(const VolumeOptions& options) {
  return static_cast<std::size_t>(options.memory_mb) * (1U << 20U) / kBytesOfBlock;
}

// Memory that is asked of the system as it is written to.
template <class T>
class Pages {
 public:
  explicit Pages(std::size_t count) : bytes_(count * sizeof(T)) {
    void* memory = mmap(nullptr, bytes_, PROT_READ | PROT_WRITE,
                        MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (memory == MAP_FAILED) throw std::bad_alloc();
    data_ = static_cast<T*>(memory);
  }
  ~Pages() { munmap(data_, bytes_); }
  Pages(const Pages&) = delete;
  Pages& operator=(const Pages&) = delete;
  [[nodiscard]] T* data() const { return data_; }

 private:
  std::size_t bytes_;
  T* data_ = nullptr;
};

}  // namespace

OptionSet describe(VolumeOptions& options) {
  OptionSet set;
  set.add("voxel_m", options.voxel_m, "side of a voxel, m", 0.001, 1.0);
  set.add("window_log2", options.window_log2, "blocks of 8 voxels along a side of the window: 2^n",
          4, 8);
  set.add("memory_mb", options.memory_mb, "voxels at hand, and in the archive, MiB", 16, 4096);
  set.add("archive_on_disk", options.archive_on_disk,
          "what the camera leaves behind is kept in a temporary file, else in memory");
  set.add("shift_m", options.shift_m,
          "the window moves when its middle is off by more, m; 0: by an eighth of the window", 0.0,
          1e3);
  set.add("keep_radius_m", options.keep_radius_m,
          "what is farther away is dropped from the archive, m; 0: nothing is", 0.0, 1e6);
  return set;
}

// Behind the voxels a guard, so that vectors of 32 bits can be loaded at any of them.
struct VoxelVolume::Pool {
  explicit Pool(std::size_t blocks)
      : most(blocks),
        distance(blocks * kBlockVoxels + 16),
        weight(blocks * kBlockVoxels + 16),
        colour(blocks * kBlockVoxels + 16) {}
  std::size_t most;
  Pages<std::int16_t> distance;
  Pages<std::uint8_t> weight;
  Pages<Rgb> colour;
};

VoxelVolume::VoxelVolume(const VolumeOptions& options)
    : options_(options),
      pool_(std::make_unique<Pool>(most_blocks(options))),
      archive_(std::make_unique<BlockArchive>(most_blocks(options), options.archive_on_disk)) {
  const int side = 1 << options.window_log2;
  slots_.assign(std::size_t{1} << (3 * options.window_log2), -1);
  view_.slots = slots_.data();
  view_.log2_side = options.window_log2;
  for (std::int32_t& o : view_.origin) o = -side / 2;
  view_.distance = pool_->distance.data();
  view_.weight = pool_->weight.data();
  view_.colour = pool_->colour.data();
  view_.voxel_m = static_cast<float>(options.voxel_m);
}

VoxelVolume::~VoxelVolume() = default;
VoxelVolume::VoxelVolume(VoxelVolume&&) noexcept = default;
VoxelVolume& VoxelVolume::operator=(VoxelVolume&&) noexcept = default;

void VoxelVolume::clear() {
  std::fill(slots_.begin(), slots_.end(), -1);
  places_.clear();
  used_.clear();
  free_.clear();
  at_hand_ = 0;
  refused_ = 0;
  archive_->clear();
}

std::size_t VoxelVolume::bytes() const {
  return places_.size() * kBytesOfBlock + slots_.size() * sizeof(slots_[0]);
}

BlockPlace VoxelVolume::block_of(const Eigen::Vector3d& position) const {
  const Eigen::Vector3d voxel = position / options_.voxel_m;
  return (voxel / kBlockSide).array().floor().cast<int>();
}

int VoxelVolume::take() {
  if (!free_.empty()) {
    const int index = free_.back();
    free_.pop_back();
    return index;
  }
  if (places_.size() >= pool_->most) return -1;
  places_.push_back(BlockPlace::Zero());
  used_.push_back(0);
  return size() - 1;
}

int VoxelVolume::touch(const BlockPlace& block) {
  const int side = 1 << view_.log2_side;
  for (int i = 0; i < 3; ++i) {
    if (block[i] < view_.origin[i] || block[i] >= view_.origin[i] + side) return -1;
  }
  std::int32_t& slot = slots_[view_.slot_of(block.x(), block.y(), block.z())];
  if (slot >= 0) return slot;
  const int index = take();
  if (index < 0) {
    ++refused_;
    return -1;
  }
  BlockVoxels back;
  if (archive_->size() > 0 && archive_->take(block, back)) {
    load(index, back);
  } else {
    const std::size_t first = VolumeView::voxel_of(index, 0, 0, 0);
    std::fill_n(view_.distance + first, kBlockVoxels, std::int16_t{0});
    std::fill_n(view_.weight + first, kBlockVoxels, std::uint8_t{0});
    std::fill_n(view_.colour + first, kBlockVoxels, Rgb{});
  }
  places_[static_cast<std::size_t>(index)] = block;
  used_[static_cast<std::size_t>(index)] = 1;
  slot = index;
  ++at_hand_;
  return index;
}

void VoxelVolume::load(int index, const BlockVoxels& voxels) {
  const std::size_t first = VolumeView::voxel_of(index, 0, 0, 0);
  std::copy_n(voxels.distance, kBlockVoxels, view_.distance + first);
  std::copy_n(voxels.weight, kBlockVoxels, view_.weight + first);
  std::copy_n(voxels.colour, kBlockVoxels, view_.colour + first);
}

void VoxelVolume::save(int index, BlockVoxels& voxels) const {
  const std::size_t first = VolumeView::voxel_of(index, 0, 0, 0);
  std::copy_n(view_.distance + first, kBlockVoxels, voxels.distance);
  std::copy_n(view_.weight + first, kBlockVoxels, voxels.weight);
  std::copy_n(view_.colour + first, kBlockVoxels, voxels.colour);
}

bool VoxelVolume::centre_on(const Eigen::Vector3d& position) {
  const int side = 1 << view_.log2_side;
  const BlockPlace middle = block_of(position);
  const BlockPlace old(view_.origin[0], view_.origin[1], view_.origin[2]);
  const BlockPlace wanted = middle - BlockPlace::Constant(side / 2);
  const double slack =
      options_.shift_m > 0.0 ? options_.shift_m / (options_.voxel_m * kBlockSide) : side / 8;
  if ((wanted - old).cwiseAbs().maxCoeff() <= slack) return false;
  // What leaves goes while the old window still says where it is.
  for (int index = 0; index < size(); ++index) {
    if (!exists(index)) continue;
    const BlockPlace p = place(index) - wanted;
    if (p.minCoeff() < 0 || p.maxCoeff() >= side) {
      BlockVoxels voxels;
      save(index, voxels);
      archive_->put(place(index), voxels, middle);
      const BlockPlace& at = place(index);
      slots_[view_.slot_of(at.x(), at.y(), at.z())] = -1;
      used_[static_cast<std::size_t>(index)] = 0;
      free_.push_back(index);
      --at_hand_;
    }
  }
  for (int i = 0; i < 3; ++i) view_.origin[i] = wanted[i];
  if (options_.keep_radius_m > 0.0) {
    archive_->drop_beyond(middle, options_.keep_radius_m / (options_.voxel_m * kBlockSide));
  }
  // What was left there once comes back.
  std::vector<BlockPlace> back;
  for (const BlockPlace& p : archive_->places()) {
    const BlockPlace in = p - wanted;
    if (in.minCoeff() >= 0 && in.maxCoeff() < side) back.push_back(p);
  }
  std::sort(back.begin(), back.end(), [](const BlockPlace& a, const BlockPlace& b) {
    return std::tuple(a.z(), a.y(), a.x()) < std::tuple(b.z(), b.y(), b.x());
  });
  for (const BlockPlace& p : back) touch(p);
  return true;
}

std::vector<BlockPlace> VoxelVolume::all_blocks() const {
  std::vector<BlockPlace> all = archive_->places();
  for (int index = 0; index < size(); ++index) {
    if (exists(index)) all.push_back(place(index));
  }
  std::sort(all.begin(), all.end(), [](const BlockPlace& a, const BlockPlace& b) {
    return std::tuple(a.z(), a.y(), a.x()) < std::tuple(b.z(), b.y(), b.x());
  });
  return all;
}

bool VoxelVolume::read(const BlockPlace& block, BlockVoxels& voxels) const {
  const int index = find(block);
  if (index < 0) return archive_->read(block, voxels);
  save(index, voxels);
  return true;
}

}  // namespace tread
