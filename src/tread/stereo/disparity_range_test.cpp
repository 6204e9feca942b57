#include "tread/stereo/disparity_range.hpp"

#include <gtest/gtest.h>

#include <utility>

#include "stereo_images.hpp"

namespace tread {
namespace {

TEST(DisparityRange, CoversTheSceneWithAMarginAndNotMuchMore) {
  for (double largest : {20.0, 90.0, 200.0}) {
    // Coarse texture, so that something is left of it at a quarter of the size.
    const testing::Texture texture(3);
    Image<std::uint8_t> left(900, 160), right(900, 160);
    for (int y = 0; y < 160; ++y) {
      for (int x = 0; x < 900; ++x) {
        const double d = x < 450 ? 10.0 : largest;
        left(x, y) = static_cast<std::uint8_t>(texture((x - d) / 5.0, y / 5.0));
        right(x, y) = static_cast<std::uint8_t>(texture(x / 5.0, y / 5.0));
      }
    }
    const auto range = estimate_num_disparities(left, right, {});
    ASSERT_TRUE(range);
    EXPECT_GE(*range, std::max(64.0, largest + 1));
    EXPECT_LE(*range, std::max(64.0, 1.6 * largest + 16));
    EXPECT_EQ(*range % 16, 0);
  }
}

TEST(DisparityRange, CountsFromTheFirstDisparitySearched) {
  const testing::Pair pair = testing::textured_pair(640, 120, 5, [](int, int) { return 100.0; });
  const int from_zero = *estimate_num_disparities(pair.left, pair.right, {});
  StereoOptions options;
  options.sad.min_disparity_px = 48;
  EXPECT_EQ(*estimate_num_disparities(pair.left, pair.right, options),
            std::max(64, from_zero - 48));
  options.sad.min_disparity_px = 600;  // what is left of the image
  EXPECT_LE(*estimate_num_disparities(pair.left, pair.right, options), 40);
}

// Its stages are not those of the frames: they would spoil the means.
TEST(DisparityRange, IsTimedAsAStageOfItsOwn) {
  Timings timings;
  Context context;
  context.timings = &timings;
  const Image<std::uint8_t> wall(640, 480, 77);
  ASSERT_TRUE(estimate_num_disparities(wall, wall, {}, context));
  ASSERT_EQ(timings.entries().size(), 1U);
  EXPECT_EQ(timings.entries().begin()->first, "stereo/range");
  EXPECT_EQ(timings.entries().begin()->second.calls, 1);
}

// A pair of one disparity in its first rows, without texture in the others.
std::pair<Image<std::uint8_t>, Image<std::uint8_t>> pair_of(int disparity_px, int width, int rows) {
  const testing::Texture texture(5);
  Image<std::uint8_t> left(width, 160, 90), right(width, 160, 90);
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < width; ++x) {
      left(x, y) = static_cast<std::uint8_t>(texture((x - disparity_px) / 5.0, y / 5.0));
      right(x, y) = static_cast<std::uint8_t>(texture(x / 5.0, y / 5.0));
    }
  }
  return {std::move(left), std::move(right)};
}

// What is seen, a quarter more, and up to the next 16: 100, 125, 128.
TEST(DisparityRange, OfOneDisparityIsAQuarterMore) {
  const auto [left, right] = pair_of(100, 600, 160);
  EXPECT_EQ(*estimate_num_disparities(left, right, {}), 128);
}

TEST(DisparityRange, AFewMatchesSayNothing) {
  const auto [left, right] = pair_of(100, 320, 4);
  StereoOptions options;
  options.speckle.enabled = false;
  options.sad.window_width_px = options.sad.window_height_px = 3;
  EXPECT_EQ(*estimate_num_disparities(left, right, options), 64);
}

TEST(DisparityRange, WithoutTextureTheLeastAndNeverWiderThanTheImage) {
  const Image<std::uint8_t> wall(640, 480, 77), strip(20, 5, 3), dot(1, 1, 3);
  EXPECT_EQ(*estimate_num_disparities(wall, wall, {}), 64);
  EXPECT_EQ(*estimate_num_disparities(strip, strip, {}), 20);
  EXPECT_EQ(*estimate_num_disparities(dot, dot, {}), 1);
  EXPECT_FALSE(estimate_num_disparities(wall, strip, {}));
  EXPECT_FALSE(estimate_num_disparities({}, {}, {}));
}

// At a quarter of its width such a pair is still wider than any search.
TEST(DisparityRange, VeryWidePairsAreNoError) {
  const testing::Pair pair = testing::textured_pair(8200, 24, 3, [](int, int) { return 60.0; });
  StereoOptions options;
  const auto needed = estimate_num_disparities(pair.left, pair.right, options);
  ASSERT_TRUE(needed) << needed.error().message();
  EXPECT_GE(*needed, 61);
  EXPECT_LE(*needed, 96);
}

}  // namespace
}  // namespace tread
