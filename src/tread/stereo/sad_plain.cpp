#include "tread/stereo/sad_plain.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <vector>

namespace tread {
namespace {

class PlainBand {
 public:
  PlainBand(const SadImages& images, const SadOptions& options)
      : images_(images),
        options_(options),
        width_(images.reference.width),
        radius_x_(options.window_width_px / 2),
        radius_y_(options.window_height_px / 2),
        range_(options.num_disparities),
        columns_(width_ + 2 * radius_x_),
        sums_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(range_)),
        costs_(static_cast<std::size_t>(range_)),
        winners_(static_cast<std::size_t>(width_)) {}

  void match(int first, int last, const MatchOutput& out) {
    for (int y = first - radius_y_; y < first + radius_y_; ++y) add_row(y, 1);
    for (int y = first; y < last; ++y) {
      add_row(y + radius_y_, 1);
      match_row(out.disparity.row(y));
      if (!out.residual.empty()) rate_row(out.disparity.row(y), out.residual.row(y));
      add_row(y - radius_y_, -1);
    }
  }

 private:
  struct Winner {
    int index = -1;  // disparity - min_disparity, -1: nothing to try
    int cost = 0;
    int slope = 0;  // 0: not known
  };

  [[nodiscard]] int pixel(ImageView<const std::uint8_t> image, int x, int row) const {
    x = std::clamp(x, 0, width_ - 1);
    return image.row(row)[images_.mirrored ? width_ - 1 - x : x];
  }

  // Adds (sign 1) or takes away (-1) an image row's differences. Rows and columns outside the
  // image are the nearest ones inside.
  void add_row(int y, int sign) {
    const int row = std::clamp(y, 0, images_.reference.height - 1);
    for (int c = 0; c < columns_; ++c) {
      const int x = c - radius_x_;
      const int here = pixel(images_.reference, x, row);
      int* sums = &sums_[static_cast<std::size_t>(c) * static_cast<std::size_t>(range_)];
      for (int d = 0; d < range_; ++d) {
        const int other = pixel(images_.other, x - options_.min_disparity_px - d, row);
        sums[d] += sign * std::abs(here - other);
      }
    }
  }

  // How many disparities of the range stay inside the other image at a column.
  [[nodiscard]] int available(int x) const {
    const int fit = std::min(range_, x - options_.min_disparity_px + 1);
    if (fit < range_ && !options_.reduced_range_at_border) return 0;
    return std::max(0, fit);
  }

  void match_row(Disparity* out) {
    std::fill(costs_.begin(), costs_.end(), 0);
    for (int c = 0; c < 2 * radius_x_; ++c) slide(c, 1);
    for (int x = 0; x < width_; ++x) {
      slide(x + 2 * radius_x_, 1);
      const int fit = available(x);
      Winner& winner = winners_[static_cast<std::size_t>(x)];
      winner = best(fit);
      if (winner.index > 0 && winner.index < fit - 1) {
        const auto i = static_cast<std::size_t>(winner.index);
        winner.slope = std::max(costs_[i - 1], costs_[i + 1]) - winner.cost;
      }
      const bool accepted = winner.index >= 0 && unique(winner, fit);
      out[x] = accepted ? refined(winner.index, fit) : kNoMatch;
      slide(x, -1);
    }
    if (options_.left_right_tolerance_px >= 0) check_back(out);
    if (images_.mirrored) std::reverse(out, out + width_);
  }

  void rate_row(const Disparity* found, std::uint8_t* residual) const {
    for (int x = 0; x < width_; ++x) {
      const Winner& w = winners_[static_cast<std::size_t>(images_.mirrored ? width_ - 1 - x : x)];
      residual[x] = found[x] == kNoMatch ? kNoResidual : residual_of(w.cost, w.slope);
    }
  }

  void slide(int c, int sign) {
    const int* sums = &sums_[static_cast<std::size_t>(c) * static_cast<std::size_t>(range_)];
    for (int d = 0; d < range_; ++d) costs_[static_cast<std::size_t>(d)] += sign * sums[d];
  }

  [[nodiscard]] Winner best(int fit) const {
    if (fit <= 0) return {};
    const auto least = std::min_element(costs_.begin(), costs_.begin() + fit);
    return {static_cast<int>(least - costs_.begin()), *least};
  }

  [[nodiscard]] bool unique(Winner winner, int fit) const {
    if (options_.uniqueness_percent <= 0) return true;
    const std::int64_t factor = uniqueness_factor(options_.uniqueness_percent);
    const int margin = static_cast<int>(winner.cost * factor >> 16);
    for (int d = 0; d < fit; ++d) {
      if (std::abs(d - winner.index) <= 1) continue;
      if (costs_[static_cast<std::size_t>(d)] <= winner.cost + margin) return false;
    }
    return true;
  }

  [[nodiscard]] Disparity refined(int index, int fit) const {
    const int whole = (options_.min_disparity_px + index) * kDisparityScale;
    const bool at_end = index == 0 || index == fit - 1;
    if (at_end) return options_.strict_sub_pixel ? kNoMatch : static_cast<Disparity>(whole);
    const auto i = static_cast<std::size_t>(index);
    const int l = costs_[i - 1], c = costs_[i], r = costs_[i + 1];
    if (options_.strict_sub_pixel && (l <= c || r <= c)) return kNoMatch;
    int divisor = 0;
    if (options_.sub_pixel == SubPixel::kSymmetricV) divisor = std::max(l, r) - c;
    if (options_.sub_pixel == SubPixel::kParabola) divisor = l + r - 2 * c;
    if (divisor <= 0) return static_cast<Disparity>(whole);
    const double delta = static_cast<double>(l - r) * options_.sub_pixel_steps / (2.0 * divisor);
    const auto steps = static_cast<int>(std::lrint(delta));  // half to even
    return static_cast<Disparity>(whole + steps * kDisparityScale / options_.sub_pixel_steps);
  }

  // A pixel of the other image belongs to the cheapest of those that chose it, of equal ones to the
  // one with the smaller disparity; the others have no match.
  void check_back(Disparity* out) const {
    std::vector<Winner> owner(static_cast<std::size_t>(width_));
    const auto chosen = [&](int x) {
      return static_cast<std::size_t>(x - options_.min_disparity_px -
                                      winners_[static_cast<std::size_t>(x)].index);
    };
    for (int x = 0; x < width_; ++x) {
      const Winner& winner = winners_[static_cast<std::size_t>(x)];
      if (winner.index < 0) continue;
      Winner& o = owner[chosen(x)];
      if (o.index < 0 || winner.cost < o.cost) o = winner;
    }
    for (int x = 0; x < width_; ++x) {
      const int index = winners_[static_cast<std::size_t>(x)].index;
      if (index < 0) continue;
      if (std::abs(owner[chosen(x)].index - index) > options_.left_right_tolerance_px) {
        out[x] = kNoMatch;
      }
    }
  }

  const SadImages& images_;
  const SadOptions& options_;
  int width_;
  int radius_x_;
  int radius_y_;
  int range_;
  int columns_;                  // image columns and a radius on both sides
  std::vector<int> sums_;        // [column][disparity], over the rows of the window
  std::vector<int> costs_;       // [disparity], of the window at hand
  std::vector<Winner> winners_;  // of the row
};

}  // namespace

void match_rows_plain(const SadImages& images, const SadOptions& options, int first, int last,
                      const MatchOutput& out) {
  PlainBand(images, options).match(first, last, out);
}

}  // namespace tread
