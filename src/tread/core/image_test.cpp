#include "tread/core/image.hpp"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace tread
