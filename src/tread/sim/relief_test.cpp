#include "tread/sim/relief.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

namespace tread {
namespace {

using Eigen::Vector2d;

GridGeometry square(double side, double resolution) {
  const int n = static_cast<int>(std::lround(side / resolution));
  return {resolution, Vector2d::Zero(), n, n};
}

// Power of the rows of a grid at a wave number, with a Hann window.
double profile_power(const Grid<float>& heights, double k) {
  const GridGeometry& g = heights.geometry;
  double power = 0.0;
  for (int y = 0; y < g.rows; y += 5) {
    std::complex<double> sum = 0.0;
    for (int x = 0; x < g.columns; ++x) {
      const double window = 0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * x / g.columns);
      sum += window * heights[{x, y}] * std::polar(1.0, -k * x * g.resolution_m);
    }
    power += std::norm(sum);
  }
  return power;
}

// Mean over a third of an octave around, and over several grounds: single waves do not matter.
double mean_power(double exponent, double wavelength) {
  double power = 0.0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const Grid<float> heights = noise_relief(square(20.0, 0.05), {0.1, 8.0, 0.2, exponent}, seed);
    for (double f = 0.9; f < 1.15; f += 0.02) {
      power += profile_power(heights, 2.0 * std::numbers::pi / (wavelength * f));
    }
  }
  return power;
}

TEST(Relief, NoiseHasTheHeightAskedFor) {
  for (const double rms : {0.01, 0.2}) {
    const Grid<float> heights = noise_relief(square(40.0, 0.1), {rms, 4.0, 0.3, 2.0}, 9);
    double sum = 0.0, squares = 0.0;
    for (const float h : heights.values) {
      sum += h;
      squares += h * h;
    }
    const auto n = static_cast<double>(heights.values.size());
    EXPECT_NEAR(sum / n, 0.0, 0.1 * rms);
    EXPECT_NEAR(std::sqrt(squares / n), rms, 0.05 * rms);
  }
}

TEST(Relief, NoiseHasTheSpectrumAskedFor) {
  for (const double exponent : {1.5, 2.2, 3.0}) {
    const double long_waves = mean_power(exponent, 2.0), short_waves = mean_power(exponent, 0.5);
    EXPECT_NEAR(std::log2(long_waves / short_waves) / 2.0, exponent, 0.25) << exponent;
  }
  // Nothing of shorter waves than asked for: four octaves below it would be 2^-8.8 of a 2 m wave.
  const Grid<float> smooth = noise_relief(square(20.0, 0.05), {0.1, 8.0, 1.0, 2.2}, 3);
  EXPECT_LT(profile_power(smooth, 2.0 * std::numbers::pi / 0.25),
            1e-5 * profile_power(smooth, 2.0 * std::numbers::pi / 2.0));
}

TEST(Relief, NoiseIsOfThePlaceAndNotOfTheGrid) {
  const NoiseOptions options{0.1, 4.0, 0.5, 2.2};
  const Grid<float> fine = noise_relief({0.1, Vector2d(0.05, 0.05), 41, 31}, options, 4),
                    coarse = noise_relief({0.2, Vector2d::Zero(), 20, 15}, options, 4);
  for (int y = 0; y < 15; ++y) {
    for (int x = 0; x < 20; ++x) {
      EXPECT_NEAR((coarse[{x, y}]), (fine[{2 * x, 2 * y}]), 1e-5);
    }
  }
}

TEST(Relief, BandsRampsMoundsAndLevelDiscs) {
  Grid<float> heights(square(10.0, 0.1));
  const auto at = [&](double x, double y) { return heights[heights.geometry.cell_at({x, y})]; };
  add_band(heights, {{2.05, 0.0}, {2.05, 10.0}, 0.6, 0.4}, -0.4);
  EXPECT_FLOAT_EQ(at(2.05, 5.0), -0.4F);
  EXPECT_FLOAT_EQ(at(2.31, 5.0), -0.4F);
  EXPECT_NEAR(at(2.55, 5.0), -0.2, 1e-6);  // half way up the bank
  EXPECT_FLOAT_EQ(at(2.85, 5.0), 0.0F);
  add_ramp(heights, {{4.05, 5.0}, {6.05, 5.0}, 2.0, 0.5}, 0.5, 1.0);
  EXPECT_NEAR(at(5.05, 5.0), 0.25, 1e-6);
  EXPECT_NEAR(at(6.55, 5.5), 0.5, 1e-6);
  EXPECT_FLOAT_EQ(at(7.65, 5.0), 0.0F);
  EXPECT_FLOAT_EQ(at(5.05, 6.65), 0.0F);
  add_mound(heights, {8.55, 8.55}, 1.0, 0.3);
  EXPECT_NEAR(at(8.55, 8.55), 0.3, 1e-6);
  EXPECT_NEAR(at(9.05, 8.55), 0.15, 1e-6);
  level_disc(heights, {8.55, 8.55}, 0.3, 0.2);
  EXPECT_NEAR(at(8.75, 8.55), 0.3, 1e-6);
  EXPECT_NEAR(at(9.05, 8.55), 0.15, 1e-6);
}

}  // namespace
}  // namespace tread
