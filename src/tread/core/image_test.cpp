#include "tread/core/image.hpp"

#include <gtest/gtest.h>

#include "tread/core/shrink.hpp"

namespace tread {
namespace {

TEST(Image, RowsAreAlignedAndHoldTheFill) {
  for (int width : {1, 63, 64, 65, 641}) {
    Image<std::uint8_t> image(width, 5, 7);
    for (int y = 0; y < 5; ++y) {
      EXPECT_EQ(reinterpret_cast<std::uintptr_t>(image.row(y)) % 64, 0U);
      for (int x = 0; x < width; ++x) EXPECT_EQ(image(x, y), 7);
    }
  }
  Image<float> floats(17, 3);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(floats.row(2)) % 64, 0U);
}

TEST(Image, CopiesAreDeepAndMovesLeaveNothingShared) {
  Image<int> a(3, 2, 1);
  Image<int> b = a;
  b(0, 0) = 5;
  EXPECT_EQ(a(0, 0), 1);
  EXPECT_FALSE(a == b);
  Image<int> c = std::move(b);
  EXPECT_EQ(c(0, 0), 5);
  EXPECT_EQ(c.width, 3);
}

TEST(Image, ResizeWithinCapacityKeepsTheMemory) {
  Image<std::uint16_t> image(640, 480);
  const auto* before = image.row(0);
  image.resize(320, 240);
  image.resize(640, 480);
  EXPECT_EQ(image.row(0), before);
}

TEST(Image, ViewBorrowsForeignRows) {
  int buffer[12] = {0, 1, 2, -1, 3, 4, 5, -1, 6, 7, 8, -1};
  const ImageView<int> view{buffer, 3, 3, 4};
  EXPECT_EQ(view(2, 1), 5);
  const ImageView<const int> read_only = view;
  EXPECT_EQ(read_only(0, 2), 6);
  EXPECT_TRUE(ImageView<int>{}.empty());
}

TEST(Shrink, BlocksBecomeTheirMeanRoundedToNearest) {
  Image<std::uint8_t> image(5, 4);
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 5; ++x) image(x, y) = static_cast<std::uint8_t>(10 * x + y);
  }
  Image<std::uint8_t> small;
  shrink(image, 2, small);
  ASSERT_EQ(small.width, 2);  // the fifth column is half a block
  ASSERT_EQ(small.height, 2);
  EXPECT_EQ(small(0, 0), 6);   // 0 1 10 11: 5.5
  EXPECT_EQ(small(1, 1), 28);  // 22 23 32 33: 27.5
  shrink(image, 1, small);
  EXPECT_TRUE(small == image);
  shrink(Image<std::uint8_t>(1, 1, 9), 4, small);
  EXPECT_EQ(small(0, 0), 9);
  Image<Rgb> colour(2, 2, {0, 100, 200}), mean;
  colour(0, 0) = {8, 104, 255};
  shrink(colour, 2, mean);
  EXPECT_EQ(mean(0, 0), (Rgb{2, 101, 214}));
}

}  // namespace
}  // namespace tread
