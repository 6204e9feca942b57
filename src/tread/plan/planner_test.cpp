#include "tread/plan/planner.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "grid_oracle.hpp"
#include "tread/plan/line_cost.hpp"

namespace tread {
namespace {

using testing::filled_grid;
using testing::part_in_cell;
using testing::random_grid;
using Points = std::vector<Eigen::Vector2d>;

constexpr float kWall = 80.0F;
const float kUnknown = std::numeric_limits<float>::quiet_NaN();

double polyline_cost(const Grid<float>& grid, const Points& points,
                     const GridSearchOptions& options) {
  double sum = 0.0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    sum += line_cost(grid, points[i - 1], points[i], options);
  }
  return sum;
}

// Does a closed lethal cell share a point with one of the lines, start and goal themselves aside?
bool touches_lethal(const Grid<float>& grid, const Points& points,
                    const GridSearchOptions& options) {
  const GridGeometry& geometry = grid.geometry;
  const auto in_cells = [&](const Eigen::Vector2d& p) {
    return Eigen::Vector2d((p - geometry.origin) / geometry.resolution_m);
  };
  for (std::size_t i = 1; i < points.size(); ++i) {
    Eigen::Vector2d a = in_cells(points[i - 1]);
    Eigen::Vector2d b = in_cells(points[i]);
    const Eigen::Vector2d towards = 1e-5 * (b - a).normalized();
    if (i == 1) a += towards;
    if (i + 1 == points.size()) b -= towards;
    for (int y = 0; y < geometry.rows; ++y) {
      for (int x = 0; x < geometry.columns; ++x) {
        if (std::isfinite(testing::oracle_cost(grid, {x, y}, options))) continue;
        const auto [first, last] = part_in_cell(a, b, {x, y}, 1e-8);
        if (first <= last) return true;
      }
    }
  }
  return false;
}

// Everything a found plan promises.
void check_plan(const Grid<float>& grid, const Eigen::Vector2d& start, const Eigen::Vector2d& goal,
                const PlannerOptions& options, const Plan& plan) {
  const GridSearchOptions search{options.lethal_cost, options.unexplored_cost};
  ASSERT_EQ(plan.status, PlanStatus::kFound) << plan.reason;
  EXPECT_TRUE(plan.reason.empty());
  ASSERT_GE(plan.path.size(), 2U);
  ASSERT_GE(plan.waypoints.size(), 2U);
  for (const Points* points : {&plan.path, &plan.waypoints}) {
    for (std::size_t i = 1; i < points->size(); ++i) EXPECT_NE((*points)[i - 1], (*points)[i]);
    EXPECT_EQ(points->front(), start);
    EXPECT_EQ(points->back(), goal);
    EXPECT_FALSE(touches_lethal(grid, *points, search));
  }
  const double path_cost = polyline_cost(grid, plan.path, search);
  EXPECT_NEAR(plan.cost, path_cost, 1e-9 * path_cost);
  const double cost = polyline_cost(grid, plan.waypoints, search);
  EXPECT_LE(cost, (1.0 + options.shortcut_tolerance) * path_cost + 1e-9);
  double length = 0.0;
  std::vector<std::size_t> index = {0};  // of the waypoints in the path
  for (std::size_t i = 1; i < plan.waypoints.size(); ++i) {
    length += (plan.waypoints[i] - plan.waypoints[i - 1]).norm();
    std::size_t k = index.back() + 1;
    while (k < plan.path.size() && plan.path[k] != plan.waypoints[i]) ++k;
    ASSERT_LT(k, plan.path.size()) << "waypoint is not of the path";
    index.push_back(k);
  }
  EXPECT_NEAR(plan.length_m, length, 1e-9);
  // None can be left out: the line past it is blocked or costs too much.
  for (std::size_t i = 1; i + 1 < plan.waypoints.size(); ++i) {
    const Eigen::Vector2d& before = plan.waypoints[i - 1];
    const Eigen::Vector2d& after = plan.waypoints[i + 1];
    if (!line_is_clear(grid, before, after, search)) continue;
    const auto first = plan.path.begin() + static_cast<std::ptrdiff_t>(index[i - 1]);
    const auto last = plan.path.begin() + static_cast<std::ptrdiff_t>(index[i + 1] + 1);
    const double replaced = polyline_cost(grid, Points(first, last), search);
    EXPECT_GT(line_cost(grid, before, after, search),
              (1.0 + options.shortcut_tolerance) * replaced);
  }
}

TEST(Planner, OpenGroundNeedsTwoWaypoints) {
  const Grid<float> grid = filled_grid(50, 40, 1.0F, 0.3, {-3.0, 2.0});
  const Eigen::Vector2d start(-2.9, 2.05);
  const PlannerOptions options{50.0, 1.0, 0.02};  // all ground alike, beyond the map too
  for (const Eigen::Vector2d& goal : {Eigen::Vector2d(11.3, 13.1), Eigen::Vector2d(-2.85, 2.1),
                                      Eigen::Vector2d(11.0, 2.0), Eigen::Vector2d(300.0, -40.0)}) {
    const Plan plan = plan_waypoints(grid, start, goal, options);
    check_plan(grid, start, goal, options, plan);
    EXPECT_EQ(plan.waypoints.size(), 2U);
    EXPECT_NEAR(plan.length_m, (goal - start).norm(), 1e-9);
    EXPECT_EQ(plan.goal_beyond_map, goal.x() > 100.0);
  }
}

TEST(Planner, GoesRoundAWallWithFewWaypoints) {
  Grid<float> grid = filled_grid(21, 21, 1.0F);
  for (int y = 0; y < 15; ++y) grid[{10, y}] = kWall;
  const Eigen::Vector2d start(2.2, 3.3);
  const Eigen::Vector2d goal(18.7, 3.1);
  const Plan plan = plan_waypoints(grid, start, goal, {});
  check_plan(grid, start, goal, {}, plan);
  EXPECT_EQ(plan.expanded, search_grid(grid, {2, 3}, {18, 3}, {}).expanded);
  // Over the end of the wall: by cells beside its corners (10, 15) and (11, 15), or a little off.
  EXPECT_GE(plan.waypoints.size(), 3U);
  EXPECT_LE(plan.waypoints.size(), 6U);
  const double taut = (Eigen::Vector2d(10.0, 15.0) - start).norm() + 1.0 +
                      (goal - Eigen::Vector2d(11.0, 15.0)).norm();
  EXPECT_GT(plan.length_m, taut);
  EXPECT_LT(plan.length_m, 1.08 * taut);
}

TEST(Planner, KeepsItsPromisesOnRandomMaps) {
  std::mt19937 random(21);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  int found = 0;
  int beyond = 0;
  for (unsigned seed = 0; seed < 60; ++seed) {
    for (const testing::Terrain terrain : testing::kAllTerrains) {
      const int columns = 1 + static_cast<int>(random() % 30);
      const int rows = 1 + static_cast<int>(random() % 30);
      const Grid<float> grid = random_grid(columns, rows, terrain, seed, 0.25, {-4.0, 8.0});
      const Eigen::Vector2d size = 0.25 * Eigen::Vector2d(columns, rows);
      const PlannerOptions options{50.0, 5.0, seed % 2 == 0 ? 0.02 : 0.0};
      const auto place = [&](double low, double high) {
        const auto part = [&] { return low + (high - low) * unit(random); };
        return Eigen::Vector2d(grid.geometry.origin.x() + part() * size.x(),
                               grid.geometry.origin.y() + part() * size.y());
      };
      for (int k = 0; k < 4; ++k) {
        const Eigen::Vector2d start = place(0.0, 1.0);
        const Eigen::Vector2d goal = k % 2 == 0 ? place(0.0, 1.0) : place(-1.0, 2.0);
        const Plan plan = plan_waypoints(grid, start, goal, options);
        if (plan.status != PlanStatus::kFound) {
          EXPECT_FALSE(plan.reason.empty());
          continue;
        }
        ++found;
        beyond += plan.goal_beyond_map ? 1 : 0;
        check_plan(grid, start, goal, options, plan);
        if (HasFailure()) FAIL() << "seed " << seed;
      }
    }
  }
  EXPECT_GT(found, 400);
  EXPECT_GT(beyond, 100);
}

TEST(Planner, EndsOnEdgesAndCornersOfCells) {
  // Cells of one metre; ends on a lattice of half metres meet edges and corners exactly.
  std::mt19937 random(4);
  int found = 0;
  for (unsigned seed = 0; seed < 150; ++seed) {
    const Grid<float> grid = random_grid(8, 6, testing::Terrain::kObstacles, seed);
    const auto place = [&] {
      return Eigen::Vector2d(static_cast<int>(random() % 16) / 2.0,
                             static_cast<int>(random() % 12) / 2.0);
    };
    const Eigen::Vector2d start = place();
    const Eigen::Vector2d goal = place();
    const Plan plan = plan_waypoints(grid, start, goal, {});
    if (start == goal || plan.status != PlanStatus::kFound) continue;
    check_plan(grid, start, goal, {}, plan);
    ++found;
  }
  EXPECT_GT(found, 30);
}

TEST(Planner, CornersOfTheMap) {
  const Grid<float> grid = filled_grid(6, 4, 1.0F, 0.5, {1.0, 1.0});
  const Eigen::Vector2d lower(1.0, 1.0);
  const Eigen::Vector2d upper(4.0, 3.0);  // a corner point of the map, and beyond it
  const Plan plan = plan_waypoints(grid, lower, upper, {});
  check_plan(grid, lower, upper, {}, plan);
  EXPECT_TRUE(plan.goal_beyond_map);
  EXPECT_EQ(plan.path[plan.path.size() - 2], grid.geometry.centre({5, 3}));
  EXPECT_FALSE(plan_waypoints(grid, upper - Eigen::Vector2d(0.1, 0.1), lower, {}).goal_beyond_map);
  EXPECT_EQ(plan_waypoints(grid, upper, lower, {}).status, PlanStatus::kStartOutside);
}

TEST(Planner, EndsInTheCentresOfCells) {
  Grid<float> grid = filled_grid(12, 9, 1.0F, 0.5, {-1.0, 4.0});
  for (int y = 0; y < 6; ++y) grid[{5, y}] = kWall;
  const GridGeometry& g = grid.geometry;
  for (const Cell& end : {Cell{1, 0}, Cell{0, 1}, Cell{11, 0}, Cell{11, 8}}) {
    const Plan plan = plan_waypoints(grid, g.centre({0, 0}), g.centre(end), {});
    check_plan(grid, g.centre({0, 0}), g.centre(end), {}, plan);
  }
}

// Each upper edge for itself: a start there is outside, a goal beyond.
TEST(Planner, UpperEdgesAreBeyondTheMap) {
  const Grid<float> grid = filled_grid(6, 4, 1.0F);
  const Eigen::Vector2d inside(2.5, 2.5);
  for (const Eigen::Vector2d& edge : {Eigen::Vector2d(6.0, 1.5), Eigen::Vector2d(1.5, 4.0)}) {
    EXPECT_EQ(plan_waypoints(grid, edge, inside, {}).status, PlanStatus::kStartOutside);
    const Plan plan = plan_waypoints(grid, inside, edge, {});
    check_plan(grid, inside, edge, {}, plan);
    EXPECT_TRUE(plan.goal_beyond_map);
  }
}

TEST(Planner, MapOfOneCell) {
  const Grid<float> grid = filled_grid(1, 1, 2.0F);
  const Eigen::Vector2d start(0.25, 0.5);
  for (const Eigen::Vector2d& goal :
       {Eigen::Vector2d(0.75, 0.5), Eigen::Vector2d(5.0, 0.5), Eigen::Vector2d(-3.0, -4.0)}) {
    const Plan plan = plan_waypoints(grid, start, goal, {});
    check_plan(grid, start, goal, {}, plan);
    EXPECT_EQ(plan.waypoints.size(), 2U);
  }
}

TEST(Planner, StartIsGoal) {
  const Eigen::Vector2d here(1.2, 0.7);
  const Plan plan = plan_waypoints(filled_grid(3, 3, 1.0F), here, here, {});
  ASSERT_EQ(plan.status, PlanStatus::kFound);
  EXPECT_EQ(plan.waypoints, (Points{here, here}));
  EXPECT_EQ(plan.path, (Points{here, here}));
  EXPECT_EQ(plan.length_m, 0.0);
  EXPECT_EQ(plan.cost, 0.0);
}

// Paper R: the unexplored cost "is higher than the cost associated with good terrain, causing the
// robot to tend towards places in the environment where it has seen flat ground".
TEST(Planner, PrefersSeenFlatGroundUpToTheRatioOfCosts) {
  const Eigen::Vector2d start(0.5, 20.5);
  const Eigen::Vector2d goal(10.5, 20.5);
  // A seen corridor of three sides: down by `depth`, across, and up again.
  const auto corridor = [](int depth) {
    Grid<float> grid = filled_grid(11, 21, kUnknown);
    for (int y = 20 - depth; y <= 20; ++y) grid[{0, y}] = grid[{10, y}] = 1.0F;
    for (int x = 0; x <= 10; ++x) grid[{x, 20 - depth}] = 1.0F;
    return grid;
  };
  PlannerOptions options;
  options.unexplored_cost = 4.0;
  options.shortcut_tolerance = 0.0;
  // Straight: 1 m in seen cells, 9 m at 4 = 37. Detour: 10 + 2 depth, less the cut corners.
  const auto lowest = [&](int depth) {
    double y = 1e9;
    for (const auto& p : plan_waypoints(corridor(depth), start, goal, options).path) {
      y = std::min(y, p.y());
    }
    return y;
  };
  EXPECT_DOUBLE_EQ(lowest(3), 17.5);
  EXPECT_DOUBLE_EQ(lowest(10), 10.5);  // 30 < 37
  EXPECT_DOUBLE_EQ(lowest(16), 20.5);  // 42 > 37
  options.unexplored_cost = 1.0;       // no dearer than good terrain: straight through
  EXPECT_DOUBLE_EQ(lowest(3), 20.5);
}

TEST(Planner, LeavesTheMapAndGoesStraightToTheGoal) {
  Grid<float> grid = filled_grid(10, 10, 1.0F);
  for (int y = 0; y < 8; ++y) grid[{6, y}] = kWall;
  const Eigen::Vector2d start(2.5, 2.5);
  const Eigen::Vector2d goal(40.5, 2.5);
  const Plan plan = plan_waypoints(grid, start, goal, {});
  check_plan(grid, start, goal, {}, plan);
  EXPECT_TRUE(plan.goal_beyond_map);
  const Eigen::Vector2d exit = plan.path[plan.path.size() - 2];
  EXPECT_DOUBLE_EQ(exit.x(), 9.5);
}

TEST(Planner, FarGoalsAndFarOriginsWork) {
  const Grid<float> grid =
      random_grid(40, 40, testing::Terrain::kObstacles, 8, 0.05, {512345.67, 5401234.56});
  Eigen::Vector2d start = grid.geometry.origin;
  for (int i = 0; i < 40; ++i) {
    if (grid[{i, 20}] < 50.0F) start = grid.geometry.centre({i, 20});
  }
  int found = 0;
  for (const Eigen::Vector2d& goal : {Eigen::Vector2d(512346.5, 5401235.0), Eigen::Vector2d(0, 0),
                                      Eigen::Vector2d(512347.41, 5401235.76)}) {
    const Plan plan = plan_waypoints(grid, start, goal, {});
    if (plan.status != PlanStatus::kFound) continue;
    check_plan(grid, start, goal, {}, plan);
    ++found;
  }
  EXPECT_GE(found, 1);
  // Too far for numbers: no plan, but an answer.
  EXPECT_EQ(plan_waypoints(filled_grid(3, 3, 1.0F), {1.0, 1.0}, {1e200, 0.0}, {}).status,
            PlanStatus::kUnreachable);
}

TEST(PlannerReasons, EmptyMap) {
  const Plan plan = plan_waypoints(Grid<float>{}, {0.0, 0.0}, {1.0, 1.0}, {});
  EXPECT_EQ(plan.status, PlanStatus::kMapEmpty);
  EXPECT_EQ(plan.reason, "the cost map has no cells: map some ground before planning");
  EXPECT_TRUE(plan.waypoints.empty());
}

TEST(PlannerReasons, StartOutside) {
  const Grid<float> grid = filled_grid(4, 4, 1.0F, 0.5);
  const Plan plan = plan_waypoints(grid, {-3.0, 0.3}, {1.0, 1.0}, {});
  EXPECT_EQ(plan.status, PlanStatus::kStartOutside);
  EXPECT_EQ(plan.reason,
            "the start (-3.00, 0.30) is not on the map, which spans (0.00, 0.00) to (2.00, 2.00); "
            "the nearest free place is (0.25, 0.25)");
  EXPECT_EQ(plan_waypoints(grid, {1e300, 0.3}, {1.0, 1.0}, {}).status, PlanStatus::kStartOutside);
}

TEST(PlannerReasons, StartAndGoalBlocked) {
  Grid<float> grid = filled_grid(5, 5, 1.0F);
  grid[{3, 4}] = kWall;
  grid[{2, 4}] = kWall;
  const Plan goal = plan_waypoints(grid, {0.5, 0.5}, {3.0, 4.0}, {});
  EXPECT_EQ(goal.status, PlanStatus::kGoalBlocked);
  EXPECT_EQ(goal.reason,
            "the goal (3.00, 4.00) lies in an obstacle (cost 80, lethal from 50); the nearest free place is "
            "(2.50, 3.50)");
  const Plan start = plan_waypoints(grid, {3.9, 4.5}, {0.5, 0.5}, {});
  EXPECT_EQ(start.status, PlanStatus::kStartBlocked);
  EXPECT_EQ(start.reason,
            "the start (3.90, 4.50) lies in an obstacle (cost 80, lethal from 50); the nearest free place is "
            "(4.50, 4.50)");
  const Plan none = plan_waypoints(filled_grid(2, 2, kWall), {0.5, 0.5}, {1.5, 1.5}, {});
  EXPECT_NE(none.reason.find("no place of the map is free: raise lethal_cost"), std::string::npos);
}

TEST(PlannerReasons, UnexploredGroundThatIsLethal) {
  PlannerOptions options;
  options.unexplored_cost = 60.0;
  Grid<float> grid = filled_grid(3, 3, 1.0F);
  grid[{2, 1}] = kUnknown;
  const Plan inside = plan_waypoints(grid, {0.5, 0.5}, {2.5, 1.6}, options);
  EXPECT_EQ(inside.status, PlanStatus::kGoalBlocked);
  EXPECT_EQ(inside.reason,
            "the goal (2.50, 1.60) lies in an obstacle (unexplored, cost 60, lethal from 50); the nearest "
            "free place is (2.50, 2.50)");
  const Plan beyond = plan_waypoints(grid, {0.5, 0.5}, {9.0, 0.5}, options);
  EXPECT_EQ(beyond.status, PlanStatus::kGoalBlocked);
  EXPECT_TRUE(beyond.waypoints.empty());
  EXPECT_EQ(beyond.reason,
            "the goal (9.00, 0.50) lies beyond the map in an obstacle (unexplored, cost 60, lethal from 50); "
            "lower unexplored_cost below lethal_cost; the nearest free place is (2.50, 0.50)");
}

TEST(PlannerReasons, Unreachable) {
  Grid<float> grid = filled_grid(9, 5, 1.0F);
  for (int y = 0; y < 5; ++y) grid[{4, y}] = kWall;
  const Plan inside = plan_waypoints(grid, {0.5, 0.5}, {7.5, 2.5}, {});
  EXPECT_EQ(inside.status, PlanStatus::kUnreachable);
  EXPECT_EQ(inside.reason,
            "obstacles (cost 50 and above) part the start (0.50, 0.50) from the goal (7.50, 2.50); "
            "the nearest place that can be reached is (3.50, 2.50)");
  EXPECT_TRUE(inside.path.empty());
  const Plan beyond = plan_waypoints(grid, {0.5, 0.5}, {20.0, 2.5}, {});
  EXPECT_EQ(beyond.status, PlanStatus::kUnreachable);
  EXPECT_EQ(beyond.reason,
            "obstacles (cost 50 and above) part the start (0.50, 0.50) from all exits of the map "
            "to the goal (20.00, 2.50); the nearest place that can be reached is (3.50, 2.50)");
  EXPECT_TRUE(beyond.goal_beyond_map);
}

TEST(Planner, ReportsItsTime) {
  Timings timings;
  (void)plan_waypoints(filled_grid(3, 3, 1.0F), {0.5, 0.5}, {2.5, 2.5}, {}, {1, &timings});
  ASSERT_TRUE(timings.entries().contains("plan/waypoints"));
  EXPECT_EQ(timings.entries().at("plan/waypoints").calls, 1);
}

TEST(PlannerOptions, AreDescribedWithTheirRanges) {
  PlannerOptions options;
  EXPECT_TRUE(check_options(options).has_value());
  EXPECT_TRUE(describe(options).set("unexplored_cost", "2.5").has_value());
  EXPECT_EQ(options.unexplored_cost, 2.5);
  EXPECT_FALSE(describe(options).set("lethal_cost", "0").has_value());
  EXPECT_FALSE(describe(options).set("unexplored_cost", "-1").has_value());
  EXPECT_FALSE(describe(options).set("shortcut_tolerance", "-0.1").has_value());
  options.shortcut_tolerance = 1.5;
  const Status bad = check_options(options);
  ASSERT_FALSE(bad.has_value());
  EXPECT_EQ(bad.error().where, "shortcut_tolerance");
  options.shortcut_tolerance = 0.0;
  options.unexplored_cost = options.lethal_cost;  // unexplored ground is lethal
  EXPECT_TRUE(check_options(options).has_value());
  options.unexplored_cost = 50.5;
  const Status above = check_options(options);
  ASSERT_FALSE(above.has_value());
  EXPECT_EQ(above.error().message(),
            "unexplored_cost, lethal_cost: 50.5 and 50, but unexplored ground must cost at most "
            "what is lethal. Change one of them.");
  EXPECT_EQ(describe(options).fields().size(), 3U);
}

TEST(PlanStatusNames, AllDiffer) {
  std::set<std::string> names;
  for (const PlanStatus status :
       {PlanStatus::kFound, PlanStatus::kMapEmpty, PlanStatus::kStartOutside,
        PlanStatus::kStartBlocked, PlanStatus::kGoalBlocked, PlanStatus::kUnreachable}) {
    names.insert(to_string(status));
  }
  EXPECT_EQ(names.size(), 6U);
  EXPECT_FALSE(names.contains("?"));
}

}  // namespace
}  // namespace tread
