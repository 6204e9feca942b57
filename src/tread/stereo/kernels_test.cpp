// The vectorised kernels against their plain forms, bit for bit, on every instruction set that this
// machine has. The images are exactly as large as their pixels, so that a sanitizer sees a read
// behind them.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <string>
#include <vector>

#include "instruction_sets.hpp"
#include "tread/stereo/edge_image.hpp"
#include "tread/stereo/filter_kernel.hpp"
#include "tread/stereo/hole_filter.hpp"
#include "tread/stereo/sad_plain.hpp"
#include "tread/stereo/sgm_matcher.hpp"
#include "tread/stereo/sgm_plain.hpp"

namespace tread {
namespace {

using testing::on_every_target;

// Pixels without a byte to spare behind them.
template <class T>
struct Tight {
  Tight(int w, int h, std::ptrdiff_t row_stride)
      : width(w),
        height(h),
        stride(row_stride),
        pixels(static_cast<std::size_t>(stride * (h - 1) + w)) {}
  [[nodiscard]] ImageView<const T> view() const { return {pixels.data(), width, height, stride}; }
  int width, height;
  std::ptrdiff_t stride;
  std::vector<T> pixels;
};

struct Case {
  int width = 0, height = 0, spread = 0;
  SadOptions options;
  unsigned seed = 0;
};

std::ostream& operator<<(std::ostream& out, const Case& c) {
  return out << c.width << "x" << c.height << " window " << c.options.window_width_px << "x"
             << c.options.window_height_px << " disparities " << c.options.min_disparity_px << "+"
             << c.options.num_disparities << " spread " << c.spread << " seed " << c.seed;
}

// Noise on steps: costs tie, checks pass and fail.
Tight<std::uint8_t> blocks(const Case& c, unsigned seed) {
  std::mt19937 random(seed);
  Tight<std::uint8_t> image(c.width, c.height, c.width + static_cast<int>(random() % 3));
  const auto range = static_cast<std::uint32_t>(c.spread) + 1;
  std::uint32_t level = 0;
  for (auto& pixel : image.pixels) {
    if (random() % 4 == 0) level = static_cast<std::uint32_t>(random() % range);
    pixel = static_cast<std::uint8_t>(128 - c.spread / 2 + static_cast<int>(level));
  }
  return image;
}

void expect_equal_to_plain(const Case& c) {
  const Tight<std::uint8_t> reference = blocks(c, c.seed), other = blocks(c, c.seed + 1000);
  SadImages images{reference.view(), other.view(), c.options.reference == Reference::kRight,
                   c.spread};
  // One of both images shifted, so that there is something to find.
  Tight<std::uint8_t> shifted = other;
  const int shift = c.options.min_disparity_px + c.options.num_disparities / 2;
  const int sign = images.mirrored ? 1 : -1;
  for (int y = 0; y < c.height; ++y) {
    for (int x = 0; x < c.width; ++x) {
      const int to = x + sign * shift;
      if (to < 0 || to >= c.width || (x / 16 + y / 8) % 3 == 0) continue;
      shifted.pixels[static_cast<std::size_t>(y * shifted.stride + to)] =
          reference.pixels[static_cast<std::size_t>(y * reference.stride + x)];
    }
  }
  images.other = shifted.view();
  Image<Disparity> expected(c.width, c.height, 1), found(c.width, c.height, 2);
  Image<std::uint8_t> expected_residual(c.width, c.height, 1), residual(c.width, c.height, 2);
  match_rows_plain(images, c.options, 0, c.height, {expected, expected_residual});
  Image<std::uint8_t> memory;
  const int middle = c.height / 2;
  match_rows(images, c.options, 0, middle, memory, {found, residual});
  match_rows(images, c.options, middle, c.height, memory, {found, residual});
  ASSERT_TRUE(found == expected) << c;
  ASSERT_TRUE(residual == expected_residual) << c;
}

Case random_case(unsigned seed) {
  std::mt19937 random(seed);
  const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  const auto choose = [&](auto... values) {
    const std::array all{values...};
    return all[static_cast<std::size_t>(below(static_cast<int>(all.size())))];
  };
  Case c;
  c.seed = seed;
  c.width = choose(1, 2, 7, 33, 64, 90, 131, 200);
  c.height = 1 + below(24);
  c.spread = choose(3, 30, 30, 60, 127, 255);
  SadOptions& o = c.options;
  o.window_width_px = 1 + 2 * below(16);
  o.window_height_px = 1 + 2 * below(16);
  while (o.window_width_px * o.window_height_px * c.spread > kLargestKernelSum) c.spread /= 2;
  o.min_disparity_px = below(std::min(c.width, 20));
  o.num_disparities = 1 + below(c.width - o.min_disparity_px);
  o.reference = choose(Reference::kLeft, Reference::kRight);
  o.reduced_range_at_border = below(3) > 0;
  o.sub_pixel = choose(SubPixel::kNone, SubPixel::kSymmetricV, SubPixel::kParabola);
  o.sub_pixel_steps = choose(1, 3, 4, 6, 16, 64);
  o.strict_sub_pixel = below(2) == 0;
  o.uniqueness_percent = choose(0, 1, 15, 100);
  o.left_right_tolerance_px = below(4) - 1;
  return c;
}

TEST(SadKernel, EqualsThePlainFormOnEveryInstructionSet) {
  on_every_target([] {
    for (unsigned seed = 1; seed <= 250; ++seed) {
      expect_equal_to_plain(random_case(seed));
      if (::testing::Test::HasFatalFailure()) return;
    }
  });
}

TEST(SadKernel, EqualsThePlainFormOnWideImagesAndRanges) {
  std::vector<Case> cases;
  for (const auto& [width, disparities] : {std::pair{4096, 70}, {4096, 256}, {1500, 1000}}) {
    Case c;
    c.width = width;
    c.height = 3;
    c.spread = 30;
    c.seed = static_cast<unsigned>(disparities);
    c.options.num_disparities = disparities;
    cases.push_back(c);
    c.options.window_width_px = c.options.window_height_px = 31;
    c.options.uniqueness_percent = 5;
    cases.push_back(c);
  }
  on_every_target([&] {
    for (const Case& c : cases) {
      expect_equal_to_plain(c);
      if (::testing::Test::HasFatalFailure()) return;
    }
  });
}

// Costs so large that the margin of uniqueness does not fit a byte.
TEST(SadKernel, UniquenessOfLargeCosts) {
  Case c;
  c.width = 120;
  c.height = 9;
  c.spread = 255;
  c.options.window_width_px = c.options.window_height_px = 11;
  c.options.num_disparities = 40;
  for (int percent : {1, 5, 20, 100}) {
    c.options.uniqueness_percent = percent;
    c.seed = static_cast<unsigned>(percent);
    on_every_target([&] { expect_equal_to_plain(c); });
  }
}

using DisparityAndResidual = std::pair<Image<Disparity>, Image<std::uint8_t>>;

DisparityAndResidual sgm_plain(ImageView<const std::uint8_t> left,
                               ImageView<const std::uint8_t> right,
                               ImageView<const std::uint8_t> left_edges,
                               ImageView<const std::uint8_t> right_edges,
                               const SgmOptions& options) {
  const int width = left.width, height = left.height;
  Image<std::uint8_t> left_census(width, 3 * height), right_census(width, 3 * height);
  for (int y = 0; y < height; ++y) {
    census_row_plain(left, y, left_census);
    census_row_plain(right, y, right_census);
  }
  DisparityAndResidual made{{width, height}, {width, height}};
  match_sgm_plain({left_edges, right_edges, left_census, right_census}, options,
                  {made.first, made.second});
  return made;
}

// A pair and its edges with patches shifted by different disparities, of random size and options.
struct SgmCase {
  int width = 0, height = 0;
  SgmOptions options;
  unsigned seed = 0;
};

void expect_sgm_equal_to_plain(const SgmCase& c) {
  Case sizes;
  sizes.width = c.width;
  sizes.height = c.height;
  sizes.spread = 200;
  const Tight<std::uint8_t> left = blocks(sizes, c.seed);
  Tight<std::uint8_t> right = blocks(sizes, c.seed + 1000);
  for (int y = 0; y < c.height; ++y) {
    for (int x = 0; x < c.width; ++x) {
      const int to = x - c.options.min_disparity_px - c.options.num_disparities / (2 + y / 8 % 3);
      if (to < 0 || (x / 16 + y / 8) % 4 == 0) continue;
      right.pixels[static_cast<std::size_t>(y * right.stride + to)] =
          left.pixels[static_cast<std::size_t>(y * left.stride + x)];
    }
  }
  Image<std::uint8_t> left_edges, right_edges;
  edge_image(left.view(), {}, left_edges);
  edge_image(right.view(), {}, right_edges);
  const auto match = [&](int threads) {
    SgmMatcher matcher;
    Image<Disparity> found(c.width, c.height, 2);
    Image<std::uint8_t> residual(c.width, c.height, 2);
    Context context;
    context.threads = threads;
    matcher.match(left.view(), right.view(), left_edges, right_edges, c.options, found, &residual,
                  context);
    return std::pair(std::move(found), std::move(residual));
  };
  const auto expected = sgm_plain(left.view(), right.view(), left_edges, right_edges, c.options);
  on_every_target([&] {
    ASSERT_TRUE(match(1) == expected)
        << c.width << "x" << c.height << " disparities " << c.options.min_disparity_px << "+"
        << c.options.num_disparities << " seed " << c.seed;
    ASSERT_TRUE(match(2) == expected);
  });
  if (c.width > 60 && c.options.num_disparities > 4) {
    EXPECT_GT(disparity_density(expected.first), 0.02) << c.seed << " tests nothing";
  }
}

TEST(SgmKernel, EqualsThePlainFormOnEveryInstructionSetAndThreadCount) {
  for (unsigned seed = 1; seed <= 90; ++seed) {
    std::mt19937 random(seed);
    const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
    SgmCase c;
    c.seed = seed;
    const std::array widths{1, 2, 15, 33, 64, 90, 131, 200, 400};
    c.width = widths[static_cast<std::size_t>(below(9))];
    c.height = 1 + below(30);
    c.options.min_disparity_px = below(std::min(c.width, 12));
    c.options.num_disparities = 1 + below(std::min(300, c.width - c.options.min_disparity_px));
    c.options.paths = std::array{SgmPaths::kThree, SgmPaths::kFour, SgmPaths::kEight}[seed % 3];
    c.options.p2 = below(50);
    c.options.p1 = below(c.options.p2 + 1);
    c.options.uniqueness_percent = std::array{0, 4, 30, 100}[static_cast<std::size_t>(below(4))];
    c.options.left_right_tolerance_px = below(4) - 1;
    c.options.strict_sub_pixel = below(2) == 0;
    c.options.sub_pixel = below(2) == 0 ? SubPixel::kSymmetricV : SubPixel::kParabola;
    expect_sgm_equal_to_plain(c);
    if (::testing::Test::HasFailure()) return;
  }
}

// Costs as large as they get: an image against its negative.
TEST(SgmKernel, EqualsThePlainFormWhereNothingFits) {
  for (const int range : {5, 16, 33, 65}) {
    for (const auto& chosen : std::array<std::pair<int, SgmPaths>, 3>{
             {{20, SgmPaths::kThree}, {49, SgmPaths::kThree}, {49, SgmPaths::kEight}}}) {
      const int p1 = chosen.first;
      const SgmPaths paths = chosen.second;
      std::mt19937 random(static_cast<unsigned>(range + p1));
      Image<std::uint8_t> left(200, 40), right(200, 40), left_edges, right_edges;
      for (int y = 0; y < left.height; ++y) {
        for (int x = 0; x < left.width; ++x) {
          left(x, y) = static_cast<std::uint8_t>(random());
          right(x, y) = static_cast<std::uint8_t>(255 - left(x, y));
        }
      }
      edge_image(left, {}, left_edges);
      edge_image(right, {}, right_edges);
      SgmOptions options;
      options.num_disparities = range;
      options.p1 = p1;
      options.paths = paths;
      options.uniqueness_percent = 100;
      options.left_right_tolerance_px = -1;
      const auto match = [&] {
        SgmMatcher matcher;
        Image<Disparity> found;
        matcher.match(left, right, left_edges, right_edges, options, found);
        return found;
      };
      const Image<Disparity> expected =
          sgm_plain(left, right, left_edges, right_edges, options).first;
      on_every_target([&] { ASSERT_TRUE(match() == expected) << range << " " << p1; });
    }
  }
}

TEST(GradientRow, EqualsItsDefinitionOnEveryInstructionSet) {
  on_every_target([] {
    for (int width : {1, 2, 3, 31, 32, 33, 65, 1023, 1024, 1025, 1056, 2050, 4096}) {
      for (int limit : {1, 15, 127, 128}) {
        std::mt19937 random(static_cast<unsigned>(width));
        std::array<std::vector<std::uint8_t>, 3> rows;
        for (auto& row : rows) {
          row.resize(static_cast<std::size_t>(width));
          for (auto& pixel : row) pixel = static_cast<std::uint8_t>(random());
        }
        std::vector<std::uint8_t> out(static_cast<std::size_t>(width));
        gradient_row(rows[0].data(), rows[1].data(), rows[2].data(), width, limit, out.data());
        for (int x = 0; x < width; ++x) {
          const auto l = static_cast<std::size_t>(std::max(x - 1, 0));
          const auto r = static_cast<std::size_t>(std::min(x + 1, width - 1));
          const int response =
              rows[0][r] - rows[0][l] + 2 * (rows[1][r] - rows[1][l]) + rows[2][r] - rows[2][l];
          const int expected = 128 + std::clamp(response, -limit, std::min(limit, 127));
          ASSERT_EQ(out[static_cast<std::size_t>(x)], expected) << width << " " << x;
        }
      }
    }
  });
}

// All rules on images of many sizes: what is known stays, holes take the previous frame's value, or
// else the median of their neighbourhood.
TEST(FillHoles, EqualsItsDefinitionOnEveryInstructionSetAndThreadCount) {
  using O = HoleFilterOptions;
  std::vector<O> rules(7);
  rules[0].median = rules[1].median = O::Median::kAll;
  rules[0].max_spread_px = rules[2].max_spread_px = 0.0;
  rules[1].max_spread_px = 5.0;
  rules[2].min_known = 1;
  rules[3].min_known = 3;
  rules[4].max_spread_px = 2.0;
  rules[5].min_known = 6;
  rules[6].min_known = 8;
  const auto filled = [](const Image<Disparity>& image, int x, int y, const O& o) {
    std::vector<Disparity> known;
    for (int v = std::max(0, y - 1); v <= std::min(image.height - 1, y + 1); ++v) {
      for (int u = std::max(0, x - 1); u <= std::min(image.width - 1, x + 1); ++u) {
        if (image(u, v) != kNoMatch) known.push_back(image(u, v));
      }
    }
    const bool all = o.median == O::Median::kAll;
    if (known.size() < static_cast<std::size_t>(all ? 5 : o.min_known)) return kNoMatch;
    std::sort(known.begin(), known.end());
    const double spread_px = disparity_px(known.back()) - disparity_px(known.front());
    if (o.max_spread_px > 0.0 && spread_px > o.max_spread_px) return kNoMatch;
    return known[all ? 4 : known.size() / 2];
  };
  on_every_target([&] {
    for (const int width : {1, 2, 5, 63, 64, 65, 130, 300}) {
      for (std::size_t rule = 0; rule < rules.size(); ++rule) {
        std::mt19937 random(static_cast<unsigned>(width) + static_cast<unsigned>(rule));
        O options = rules[rule];
        options.temporal = random() % 2 == 0;
        const unsigned holes = 2 + random() % 4, levels = random() % 2 == 0 ? 0xFFFF : 300;
        const auto random_image = [&] {
          Image<Disparity> image(width, 70);
          for (int y = 0; y < image.height; ++y) {
            for (int x = 0; x < width; ++x) {
              image(x, y) =
                  random() % holes == 0 ? kNoMatch : static_cast<Disparity>(random() % levels);
            }
          }
          return image;
        };
        HoleFilter filter;
        Context context;
        context.threads = 1 + static_cast<int>(random() % 2);
        const Image<Disparity> before = random_image(), now = random_image();
        Image<Disparity> image = before;
        filter.apply(image, options, context);
        image = now;
        filter.apply(image, options, context);
        for (int y = 0; y < now.height; ++y) {
          for (int x = 0; x < width; ++x) {
            Disparity expected = now(x, y);
            if (expected == kNoMatch && options.temporal) expected = before(x, y);
            if (expected == kNoMatch) expected = filled(now, x, y, options);
            ASSERT_EQ(image(x, y), expected) << width << " rule " << rule << " " << x << " " << y;
          }
        }
      }
    }
  });
}

TEST(LinkRow, EqualsItsDefinitionOnEveryInstructionSet) {
  on_every_target([] {
    for (int width : {1, 2, 63, 64, 65, 127, 128, 200}) {
      for (int limit : {0, 32, 4096}) {
        std::mt19937 random(static_cast<unsigned>(width + limit));
        std::array<std::vector<Disparity>, 2> rows;
        for (auto& row : rows) {
          row.resize(static_cast<std::size_t>(width));
          for (auto& d : row) {
            d = random() % 4 == 0 ? kNoMatch : static_cast<Disparity>(65400 + random() % 72);
          }
        }
        const auto near = [limit](int a, int b) {
          return a != kNoMatch && b != kNoMatch && std::abs(a - b) <= limit;
        };
        for (const bool with_above : {false, true}) {
          const std::size_t words = (static_cast<std::size_t>(width) + 63) / 64;
          std::vector<std::uint64_t> known(words, ~0ULL), left(words, ~0ULL), above(words, ~0ULL);
          link_row(with_above ? rows[0].data() : nullptr, rows[1].data(), width, limit,
                   known.data(), left.data(), above.data());
          for (std::size_t x = 0; x < words * 64; ++x) {
            const bool inside = x < rows[1].size();
            const auto bit = [x](const auto& bits) { return (bits[x / 64] >> (x % 64) & 1U) != 0; };
            ASSERT_EQ(bit(known), inside && rows[1][x] != kNoMatch) << width << " " << x;
            ASSERT_EQ(bit(left), inside && x > 0 && near(rows[1][x - 1], rows[1][x]));
            ASSERT_EQ(bit(above), inside && with_above && near(rows[0][x], rows[1][x]));
          }
        }
      }
    }
  });
}

}  // namespace
}  // namespace tread
