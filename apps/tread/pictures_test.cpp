#include "pictures.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace tread {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

Image<float> row_of(std::initializer_list<float> values) {
  Image<float> image(static_cast<int>(values.size()), 1);
  std::copy(values.begin(), values.end(), image.row(0));
  return image;
}

template <class Height>
Grid<float> make_grid(int columns, int rows, const Height& height) {
  Grid<float> grid(GridGeometry{0.5, {-3.0, 2.0}, columns, rows});
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) grid[{x, y}] = static_cast<float>(height(x, y));
  }
  return grid;
}

TEST(ColourMap, SpansTheScaleAndMarksTheUnknown) {
  const Rgb unknown{1, 2, 3};
  const Image<Rgb> picture = colour_map(row_of({2.0F, 4.0F, 6.0F, -9.0F, 99.0F, kNaN, kInfinity}),
                                        2.0F, 6.0F, Palette::kHeight, unknown);
  EXPECT_EQ(picture(0, 0), palette_colour(Palette::kHeight, 0.0));
  EXPECT_EQ(picture(1, 0), palette_colour(Palette::kHeight, 0.5));
  EXPECT_EQ(picture(2, 0), palette_colour(Palette::kHeight, 1.0));
  EXPECT_EQ(picture(3, 0), picture(0, 0));
  EXPECT_EQ(picture(4, 0), picture(2, 0));
  EXPECT_EQ(picture(5, 0), unknown);
  EXPECT_EQ(picture(6, 0), unknown);
}

TEST(ColourMap, LethalValuesHaveTheirColourAndNoPaletteHasThatOfTheUnknown) {
  ColourScale scale;
  scale.palette = Palette::kCost;
  scale.high = 20.0F;
  scale.lethal_from = 50.0F;
  EXPECT_EQ(colour_of(scale, 50.0F), kLethalColour);
  EXPECT_EQ(colour_of(scale, kInfinity), kLethalColour);
  EXPECT_EQ(colour_of(scale, 49.9F), palette_colour(Palette::kCost, 1.0));
  EXPECT_EQ(colour_of(scale, kNaN), kUnknownColour);
  EXPECT_EQ(colour_of(scale, -kInfinity), kUnknownColour);
  for (const Palette palette : {Palette::kHeight, Palette::kCost, Palette::kDisparity}) {
    for (int i = 0; i < 256; ++i) {
      const Rgb c = palette_colour(palette, i / 255.0);
      const int apart = std::abs(c.r - kUnknownColour.r) + std::abs(c.g - kUnknownColour.g) +
                        std::abs(c.b - kUnknownColour.b);
      EXPECT_GT(apart, 40) << i;
    }
  }
}

TEST(ColourMap, AReversedScaleBeginsWithTheLastColour) {
  ColourScale scale;
  scale.reversed = true;
  EXPECT_EQ(colour_of(scale, 0.0F), palette_colour(scale.palette, 1.0));
  EXPECT_EQ(colour_of(scale, 1.0F), palette_colour(scale.palette, 0.0));
  scale.high = scale.low;
  EXPECT_EQ(colour_of(scale, 5.0F), palette_colour(scale.palette, 1.0));
}

TEST(ValueRangeOf, LeavesOutliersOut) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> value(2.0F, 3.0F);
  Image<float> image(100, 100);
  for (int y = 0; y < 100; ++y) {
    for (int x = 0; x < 100; ++x) image(x, y) = value(random);
  }
  image(3, 4) = 1e6F;
  image(5, 6) = -1e6F;
  image(7, 8) = kNaN;
  image(9, 9) = kInfinity;
  const ValueRange range = value_range(image, 0.01);
  EXPECT_NEAR(range.low, 2.01, 0.01);
  EXPECT_NEAR(range.high, 2.99, 0.01);
  EXPECT_EQ(value_range(image, 0.0).high, 1e6F);
  EXPECT_EQ(value_range(image, 0.0).low, -1e6F);
}

TEST(ValueRangeOf, IsNeverEmpty) {
  for (const float level : {0.0F, 5.0F, -1e5F}) {
    const ValueRange range = value_range(row_of({level, level, level}));
    EXPECT_LT(range.low, level);
    EXPECT_GT(range.high, level);
  }
  const ValueRange none = value_range(row_of({kNaN, kInfinity}));
  EXPECT_EQ(none.low, 0.0F);
  EXPECT_EQ(none.high, 1.0F);
}

TEST(Pictures, GreyEnlargedAndSideBySide) {
  Image<std::uint8_t> grey(2, 1);
  grey(0, 0) = 7;
  grey(1, 0) = 200;
  const Image<Rgb> picture = grey_picture(grey);
  EXPECT_EQ(picture(1, 0), (Rgb{200, 200, 200}));
  const Image<Rgb> large = enlarge(picture, 3);
  ASSERT_EQ(large.width, 6);
  ASSERT_EQ(large.height, 3);
  EXPECT_EQ(large(2, 2), picture(0, 0));
  EXPECT_EQ(large(3, 0), picture(1, 0));
  const Image<Rgb> both = side_by_side(picture, large, 4);
  ASSERT_EQ(both.width, 12);
  ASSERT_EQ(both.height, 3);
  EXPECT_EQ(both(1, 0), picture(1, 0));
  EXPECT_EQ(both(2, 0), kUnknownColour);
  EXPECT_EQ(both(6, 2), large(0, 2));
}

TEST(CropToKnown, KeepsTheKnownAndItsPlace) {
  Grid<float> grid = make_grid(20, 10, [](int, int) { return kNaN; });
  grid[{7, 3}] = 1.0F;
  grid[{9, 6}] = kInfinity;  // known to be out of reach
  const Grid<float> part = crop_to_known(grid, 1);
  EXPECT_EQ(part.geometry.columns, 5);
  EXPECT_EQ(part.geometry.rows, 6);
  EXPECT_EQ((part[{1, 1}]), 1.0F);
  EXPECT_EQ((part[{3, 4}]), kInfinity);
  EXPECT_TRUE(part.geometry.centre({1, 1}).isApprox(grid.geometry.centre({7, 3})));
  EXPECT_EQ(crop_to_known(grid, 100).geometry, grid.geometry);
  const Grid<float> nothing = make_grid(4, 4, [](int, int) { return kNaN; });
  EXPECT_EQ(crop_to_known(nothing).geometry, nothing.geometry);
}

TEST(Shrink, IsTheMeanOfTheKnown) {
  Grid<float> grid = make_grid(5, 3, [](int x, int y) { return x + 10 * y; });
  grid[{0, 0}] = kNaN;
  grid[{4, 2}] = kNaN;
  const Grid<float> small = shrink(grid, 2);
  ASSERT_EQ(small.geometry.columns, 3);
  ASSERT_EQ(small.geometry.rows, 2);
  EXPECT_EQ(small.geometry.resolution_m, 1.0);
  EXPECT_NEAR((small[{0, 0}]), (1 + 10 + 11) / 3.0, 1e-6);
  EXPECT_NEAR((small[{1, 0}]), (2 + 3 + 12 + 13) / 4.0, 1e-6);
  EXPECT_TRUE(std::isnan(small[{2, 1}]));
}

TEST(DrawMap, YPointsUpAndCellsAreSquares) {
  const Grid<float> grid =
      make_grid(4, 3, [](int x, int y) { return x == 1 && y == 2 ? 1.0 : 0.0; });
  const ColourScale scale;
  const MapPicture map = draw_map(grid, scale, 43);
  ASSERT_EQ(map.image.width, 40);
  ASSERT_EQ(map.image.height, 30);
  const Rgb one = palette_colour(scale.palette, 1.0);
  EXPECT_EQ(map.image(10, 0), one);
  EXPECT_EQ(map.image(19, 9), one);
  EXPECT_NE(map.image(9, 0), one);
  EXPECT_NE(map.image(19, 10), one);
  // The centre of the cell lies between the pixels 14 and 15, 4 and 5.
  EXPECT_TRUE(map.pixel_of(grid.geometry.centre({1, 2})).isApprox(Eigen::Vector2d(14.5, 4.5)));
}

TEST(DrawMap, LargeMapsAreShrunk) {
  const Grid<float> grid = make_grid(250, 100, [](int x, int) { return x < 125 ? 0.0 : 1.0; });
  const MapPicture map = draw_map(grid, {}, 100);
  EXPECT_EQ(map.image.width, 84);
  EXPECT_EQ(map.image.height, 34);
  EXPECT_NEAR(map.pixel_of(grid.geometry.origin).x(), -0.5, 1e-9);
  EXPECT_NEAR(map.pixel_of(grid.geometry.origin).y(), 33.5, 1e-9);
  const MapPicture relief = draw_relief(grid, {}, 100);
  EXPECT_EQ(relief.image.width, 84);
}

TEST(DrawRelief, SlopesTowardsTheLightAreBrighter) {
  ColourScale scale;
  scale.palette = Palette::kGrey;
  scale.low = -20.0F;
  scale.high = 20.0F;
  const auto brightness = [&](double gx, double gy, double exaggeration) {
    const Grid<float> grid =
        make_grid(9, 9, [&](int x, int y) { return 0.5 * (gx * (x - 4) + gy * (y - 4)); });
    return draw_relief(grid, scale, 9, exaggeration).image(4, 4).r;
  };
  const int level = brightness(0.0, 0.0, 1.0);
  EXPECT_EQ(level, palette_colour(Palette::kGrey, 0.5).r);
  EXPECT_GT(brightness(0.5, -0.5, 1.0), level + 10);  // faces the upper left
  EXPECT_LT(brightness(-0.5, 0.5, 1.0), level - 30);
  EXPECT_LT(brightness(-0.5, 0.5, 2.0), brightness(-0.5, 0.5, 1.0));
  EXPECT_EQ(brightness(-9.0, 9.0, 1.0), std::lround(0.3 * level));  // turned away: ambient light
}

TEST(DrawRelief, UnknownCellsAreFlatAndDoNotSpread) {
  Grid<float> grid = make_grid(5, 5, [](int, int) { return 0.5; });
  grid[{2, 2}] = kNaN;
  const MapPicture map = draw_relief(grid, {}, 5);
  EXPECT_EQ(map.image(2, 2), kUnknownColour);
  EXPECT_EQ(map.image(1, 2), palette_colour(Palette::kHeight, 0.5));
  Grid<float> alone = make_grid(3, 3, [](int, int) { return kNaN; });
  alone[{1, 1}] = 0.5F;
  EXPECT_EQ(draw_relief(alone, {}, 3).image(1, 1), palette_colour(Palette::kHeight, 0.5));
}

TEST(DrawMap, AnEmptyMapIsAnEmptyPicture) {
  EXPECT_TRUE(draw_map(Grid<float>{}, {}).image.empty());
}

TEST(NumberText, IsShort) {
  EXPECT_EQ(number_text(0.0), "0");
  EXPECT_EQ(number_text(-0.0001), "-1.00e-04");
  EXPECT_EQ(number_text(0.25, "m"), "0.25 m");
  EXPECT_EQ(number_text(1.0), "1");
  EXPECT_EQ(number_text(-12.34), "-12.3");
  EXPECT_EQ(number_text(100.0), "100");
  EXPECT_EQ(number_text(99999.0), "99999");
  EXPECT_EQ(number_text(1.5e7), "1.50e+07");
  EXPECT_EQ(number_text(std::nan("")), "unknown");
  EXPECT_EQ(number_text(INFINITY), "inf");
}

TEST(RoundTicks, AreRoundAndInside) {
  const std::vector<double> ticks = round_ticks(-0.28, 1.04, 5);
  ASSERT_EQ(ticks.size(), 7U);
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    EXPECT_NEAR(ticks[i], -0.2 + 0.2 * static_cast<double>(i), 1e-12);
  }
  EXPECT_EQ(round_ticks(0.0, 10.0, 2), (std::vector<double>{0.0, 5.0, 10.0}));
  EXPECT_TRUE(round_ticks(1.0, 1.0, 4).empty());
  EXPECT_TRUE(round_ticks(2.0, 1.0, 4).empty());
}

}  // namespace
}  // namespace tread
