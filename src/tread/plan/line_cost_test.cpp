#include "tread/plan/line_cost.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "grid_oracle.hpp"

namespace tread {
namespace {

using std::numbers::sqrt2;
using testing::filled_grid;
using testing::oracle_cost;
using testing::part_in_cell;

Grid<float> with_wall_at(int columns, int rows, Cell wall) {
  Grid<float> grid = filled_grid(columns, rows, 1.0F);
  grid[wall] = 100.0F;
  return grid;
}

TEST(LineCost, IsExactInEachCell) {
  Grid<float> grid = filled_grid(3, 2, 1.0F, 0.5, {10.0, 20.0});
  grid[{1, 0}] = 4.0F;
  grid[{2, 0}] = 10.0F;
  // Cells of half a metre: 0.25 m at 1, 0.5 m at 4, 0.125 m at 10.
  EXPECT_NEAR(line_cost(grid, {10.25, 20.1}, {11.125, 20.1}, {}), 0.25 + 2.0 + 1.25, 1e-12);
  EXPECT_NEAR(line_cost(grid, {11.125, 20.1}, {10.25, 20.1}, {}), 0.25 + 2.0 + 1.25, 1e-12);
  // Straight up through cells of one cost; within one cell; no length at all.
  EXPECT_NEAR(line_cost(grid, {10.1, 20.0}, {10.1, 20.9}, {}), 0.9, 1e-12);
  EXPECT_NEAR(line_cost(grid, {10.6, 20.1}, {10.9, 20.5}, {}), 4.0 * 0.5, 1e-12);
  EXPECT_EQ(line_cost(grid, {10.6, 20.1}, {10.6, 20.1}, {}), 0.0);
}

TEST(LineCost, OutsideCostsAsUnexploredGround) {
  const Grid<float> grid = filled_grid(2, 2, 1.0F);
  EXPECT_NEAR(line_cost(grid, {0.5, 0.5}, {12.0, 0.5}, {}), 1.5 + 50.0, 1e-12);
  EXPECT_NEAR(line_cost(grid, {-3.0, 0.5}, {4.0, 0.5}, {}), 15.0 + 2.0 + 10.0, 1e-12);
  EXPECT_NEAR(line_cost(grid, {-3.0, 5.0}, {4.0, 5.0}, {}), 35.0, 1e-12);
  EXPECT_NEAR(line_cost(grid, {-1.0, 1.5}, {1.5, 4.0}, {}), 5.0 * 2.5 * sqrt2, 1e-12);
  EXPECT_NEAR(line_cost(grid, {0.5, 0.5}, {0.5, 1e9}, {}), 1.5 + 5.0 * (1e9 - 2.0), 1e-3);
}

// As for all cells: the lower edges of the map are on it, the upper ones beyond it.
TEST(LineCost, AlongTheEdgesOfTheMap) {
  const Grid<float> grid = filled_grid(4, 3, 1.0F);
  EXPECT_NEAR(line_cost(grid, {1.0, 0.0}, {3.0, 0.0}, {}), 2.0, 1e-12);
  EXPECT_NEAR(line_cost(grid, {0.0, 1.0}, {0.0, 3.0}, {}), 2.0, 1e-12);
  EXPECT_NEAR(line_cost(grid, {1.0, 3.0}, {3.0, 3.0}, {}), 10.0, 1e-12);
  EXPECT_NEAR(line_cost(grid, {4.0, 1.0}, {4.0, 3.0}, {}), 10.0, 1e-12);
}

TEST(LineCost, StepBetweenCentresCostsWhatTheSearchCharges) {
  Grid<float> grid = filled_grid(2, 2, 100.0F, 0.3, {-7.0, 1e5});
  grid[{0, 0}] = 3.0F;
  grid[{1, 1}] = 8.0F;
  // Exactly through the corner: the walls beside it have no length.
  const GridGeometry& g = grid.geometry;
  EXPECT_NEAR(line_cost(grid, g.centre({0, 0}), g.centre({1, 1}), {}), 0.3 * sqrt2 * 5.5, 1e-9);
}

TEST(LineCost, InfiniteThroughALethalCell) {
  const Grid<float> grid = with_wall_at(3, 1, {1, 0});
  EXPECT_TRUE(std::isinf(line_cost(grid, {0.5, 0.5}, {2.5, 0.5}, {})));
}

TEST(LineCost, IsTheSumOfThePartsInAllCells) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-3.0, 15.0);
  for (unsigned seed = 0; seed < 200; ++seed) {
    const Grid<float> grid = testing::random_grid(12, 9, testing::Terrain::kWeights, seed);
    const Eigen::Vector2d a(place(random), place(random));
    const Eigen::Vector2d b(place(random), place(random));
    double inside = 0.0;
    double sum = 0.0;
    for (int y = 0; y < 9; ++y) {
      for (int x = 0; x < 12; ++x) {
        const auto [first, last] = part_in_cell(a, b, {x, y}, 0.0);
        if (first >= last) continue;
        inside += last - first;
        sum += (last - first) * oracle_cost(grid, {x, y}, {});
      }
    }
    const double expected = (sum + 5.0 * (1.0 - inside)) * (b - a).norm();
    EXPECT_NEAR(line_cost(grid, a, b, {}), expected, 1e-9 * expected);
  }
}

TEST(LineIsClear, NotThroughALethalCell) {
  const Grid<float> grid = with_wall_at(5, 5, {2, 2});
  EXPECT_FALSE(line_is_clear(grid, {0.5, 2.5}, {4.5, 2.5}, {}));
  EXPECT_FALSE(line_is_clear(grid, {2.5, 4.5}, {2.5, 0.5}, {}));
  EXPECT_FALSE(line_is_clear(grid, {0.5, 0.5}, {4.5, 4.5}, {}));
  EXPECT_TRUE(line_is_clear(grid, {0.5, 1.5}, {4.5, 1.5}, {}));
  EXPECT_TRUE(line_is_clear(grid, {1.5, 4.5}, {1.5, 0.5}, {}));
}

TEST(LineIsClear, CornersAndEdgesTouch) {
  const Grid<float> grid = with_wall_at(5, 5, {2, 2});
  // Through the corner (2, 3) from below left and along it: both cells beside a corner count.
  EXPECT_FALSE(line_is_clear(grid, {1.5, 2.5}, {2.5, 3.5}, {}));
  EXPECT_FALSE(line_is_clear(grid, {2.5, 3.5}, {1.5, 2.5}, {}));
  EXPECT_FALSE(line_is_clear(grid, {0.5, 4.5}, {3.5, 1.5 - 1e-9}, {}));
  // Along each of its edges.
  EXPECT_FALSE(line_is_clear(grid, {0.5, 2.0}, {4.5, 2.0}, {}));
  EXPECT_FALSE(line_is_clear(grid, {0.5, 3.0}, {4.5, 3.0}, {}));
  EXPECT_FALSE(line_is_clear(grid, {2.0, 0.5}, {2.0, 4.5}, {}));
  EXPECT_FALSE(line_is_clear(grid, {3.0, 4.5}, {3.0, 0.5}, {}));
  // A hair beside the edge is not on it.
  EXPECT_TRUE(line_is_clear(grid, {0.5, 2.0 - 1e-4}, {4.5, 2.0 - 1e-4}, {}));
}

TEST(LineIsClear, AnEndOnTheEdgeOfAnObstacleDoesNotBlock) {
  const Grid<float> grid = with_wall_at(5, 5, {2, 2});
  // (3, 2.5) is in cell (3, 2), on the edge of the wall; (2, 2.5) is in the wall.
  EXPECT_TRUE(line_is_clear(grid, {3.0, 2.5}, {4.5, 2.5}, {}));
  EXPECT_TRUE(line_is_clear(grid, {4.5, 4.0}, {3.0, 2.5}, {}));
  EXPECT_FALSE(line_is_clear(grid, {3.0, 2.5}, {1.5, 2.5}, {}));
  EXPECT_FALSE(line_is_clear(grid, {2.0, 2.5}, {0.5, 2.5}, {}));
  EXPECT_FALSE(line_is_clear(grid, {0.5, 2.5}, {2.0, 2.5}, {}));
  EXPECT_TRUE(line_is_clear(grid, {3.0, 2.5}, {3.0, 2.5}, {}));
}

TEST(LineIsClear, OutsideIsFree) {
  const Grid<float> grid = with_wall_at(3, 3, {0, 0});
  EXPECT_TRUE(line_is_clear(grid, {-1.0, 0.0 - 0.1}, {9.0, -0.1}, {}));
  EXPECT_TRUE(line_is_clear(grid, {2.5, 2.5}, {1e12, 3e11}, {}));
  EXPECT_FALSE(line_is_clear(grid, {-1.0, 0.5}, {9.0, 0.5}, {}));
  EXPECT_FALSE(line_is_clear(grid, {1.5, 1.5}, {-1e9, -1e9}, {}));
}

TEST(LineIsClear, AgreesWithTheClippingOfEveryCell) {
  std::mt19937 random(9);
  int clear = 0;
  int blocked = 0;
  for (unsigned seed = 0; seed < 600; ++seed) {
    Grid<float> grid = filled_grid(11, 13, 1.0F);
    for (float& value : grid.values) value = random() % 12 == 0 ? 100.0F : 1.0F;
    // Eighths of a cell off its edges: many corners are met exactly, no end is on an edge.
    const auto place = [&](int cells) {
      return (static_cast<int>(random() % (8 * static_cast<unsigned>(cells))) / 4 * 2 + 1) / 8.0;
    };
    const Eigen::Vector2d a(place(11), place(13));
    const Eigen::Vector2d b(place(11), place(13));
    bool expected = true;
    for (int y = 0; y < 13; ++y) {
      for (int x = 0; x < 11; ++x) {
        if (grid[{x, y}] < 50.0F) continue;
        const auto [first, last] = part_in_cell(a, b, {x, y}, 1e-9);
        expected = expected && first > last;
      }
    }
    EXPECT_EQ(line_is_clear(grid, a, b, {}), expected)
        << a.transpose() << " to " << b.transpose() << " seed " << seed;
    (expected ? clear : blocked) += 1;
  }
  EXPECT_GT(clear, 100);
  EXPECT_GT(blocked, 100);
}

}  // namespace
}  // namespace tread
