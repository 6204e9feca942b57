#include "tread/stereo/sgm_plain.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "tread/stereo/sad_kernel.hpp"
#include "tread/stereo/sad_plain.hpp"

namespace tread {
namespace {

class PlainSgm {
 public:
  PlainSgm(const SgmImages& images, const SgmOptions& options)
      : images_(images),
        options_(options),
        width_(images.left_edges.width),
        height_(images.left_edges.height),
        range_(options.num_disparities) {}

  void match(const MatchOutput& out) {
    std::vector<std::vector<int>> cost, sum;
    for (int y = 0; y < height_; ++y) {
      cost.push_back(costs(y));
      sum.emplace_back(cost.back().size());
    }
    struct Direction {
      int x, y;
    };
    std::vector<Direction> directions{{1, 0}, {-1, 0}, {0, 1}};
    if (options_.paths != SgmPaths::kThree) directions.push_back({0, -1});
    if (options_.paths == SgmPaths::kEight) {
      directions.insert(directions.end(), {{1, 1}, {-1, 1}, {1, -1}, {-1, -1}});
    }
    for (const auto [dx, dy] : directions) follow(cost, dx, dy, sum);
    for (int y = 0; y < height_; ++y) {
      choose(sum[static_cast<std::size_t>(y)], out.disparity.row(y),
             out.residual.empty() ? nullptr : out.residual.row(y));
    }
  }

 private:
  [[nodiscard]] std::size_t at(int x) const {
    return static_cast<std::size_t>(x) * static_cast<std::size_t>(range_);
  }

  [[nodiscard]] std::vector<int> costs(int y) const {
    std::vector<int> cost(at(width_));
    for (int x = 0; x < width_; ++x) {
      for (int d = 0; d < range_; ++d) {
        const int shift = options_.min_disparity_px + d;
        const int other = std::max(x - shift, 0);
        int differing = 0;
        for (int k = 3 * y; k < 3 * y + 3; ++k) {
          differing += std::popcount(static_cast<unsigned>(images_.left_census(x, k)) ^
                                     images_.right_census(other, k));
        }
        int sum = 0;
        for (int j = -1; j <= 1; ++j) {
          const int v = std::clamp(y + j, 0, height_ - 1);
          for (int i = -2; i <= 2; ++i) {
            sum += std::abs(images_.left_edges(std::clamp(x + i, 0, width_ - 1), v) -
                            images_.right_edges(std::clamp(x + i - shift, 0, width_ - 1), v));
          }
        }
        cost[at(x) + static_cast<std::size_t>(d)] =
            differing + std::min(kSgmLargestEdgeCost, sum / 8);
      }
    }
    return cost;
  }

  // One pixel of a path: from `before`, the pixel before it on the path (null: it is the first).
  void step(const int* cost, const int* before, int* out) const {
    if (before == nullptr) {
      std::copy(cost, cost + range_, out);
      return;
    }
    const int least = *std::min_element(before, before + range_);
    for (int d = 0; d < range_; ++d) {
      int cheapest = std::min(before[d], least + options_.p2);
      if (d > 0) cheapest = std::min(cheapest, before[d - 1] + options_.p1);
      if (d + 1 < range_) cheapest = std::min(cheapest, before[d + 1] + options_.p1);
      out[d] = cost[d] + cheapest - least;
    }
  }

  // Adds the path that comes from (-dx, -dy) to the sums of all pixels.
  void follow(const std::vector<std::vector<int>>& cost, int dx, int dy,
              std::vector<std::vector<int>>& sum) const {
    std::vector<int> before(at(width_)), here(before.size());
    for (int j = 0; j < height_; ++j) {
      const auto y = static_cast<std::size_t>(dy < 0 ? height_ - 1 - j : j);
      for (int i = 0; i < width_; ++i) {
        const int x = dx < 0 ? width_ - 1 - i : i, from = x - dx;
        const bool first = from < 0 || from >= width_ || (dy != 0 && j == 0);
        const int* path = first ? nullptr : dy == 0 ? &here[at(from)] : &before[at(from)];
        step(&cost[y][at(x)], path, &here[at(x)]);
      }
      for (std::size_t k = 0; k < here.size(); ++k) sum[y][k] += here[k];
      std::swap(before, here);
    }
  }

  void choose(const std::vector<int>& sum, Disparity* out, std::uint8_t* residual) const {
    struct Winner {
      int index = -1;
      int cost = 0;
    };
    std::vector<Winner> winners(static_cast<std::size_t>(width_)), owners(winners.size());
    std::fill(out, out + width_, kNoMatch);
    const int min_disparity = options_.min_disparity_px;
    for (int x = min_disparity; x < width_; ++x) {
      const int* s = &sum[at(x)];
      const int fit = std::min(range_, x - min_disparity + 1);
      const int index = static_cast<int>(std::min_element(s, s + fit) - s);
      winners[static_cast<std::size_t>(x)] = {index, s[index]};
      Winner& owner = owners[static_cast<std::size_t>(x - min_disparity - index)];
      if (owner.index < 0 || s[index] < owner.cost) owner = {index, s[index]};
      if (unique(s, fit, index)) out[x] = refined(s, fit, index);
    }
    for (int x = min_disparity; options_.left_right_tolerance_px >= 0 && x < width_; ++x) {
      const int index = winners[static_cast<std::size_t>(x)].index;
      const int back = owners[static_cast<std::size_t>(x - min_disparity - index)].index;
      if (std::abs(back - index) > options_.left_right_tolerance_px) out[x] = kNoMatch;
    }
    for (int x = 0; residual != nullptr && x < width_; ++x) {
      const int fit = std::min(range_, x - min_disparity + 1);
      residual[x] = out[x] == kNoMatch
                        ? kNoResidual
                        : rate(&sum[at(x)], fit, winners[static_cast<std::size_t>(x)].index);
    }
  }

  [[nodiscard]] std::uint8_t rate(const int* s, int fit, int index) const {
    if (index == 0 || index == fit - 1) return kLargestResidual;
    return residual_of(s[index], std::max(s[index - 1], s[index + 1]) - s[index]);
  }

  [[nodiscard]] bool unique(const int* s, int fit, int index) const {
    if (options_.uniqueness_percent <= 0) return true;
    const int margin = s[index] * uniqueness_factor(options_.uniqueness_percent) >> 16;
    for (int d = 0; d < fit; ++d) {
      if (std::abs(d - index) > 1 && s[d] <= s[index] + margin) return false;
    }
    return true;
  }

  [[nodiscard]] Disparity refined(const int* s, int fit, int index) const {
    const auto whole =
        static_cast<Disparity>((options_.min_disparity_px + index) * kDisparityScale);
    if (index == 0 || index == fit - 1) return options_.strict_sub_pixel ? kNoMatch : whole;
    const int l = s[index - 1], c = s[index], r = s[index + 1];
    if (options_.strict_sub_pixel && (l <= c || r <= c)) return kNoMatch;
    int divisor = 0;
    if (options_.sub_pixel == SubPixel::kSymmetricV) divisor = std::max(l, r) - c;
    if (options_.sub_pixel == SubPixel::kParabola) divisor = l + r - 2 * c;
    if (divisor <= 0) return whole;
    const double steps = static_cast<double>(l - r) * kDisparityScale / (2.0 * divisor);
    return static_cast<Disparity>(whole + std::lrint(steps));
  }

  const SgmImages& images_;
  const SgmOptions& options_;
  int width_;
  int height_;
  int range_;
};

}  // namespace

void census_row_plain(ImageView<const std::uint8_t> image, int y, Image<std::uint8_t>& census) {
  for (int x = 0; x < image.width; ++x) {
    unsigned bits = 0;
    for (int j = -2; j <= 2; ++j) {
      for (int i = -2; i <= 2; ++i) {
        if (i == 0 && j == 0) continue;
        const int neighbour =
            image(std::clamp(x + i, 0, image.width - 1), std::clamp(y + j, 0, image.height - 1));
        bits = bits << 1 | (neighbour < image(x, y) ? 1U : 0U);
      }
    }
    for (int k = 0; k < 3; ++k) {
      census(x, 3 * y + k) = static_cast<std::uint8_t>(bits >> (16 - 8 * k));
    }
  }
}

void match_sgm_plain(const SgmImages& images, const SgmOptions& options, const MatchOutput& out) {
  PlainSgm(images, options).match(out);
}

}  // namespace tread
