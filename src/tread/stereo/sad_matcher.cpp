#include "tread/stereo/sad_matcher.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <limits>
#include <vector>

#include "tread/core/parallel.hpp"

namespace tread {
namespace {

// Rows that one thread works through with one set of running sums.
constexpr int kBandRows = 64;

// The winner of one pixel and its neighbours on the cost curve.
struct Winner {
  int index = -1;  // disparity - min_disparity, -1: none
};

// Matches a band of rows with the left image as the reference. Sum holds a window's costs.
template <class Sum>
class BandMatcher {
 public:
  BandMatcher(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right,
              const SadOptions& options)
      : left_(left),
        right_(right),
        options_(options),
        radius_x_(options.window_width_px / 2),
        radius_y_(options.window_height_px / 2),
        range_(options.num_disparities),
        columns_(left.width + 2 * radius_x_) {
    const auto cells = static_cast<std::size_t>(columns_) * static_cast<std::size_t>(range_);
    column_sums_.assign(cells, 0);
    column_texture_.assign(static_cast<std::size_t>(columns_), 0);
    costs_.resize(static_cast<std::size_t>(range_));
    winners_.resize(static_cast<std::size_t>(left.width));
    right_cost_.resize(static_cast<std::size_t>(left.width));
    right_winner_.resize(static_cast<std::size_t>(left.width));
    left_row_.resize(static_cast<std::size_t>(columns_));
    right_row_.resize(static_cast<std::size_t>(columns_ + options.min_disparity_px + range_));
  }

  void match_rows(int first, int last, Image<Disparity>& disparity) {
    for (int y = first - radius_y_; y < first + radius_y_; ++y) add_row(y, 1);
    for (int y = first; y < last; ++y) {
      add_row(y + radius_y_, 1);
      match_row(y, disparity.row(y));
      add_row(y - radius_y_, -1);
    }
  }

 private:
  // Adds (sign 1) or takes away (-1) an image row's differences. Rows and columns outside the
  // image are the nearest ones inside.
  void add_row(int y, int sign) {
    const int width = left_.width;
    const int row = std::clamp(y, 0, left_.height - 1);
    for (int c = 0; c < columns_; ++c) {
      left_row_[static_cast<std::size_t>(c)] =
          left_.row(row)[std::clamp(c - radius_x_, 0, width - 1)];
    }
    // Reversed, so that the disparities of one pixel lie in order: entry k is column width - 1 +
    // radius - k of the right image.
    for (std::size_t k = 0; k < right_row_.size(); ++k) {
      const int u = width - 1 + radius_x_ - options_.min_disparity_px - static_cast<int>(k);
      right_row_[k] = right_.row(row)[std::clamp(u, 0, width - 1)];
    }
    for (int c = 0; c < columns_; ++c) {
      const int here = left_row_[static_cast<std::size_t>(c)];
      const std::uint8_t* other = &right_row_[static_cast<std::size_t>(columns_ - 1 - c)];
      Sum* sums = &column_sums_[static_cast<std::size_t>(c) * static_cast<std::size_t>(range_)];
      if (sign > 0) {
        for (int d = 0; d < range_; ++d) {
          sums[d] = static_cast<Sum>(sums[d] + static_cast<Sum>(std::abs(here - other[d])));
        }
      } else {
        for (int d = 0; d < range_; ++d) {
          sums[d] = static_cast<Sum>(sums[d] - static_cast<Sum>(std::abs(here - other[d])));
        }
      }
      column_texture_[static_cast<std::size_t>(c)] += sign * std::abs(here - 128);
    }
  }

  // How many disparities of the range stay inside the right image at a column.
  [[nodiscard]] int available(int x) const {
    const int fit = std::min(range_, x - options_.min_disparity_px + 1);
    if (fit < range_ && !options_.reduced_range_at_border) return 0;
    return std::max(0, fit);
  }

  [[nodiscard]] bool window_fits(int x, int y) const {
    return x >= radius_x_ && y >= radius_y_ && x < left_.width - radius_x_ &&
           y < left_.height - radius_y_;
  }

  void match_row(int y, Disparity* out) {
    const int width = left_.width;
    const bool check = options_.left_right_tolerance_px >= 0;
    std::fill(right_cost_.begin(), right_cost_.end(), std::numeric_limits<Sum>::max());
    std::fill(right_winner_.begin(), right_winner_.end(), -1);
    std::fill(costs_.begin(), costs_.end(), Sum{0});
    std::int64_t texture = 0;
    for (int c = 0; c < 2 * radius_x_; ++c) slide(c, -1, texture);
    for (int x = 0; x < width; ++x) {
      slide(x + 2 * radius_x_, x - 1, texture);
      const int fit = available(x);
      if (check) vote_right(x, fit);
      Winner& winner = winners_[static_cast<std::size_t>(x)];
      winner = best(fit);
      out[x] = kNoMatch;
      if (winner.index < 0) continue;
      const bool accepted = (options_.border == Border::kReplicate || window_fits(x, y)) &&
                            textured(texture) && unique(winner.index, fit);
      if (accepted) out[x] = refined(winner.index, fit);
    }
    if (!check) return;
    for (int x = 0; x < width; ++x) {
      if (out[x] == kNoMatch) continue;
      const int index = winners_[static_cast<std::size_t>(x)].index;
      const int column = x - index - options_.min_disparity_px;
      const int back = right_winner_[static_cast<std::size_t>(column)];
      if (std::abs(back - index) > options_.left_right_tolerance_px) out[x] = kNoMatch;
    }
  }

  // Moves the window: takes column `in` in and, if not negative, column `drop` out.
  void slide(int in, int drop, std::int64_t& texture) {
    const auto range = static_cast<std::size_t>(range_);
    const Sum* added = &column_sums_[static_cast<std::size_t>(in) * range];
    texture += column_texture_[static_cast<std::size_t>(in)];
    if (drop < 0) {
      for (std::size_t d = 0; d < range; ++d) costs_[d] = static_cast<Sum>(costs_[d] + added[d]);
      return;
    }
    const Sum* dropped = &column_sums_[static_cast<std::size_t>(drop) * range];
    texture -= column_texture_[static_cast<std::size_t>(drop)];
    for (std::size_t d = 0; d < range; ++d) {
      costs_[d] = static_cast<Sum>(costs_[d] + added[d] - dropped[d]);
    }
  }

  [[nodiscard]] Winner best(int fit) const {
    if (fit <= 0) return {};
    const auto end = costs_.begin() + fit;
    return {static_cast<int>(std::min_element(costs_.begin(), end) - costs_.begin())};
  }

  // Every disparity of x is also a candidate of a right pixel; of equal ones the smaller stays.
  void vote_right(int x, int fit) {
    const int column = x - options_.min_disparity_px;
    for (int d = 0; d < fit; ++d) {
      const auto right = static_cast<std::size_t>(column - d);
      if (costs_[static_cast<std::size_t>(d)] < right_cost_[right]) {
        right_cost_[right] = costs_[static_cast<std::size_t>(d)];
        right_winner_[right] = d;
      }
    }
  }

  [[nodiscard]] bool textured(std::int64_t texture) const {
    const double area = static_cast<double>(options_.window_width_px) * options_.window_height_px;
    return static_cast<double>(texture) >= options_.min_texture * area;
  }

  [[nodiscard]] bool unique(int index, int fit) const {
    if (options_.uniqueness_percent <= 0) return true;
    const std::int64_t limit = static_cast<std::int64_t>(costs_[static_cast<std::size_t>(index)]) *
                               (100 + options_.uniqueness_percent);
    for (int d = 0; d < fit; ++d) {
      if (std::abs(d - index) <= 1) continue;
      if (static_cast<std::int64_t>(costs_[static_cast<std::size_t>(d)]) * 100 <= limit)
        return false;
    }
    return true;
  }

  [[nodiscard]] Disparity refined(int index, int fit) const {
    const int whole = (options_.min_disparity_px + index) * kDisparityScale;
    const bool at_end = index == 0 || index == fit - 1;
    if (at_end) return options_.strict_sub_pixel ? kNoMatch : static_cast<Disparity>(whole);
    const auto i = static_cast<std::size_t>(index);
    const double l = costs_[i - 1], c = costs_[i], r = costs_[i + 1];
    if (options_.strict_sub_pixel && (l <= c || r <= c)) return kNoMatch;
    double delta = 0.0;
    if (options_.sub_pixel == SubPixel::kSymmetricV && std::max(l, r) > c) {
      delta = (l - r) / (2.0 * (std::max(l, r) - c));
    } else if (options_.sub_pixel == SubPixel::kParabola && l + r > 2.0 * c) {
      delta = (l - r) / (2.0 * (l + r - 2.0 * c));
    }
    const auto steps = std::lround(delta * options_.sub_pixel_steps);
    return static_cast<Disparity>(whole + steps * kDisparityScale / options_.sub_pixel_steps);
  }

  ImageView<const std::uint8_t> left_;
  ImageView<const std::uint8_t> right_;
  const SadOptions& options_;
  int radius_x_;
  int radius_y_;
  int range_;
  int columns_;                   // image columns and a radius on both sides
  std::vector<Sum> column_sums_;  // [column][disparity], over the rows of the window
  std::vector<std::int64_t> column_texture_;
  std::vector<Sum> costs_;       // [disparity], of the window at hand
  std::vector<Winner> winners_;  // of the row
  std::vector<Sum> right_cost_;  // of the row, by right column
  std::vector<int> right_winner_;
  std::vector<std::uint8_t> left_row_;
  std::vector<std::uint8_t> right_row_;
};

template <class Sum>
void match_left_reference(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right,
                          const SadOptions& options, Image<Disparity>& disparity,
                          const Context& context) {
  parallel_chunks(context, 0, left.height, kBandRows, [&](int first, int last) {
    BandMatcher<Sum>(left, right, options).match_rows(first, last, disparity);
  });
}

template <class T>
void mirror(ImageView<const T> from, Image<T>& to) {
  to.resize(from.width, from.height);
  for (int y = 0; y < from.height; ++y) {
    std::reverse_copy(from.row(y), from.row(y) + from.width, to.row(y));
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
                       Image<Disparity>& disparity, const Context& context) {
  assert(same_size(left, right) && !left.empty());
  const ScopedTimer timer(context, "stereo/match");
  disparity.resize(left.width, left.height);
  // With the right image as the reference a match lies at x + d. Mirrored, it lies at x - d.
  const bool mirrored = options.reference == Reference::kRight;
  if (mirrored) {
    mirror(left, mirrored_left_);
    mirror(right, mirrored_right_);
    left = mirrored_right_;
    right = mirrored_left_;
  }
  const int largest_sum = options.window_width_px * options.window_height_px * largest_difference;
  if (largest_sum < std::numeric_limits<std::uint16_t>::max()) {
    match_left_reference<std::uint16_t>(left, right, options, disparity, context);
  } else {
    match_left_reference<std::uint32_t>(left, right, options, disparity, context);
  }
  if (!mirrored) return;
  for (int y = 0; y < disparity.height; ++y) {
    std::reverse(disparity.row(y), disparity.row(y) + disparity.width);
  }
}

}  // namespace tread
