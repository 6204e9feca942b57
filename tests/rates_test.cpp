// The rates that the papers print, on this machine: nothing as fine as a benchmark, but a stage
// that becomes ten times slower fails here. Only in builds that are optimised and not instrumented.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include "stereo_images.hpp"
#include "tread/plan/a_star.hpp"
#include "tread/plan/planner.hpp"
#include "tread/stereo/depth.hpp"
#include "tread/stereo/stereo_matcher.hpp"
#include "tread/terrain/cost_map.hpp"
#include "tread/terrain/local_map.hpp"

namespace tread {
namespace {

#ifdef NDEBUG
constexpr bool kOptimised = true;
#else
constexpr bool kOptimised = false;
#endif

#define TREAD_NEEDS_OPTIMISED_CODE() \
  if (!kOptimised) GTEST_SKIP() << "needs an optimised build: preset release"

// The best of some runs: other work on the machine can only add.
double best_seconds(int runs, const std::function<void()>& work) {
  double best = std::numeric_limits<double>::infinity();
  for (int i = 0; i < runs; ++i) {
    const auto start = std::chrono::steady_clock::now();
    work();
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    best = std::min(best, elapsed.count());
  }
  return best;
}

// Ground from 0.8 m at the lower border to 4 m at the upper one, as the walker's camera sees it.
testing::Pair slanted_ground() {
  return testing::textured_pair(640, 480, 3, [](int, int y) { return 10.0 + 40.0 * y / 480.0; });
}

// "640 x 480 at 15 Hz", on four threads; disparity and depth.
TEST(Rates, PaperQStereoAt15Hz) {
  TREAD_NEEDS_OPTIMISED_CODE();
  const testing::Pair pair = slanted_ground();
  const RectifiedRig rig = rectified_rig(bumblebee2(640)).value();
  StereoMatcher matcher;
  Image<float> depth;
  const double seconds = best_seconds(8, [&] {
    const auto disparity =
        matcher.match(pair.left, pair.right, paper_q_stereo_options(), Context{4, nullptr});
    ASSERT_TRUE(disparity);
    depth_image(*disparity, rig, {}, depth);
  });
  EXPECT_LT(seconds, 1.0 / 15.0);
}

// Paper R: stereo at 4 Hz a computer, with the defaults on one thread, left to the cloud.
TEST(Rates, PaperRStereoAt4HzAComputer) {
  TREAD_NEEDS_OPTIMISED_CODE();
  const testing::Pair pair = slanted_ground();
  const RectifiedRig rig = rectified_rig(bumblebee2(640)).value();
  StereoMatcher matcher;
  Image<float> depth;
  PointCloud cloud;
  const double seconds = best_seconds(3, [&] {
    const auto disparity = matcher.match(pair.left, pair.right, {});
    ASSERT_TRUE(disparity);
    depth_image(*disparity, rig, {0.8, 6.0}, depth);
    depth_cloud(depth, rig, Reference::kLeft, {}, cloud);
  });
  EXPECT_GT(cloud.points.size(), 200000U);
  EXPECT_LT(seconds, 1.0 / 4.0);
}

// Map building at 15 to 20 Hz: from the points of a full image to the cost map, at ever new poses.
TEST(Rates, PaperRMapBuildingAt20Hz) {
  TREAD_NEEDS_OPTIMISED_CODE();
  const RectifiedRig rig = rectified_rig(bumblebee2(640)).value();
  const CameraMount mount = level_mount(1.0, 0.35, true);
  std::vector<Eigen::Vector3f> points;
  for (int v = 200; v < 480; ++v) {
    for (int u = 0; u < 640; ++u) {
      const Eigen::Vector3d ray = mount.T_body_left.linear() * rig.point(u, v, 1.0);
      const double depth = -1.0 / ray.z();
      if (depth > 0.0 && depth < 6.0) points.push_back(rig.point(u, v, depth).cast<float>());
    }
  }
  ASSERT_GT(points.size(), 150000U);
  const GridGeometry cells = local_cells(view_from_above(rig, mount.T_body_left, 6.0), 0.1);
  LocalMapBuilder builder;
  Grid<float> known;
  Grid<float> derivative;
  GlobalMap ground;
  CostMap cost;
  double x = 0.0;
  std::size_t changed = 0;
  const double seconds = best_seconds(10, [&] {
    const LevelPose pose{{x, 0.0, 0.0}, 0.1 * x};
    ground.heights_below(cells, pose, known);
    const Grid<float>& height = builder.build(points, mount.T_body_left, cells, {}, {&known});
    sobel_squared(height, derivative);
    ASSERT_TRUE(ground.integrate(height, derivative, pose, {}));
    const std::vector<Cell> changes = ground.take_changes();
    changed += changes.size();
    cost.update(ground, changes);
    x += 0.5;
  });
  EXPECT_GT(changed, 2000U);
  EXPECT_LT(seconds, 1.0 / 20.0);
}

// A course of about 150 m: 1500 x 1500 ground cells of 0.1 m, 500 x 500 cost cells of 0.3 m, and
// the planner's 2 Hz on them from corner to corner. Rough everywhere, a few walls with one gap
// each.
TEST(Rates, PaperRCourseOf150MetresIsPlannedAt2Hz) {
  const GridGeometry geometry{0.1, {0.0, 0.0}, 1500, 1500};
  Grid<float> derivative(geometry, 0.0F);
  std::mt19937 random(4);
  for (float& value : derivative.values) value = static_cast<float>(random() % 100) / 500.0F;
  for (int wall = 0; wall < 4; ++wall) {
    for (int y = 0; y < 1400; ++y) {
      for (int x = 0; x < 6; ++x) {
        derivative[{300 * (wall + 1) + x, wall % 2 == 0 ? y : 1499 - y}] = 5.0F;
      }
    }
  }
  GlobalMap ground;
  GlobalMapOptions copy;
  copy.first = GlobalMapOptions::First::kCopy;
  ASSERT_TRUE(ground.integrate(Grid<float>(geometry, 0.0F), derivative, {}, copy));
  CostMap cost;
  cost.update(ground, ground.take_changes());
  const Grid<float> grid = cost.grid();
  // The course and the two cells around it whose windows reach in.
  ASSERT_EQ(grid.geometry.columns, 504);
  ASSERT_EQ(grid.geometry.rows, 504);
  const Eigen::Vector2d start(1.0, 1.0), goal(149.0, 149.0);
  Plan plan;
  const double seconds = best_seconds(3, [&] { plan = plan_waypoints(grid, start, goal, {}); });
  ASSERT_EQ(plan.status, PlanStatus::kFound) << plan.reason;
  // Up, down, up, down and up again past the ends of the walls.
  EXPECT_GT(plan.length_m, 500.0);
  EXPECT_LT(seconds, 0.5);
}

// The same course searched on the ground cells themselves: nine times as many.
TEST(Rates, AStarOn1500x1500CellsInHalfASecond) {
  TREAD_NEEDS_OPTIMISED_CODE();
  Grid<float> grid(GridGeometry{0.1, {0.0, 0.0}, 1500, 1500}, 1.0F);
  std::mt19937 random(5);
  for (int k = 0; k < 4000; ++k) {
    const int x = static_cast<int>(random() % 1490), y = static_cast<int>(random() % 1490);
    if (x + y < 40 || x + y > 2940) continue;
    for (int v = y; v < y + 8; ++v) {
      for (int u = x; u < x + 8; ++u) grid[{u, v}] = 100.0F;
    }
  }
  GridPath path;
  const double seconds = best_seconds(3, [&] {
    path = search_grid(grid, {0, 0}, {1499, 1499}, {});
  });
  ASSERT_TRUE(path.found);
  EXPECT_GE(path.cost, 1499 * 0.1 * std::sqrt(2.0) - 1e-6);
  EXPECT_LT(seconds, 0.5);
}

}  // namespace
}  // namespace tread
