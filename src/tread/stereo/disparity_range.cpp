#include "tread/stereo/disparity_range.hpp"

#include <algorithm>
#include <vector>

#include "tread/core/shrink.hpp"

namespace tread {
namespace {

constexpr int kShrink = 4;
constexpr int kLeast = 64;

}  // namespace

Result<int> estimate_num_disparities(ImageView<const std::uint8_t> left,
                                     ImageView<const std::uint8_t> right,
                                     const StereoOptions& options, const Context& context) {
  const ScopedTimer timer(context, "stereo/range");
  const Context untimed{context.threads, nullptr};  // the stages below are those of frames
  const int first = options.sad.min_disparity_px;
  const int widest = std::max(1, std::min(left.width, kMaxDisparity) - first);
  const int least = std::min(kLeast, widest);
  if (left.empty() || !same_size(left, right)) {  // let the matcher say what is wrong
    StereoMatcher matcher;
    if (const auto refused = matcher.match(left, right, options); !refused) return forward(refused);
  }
  Image<std::uint8_t> small_left, small_right;
  shrink(left, kShrink, small_left);
  shrink(right, kShrink, small_right);
  StereoOptions coarse = options;
  coarse.method = StereoMethod::kSad;
  coarse.sad.min_disparity_px = 0;
  coarse.sad.num_disparities = std::clamp(small_left.width / 2, 1, kMaxDisparity / kShrink + 1);
  coarse.holes.spatial = coarse.holes.temporal = false;
  coarse.temporal.enabled = coarse.rate = false;
  coarse.speckle.max_size_px /= kShrink * kShrink;
  StereoMatcher matcher;
  const auto disparity = matcher.match(small_left, small_right, coarse, untimed);
  if (!disparity) return forward(disparity);

  std::vector<int> matched;
  for (int y = 0; y < disparity->height; ++y) {
    for (int x = 0; x < disparity->width; ++x) {
      const Disparity d = (*disparity)(x, y);
      if (d != kNoMatch) matched.push_back(d);
    }
  }
  if (matched.size() < 200) return least;
  const auto rank = matched.begin() + static_cast<std::ptrdiff_t>(matched.size() * 995 / 1000);
  std::nth_element(matched.begin(), rank, matched.end());
  const int needed = kShrink * *rank * 5 / 4 / kDisparityScale - first;
  return std::min(widest, std::max(least, (needed + 16) / 16 * 16));
}

}  // namespace tread
