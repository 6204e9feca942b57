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

Grid<float> heights(const std::vector<Vector3f>& points, const LocalMapOptions& options = {},
                    const Isometry3d& T = Isometry3d::Identity()) {
  LocalMapBuilder builder;
  return builder.build(points, T, options);
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
  EXPECT_EQ(map.geometry.rows, 120);  // 12 m across: at most 120 x 120 with what is behind
  EXPECT_EQ(map.geometry.cell_at({0.05, -5.95}), (Cell{0, 0}));
  LocalMapOptions options;
  options.behind_m = 6.0;
  EXPECT_EQ(heights({}, options).geometry.columns, 120);
}

// "a model of at least 2 m^2" of cells of 5 mm is 80 000 cells. Paper Q's camera, 1 m above the
// ground and looking straight down, fills them from one image of 640 x 480: 1.92 x 1.44 m.
TEST(PaperQ, TwoSquareMetresAre80000CellsOfFiveMillimetres) {
  LocalMapOptions options;
  options.resolution_m = 0.005;
  options.range_m = 1.0;
  const GridGeometry half = heights({}, options).geometry;  // 1 m ahead, 2 m across
  EXPECT_EQ(half.columns * half.rows, 80000);

  const RectifiedRig rig = rectified_rig(bumblebee2(640)).value();
  std::vector<Vector3f> points;
  for (int v = 0; v < rig.size.height; ++v) {
    for (int u = 0; u < rig.size.width; ++u) points.push_back(rig.point(u, v, 1.0).cast<float>());
  }
  options.behind_m = 1.0;
  options.min_points = 1;
  const CameraMount mount = level_mount(1.0, 90.0 * kDegree, false);
  int known = 0;
  for (float height : heights(points, options, mount.T_body_left).values) {
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
  options = {};
  options.range_m = 460.0;  // 4600 x 9200 cells of 24 bytes: 0.95 GiB
  EXPECT_TRUE(check_options(options));
  options.behind_m = 460.0;
  EXPECT_EQ(check_options(options).error().where, "resolution_m, range_m, behind_m");
  options.resolution_m = 0.2;
  EXPECT_TRUE(check_options(options));
}

}  // namespace
}  // namespace tread
