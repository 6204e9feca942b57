#include "tread/stereo/disparity_range.hpp"

#include <gtest/gtest.h>

#include "tread/stereo/test_images.hpp"

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

TEST(DisparityRange, WithoutTextureTheLeastAndNeverWiderThanTheImage) {
  const Image<std::uint8_t> wall(640, 480, 77), strip(20, 5, 3), dot(1, 1, 3);
  EXPECT_EQ(*estimate_num_disparities(wall, wall, {}), 64);
  EXPECT_EQ(*estimate_num_disparities(strip, strip, {}), 20);
  EXPECT_EQ(*estimate_num_disparities(dot, dot, {}), 1);
  EXPECT_FALSE(estimate_num_disparities(wall, strip, {}));
  EXPECT_FALSE(estimate_num_disparities({}, {}, {}));
}

}  // namespace
}  // namespace tread
