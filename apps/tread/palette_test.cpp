#include "palette.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <vector>

namespace tread {
namespace {

// CIE 1976 lightness, 0 to 100, another space than the one the palettes are made in.
double lightness(Rgb c) {
  const auto linear = [](int byte) {
    const double v = byte / 255.0;
    return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
  };
  const double y = 0.2126 * linear(c.r) + 0.7152 * linear(c.g) + 0.0722 * linear(c.b);
  return y > 0.008856 ? 116.0 * std::cbrt(y) - 16.0 : 903.3 * y;
}

std::vector<double> lightness_of(Palette palette, int steps) {
  std::vector<double> values;
  for (int i = 0; i <= steps; ++i) {
    values.push_back(lightness(palette_colour(palette, static_cast<double>(i) / steps)));
  }
  return values;
}

class SequentialPalette : public ::testing::TestWithParam<Palette> {};

TEST_P(SequentialPalette, GetsLighterWithEveryStep) {
  const std::vector<double> values = lightness_of(GetParam(), 64);
  for (std::size_t i = 1; i < values.size(); ++i) EXPECT_GT(values[i], values[i - 1]) << i;
  EXPECT_LT(values.front(), 20.0);
  EXPECT_GT(values.back(), 84.0);
}

TEST_P(SequentialPalette, StepsAreNearlyEven) {
  const std::vector<double> values = lightness_of(GetParam(), 8);
  const double mean = (values.back() - values.front()) / 8.0;
  for (std::size_t i = 1; i < values.size(); ++i) {
    EXPECT_NEAR(values[i] - values[i - 1], mean, 0.4 * mean) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(All, SequentialPalette,
                         ::testing::Values(Palette::kHeight, Palette::kCost, Palette::kGrey));

TEST(Palette, DisparityIsLightestInsideAndChangesFast) {
  const std::vector<double> values = lightness_of(Palette::kDisparity, 64);
  std::size_t lightest = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (values[i] > values[lightest]) lightest = i;
  }
  EXPECT_GT(lightest, 20U);
  EXPECT_LT(lightest, 50U);
  for (std::size_t i = 1; i <= lightest; ++i) EXPECT_GE(values[i], values[i - 1]);
  for (std::size_t i = lightest + 1; i < values.size(); ++i) EXPECT_LE(values[i], values[i - 1]);
  // A sixteenth of the scale is always a difference one sees.
  for (int i = 0; i < 16; ++i) {
    const Rgb a = palette_colour(Palette::kDisparity, i / 16.0);
    const Rgb b = palette_colour(Palette::kDisparity, (i + 1) / 16.0);
    EXPECT_GT(std::abs(a.r - b.r) + std::abs(a.g - b.g) + std::abs(a.b - b.b), 24) << i;
  }
}

TEST(Palette, HasNoJumps) {
  for (const Palette palette :
       {Palette::kHeight, Palette::kCost, Palette::kDisparity, Palette::kGrey}) {
    for (int i = 0; i < 255; ++i) {
      const Rgb a = palette_colour(palette, i / 255.0);
      const Rgb b = palette_colour(palette, (i + 1) / 255.0);
      EXPECT_LE(std::abs(a.r - b.r), 14) << i;
      EXPECT_LE(std::abs(a.g - b.g), 14) << i;
      EXPECT_LE(std::abs(a.b - b.b), 14) << i;
    }
  }
}

TEST(Palette, EndsHoldBeyondTheScale) {
  const Rgb dark = palette_colour(Palette::kGrey, 0.0);
  EXPECT_EQ(dark, (Rgb{dark.r, dark.r, dark.r}));
  EXPECT_LT(dark.r, 16);
  EXPECT_EQ(palette_colour(Palette::kGrey, 1.0), (Rgb{255, 255, 255}));
  EXPECT_EQ(palette_colour(Palette::kCost, -3.0), palette_colour(Palette::kCost, 0.0));
  EXPECT_EQ(palette_colour(Palette::kCost, 1e9), palette_colour(Palette::kCost, 1.0));
}

TEST(Palette, HexColour) {
  EXPECT_EQ(hex_colour({0, 15, 255}), "#000fff");
}

}  // namespace
}  // namespace tread
