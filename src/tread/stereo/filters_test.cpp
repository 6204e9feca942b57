#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <random>
#include <utility>
#include <vector>

#include "tread/stereo/hole_filter.hpp"
#include "tread/stereo/speckle_filter.hpp"

namespace tread {
namespace {

using O = HoleFilterOptions;
constexpr Disparity X = kNoMatch;

Image<Disparity> image(std::vector<std::vector<Disparity>> rows) {
  Image<Disparity> out(static_cast<int>(rows[0].size()), static_cast<int>(rows.size()));
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) {
      out(x, y) = rows[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)];
    }
  }
  return out;
}

// Paper Q, IV-A.2, the median of nine with "no match" as the largest: five known neighbours fill a
// hole with the fifth smallest, the largest of them; four do not.
// The paper's filter: of the readings the first of each.
O as_the_paper() {
  O options;
  options.median = O::Median::kAll;
  options.max_spread_px = 0.0;
  return options;
}

TEST(HoleFilter, MedianOfNineNeedsFiveNeighboursAndTakesTheFifth) {
  HoleFilter filter;
  Image<Disparity> five = image({{10, 20, 30}, {40, X, 50}, {X, X, X}});
  filter.apply(five, as_the_paper());
  EXPECT_EQ(five(1, 1), 50);
  Image<Disparity> four = image({{10, 20, 30}, {40, X, X}, {X, X, X}});
  filter.apply(four, as_the_paper());
  EXPECT_EQ(four(1, 1), X);
  Image<Disparity> all = image({{10, 20, 30}, {40, X, 50}, {60, 70, 80}});
  filter.apply(all, as_the_paper());
  EXPECT_EQ(all(1, 1), 50);
}

TEST(HoleFilter, MedianOfTheKnownIgnoresTheUnknown) {
  HoleFilter filter;
  O options;
  options.median = O::Median::kKnown;
  options.min_known = 3;
  Image<Disparity> three = image({{10, 20, 30}, {X, X, X}, {X, X, X}});
  filter.apply(three, options);
  EXPECT_EQ(three(1, 1), 20);
  Image<Disparity> even = image({{10, 20, 30}, {40, X, X}, {X, X, X}});
  filter.apply(even, options);
  EXPECT_EQ(even(1, 1), 30);
  Image<Disparity> two = image({{10, 20, X}, {X, X, X}, {X, X, X}});
  filter.apply(two, options);
  EXPECT_EQ(two(1, 1), X);
}

// Between the near side and the far side of an edge there is nothing to tell which a hole is of.
TEST(HoleFilter, DepthEdgesStayHoles) {
  HoleFilter filter;
  O options;
  options.max_spread_px = 0.7;  // 44.8 steps
  Image<Disparity> within = image({{10, 10, 55}, {10, X, 55}, {10, 10, 55}});
  filter.apply(within, options);
  EXPECT_EQ(within(1, 1), 10);
  Image<Disparity> beyond = image({{10, 10, 56}, {10, X, 56}, {10, 10, 56}});
  filter.apply(beyond, options);
  EXPECT_EQ(beyond(1, 1), X);
  options.max_spread_px = 0.0;
  filter.apply(beyond, options);
  EXPECT_EQ(beyond(1, 1), 10);
}

TEST(HoleFilter, InPlaceSpreadsWithinAPassAndBufferedDoesNot) {
  // The hole at (1, 1) fills; the one at (2, 1) has four neighbours, five once (1, 1) is filled.
  const Image<Disparity> start = image({{5, 5, 5, X}, {5, X, X, X}, {5, 5, 5, X}});
  HoleFilter filter;
  Image<Disparity> buffered = start;
  filter.apply(buffered, {});
  EXPECT_EQ(buffered(1, 1), 5);
  EXPECT_EQ(buffered(2, 1), X);
  O options;
  options.update = O::Update::kInPlace;
  Image<Disparity> in_place = start;
  filter.apply(in_place, options);
  EXPECT_EQ(in_place(1, 1), 5);
  EXPECT_EQ(in_place(2, 1), 5);
  options = {};
  options.passes = 2;
  Image<Disparity> twice = start;
  filter.apply(twice, options);
  EXPECT_EQ(twice(2, 1), 5);
}

TEST(HoleFilter, PreviousFrameComesFirst) {
  HoleFilter filter;
  O options;
  options.temporal = true;
  Image<Disparity> first = image({{1, 1, 1}, {1, 77, 1}, {1, 1, 1}});
  filter.apply(first, options);
  Image<Disparity> second = image({{9, 9, 9}, {9, X, 9}, {9, 9, 9}});
  filter.apply(second, options);
  EXPECT_EQ(second(1, 1), 77);  // and not the median, 9
}

TEST(HoleFilter, RawPreviousLivesOneFrameFilteredForEver) {
  for (auto [previous, third] :
       {std::pair{O::Previous::kRaw, X}, std::pair{O::Previous::kFiltered, Disparity{77}}}) {
    HoleFilter filter;
    O options;
    options.temporal = true;
    options.spatial = false;
    options.previous = previous;
    Image<Disparity> frame = image({{77}});
    filter.apply(frame, options);
    frame = image({{X}});
    filter.apply(frame, options);
    EXPECT_EQ(frame(0, 0), 77);
    frame = image({{X}});
    filter.apply(frame, options);
    EXPECT_EQ(frame(0, 0), third);
  }
}

TEST(HoleFilter, ForgetsThePreviousFrameOnResetAndOnAChangeOfSize) {
  HoleFilter filter;
  O options;
  options.temporal = true;
  Image<Disparity> frame = image({{7, 7}});
  filter.apply(frame, options);
  Image<Disparity> other = image({{X}, {X}});
  filter.apply(other, options);
  EXPECT_EQ(other(0, 0), X);
  frame = image({{7, 7}});
  filter.apply(frame, options);
  filter.reset();
  frame = image({{X, X}});
  filter.apply(frame, options);
  EXPECT_EQ(frame(0, 0), X);
}

// Flood fill from every pixel, as the definition says.
Image<Disparity> speckle_oracle(Image<Disparity> in, int max_size, int max_difference) {
  Image<int> seen(in.width, in.height, 0);
  Image<Disparity> out = in;
  for (int y = 0; y < in.height; ++y) {
    for (int x = 0; x < in.width; ++x) {
      if (in(x, y) == kNoMatch || seen(x, y) != 0) continue;
      std::vector<std::pair<int, int>> patch = {{x, y}};
      seen(x, y) = 1;
      for (std::size_t i = 0; i < patch.size(); ++i) {
        const auto [px, py] = patch[i];
        const std::pair<int, int> next[] = {{px + 1, py}, {px - 1, py}, {px, py + 1}, {px, py - 1}};
        for (const auto& [u, v] : next) {
          if (u < 0 || v < 0 || u >= in.width || v >= in.height || seen(u, v) != 0) continue;
          if (in(u, v) == kNoMatch || std::abs(in(u, v) - in(px, py)) > max_difference) continue;
          seen(u, v) = 1;
          patch.emplace_back(u, v);
        }
      }
      if (static_cast<int>(patch.size()) > max_size) continue;
      for (const auto& [u, v] : patch) out(u, v) = kNoMatch;
    }
  }
  return out;
}

TEST(SpeckleFilter, EqualsFloodFill) {
  std::mt19937 random(17);
  SpeckleFilter filter;
  for (int round = 0; round < 60; ++round) {
    // Some rounds wider than a word of bits and higher than a band of rows.
    const unsigned scale = round % 4 == 0 ? 4 : 1;
    Image<Disparity> noisy(1 + static_cast<int>(random() % (60 * scale)),
                           1 + static_cast<int>(random() % (40 * scale)));
    const unsigned levels = 2 + random() % 4, holes = random() % 4;
    for (int y = 0; y < noisy.height; ++y) {
      for (int x = 0; x < noisy.width; ++x) {
        noisy(x, y) =
            random() % 10 < holes ? kNoMatch : static_cast<Disparity>(40 * (random() % levels));
      }
    }
    for (int size : {0, 1, 7, 60}) {
      // 0.7 px are 44.8 steps: 40 joins, 80 does not. 0.625 px are 40: the limit itself joins.
      for (const auto& [px, steps] : {std::pair(0.7, 45), {0.625, 40}, {0.61, 39}}) {
        Image<Disparity> filtered = noisy;
        filter.apply(filtered, {true, size, px});
        EXPECT_TRUE(filtered == speckle_oracle(noisy, size, steps)) << round << " " << size;
      }
    }
  }
}

TEST(SpeckleFilter, OffLeavesEverything) {
  Image<Disparity> one = image({{5, X}, {X, X}});
  SpeckleFilter filter;
  filter.apply(one, {false, 100, 1.0});
  EXPECT_EQ(one(0, 0), 5);
  filter.apply(one, {true, 1, 1.0});
  EXPECT_EQ(one(0, 0), X);
}

}  // namespace
}  // namespace tread
