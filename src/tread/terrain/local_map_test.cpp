#include "tread/terrain/local_map.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <vector>

#include "tread/geometry/pose.hpp"
#include "tread/geometry/stereo_rig.hpp"

namespace tread {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double kDegree = std::numbers::pi / 180.0;

// Four points in every 0.1 m cell of a surface z(x, y), x ahead 0.5 to 6 m, y to both sides.
std::vector<Vector3f> surface(const std::function<double(double, double)>& z) {
  std::vector<Vector3f> points;
  for (double x = 0.525; x < 6.0; x += 0.05) {
    for (double y = -2.975; y < 3.0; y += 0.05) {
      points.emplace_back(static_cast<float>(x), static_cast<float>(y),
                          static_cast<float>(z(x, y)));
    }
  }
  return points;
}

const LevelArea kPaperR = {Eigen::Vector2d(0.0, -6.0), Eigen::Vector2d(6.0, 6.0)};

Grid<float> heights(const std::vector<Vector3f>& points, const LocalMapOptions& options = {},
                    const Isometry3d& T = Isometry3d::Identity(), const LevelArea& area = kPaperR,
                    const Grid<float>* known = nullptr) {
  LocalMapBuilder builder;
  return builder.build(points, T, local_cells(area, options.resolution_m), options, {known});
}

Grid<float> derivative(const std::function<double(double, double)>& z) {
  LocalMapOptions options;
  options.max_height_m = 100.0;
  Grid<float> d;
  sobel_squared(heights(surface(z), options), d);
  return d;
}

TEST(LocalMap, SizeIsTheRangeOfPaperR) {
  const Grid<float> map = heights({});
  EXPECT_EQ(map.geometry.columns, 60);
  EXPECT_EQ(map.geometry.rows, 120);  // 12 m across
  EXPECT_EQ(map.geometry.cell_at({0.05, -5.95}), (Cell{0, 0}));
}

TEST(LocalMap, CellsHoldTheirAreaAndLieOnMultiplesOfTheResolution) {
  const GridGeometry cells =
      local_cells(LevelArea(Eigen::Vector2d(-0.25, 0.31), Eigen::Vector2d(1.0, 0.69)), 0.1);
  EXPECT_NEAR(cells.origin.x(), -0.3, 1e-12);
  EXPECT_NEAR(cells.origin.y(), 0.3, 1e-12);
  EXPECT_EQ(cells.columns, 13);
  EXPECT_EQ(cells.rows, 4);
  EXPECT_EQ(local_cells(LevelArea(), 0.1).size(), 0U);
}

// A camera at (x, y) that looks along `yaw` and down by `pitch` sees every point of its view within
// the area, and to its borders.
TEST(LocalMap, ViewFromAboveHoldsEveryPointUpToItsDepth) {
  const RectifiedRig rig = rectified_rig(bumblebee2(640)).value();
  for (const double yaw : {0.0, 0.7, std::numbers::pi, -1.2}) {
    for (const double pitch : {0.0, 0.4, 1.5}) {
      Isometry3d T = Isometry3d(rotation_from_yaw_pitch_roll(yaw, 0.0, 0.05)) *
                     level_mount(1.0, pitch, true).T_body_left;
      T.pretranslate(Vector3d(2.5, -1.0, 0.0));
      const LevelArea area = view_from_above(rig, T, 4.0);
      LevelArea seen(T.translation().head<2>());
      for (const double depth : {0.1, 2.0, 4.0}) {
        for (int v = 0; v < rig.size.height; v += 3) {
          for (int u = 0; u < rig.size.width; u += 3) {
            seen.extend((T * rig.point(u, v, depth)).head<2>());
          }
        }
      }
      EXPECT_TRUE(area.contains(seen));
      EXPECT_LT((area.sizes() - seen.sizes()).maxCoeff(), 0.1);
    }
  }
}

// What hangs over known ground is passed under; what stands on it is not, nor what hangs over
// ground that nobody has seen.
TEST(LocalMap, WhatHangsOverKnownGroundIsLeftOut) {
  LocalMapOptions options;
  options.overhead_m = 2.0;
  Grid<float> known(local_cells(kPaperR, options.resolution_m), std::nanf(""));
  known[known.geometry.cell_at({1.05, 0.05})] = -1.0F;
  known[known.geometry.cell_at({2.05, 0.05})] = -1.0F;
  std::vector<Vector3f> points;
  for (const float dx : {0.01F, 0.02F, 0.03F}) {
    points.emplace_back(1.0F + dx, 0.01F, -0.9F);  // ground
    points.emplace_back(1.0F + dx, 0.01F, 1.5F);   // a crown above it
    points.emplace_back(2.0F + dx, 0.01F, 0.9F);   // a wall: 1.9 m above the ground
    points.emplace_back(3.0F + dx, 0.01F, 1.5F);   // above what is not known
  }
  const auto at = [&](const Grid<float>& map, double x) {
    return map[map.geometry.cell_at({x, 0.05})];
  };
  const Grid<float> map = heights(points, options, Isometry3d::Identity(), kPaperR, &known);
  EXPECT_NEAR(at(map, 1.05), -0.9, 1e-6);
  EXPECT_NEAR(at(map, 2.05), 0.9, 1e-6);
  EXPECT_NEAR(at(map, 3.05), 1.5, 1e-6);
  options.overhead_m = 0.0;
  EXPECT_NEAR(at(heights(points, options, Isometry3d::Identity(), kPaperR, &known), 1.05), 0.3,
              1e-6);
  options.overhead_m = 2.0;
  EXPECT_NEAR(at(heights(points, options), 1.05), 0.3, 1e-6);
}

// "a model of at least 2 m^2" of cells of 5 mm is 80 000 cells. Paper Q's camera, 1 m above the
// ground and looking straight down, fills them from one image of 640 x 480: 1.92 x 1.44 m.
TEST(PaperQ, TwoSquareMetresAre80000CellsOfFiveMillimetres) {
  LocalMapOptions options;
  options.resolution_m = 0.005;
  const LevelArea ahead = {Eigen::Vector2d(0.0, -1.0), Eigen::Vector2d(1.0, 1.0)};
  const GridGeometry half = heights({}, options, Isometry3d::Identity(), ahead).geometry;
  EXPECT_EQ(half.columns * half.rows, 80000);

  const RectifiedRig rig = rectified_rig(bumblebee2(640)).value();
  std::vector<Vector3f> points;
  for (int v = 0; v < rig.size.height; ++v) {
    for (int u = 0; u < rig.size.width; ++u) points.push_back(rig.point(u, v, 1.0).cast<float>());
  }
  options.min_points = 1;
  const CameraMount mount = level_mount(1.0, 90.0 * kDegree, false);
  const LevelArea view = view_from_above(rig, mount.T_body_left, 1.0);
  int known = 0;
  for (float height : heights(points, options, mount.T_body_left, view).values) {
    if (std::isnan(height)) continue;
    ++known;
    EXPECT_NEAR(height, 0.0, 1e-5);
  }
  EXPECT_GE(known, 80000);
  EXPECT_NEAR(known, 1.92 * 1.44 / (0.005 * 0.005), 400.0);  // a cell more or less at the borders
}

TEST(LocalMap, CellsAreMeanOrMaximumOfEnoughPoints) {
  const std::vector<Vector3f> points = {
      {1.01F, 0.01F, 0.1F}, {1.02F, 0.02F, 0.3F}, {1.03F, 0.03F, 0.5F}, {2.01F, 0.01F, 0.7F}};
  Grid<float> map = heights(points);
  EXPECT_NEAR(map[map.geometry.cell_at({1.05, 0.05})], 0.3, 1e-6);
  EXPECT_TRUE(std::isnan(map[map.geometry.cell_at({2.05, 0.05})]));  // one point only
  LocalMapOptions options;
  options.height = LocalMapOptions::Height::kMax;
  options.min_points = 1;
  map = heights(points, options);
  EXPECT_NEAR(map[map.geometry.cell_at({1.05, 0.05})], 0.5, 1e-6);
  EXPECT_NEAR(map[map.geometry.cell_at({2.05, 0.05})], 0.7, 1e-6);
  // Also below the robot's ground.
  const std::vector<Vector3f> ditch = {{1.01F, 0.01F, -0.6F}, {1.02F, 0.02F, -0.4F}};
  map = heights(ditch, options);
  EXPECT_NEAR(map[map.geometry.cell_at({1.05, 0.05})], -0.4, 1e-6);
}

TEST(LocalMap, SurePointsWeighMore) {
  const std::vector<Vector3f> points = {{1.01F, 0.01F, 0.0F}, {1.02F, 0.02F, 1.0F}};
  const std::vector<float> sigma_m = {0.1F, 0.2F};  // weights 100 and 25
  LocalMapBuilder builder;
  const GridGeometry cells = local_cells(kPaperR, 0.1);
  const Grid<float>& map =
      builder.build(points, Isometry3d::Identity(), cells, {}, {nullptr, sigma_m});
  EXPECT_NEAR(map[cells.cell_at({1.05, 0.05})], 0.2, 1e-6);
}

TEST(LocalMap, LeavesOutWhatIsNotFiniteTooHighOrOutside) {
  const float nan = std::nanf(""), inf = std::numeric_limits<float>::infinity();
  std::vector<Vector3f> points;
  for (int i = 0; i < 3; ++i) {
    points.insert(points.end(), {{nan, 0, 0},
                                 {1, nan, 0},
                                 {1, 0, nan},
                                 {inf, 0, 0},
                                 {1, -inf, 0},
                                 {1, 0, inf},
                                 {1, 0, 3.5F},
                                 {-1, 0, 0},
                                 {7, 0, 0},
                                 {1, 9, 0},
                                 {1e30F, 1e30F, 0}});
  }
  for (float value : heights(points).values) EXPECT_TRUE(std::isnan(value));
}

TEST(LocalMap, LevellingTakesPitchAndRollOutAndLeavesYaw) {
  const Eigen::Matrix3d R = rotation_from_yaw_pitch_roll(0.8, 0.1, -0.2);
  const Eigen::Matrix3d level = R_level_body(R);
  EXPECT_LT((rotation_from_yaw_pitch_roll(0.8, 0, 0) * level - R).norm(), 1e-12);
  // Flat ground seen by a tilted body is flat in the map.
  Isometry3d T = Isometry3d::Identity();
  T.linear() = level;
  std::vector<Vector3f> tilted;
  for (const Vector3f& p : surface([](double, double) { return 0.0; })) {
    tilted.push_back((level.transpose() * p.cast<double>()).cast<float>());
  }
  for (float h : heights(tilted, {}, T).values) {
    if (!std::isnan(h)) {
      EXPECT_NEAR(h, 0.0, 1e-5);
    }
  }
}

// METHODS 10.3: plane of slope g: 0.64 g^2 (15, 20, 30, 45 degrees: 0.046, 0.085, 0.21, 0.64).
TEST(PaperR, SobelOfAPlaneIsItsSlopeSquaredTimes064) {
  const struct {
    double degrees, published;
  } cases[] = {{15, 0.046}, {20, 0.085}, {30, 0.213}, {45, 0.64}};
  for (const auto& c : cases) {
    const double g = std::tan(c.degrees * kDegree);
    for (double heading : {0.0, 0.3, std::numbers::pi / 2}) {
      const Grid<float> d = derivative([&](double x, double y) {
        return g * (std::cos(heading) * (x - 3.0) + std::sin(heading) * y);
      });
      int known = 0;
      for (float value : d.values) {
        if (std::isnan(value)) continue;
        ++known;
        EXPECT_NEAR(value, 0.64 * g * g, 0.002 * (1 + g)) << c.degrees;
        EXPECT_NEAR(value, c.published, 0.004) << c.degrees;
      }
      EXPECT_GT(known, 1000);
    }
  }
}

// Step of h: 16 h^2 in the cells on both sides (5, 10, 15, 20 cm: 0.04, 0.16, 0.36, 0.64).
TEST(PaperR, SobelOfAStepIsSixteenTimesItsHeightSquared) {
  const struct {
    double step_m, published;
  } cases[] = {{0.05, 0.04}, {0.10, 0.16}, {0.15, 0.36}, {0.20, 0.64}};
  for (const auto& c : cases) {
    const Grid<float> d = derivative([&](double x, double) { return x < 3.0 ? 0.0 : c.step_m; });
    const GridGeometry& g = d.geometry;
    EXPECT_NEAR((d[g.cell_at({2.95, 0.05})]), c.published, 1e-4);
    EXPECT_NEAR((d[g.cell_at({3.05, 0.05})]), c.published, 1e-4);
    EXPECT_NEAR((d[g.cell_at({2.85, 0.05})]), 0.0, 1e-6);
    EXPECT_NEAR((d[g.cell_at({3.15, 0.05})]), 0.0, 1e-6);
  }
}

TEST(PaperR, NoDerivativeAtTheBorderOfTheKnownAreaNorAroundAHole) {
  Grid<float> h(GridGeometry{0.1, {0, 0}, 9, 9}, 1.0F);
  h[{4, 4}] = std::nanf("");
  Grid<float> d;
  sobel_squared(h, d);
  for (int y = 0; y < 9; ++y) {
    for (int x = 0; x < 9; ++x) {
      const bool border = x == 0 || y == 0 || x == 8 || y == 8;
      const bool near_hole = std::abs(x - 4) <= 1 && std::abs(y - 4) <= 1;
      EXPECT_EQ(std::isnan(d[{x, y}]), border || near_hole) << x << " " << y;
    }
  }
}

TEST(LocalMapOptions, ContradictionsAndMapsBeyondAllMemoryAreRefused) {
  LocalMapOptions options;
  EXPECT_TRUE(check_options(options));
  options.min_height_m = options.max_height_m;
  EXPECT_EQ(check_options(options).error().where, "min_height_m, max_height_m");
  options = {};
  options.max_height_m = std::nan("");
  EXPECT_EQ(check_options(options).error().where, "max_height_m");
  const auto square = [](double side_m) {
    return LevelArea(Eigen::Vector2d::Zero(), Eigen::Vector2d::Constant(side_m));
  };
  EXPECT_TRUE(local_map_fits(square(600.0), 0.1));  // 6000 x 6000 cells of 28 bytes: 0.94 GiB
  EXPECT_FALSE(local_map_fits(square(640.0), 0.1));
  EXPECT_TRUE(local_map_fits(square(640.0), 0.2));
}

}  // namespace
}  // namespace tread
