#include "tread/stereo/sad_matcher.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cstdlib>

#include "tread/core/parallel.hpp"
#include "tread/stereo/sad_kernel.hpp"
#include "tread/stereo/sad_plain.hpp"

namespace tread {
namespace {

// Rows of a band: the same for any number of threads, and an even share for two or four.
int band_rows(int height) {
  constexpr int kAbout = 40;
  const int bands = 4 * ((height + 4 * kAbout - 1) / (4 * kAbout));
  return (height + bands - 1) / bands;
}

// Takes the match off the pixels first to last - 1 of a row.
void clear(const MatchOutput& out, int y, int first, int last) {
  std::fill(out.disparity.row(y) + first, out.disparity.row(y) + last, kNoMatch);
  if (out.residual.empty()) return;
  std::fill(out.residual.row(y) + first, out.residual.row(y) + last, kNoResidual);
}

// Takes it off the pixels whose window leaves the image.
void clear_border(const SadOptions& options, const MatchOutput& out) {
  const int width = out.disparity.width, height = out.disparity.height;
  const int rx = std::min(options.window_width_px / 2, width);
  const int ry = options.window_height_px / 2;
  for (int y = 0; y < height; ++y) {
    const bool outside = y < ry || y >= height - ry;
    clear(out, y, 0, outside ? width : rx);
    clear(out, y, width - rx, width);
  }
}

// Takes it off the windows with little texture: mean of |edges - 128|.
void clear_plain(ImageView<const std::uint8_t> edges, const SadOptions& options,
                 std::vector<int>& column_sums, const MatchOutput& out) {
  const int rx = options.window_width_px / 2, ry = options.window_height_px / 2;
  const double needed = options.min_texture * options.window_width_px * options.window_height_px;
  column_sums.assign(static_cast<std::size_t>(edges.width), 0);
  const auto add_row = [&](int y, int sign) {
    const std::uint8_t* row = edges.row(std::clamp(y, 0, edges.height - 1));
    for (int x = 0; x < edges.width; ++x) {
      column_sums[static_cast<std::size_t>(x)] += sign * std::abs(row[x] - 128);
    }
  };
  const auto column = [&](int x) {
    return column_sums[static_cast<std::size_t>(std::clamp(x, 0, edges.width - 1))];
  };
  for (int y = -ry; y < ry; ++y) add_row(y, 1);
  for (int y = 0; y < edges.height; ++y) {
    add_row(y + ry, 1);
    std::int64_t texture = 0;
    for (int x = -rx; x < rx; ++x) texture += column(x);
    for (int x = 0; x < edges.width; ++x) {
      texture += column(x + rx);
      if (static_cast<double>(texture) < needed) clear(out, y, x, x + 1);
      texture -= column(x - rx);
    }
    add_row(y - ry, -1);
  }
}

}  // namespace

OptionSet describe(SadOptions& options) {
  OptionSet set;
  set.add_choice("reference", options.reference, "image whose pixels get the disparities",
                 {{"left", Reference::kLeft}, {"right", Reference::kRight}});
  set.add_odd("window_width_px", options.window_width_px, "width of the window, px", 1, 63);
  set.add_odd("window_height_px", options.window_height_px, "height of the window, px", 1, 63);
  set.add("min_disparity_px", options.min_disparity_px, "first disparity tried, px", 0,
          kMaxDisparity - 1);
  set.add("num_disparities", options.num_disparities, "how many disparities are tried", 1,
          kMaxDisparity);
  set.add_choice("border", options.border, "where the window leaves the image",
                 {{"full_window", Border::kFullWindow}, {"replicate", Border::kReplicate}});
  set.add("reduced_range_at_border", options.reduced_range_at_border,
          "match near the border with the part of the range that fits");
  set.add_choice("sub_pixel", options.sub_pixel, "refinement below the pixel",
                 {{"none", SubPixel::kNone},
                  {"symmetric_v", SubPixel::kSymmetricV},
                  {"parabola", SubPixel::kParabola}});
  set.add("sub_pixel_steps", options.sub_pixel_steps, "steps a pixel; paper Q: 4", 1,
          kDisparityScale);
  set.add("strict_sub_pixel", options.strict_sub_pixel,
          "no match without a minimum inside the range");
  set.add("uniqueness_percent", options.uniqueness_percent,
          "how much dearer all other disparities must be, per cent; 0: not checked", 0, 100);
  set.add("min_texture", options.min_texture,
          "least mean deviation of the edge image over the window, grey levels; 0: not checked",
          0.0, 128.0);
  set.add("left_right_tolerance_px", options.left_right_tolerance_px,
          "how far the match back may miss, px; -1: not checked", -1, 16);
  set.require({"min_disparity_px", "num_disparities"},
              fmt::format("the largest disparity must be at most {} px", kMaxDisparity),
              [&options] {
                return options.min_disparity_px + options.num_disparities - 1 <= kMaxDisparity;
              });
  return set;
}

void SadMatcher::match(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right,
                       const SadOptions& options, int largest_difference,
                       Image<Disparity>& disparity, Image<std::uint8_t>* residual,
                       const Context& context) {
  assert(same_size(left, right) && !left.empty());
  const ScopedTimer timer(context, "stereo/match");
  disparity.resize(left.width, left.height);
  MatchOutput output{disparity};
  if (residual != nullptr) {
    residual->resize(left.width, left.height);
    output.residual = *residual;
  }
  const bool mirrored = options.reference == Reference::kRight;
  const SadImages images = mirrored ? SadImages{right, left, true, largest_difference}
                                    : SadImages{left, right, false, largest_difference};
  const int largest_sum = options.window_width_px * options.window_height_px * largest_difference;
  memory_.resize(static_cast<std::size_t>(worker_count(context)));
  parallel_chunks(context, 0, left.height, band_rows(left.height),
                  [&](int first, int last, int worker) {
                    if (largest_sum > kLargestKernelSum) {
                      match_rows_plain(images, options, first, last, output);
                    } else {
                      match_rows(images, options, first, last,
                                 memory_[static_cast<std::size_t>(worker)], output);
                    }
                  });
  if (options.min_texture > 0.0) clear_plain(images.reference, options, column_sums_, output);
  if (options.border == Border::kFullWindow) clear_border(options, output);
}

}  // namespace tread
