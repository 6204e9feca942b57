#include "tread/plan/a_star.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <numbers>
#include <random>
#include <sstream>
#include <string>

#include "grid_oracle.hpp"
#include "test_data.hpp"

namespace tread {
namespace {

using std::numbers::sqrt2;
using testing::filled_grid;
using testing::kAllTerrains;
using testing::oracle_cost;
using testing::oracle_costs;
using testing::oracle_step;
using testing::part_in_cell;
using testing::random_grid;
using testing::Terrain;

constexpr float kWall = 100.0F;

// The cost of a path's steps, infinity if one is not allowed.
double steps_cost(const Grid<float>& grid, const std::vector<Cell>& cells,
                  const GridSearchOptions& options) {
  double sum = 0.0;
  for (std::size_t i = 1; i < cells.size(); ++i) {
    const int dx = cells[i].x - cells[i - 1].x;
    const int dy = cells[i].y - cells[i - 1].y;
    if (std::max(std::abs(dx), std::abs(dy)) != 1) return testing::kNever;
    sum += oracle_step(grid, cells[i - 1], dx, dy, options);
  }
  return sum;
}

// Rows of text, the first at the top: '#' is a wall.
Grid<float> drawn(const std::vector<std::string>& picture) {
  const int rows = static_cast<int>(picture.size());
  Grid<float> grid = filled_grid(static_cast<int>(picture[0].size()), rows, 1.0F);
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < grid.geometry.columns; ++x) {
      const std::string& line = picture[static_cast<std::size_t>(rows - 1 - y)];
      if (line[static_cast<std::size_t>(x)] == '#') grid[{x, y}] = kWall;
    }
  }
  return grid;
}

TEST(AStar, StepCostsLengthTimesMeanOfBothCells) {
  Grid<float> grid = filled_grid(2, 2, 1.0F, 0.5);
  grid[{1, 0}] = 3.0F;
  grid[{0, 1}] = 40.0F;
  grid[{1, 1}] = 5.0F;
  EXPECT_DOUBLE_EQ(search_grid(grid, {0, 0}, {1, 0}, {}).cost, 0.5 * 2.0);
  EXPECT_DOUBLE_EQ(search_grid(grid, {0, 0}, {1, 1}, {}).cost, 0.5 * sqrt2 * 3.0);
}

TEST(AStar, DiagonalStepNeedsBothCellsBesideIt) {
  EXPECT_DOUBLE_EQ(search_grid(drawn({"..", ".."}), {0, 0}, {1, 1}, {}).cost, sqrt2);
  EXPECT_DOUBLE_EQ(search_grid(drawn({"..", ".#"}), {0, 0}, {1, 1}, {}).cost, 2.0);
  EXPECT_DOUBLE_EQ(search_grid(drawn({"#.", ".."}), {0, 0}, {1, 1}, {}).cost, 2.0);
  EXPECT_FALSE(search_grid(drawn({"#.", ".#"}), {0, 0}, {1, 1}, {}).found);
}

TEST(AStar, WindingMazeHasKnownLength) {
  // Walls across with a gap at alternating ends: no step through a gap can be diagonal.
  for (const int columns : {2, 5, 8, 31}) {
    for (const int walls : {1, 2, 7}) {
      Grid<float> grid = filled_grid(columns, 2 * walls + 1, 1.0F);
      for (int wall = 0; wall < walls; ++wall) {
        const int gap = wall % 2 == 0 ? columns - 1 : 0;
        for (int x = 0; x < columns; ++x) {
          if (x != gap) grid[{x, 2 * wall + 1}] = kWall;
        }
      }
      const Cell goal{walls % 2 == 0 ? columns - 1 : 0, 2 * walls};
      const GridPath path = search_grid(grid, {0, 0}, goal, {});
      ASSERT_TRUE(path.found);
      EXPECT_NEAR(path.cost, (columns - 1) * (walls + 1) + 2 * walls, 1e-9);
      EXPECT_EQ(path.cells.size(), static_cast<std::size_t>(path.cost + 1.5));
    }
  }
}

TEST(AStar, DrawnMazeHasKnownLength) {
  const Grid<float> grid = drawn({
      "......#",  //
      ".####.#",  //
      ".#.....",  //
      ".#.###.",  //
      "...#...",
  });
  // (0,0) E E, N N, E E E, then N N to (5,4): diagonals would cut corners but at (2,2)-(5,2),
  // all of whose cells are in one row.
  const GridPath path = search_grid(grid, {0, 0}, {5, 4}, {});
  EXPECT_NEAR(path.cost, 9.0, 1e-12);
  EXPECT_EQ(path.cells.front(), (Cell{0, 0}));
  EXPECT_EQ(path.cells.back(), (Cell{5, 4}));
}

TEST(AStar, OpenGroundIsCrossedWithoutASideLook) {
  const Grid<float> grid = filled_grid(201, 101, 2.0F, 0.1);
  const GridPath path = search_grid(grid, {3, 90}, {190, 7}, {});
  EXPECT_NEAR(path.cost, 0.2 * ((187 - 83) + 83 * sqrt2), 1e-9);
  EXPECT_EQ(path.cells.size(), 188U);
  EXPECT_LE(path.expanded, 188U);
}

TEST(AStar, StartIsGoal) {
  const GridPath path = search_grid(filled_grid(1, 1, 1.0F), {0, 0}, {0, 0}, {});
  ASSERT_TRUE(path.found);
  EXPECT_EQ(path.cells, (std::vector<Cell>{{0, 0}}));
  EXPECT_EQ(path.cost, 0.0);
}

TEST(AStar, LethalStartOrGoalFindsNothing) {
  const float infinity = std::numeric_limits<float>::infinity();
  for (const float value : {50.0F, kWall, infinity}) {
    Grid<float> grid = filled_grid(3, 1, 1.0F);
    grid[{0, 0}] = value;
    EXPECT_FALSE(search_grid(grid, {0, 0}, {2, 0}, {}).found);
    EXPECT_FALSE(search_grid(grid, {2, 0}, {0, 0}, {}).found);
    EXPECT_FALSE(search_grid_to_exit(grid, {0, 0}, {-5.0, 0.5}, {}).found);
    EXPECT_TRUE(search_grid(grid, {2, 0}, {1, 0}, {}).cells.size() == 2);
  }
}

TEST(AStar, UnknownCostsTheUnexploredCostAndBlocksIfThatIsLethal) {
  Grid<float> grid = filled_grid(3, 1, std::numeric_limits<float>::quiet_NaN(), 2.0);
  EXPECT_DOUBLE_EQ(search_grid(grid, {0, 0}, {2, 0}, {50.0, 4.0}).cost, 16.0);
  EXPECT_FALSE(search_grid(grid, {0, 0}, {2, 0}, {50.0, 50.0}).found);
}

TEST(AStar, CostsOfNothingAndLessAreRaisedToTheSmallest) {
  for (const float value : {0.0F, -1.0F, -std::numeric_limits<float>::infinity()}) {
    const GridPath path = search_grid(filled_grid(9, 9, value), {0, 0}, {8, 8}, {});
    EXPECT_NEAR(path.cost, 8.0 * sqrt2 * double{kSmallestCost}, 1e-12);
  }
}

TEST(AStar, LethalFromTheLimitOn) {
  // 0.1 lies between two floats: the one below is free, the one above is lethal.
  const float below = std::nextafter(0.1F, 0.0F);
  ASSERT_LT(double{below}, 0.1);
  ASSERT_GT(double{0.1F}, 0.1);
  EXPECT_FALSE(CellCharge({0.1, 5.0}).lethal(below));
  EXPECT_TRUE(CellCharge({0.1, 5.0}).lethal(0.1F));
  // 0.7 is rounded down to a float, which is free therefore.
  ASSERT_LT(double{0.7F}, 0.7);
  EXPECT_FALSE(CellCharge({0.7, 5.0}).lethal(0.7F));
  EXPECT_TRUE(CellCharge({0.7, 5.0}).lethal(std::nextafter(0.7F, 1.0F)));
  const CellCharge without_limit({std::numeric_limits<double>::infinity(), 5.0});
  EXPECT_FALSE(without_limit.lethal(9e29F));
  EXPECT_TRUE(without_limit.lethal(1e30F));
}

TEST(AStar, CostsAsMuchAsDijkstraFinds) {
  std::mt19937 random(7);
  int found = 0;
  int not_found = 0;
  for (unsigned seed = 0; seed < 60; ++seed) {
    for (const Terrain terrain : kAllTerrains) {
      const int columns = 1 + static_cast<int>(random() % 40);
      const int rows = 1 + static_cast<int>(random() % 40);
      const Grid<float> grid = random_grid(columns, rows, terrain, seed, 0.3);
      const Cell from{static_cast<int>(random() % 1000) % columns,
                      static_cast<int>(random() % 1000) % rows};
      const Grid<double> least = oracle_costs(grid, from, {});
      for (int k = 0; k < 8; ++k) {
        const Cell goal{static_cast<int>(random() % 1000) % columns,
                        static_cast<int>(random() % 1000) % rows};
        const GridPath path = search_grid(grid, from, goal, {});
        ASSERT_EQ(path.found, std::isfinite(least[goal]));
        (path.found ? found : not_found) += 1;
        if (!path.found) continue;
        ASSERT_NEAR(path.cost, least[goal], 1e-9 * least[goal]) << "seed " << seed;
        ASSERT_EQ(path.cells.front(), from);
        ASSERT_EQ(path.cells.back(), goal);
        ASSERT_NEAR(steps_cost(grid, path.cells, {}), path.cost, 1e-9 * path.cost);
      }
    }
  }
  EXPECT_GT(found, 500);
  EXPECT_GT(not_found, 200);
}

TEST(AStar, StaysExactWhereCostsLieFarApart) {
  // Nearly free ground in a sea of dear ground: all of it falls into one bucket of the queue.
  Grid<float> grid = random_grid(120, 120, Terrain::kWeights, 3);
  for (int y = 20; y < 100; ++y) {
    for (int x = 20; x < 100; ++x) grid[{x, y}] = 0.001F * grid[{x, y}];
  }
  grid[{60, 60}] = 1e7F;
  const GridSearchOptions options{1e9, 5.0};
  const Grid<double> least = oracle_costs(grid, {0, 0}, options);
  for (const Cell goal : {Cell{119, 119}, Cell{99, 20}, Cell{60, 60}, Cell{5, 110}}) {
    const GridPath path = search_grid(grid, {0, 0}, goal, options);
    EXPECT_NEAR(path.cost, least[goal], 1e-9 * least[goal]);
    // Visits in vain end by exact order: at most 4/3 of all cells before it, all once after.
    EXPECT_LE(path.expanded, grid.values.size() * 7 / 3 + 2000);
  }
}

TEST(AStar, SamePathOnEveryRunAndForAShiftedMap) {
  Grid<float> grid = random_grid(60, 50, Terrain::kObstacles, 2);
  grid[{1, 1}] = grid[{57, 46}] = 1.0F;
  Grid<float> shifted = grid;
  shifted.geometry.origin = {100.0, -20.0};
  const GridPath one = search_grid(grid, {1, 1}, {57, 46}, {});
  const GridPath two = search_grid(grid, {1, 1}, {57, 46}, {});
  ASSERT_TRUE(one.found);
  EXPECT_EQ(one.cells, two.cells);
  EXPECT_EQ(one.expanded, two.expanded);
  EXPECT_EQ(one.cells, search_grid(shifted, {1, 1}, {57, 46}, {}).cells);
}

// Brute force: the least cost over all border cells whose line to the goal (in metres) enters the
// inside of no other cell and touches no lethal one.
double least_exit_cost(const Grid<float>& grid, Cell start, const Eigen::Vector2d& goal,
                       const GridSearchOptions& options) {
  const GridGeometry& geometry = grid.geometry;
  const Grid<double> least = oracle_costs(grid, start, options);
  const Eigen::Vector2d b = (goal - geometry.origin) / geometry.resolution_m;
  double best = testing::kNever;
  for (int y = 0; y < geometry.rows; ++y) {
    for (int x = 0; x < geometry.columns; ++x) {
      if (std::isinf(least[{x, y}])) continue;
      const Eigen::Vector2d a(x + 0.5, y + 0.5);
      bool exit = true;
      for (int v = 0; v < geometry.rows && exit; ++v) {
        for (int u = 0; u < geometry.columns && exit; ++u) {
          if (u == x && v == y) continue;
          const bool lethal = std::isinf(oracle_cost(grid, {u, v}, options));
          const auto [first, last] = part_in_cell(a, b, {u, v}, lethal ? 1e-9 : -1e-9);
          exit = first > last;
        }
      }
      const double rest = (goal - geometry.centre({x, y})).norm() * options.unexplored_cost;
      if (exit) best = std::min(best, least[{x, y}] + rest);
    }
  }
  return best;
}

TEST(AStarToExit, CostsAsMuchAsTheBestOfAllExits) {
  std::mt19937 random(11);
  int found = 0;
  int not_found = 0;
  for (unsigned seed = 0; seed < 40; ++seed) {
    for (const Terrain terrain : kAllTerrains) {
      const int columns = 1 + static_cast<int>(random() % 14);
      const int rows = 1 + static_cast<int>(random() % 14);
      const Grid<float> grid = random_grid(columns, rows, terrain, seed, 0.5, {-2.0, 3.0});
      const GridSearchOptions options{50.0, seed % 3 == 0 ? 0.5 : 5.0};
      const Cell start{static_cast<int>(random() % 100) % columns,
                       static_cast<int>(random() % 100) % rows};
      for (int k = 0; k < 6; ++k) {
        // Steps of a quarter of a cell, so that corners and edges are met exactly.
        Eigen::Vector2d u(static_cast<int>(random() % 200) - 80,
                          static_cast<int>(random() % 200) - 80);
        u /= 4.0;
        if (u.x() >= 0.0 && u.y() >= 0.0 && u.x() < columns && u.y() < rows) continue;
        const Eigen::Vector2d goal = grid.geometry.origin + 0.5 * u;
        const double expected = least_exit_cost(grid, start, goal, options);
        const GridPath path = search_grid_to_exit(grid, start, goal, options);
        ASSERT_EQ(path.found, std::isfinite(expected)) << "seed " << seed;
        (path.found ? found : not_found) += 1;
        if (!path.found) continue;
        ASSERT_NEAR(path.cost, expected, 1e-9 * expected) << "seed " << seed;
        const double rest =
            options.unexplored_cost * (goal - grid.geometry.centre(path.cells.back())).norm();
        ASSERT_NEAR(steps_cost(grid, path.cells, options) + rest, path.cost, 1e-9 * path.cost);
      }
    }
  }
  EXPECT_GT(found, 400);
  EXPECT_GT(not_found, 50);
}

TEST(AStarToExit, WalksOnSeenGroundAsFarAsItLeads) {
  const Grid<float> grid = filled_grid(10, 3, 1.0F);
  const GridPath path = search_grid_to_exit(grid, {0, 1}, {19.5, 1.5}, {});
  EXPECT_EQ(path.cells.back(), (Cell{9, 1}));
  EXPECT_NEAR(path.cost, 9.0 + 10.0 * 5.0, 1e-9);
}

TEST(AStarToExit, LeavesOnTheSideOfTheGoalOnly) {
  // A wall across: the goal is behind it, and no line from this side goes out without crossing.
  Grid<float> grid = filled_grid(9, 9, 1.0F);
  for (int x = 0; x < 9; ++x) grid[{x, 5}] = kWall;
  EXPECT_FALSE(search_grid_to_exit(grid, {4, 2}, {4.5, 20.0}, {}).found);
  EXPECT_TRUE(search_grid_to_exit(grid, {4, 2}, {4.5, -20.0}, {}).found);
  // Dear at first, but the wall ends: around it.
  grid[{8, 5}] = 1.0F;
  const GridPath around = search_grid_to_exit(grid, {4, 2}, {4.5, 20.0}, {});
  ASSERT_TRUE(around.found);
  EXPECT_EQ(around.cells.back().y, 8);
}

TEST(AStarToExit, NothingWhereUnexploredGroundIsLethal) {
  const Grid<float> grid = filled_grid(3, 3, 1.0F);
  EXPECT_FALSE(search_grid_to_exit(grid, {1, 1}, {9.0, 1.0}, {50.0, 60.0}).found);
}

TEST(AStarToExit, GoalTooFarForNumbersFindsNothingAndEnds) {
  const Grid<float> grid = filled_grid(3, 3, 1.0F);
  EXPECT_FALSE(search_grid_to_exit(grid, {1, 1}, {1e200, 1.0}, {}).found);
}

struct Query {
  Cell start;
  Cell goal;
  double length = 0.0;
};

// Row 0 of the file is row 0 of the grid: mirrored, which changes no length.
Grid<float> read_map(const std::filesystem::path& file) {
  std::ifstream text(file);
  std::string word;
  int rows = 0;
  int columns = 0;
  text >> word >> word >> word >> rows >> word >> columns >> word;
  Grid<float> grid = filled_grid(columns, rows, 1.0F);
  for (int y = 0; y < rows; ++y) {
    text >> word;
    for (int x = 0; x < columns; ++x) {
      const char c = word.at(static_cast<std::size_t>(x));
      if (c != '.' && c != 'G') grid[{x, y}] = kWall;
    }
  }
  return grid;
}

std::vector<Query> read_queries(const std::filesystem::path& file) {
  std::ifstream text(file);
  std::vector<Query> queries;
  std::string line;
  std::getline(text, line);
  while (std::getline(text, line)) {
    std::istringstream words(line);
    std::string skipped;
    Query query;
    words >> skipped >> skipped >> skipped >> skipped >> query.start.x >> query.start.y >>
        query.goal.x >> query.goal.y >> query.length;
    if (words) queries.push_back(query);
  }
  return queries;
}

void check_queries(const std::filesystem::path& folder, const std::string& name,
                   std::size_t expected_queries, std::size_t expected_without, double tolerance) {
  const Grid<float> grid = read_map(folder / (name + ".map"));
  const std::vector<Query> queries = read_queries(folder / (name + ".map.scen"));
  ASSERT_EQ(queries.size(), expected_queries);
  std::size_t without = 0;
  for (const Query& query : queries) {
    const GridPath path = search_grid(grid, query.start, query.goal, {});
    without += path.found ? 0 : 1;
    if (!path.found) continue;
    ASSERT_NEAR(path.cost, query.length, tolerance * query.length)
        << name << " from " << query.start.x << " " << query.start.y;
    ASSERT_NEAR(steps_cost(grid, path.cells, {}), path.cost, 1e-9 * path.cost);
  }
  EXPECT_EQ(without, expected_without);
}

TEST(AStar, FindsThePublishedLengthsOfMovingAiMaps) {
  TREAD_NEEDS_DATA(folder, "movingai");
  check_queries(folder, "arena", 160, 0, 5e-5);
  check_queries(folder, "Berlin_0_256", 930, 0, 1e-6);
  check_queries(folder, "random512-10-5", 1790, 0, 1e-6);
  check_queries(folder, "rmtst01", 470, 2, 1e-5);
}

}  // namespace
}  // namespace tread
