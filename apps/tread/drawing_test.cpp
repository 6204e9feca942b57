#include "drawing.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>
#include <vector>

namespace tread {
namespace {

constexpr Rgb kBlack{0, 0, 0};
constexpr Rgb kWhite{255, 255, 255};

double covered_area(const Image<Rgb>& picture) {
  double area = 0.0;
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) area += picture(x, y).g / 255.0;
  }
  return area;
}

TEST(Drawing, ALineHasItsWidthAndRoundEnds) {
  Image<Rgb> picture(60, 40, kBlack);
  const std::vector<Eigen::Vector2d> line{{10.3, 8.0}, {44.3, 25.6}};
  draw_polyline(picture, line, 5.0, kWhite);
  const double length = (line[1] - line[0]).norm();
  const double expected = 5.0 * length + std::numbers::pi * 2.5 * 2.5;
  EXPECT_NEAR(covered_area(picture), expected, 0.02 * expected);
  EXPECT_EQ(picture(27, 17), kWhite);
  EXPECT_EQ(picture(44, 8), kBlack);
}

TEST(Drawing, DiscsAndRingsHaveTheirArea) {
  Image<Rgb> disc(40, 40, kBlack), ring(40, 40, kBlack);
  draw_disc(disc, {19.2, 20.7}, 9.0, kWhite);
  EXPECT_NEAR(covered_area(disc), std::numbers::pi * 81.0, 3.0);
  draw_ring(ring, {19.2, 20.7}, 9.0, 3.0, kWhite);
  EXPECT_NEAR(covered_area(ring), 2.0 * std::numbers::pi * 9.0 * 3.0, 3.0);
  EXPECT_EQ(ring(19, 21), kBlack);
}

TEST(Drawing, EdgesAreSmooth) {
  Image<Rgb> picture(20, 20, kBlack);
  draw_polyline(picture, std::vector<Eigen::Vector2d>{{0.0, 10.25}, {19.0, 10.25}}, 2.0, kWhite);
  EXPECT_EQ(picture(10, 10), kWhite);
  EXPECT_NEAR(picture(10, 9).r, 64, 1);    // covered by a quarter
  EXPECT_NEAR(picture(10, 11).r, 191, 1);  // by three quarters
  EXPECT_EQ(picture(10, 13), kBlack);
}

TEST(Drawing, WhatLiesOutsideIsCutOff) {
  Image<Rgb> picture(10, 10, kBlack);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  draw_polyline(picture, std::vector<Eigen::Vector2d>{{-1e12, 5.0}, {1e12, 5.0}}, 2.0, kWhite);
  EXPECT_EQ(picture(0, 5), kWhite);
  EXPECT_EQ(picture(9, 5), kWhite);
  EXPECT_EQ(picture(5, 8), kBlack);
  const Image<Rgb> before = picture;
  draw_polyline(picture, {}, 2.0, kWhite);
  draw_polyline(picture, std::vector<Eigen::Vector2d>{{nan, 0.0}, {9.0, 9.0}}, 2.0, kWhite);
  draw_disc(picture, {-30.0, 4.0}, 3.0, kWhite);
  draw_ring(picture, {nan, 4.0}, 3.0, 1.0, kWhite);
  blend(picture, 10, 3, kWhite, 1.0);
  blend(picture, -1, 3, kWhite, 1.0);
  fill_rectangle(picture, 20, 20, 5, 5, kWhite);
  draw_text(picture, 300, 300, "far", 8, kWhite);
  EXPECT_EQ(picture, before);
  Image<Rgb> nothing;
  draw_text(nothing, 0, 0, "x", 8, kWhite);
  draw_disc(nothing, {0.0, 0.0}, 3.0, kWhite);
}

TEST(Drawing, RectanglesCoverTheirPixelsAndNoOthers) {
  Image<Rgb> picture(10, 10, kBlack);
  fill_rectangle(picture, 2, 3, 4, 5, kWhite);
  EXPECT_EQ(covered_area(picture), 20.0);
  EXPECT_EQ(picture(2, 3), kWhite);
  EXPECT_EQ(picture(5, 7), kWhite);
  EXPECT_EQ(picture(6, 7), kBlack);
  fill_rectangle(picture, 0, 0, 1, 1, {200, 100, 0}, 0.5);
  EXPECT_EQ(picture(0, 0), (Rgb{100, 50, 0}));
}

TEST(Drawing, TextStaysInTheSizeItIsSaidToHave) {
  const TextSize size = text_size("0.25 m", 13);
  EXPECT_GT(size.width, 30);
  Image<Rgb> picture(200, 60, kBlack);
  draw_text(picture, 20, 40, "0.25 m", 13, {10, 200, 30});
  int left = 1000, right = -1, top = 1000, bottom = -1;
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      if (picture(x, y).g < 100) continue;
      EXPECT_GT(picture(x, y).g, picture(x, y).r);  // channels are not swapped
      EXPECT_GT(picture(x, y).g, picture(x, y).b);
      left = std::min(left, x), right = std::max(right, x);
      top = std::min(top, y), bottom = std::max(bottom, y);
    }
  }
  EXPECT_GE(left, 20);
  EXPECT_LE(right, 20 + size.width);
  EXPECT_GE(top, 40 - size.height - 1);
  EXPECT_LE(bottom, 41);
  EXPECT_GE(bottom - top, 8);
}

}  // namespace
}  // namespace tread
