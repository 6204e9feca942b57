#include "tread/slam/corner_tracker.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

namespace tread {
namespace {

constexpr int kPatchRadius = 5;  // of the patch that is searched for along a row
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

struct Pyramid {
  std::vector<cv::Mat> levels;  // of the flattened image
  cv::Mat image;                // as given
};

// Following compares grey values as they are, and two images are seldom equally bright: the mean of
// the surroundings is taken off, and the contrast that is left is made the same for all.
cv::Mat flattened(const cv::Mat& image, int window_px) {
  constexpr double kMiddle = 128.0, kContrast = 36.0, kLargestGain = 6.0;
  const int side = 4 * window_px + 1;
  cv::Mat surroundings, flat;
  cv::boxFilter(image, surroundings, -1, {side, side});
  cv::addWeighted(image, 1.0, surroundings, -1.0, kMiddle, flat);
  cv::Scalar mean, spread;
  cv::meanStdDev(flat, mean, spread);
  const double gain =
      std::clamp(kContrast / std::max(spread[0], 1e-3), 1.0 / kLargestGain, kLargestGain);
  cv::addWeighted(image, gain, surroundings, -gain, kMiddle, flat);
  return flat;
}

void build(ImageView<const std::uint8_t> from, const CornerOptions& options, bool slopes,
           Pyramid& out) {
  // OpenCV has no view of constant pixels; it only reads these.
  cv::Mat(from.height, from.width, CV_8UC1, const_cast<std::uint8_t*>(from.data),
          static_cast<std::size_t>(from.stride))
      .copyTo(out.image);
  cv::buildOpticalFlowPyramid(flattened(out.image, options.window_px), out.levels,
                              {options.window_px, options.window_px}, options.levels - 1, slopes);
}

std::vector<cv::Point2f> points_of(std::span<const Eigen::Vector2d> places) {
  std::vector<cv::Point2f> points;
  points.reserve(places.size());
  for (const Eigen::Vector2d& p : places) {
    points.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
  }
  return points;
}

// A patch of zero mean and unit length.
struct Patch {
  static constexpr int kSide = 2 * kPatchRadius + 1;
  std::array<float, kSide * kSide> values;
  bool flat = true;
};
Patch patch_at(const cv::Mat& image, int u, int v) {
  Patch patch;
  float sum = 0.0F;
  std::size_t k = 0;
  for (int y = v - kPatchRadius; y <= v + kPatchRadius; ++y) {
    const std::uint8_t* row = image.ptr<std::uint8_t>(y);
    for (int x = u - kPatchRadius; x <= u + kPatchRadius; ++x, ++k) {
      patch.values[k] = row[x];
      sum += patch.values[k];
    }
  }
  const float mean = sum / static_cast<float>(patch.values.size());
  float squares = 0.0F;
  for (float& value : patch.values) {
    value -= mean;
    squares += value * value;
  }
  patch.flat = squares < static_cast<float>(patch.values.size());
  if (patch.flat) return patch;
  const float scale = 1.0F / std::sqrt(squares);
  for (float& value : patch.values) value *= scale;
  return patch;
}

// Correlation of a patch with the place (u, v) of an image.
float correlation(const Patch& patch, const cv::Mat& image, int u, int v) {
  int sum = 0, squares = 0;
  float product = 0.0F;
  std::size_t k = 0;
  for (int y = v - kPatchRadius; y <= v + kPatchRadius; ++y) {
    const std::uint8_t* row = image.ptr<std::uint8_t>(y) + (u - kPatchRadius);
    for (int x = 0; x < Patch::kSide; ++x, ++k) {
      const int value = row[x];
      sum += value;
      squares += value * value;
      product += patch.values[k] * static_cast<float>(value);
    }
  }
  constexpr float kCount = Patch::kSide * Patch::kSide;
  const float spread =
      static_cast<float>(squares) - static_cast<float>(sum) * static_cast<float>(sum) / kCount;
  return spread < kCount ? 0.0F : product / std::sqrt(spread);
}

bool has_patch(const cv::Mat& image, int u, int v) {
  return u >= kPatchRadius && v >= kPatchRadius && u < image.cols - kPatchRadius &&
         v < image.rows - kPatchRadius;
}

}  // namespace

struct CornerTracker::Impl {
  CornerOptions options;
  Pyramid left, right, kept;
  cv::Mat corners;

  [[nodiscard]] double search_row(const StereoSight& sight, double first, double last) const;
  [[nodiscard]] cv::TermCriteria criteria() const {
    return {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 30, 0.01};
  }
};

OptionSet describe(CornerOptions& options) {
  OptionSet set;
  set.add("most", options.most, "features at once", 20, 10'000);
  set.add("window_px", options.window_px, "side of the square that is followed, px", 5, 61);
  set.add("levels", options.levels, "of the pyramid", 1, 8);
  set.add("least_corner", options.least_corner,
          "slope in the weaker direction, grey values a pixel", 0.01, 255.0);
  set.add("most_return_px", options.most_return_px,
          "followed there and back a feature comes so near, px", 0.01, 10.0);
  set.add("most_row_px", options.most_row_px, "between the rows of both images, px", 0.01, 10.0);
  set.add("least_correlation", options.least_correlation, "of the patches of both images", 0.0,
          1.0);
  return set;
}

CornerTracker::CornerTracker(const CornerOptions& options) : impl_(std::make_unique<Impl>()) {
  impl_->options = options;
}
CornerTracker::~CornerTracker() = default;
CornerTracker::CornerTracker(CornerTracker&&) noexcept = default;
CornerTracker& CornerTracker::operator=(CornerTracker&&) noexcept = default;

void CornerTracker::see(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right,
                        const Context& context) {
  const ScopedTimer timer(context, "odometry/pyramids");
  impl_->left.levels.clear();  // their memory may be that of what was kept
  build(left, impl_->options, true, impl_->left);
  build(right, impl_->options, false, impl_->right);
}

void CornerTracker::keep() {
  impl_->kept.levels = impl_->left.levels;
}

void CornerTracker::follow(std::span<const Eigen::Vector2d> from, std::span<Eigen::Vector2d> to,
                           std::vector<std::uint8_t>& found, const Context& context) {
  const ScopedTimer timer(context, "odometry/follow");
  found.assign(from.size(), 0);
  if (from.empty() || impl_->kept.levels.empty()) return;
  const CornerOptions& options = impl_->options;
  const cv::Size window(options.window_px, options.window_px);
  const std::vector<cv::Point2f> start = points_of(from);
  std::vector<cv::Point2f> there = points_of(to), back = start;
  std::vector<std::uint8_t> good, good_back;
  std::vector<float> unused;
  cv::calcOpticalFlowPyrLK(impl_->kept.levels, impl_->left.levels, start, there, good, unused,
                           window, options.levels - 1, impl_->criteria(),
                           cv::OPTFLOW_USE_INITIAL_FLOW);
  cv::calcOpticalFlowPyrLK(impl_->left.levels, impl_->kept.levels, there, back, good_back, unused,
                           window, 1, impl_->criteria(), cv::OPTFLOW_USE_INITIAL_FLOW);
  const cv::Rect2f inside(2.0F, 2.0F, static_cast<float>(impl_->left.image.cols - 4),
                          static_cast<float>(impl_->left.image.rows - 4));
  for (std::size_t i = 0; i < from.size(); ++i) {
    const cv::Point2f off = back[i] - start[i];
    const bool returned = std::hypot(off.x, off.y) <= options.most_return_px;
    if (good[i] == 0 || good_back[i] == 0 || !returned || !inside.contains(there[i])) continue;
    to[i] = {there[i].x, there[i].y};
    found[i] = 1;
  }
}

// The column in the right image by correlation along the row, to a pixel.
double CornerTracker::Impl::search_row(const StereoSight& sight, double first, double last) const {
  const int u = static_cast<int>(std::lround(sight.u)), v = static_cast<int>(std::lround(sight.v));
  if (!has_patch(left.image, u, v)) return kUnknown;
  const Patch patch = patch_at(left.image, u, v);
  if (patch.flat) return kUnknown;
  const int from = std::max(kPatchRadius, u - static_cast<int>(std::ceil(last)));
  const int to =
      std::min(right.image.cols - 1 - kPatchRadius, u - static_cast<int>(std::floor(first)));
  float best = 0.0F, second = 0.0F;
  int best_x = -10;
  for (int x = from; x <= to; ++x) {
    const float c = correlation(patch, right.image, x, v);
    if (c > best) {
      if (x > best_x + 2) second = best;
      best = c;
      best_x = x;
    } else if (x > best_x + 2) {
      second = std::max(second, c);
    }
  }
  // What repeats along the row could be either.
  constexpr float kLeastLead = 0.03F;
  if (best < options.least_correlation || best - second < kLeastLead) return kUnknown;
  return best_x;
}

void CornerTracker::find_right(std::span<StereoSight> sights, double first, double last,
                               const Context& context) {
  const ScopedTimer timer(context, "odometry/find_right");
  const CornerOptions& options = impl_->options;
  std::vector<cv::Point2f> start, there;
  std::vector<std::size_t> index;
  for (std::size_t i = 0; i < sights.size(); ++i) {
    StereoSight& sight = sights[i];
    if (!sight.has_right()) sight.u_right = impl_->search_row(sight, first, last);
    if (!sight.has_right()) continue;
    start.emplace_back(static_cast<float>(sight.u), static_cast<float>(sight.v));
    there.emplace_back(static_cast<float>(sight.u_right), static_cast<float>(sight.v));
    sight.u_right = kUnknown;
    index.push_back(i);
  }
  if (start.empty()) return;
  std::vector<std::uint8_t> good;
  std::vector<float> unused;
  cv::calcOpticalFlowPyrLK(impl_->left.levels, impl_->right.levels, start, there, good, unused,
                           {options.window_px, options.window_px}, 1, impl_->criteria(),
                           cv::OPTFLOW_USE_INITIAL_FLOW);
  for (std::size_t k = 0; k < index.size(); ++k) {
    if (good[k] == 0 || std::abs(there[k].y - start[k].y) > options.most_row_px) continue;
    const double disparity = start[k].x - there[k].x;
    if (disparity < first || disparity > last) continue;
    const int u = static_cast<int>(std::lround(start[k].x)),
              v = static_cast<int>(std::lround(start[k].y)),
              u_right = static_cast<int>(std::lround(there[k].x));
    if (!has_patch(impl_->left.image, u, v) || !has_patch(impl_->right.image, u_right, v)) continue;
    const Patch patch = patch_at(impl_->left.image, u, v);
    // Half a pixel off costs some of the correlation: less is asked for than in the search.
    if (correlation(patch, impl_->right.image, u_right, v) < 0.8 * options.least_correlation) {
      continue;
    }
    sights[index[k]].u_right = there[k].x;
  }
}

std::vector<Eigen::Vector2d> CornerTracker::detect(std::span<const Eigen::Vector2d> taken,
                                                   const Context& context) {
  const ScopedTimer timer(context, "odometry/detect");
  const CornerOptions& options = impl_->options;
  std::vector<Eigen::Vector2d> found;
  const int wanted = options.most - static_cast<int>(taken.size());
  if (wanted <= 0) return found;
  const cv::Mat& image = impl_->left.image;
  constexpr int kBlock = 5;
  cv::cornerMinEigenVal(image, impl_->corners, kBlock, 3);
  // A slope of s grey values a pixel all over the block gives (2 s / 255)^2 with its filters.
  const auto least = static_cast<float>(std::pow(2.0 * options.least_corner / 255.0, 2));
  const double spacing =
      0.6 * std::sqrt(static_cast<double>(image.cols) * image.rows / options.most);
  const int border = kPatchRadius + 2;
  struct Corner {
    float strength;
    int x, y;
  };
  std::vector<Corner> corners;
  for (int y = border; y < image.rows - border; ++y) {
    const float* above = impl_->corners.ptr<float>(y - 1);
    const float* row = impl_->corners.ptr<float>(y);
    const float* below = impl_->corners.ptr<float>(y + 1);
    for (int x = border; x < image.cols - border; ++x) {
      const float c = row[x];
      if (c < least || c < row[x - 1] || c <= row[x + 1]) continue;
      if (c < above[x - 1] || c < above[x] || c < above[x + 1]) continue;
      if (c <= below[x - 1] || c <= below[x] || c <= below[x + 1]) continue;
      corners.push_back({c, x, y});
    }
  }
  std::sort(corners.begin(), corners.end(), [](const Corner& a, const Corner& b) {
    if (a.strength != b.strength) return a.strength > b.strength;
    return a.y != b.y ? a.y < b.y : a.x < b.x;
  });
  // What lies within the spacing of a feature is crossed out.
  cv::Mat free(image.rows, image.cols, CV_8UC1, cv::Scalar(1));
  const auto cross_out = [&](double x, double y) {
    cv::circle(free, {static_cast<int>(std::lround(x)), static_cast<int>(std::lround(y))},
               static_cast<int>(spacing), cv::Scalar(0), cv::FILLED);
  };
  for (const Eigen::Vector2d& p : taken) cross_out(p.x(), p.y());
  for (const Corner& corner : corners) {
    if (static_cast<int>(found.size()) >= wanted) break;
    if (free.at<std::uint8_t>(corner.y, corner.x) == 0) continue;
    found.emplace_back(corner.x, corner.y);
    cross_out(corner.x, corner.y);
  }
  return found;
}

}  // namespace tread
