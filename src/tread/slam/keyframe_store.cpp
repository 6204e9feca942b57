#include "tread/slam/keyframe_store.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace tread {
namespace {

constexpr double kStep = 0.25;    // of a standard deviation
constexpr int kMostCode = 65535;  // 0: unknown
constexpr int kQuality = 90;      // of JPEG

// Differences of either sign as numbers from zero on, seven bits a byte, the lowest first.
void put_number(int difference, std::vector<std::uint8_t>& bytes) {
  auto n = static_cast<std::uint32_t>(difference < 0 ? -2 * difference - 1 : 2 * difference);
  for (; n >= 128; n >>= 7) bytes.push_back(static_cast<std::uint8_t>(n | 128U));
  bytes.push_back(static_cast<std::uint8_t>(n));
}
bool take_number(std::span<const std::uint8_t>& bytes, int& difference) {
  std::uint32_t n = 0;
  for (int shift = 0; shift < 28; shift += 7) {
    if (bytes.empty()) return false;
    const std::uint8_t byte = bytes.front();
    bytes = bytes.subspan(1);
    n |= static_cast<std::uint32_t>(byte & 127U) << shift;
    if (byte < 128) {
      difference = static_cast<int>(n >> 1) ^ -static_cast<int>(n & 1U);
      return true;
    }
  }
  return false;
}

bool encode_picture(ImageView<const Rgb> rgb, ImageView<const std::uint8_t> grey,
                    std::vector<std::uint8_t>& bytes) {
  if (rgb.empty() && grey.empty()) return true;
  try {
    cv::Mat picture;
    // OpenCV has no view of constant pixels; it only reads these.
    if (rgb.empty()) {
      picture = cv::Mat(grey.height, grey.width, CV_8UC1, const_cast<std::uint8_t*>(grey.data),
                        static_cast<std::size_t>(grey.stride));
    } else {
      const cv::Mat wrapped(rgb.height, rgb.width, CV_8UC3, const_cast<Rgb*>(rgb.data),
                            static_cast<std::size_t>(rgb.stride) * sizeof(Rgb));
      cv::cvtColor(wrapped, picture, cv::COLOR_RGB2BGR);
    }
    std::vector<std::uint8_t> jpeg;
    if (!cv::imencode(".jpg", picture, jpeg, {cv::IMWRITE_JPEG_QUALITY, kQuality})) return false;
    bytes.insert(bytes.end(), jpeg.begin(), jpeg.end());
    return true;
  } catch (const cv::Exception&) {
    return false;
  }
}

bool decode_picture(std::span<const std::uint8_t> bytes, bool coloured, int width, int height,
                    StoredKeyframe& keyframe) {
  keyframe.rgb.resize(0, 0);
  keyframe.grey.resize(0, 0);
  if (bytes.empty()) return true;
  try {
    const cv::Mat jpeg(1, static_cast<int>(bytes.size()), CV_8UC1,
                       const_cast<std::uint8_t*>(bytes.data()));
    cv::Mat picture = cv::imdecode(jpeg, coloured ? cv::IMREAD_COLOR : cv::IMREAD_GRAYSCALE);
    if (picture.cols != width || picture.rows != height) return false;
    if (!coloured) {
      keyframe.grey.resize(width, height);
      for (int y = 0; y < height; ++y) {
        std::copy_n(picture.ptr<std::uint8_t>(y), width, keyframe.grey.row(y));
      }
      return true;
    }
    keyframe.rgb.resize(width, height);
    for (int y = 0; y < height; ++y) {
      const cv::Vec3b* from = picture.ptr<cv::Vec3b>(y);
      Rgb* to = keyframe.rgb.row(y);
      for (int x = 0; x < width; ++x) to[x] = {from[x][2], from[x][1], from[x][0]};
    }
    return true;
  } catch (const cv::Exception&) {
    return false;
  }
}

}  // namespace

KeyframeStore::KeyframeStore(const DepthNoise& noise, double farthest_m, std::size_t memory_bytes,
                             std::size_t file_bytes)
    : most_memory_pages_(memory_bytes / kPageBytes), most_file_pages_(file_bytes / kPageBytes) {
  // Depth in standard deviations: the integral of dz / (c + q z^2).
  const double c = noise.constant_m, q = noise.quadratic_per_m;
  root_ = q > 0.0 ? std::sqrt(q / c) : 0.0;
  const double whole = q > 0.0 ? std::atan(root_ * farthest_m) : farthest_m;
  const double sigmas = q > 0.0 ? whole / std::sqrt(q * c) : farthest_m / c;
  const int codes = static_cast<int>(std::min<double>(std::ceil(sigmas / kStep), kMostCode - 1));
  scale_ = codes / whole;
  depth_of_code_.push_back(std::numeric_limits<float>::quiet_NaN());
  for (int code = 0; code <= codes; ++code) {
    const double at = code / scale_;
    depth_of_code_.push_back(static_cast<float>(root_ > 0.0 ? std::tan(at) / root_ : at));
  }
  if (most_file_pages_ > 0) file_.reset(std::tmpfile());
  if (file_ == nullptr) most_file_pages_ = 0;
}

void KeyframeStore::clear() {
  records_.clear();
  free_.clear();
  memory_.clear();
  file_pages_ = 0;
}

void KeyframeStore::encode_depth(ImageView<const float> depth,
                                 std::vector<std::uint8_t>& bytes) const {
  const float farthest = depth_of_code_.back();
  int before = 0;
  for (int y = 0; y < depth.height; ++y) {
    const float* row = depth.row(y);
    for (int x = 0; x < depth.width; ++x) {
      int code = 0;
      if (const float z = row[x]; z > 0.0F && z <= farthest) {
        code = 1 + static_cast<int>(std::lround(scale_ * (root_ > 0.0 ? std::atan(root_ * z) : z)));
      }
      put_number(code - before, bytes);
      before = code;
    }
  }
}

bool KeyframeStore::decode_depth(std::span<const std::uint8_t> bytes, Image<float>& depth) const {
  int code = 0;
  for (int y = 0; y < depth.height; ++y) {
    float* row = depth.row(y);
    for (int x = 0; x < depth.width; ++x) {
      int difference = 0;
      if (!take_number(bytes, difference)) return false;
      code += difference;
      if (code < 0 || code >= static_cast<int>(depth_of_code_.size())) return false;
      row[x] = depth_of_code_[static_cast<std::size_t>(code)];
    }
  }
  return bytes.empty();
}

bool KeyframeStore::write_page(std::size_t page, std::span<const std::uint8_t> bytes) {
  if (page < most_memory_pages_) {
    if (page >= memory_.size()) memory_.resize(page + 1);
    memory_[page].assign(bytes.begin(), bytes.end());
    memory_[page].resize(kPageBytes);
    return true;
  }
  const std::size_t at = page - most_memory_pages_;
  return fseeko(file_.get(), static_cast<off_t>(at * kPageBytes), SEEK_SET) == 0 &&
         std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) == bytes.size();
}

bool KeyframeStore::write_pages(std::span<const std::uint8_t> bytes, Record& record) {
  const std::size_t count = (bytes.size() + kPageBytes - 1) / kPageBytes;
  const std::size_t had = std::min(memory_.size(), most_memory_pages_) + file_pages_;
  if (count > free_.size() + most_memory_pages_ + most_file_pages_ - had) return false;
  record.bytes = bytes.size();
  std::size_t next = had;
  bool good = true;
  for (std::size_t i = 0; i < count; ++i) {
    std::size_t page = next;
    if (free_.empty()) {
      ++next;
      if (page >= most_memory_pages_) ++file_pages_;
    } else {
      std::pop_heap(free_.begin(), free_.end(), std::greater<>());
      page = free_.back();
      free_.pop_back();
    }
    record.pages.push_back(page);
    const std::size_t first = i * kPageBytes;
    good =
        good && write_page(page, bytes.subspan(first, std::min(kPageBytes, bytes.size() - first)));
  }
  return good;
}

bool KeyframeStore::read_pages(const Record& record, std::vector<std::uint8_t>& bytes) const {
  bytes.resize(record.bytes);
  for (std::size_t i = 0; i < record.pages.size(); ++i) {
    const std::size_t page = record.pages[i], first = i * kPageBytes;
    const std::size_t count = std::min(kPageBytes, bytes.size() - first);
    if (page < most_memory_pages_) {
      std::copy_n(memory_[page].begin(), count, bytes.begin() + static_cast<std::ptrdiff_t>(first));
      continue;
    }
    const std::size_t at = page - most_memory_pages_;
    if (fseeko(file_.get(), static_cast<off_t>(at * kPageBytes), SEEK_SET) != 0 ||
        std::fread(bytes.data() + first, 1, count, file_.get()) != count) {
      return false;
    }
  }
  return true;
}

bool KeyframeStore::put(std::int64_t id, ImageView<const float> depth, ImageView<const Rgb> rgb,
                        ImageView<const std::uint8_t> grey) {
  if (records_.contains(id) || depth.empty()) return false;
  if (!same_size(rgb, depth)) rgb = {};
  if (!same_size(grey, depth)) grey = {};
  Record record;
  record.width = depth.width;
  record.height = depth.height;
  record.coloured = !rgb.empty();
  std::vector<std::uint8_t> bytes;
  bytes.reserve(2 * static_cast<std::size_t>(depth.width) * static_cast<std::size_t>(depth.height));
  encode_depth(depth, bytes);
  record.depth_bytes = bytes.size();
  if (!encode_picture(rgb, grey, bytes)) bytes.resize(record.depth_bytes);
  const bool good = write_pages(bytes, record);
  records_[id] = std::move(record);
  if (!good) remove(id);
  return good;
}

bool KeyframeStore::get(std::int64_t id, StoredKeyframe& keyframe) const {
  const auto at = records_.find(id);
  if (at == records_.end()) return false;
  const Record& record = at->second;
  std::vector<std::uint8_t> bytes;
  if (!read_pages(record, bytes)) return false;
  const std::span<const std::uint8_t> all(bytes);
  keyframe.depth.resize(record.width, record.height);
  return decode_depth(all.first(record.depth_bytes), keyframe.depth) &&
         decode_picture(all.subspan(record.depth_bytes), record.coloured, record.width,
                        record.height, keyframe);
}

void KeyframeStore::remove(std::int64_t id) {
  const auto at = records_.find(id);
  if (at == records_.end()) return;
  for (const std::size_t page : at->second.pages) {
    free_.push_back(page);
    std::push_heap(free_.begin(), free_.end(), std::greater<>());
  }
  records_.erase(at);
}

}  // namespace tread
