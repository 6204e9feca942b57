#include "tread/terrain/features.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <random>
#include <sstream>
#include <string>

#include "test_data.hpp"

namespace tread {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr double kResolution = 0.03;

template <class Height>
Grid<float> make_grid(int columns, int rows, const Height& height) {
  Grid<float> grid(GridGeometry{kResolution, {-7.0, 3.0}, columns, rows});
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) grid[{x, y}] = static_cast<float>(height(x, y));
  }
  return grid;
}

Grid<float> plane(double slope_x, double slope_y) {
  return make_grid(12, 9, [&](int x, int y) {
    return 0.7 + kResolution * (std::tan(slope_x) * x + std::tan(slope_y) * y);
  });
}

bool same_bits(const Grid<float>& a, const Grid<float>& b) {
  if (!(a.geometry == b.geometry)) return false;
  for (std::size_t i = 0; i < a.values.size(); ++i) {
    const bool unknown = std::isnan(a.values[i]) && std::isnan(b.values[i]);
    if (!unknown && a.values[i] != b.values[i]) return false;
  }
  return true;
}

TEST(TerrainFeatures, PlanesHaveTheirSlopeUpToTheBorder) {
  for (const double slope : {0.0, 0.01, 0.3, 0.8}) {
    for (const bool along_x : {true, false}) {
      const TerrainFeatures features =
          terrain_features(along_x ? plane(slope, 0.0) : plane(0.0, -slope));
      for (std::size_t i = 0; i < features.slope.values.size(); ++i) {
        EXPECT_NEAR(features.slope.values[i], 1.0 - slope, 1e-5);
        EXPECT_NEAR(features.roughness.values[i], 1.0, 1e-4);
      }
    }
  }
}

TEST(TerrainFeatures, SlopeOfAnObliquePlaneIsItsAngleToTheVertical) {
  const double gx = std::tan(0.2), gy = std::tan(0.3);
  FeatureOptions options;
  options.slope_critical_rad = 0.5;
  const TerrainFeatures features = terrain_features(plane(0.2, 0.3), options);
  const double angle = std::acos(1.0 / std::sqrt(1.0 + gx * gx + gy * gy));
  EXPECT_NEAR((features.slope[{5, 5}]), 1.0 - angle / 0.5, 1e-5);
  EXPECT_EQ((terrain_features(plane(0.6, 0.0), options).slope[{5, 5}]), 0.0F);
}

TEST(TerrainFeatures, AStepAboveTheCriticalHeightBlocksBothItsSides) {
  const auto step = [](double h) {
    return make_grid(20, 9, [h](int x, int) { return x < 10 ? 0.0 : h; });
  };
  const TerrainFeatures high = terrain_features(step(0.2));
  EXPECT_EQ((high.step[{9, 4}]), 0.0F);
  EXPECT_EQ((high.step[{10, 4}]), 0.0F);
  // One of the four critical cells is in the window: a quarter of the height counts.
  EXPECT_NEAR((high.step[{8, 4}]), 1.0 - 0.25 * 0.2 / 0.12, 1e-6);
  EXPECT_NEAR((high.step[{11, 4}]), 1.0 - 0.25 * 0.2 / 0.12, 1e-6);
  EXPECT_EQ((high.step[{7, 4}]), 1.0F);
  // At the border the window holds three of the four.
  EXPECT_NEAR((terrain_features(step(0.15)).step[{9, 0}]), 1.0 - 0.75 * 0.15 / 0.12, 1e-6);
  // Differences below the critical height do not count at all.
  const TerrainFeatures low = terrain_features(step(0.11));
  for (const float value : low.step.values) EXPECT_EQ(value, 1.0F);
}

TEST(TerrainFeatures, RoughnessOfACheckerboardIsKnown) {
  // 3 x 3 cells at +-a, five of one sign: mean a / 9, squares about it 9 a^2 - a^2 / 9.
  const double a = 0.01;
  const TerrainFeatures features =
      terrain_features(make_grid(9, 9, [a](int x, int y) { return (x + y) % 2 == 0 ? a : -a; }));
  const double roughness = a * std::sqrt((9.0 - 1.0 / 9.0) / 8.0);
  EXPECT_NEAR((features.roughness[{4, 4}]), 1.0 - roughness / 0.05, 1e-5);
  EXPECT_NEAR((features.roughness[{4, 3}]), 1.0 - roughness / 0.05, 1e-5);
  EXPECT_NEAR((features.slope[{4, 4}]), 1.0, 1e-5);
}

TEST(TerrainFeatures, RoughnessOfSeededNoiseIsItsDeviation) {
  const double sigma = 0.008;
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, sigma);
  FeatureOptions options;
  options.normal_radius_m = 0.15;
  options.roughness_radius_m = 0.15;
  const Grid<float> grid =
      make_grid(60, 60, [&](int x, int) { return 0.3 * kResolution * x + noise(random); });
  const TerrainFeatures features = terrain_features(grid, options);
  double squares = 0.0;
  int count = 0;
  for (int y = 5; y < 55; ++y) {
    for (int x = 5; x < 55; ++x, ++count) {
      squares += std::pow((1.0 - features.roughness[{x, y}]) * options.roughness_critical_m, 2);
    }
  }
  // 81 cells, three parameters fitted; distances are perpendicular to the slope.
  const double expected = sigma * std::sqrt(78.0 / 80.0 / (1.0 + 0.09));
  EXPECT_NEAR(std::sqrt(squares / count), expected, 0.03 * expected);
}

TEST(TerrainFeatures, RoughnessMayUseItsOwnRadius) {
  // A bump beyond the window of the normal and inside that of the roughness.
  FeatureOptions options;
  options.roughness_radius_m = 0.09;
  const Grid<float> grid =
      make_grid(11, 11, [](int x, int y) { return x == 8 && y == 5 ? 0.04 : 0.0; });
  const TerrainFeatures features = terrain_features(grid, options);
  EXPECT_NEAR((features.slope[{5, 5}]), 1.0, 1e-6);
  // 29 cells within three cells: 0.04^2 (1 - 1 / 29) / 28.
  const double roughness = 0.04 * std::sqrt((1.0 - 1.0 / 29.0) / 28.0);
  EXPECT_NEAR((features.roughness[{5, 5}]), 1.0 - roughness / 0.05, 1e-5);
}

TEST(TerrainFeatures, UnknownCellsStayUnknownAndDoNotDisturbTheirNeighbours) {
  Grid<float> grid = plane(0.2, 0.0);
  grid[{4, 4}] = kNaN;
  grid[{5, 4}] = std::numeric_limits<float>::infinity();
  const TerrainFeatures features = terrain_features(grid);
  for (const Cell hole : {Cell{4, 4}, Cell{5, 4}}) {
    EXPECT_TRUE(std::isnan(features.slope[hole]));
    EXPECT_TRUE(std::isnan(features.step[hole]));
    EXPECT_TRUE(std::isnan(features.roughness[hole]));
    EXPECT_TRUE(std::isnan(features.traversability[hole]));
  }
  EXPECT_NEAR((features.slope[{3, 4}]), 0.8, 1e-5);
  EXPECT_NEAR((features.slope[{5, 5}]), 0.8, 1e-5);
  EXPECT_NEAR((features.step[{3, 4}]), 1.0, 1e-6);
}

TEST(TerrainFeatures, ANormalNeedsThreeCellsThatAreNotInLine) {
  Grid<float> grid = make_grid(9, 9, [](int, int) { return kNaN; });
  for (int i = 1; i < 8; ++i) grid[{i, i}] = 0.1F * static_cast<float>(i);
  TerrainFeatures features = terrain_features(grid);
  EXPECT_TRUE(std::isnan(features.slope[{4, 4}]));
  EXPECT_TRUE(std::isnan(features.traversability[{4, 4}]));
  EXPECT_EQ((features.step[{4, 4}]), 1.0F);  // no neighbour to step from
  grid[{5, 4}] = 0.45F;
  features = terrain_features(grid);
  EXPECT_FALSE(std::isnan(features.slope[{4, 4}]));
  grid = make_grid(9, 9, [](int, int) { return kNaN; });
  grid[{2, 2}] = 0.0F;
  grid[{2, 3}] = 0.0F;
  EXPECT_TRUE(std::isnan(terrain_features(grid).slope[{2, 2}]));
}

TEST(TerrainFeatures, RadiiBelowACellStillReachTheNeighbours) {
  FeatureOptions options;
  options.normal_radius_m = options.roughness_radius_m = 0.001;
  options.step_radius_m = options.step_second_radius_m = 0.001;
  const TerrainFeatures features = terrain_features(plane(0.4, 0.0), options);
  EXPECT_NEAR((features.slope[{5, 5}]), 0.6, 1e-5);
  const Grid<float> step = make_grid(8, 8, [](int x, int) { return x < 4 ? 0.0 : 0.3; });
  EXPECT_EQ((terrain_features(step, options).step[{3, 4}]), 0.0F);
}

TEST(TerrainFeatures, TraversabilityIsTheMean) {
  const TerrainFeatures features = terrain_features(
      make_grid(20, 20, [](int x, int y) { return 0.03 * ((x * 7 + y * 5) % 6); }));
  for (std::size_t i = 0; i < features.slope.values.size(); ++i) {
    const float mean =
        (features.slope.values[i] + features.step.values[i] + features.roughness.values[i]) / 3.0F;
    EXPECT_NEAR(features.traversability.values[i], mean, 1e-6);
  }
}

TEST(TerrainFeatures, AnEmptyGridGivesEmptyLayers) {
  EXPECT_TRUE(terrain_features(Grid<float>{}).slope.values.empty());
}

TEST(TerrainFeatures, ThreadsDoNotChangeABit) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> height(0.0, 0.2);
  const Grid<float> grid = make_grid(53, 47, [&](int x, int y) {
    const double value = height(random);
    return (x * y) % 11 == 3 ? std::numeric_limits<double>::quiet_NaN() : value;
  });
  Timings timings;
  const TerrainFeatures one = terrain_features(grid, {}, {.threads = 1, .timings = &timings});
  const TerrainFeatures two = terrain_features(grid, {}, {.threads = 2});
  EXPECT_TRUE(same_bits(one.slope, two.slope));
  EXPECT_TRUE(same_bits(one.step, two.step));
  EXPECT_TRUE(same_bits(one.roughness, two.roughness));
  EXPECT_TRUE(same_bits(one.traversability, two.traversability));
  EXPECT_EQ(timings.entries().count("terrain/features"), 1U);
}

TEST(FeatureOptions, AreDescribedAndChecked) {
  FeatureOptions options;
  EXPECT_TRUE(check_options(options));
  OptionSet set = describe(options);
  EXPECT_EQ(set.fields().size(), 8U);
  ASSERT_TRUE(set.set("step_critical_cells", "9"));
  EXPECT_EQ(options.step_critical_cells, 9);
  EXPECT_FALSE(set.set("slope_critical_rad", "0"));
  options.normal_radius_m = -1.0;
  EXPECT_FALSE(check_options(options));
}

// One layer of the decoded maps: a line per x from the largest down, in it y from the largest down.
Grid<float> read_layer(const std::filesystem::path& path) {
  Grid<float> grid(GridGeometry{kResolution, {-1.5, -1.995}, 100, 133});
  std::ifstream file(path);
  for (int x = 99; x >= 0; --x) {
    std::string line, number;
    std::getline(file, line);
    std::istringstream numbers(line);
    for (int y = 132; y >= 0; --y) {
      std::getline(numbers, number, ',');
      grid[{x, y}] = std::stof(number);
    }
  }
  return grid;
}

double equal_share(const Grid<float>& a, const Grid<float>& b, double tolerance) {
  int equal = 0;
  for (std::size_t i = 0; i < a.values.size(); ++i) {
    if (std::abs(a.values[i] - b.values[i]) <= tolerance) ++equal;
  }
  return static_cast<double>(equal) / static_cast<double>(a.values.size());
}

TEST(TerrainFeatures, EqualTheLayersOfTheTraversabilityEstimationPackage) {
  TREAD_NEEDS_DATA(folder, "terrain/traversability_estimation/elevation_map_decoded");
  // The two cells that differ are at the border, on exact planes, which the package calls level.
  const TerrainFeatures features = terrain_features(read_layer(folder / "elevation.csv"));
  EXPECT_GE(equal_share(features.slope, read_layer(folder / "traversability_slope.csv"), 1e-3),
            0.999);
  EXPECT_EQ(equal_share(features.step, read_layer(folder / "traversability_step.csv"), 1e-3), 1.0);
  EXPECT_GE(
      equal_share(features.roughness, read_layer(folder / "traversability_roughness.csv"), 1e-3),
      0.999);
  EXPECT_GE(equal_share(features.traversability, read_layer(folder / "traversability.csv"), 1e-3),
            0.999);
}

}  // namespace
}  // namespace tread
