#include "tread/terrain/cost_map.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <utility>

namespace tread {
namespace {

// A map that has measured one derivative everywhere in a square of 12 m around the origin.
GlobalMap uniform_map(float derivative) {
  GlobalMap map;
  GlobalMapOptions copy;
  copy.first = GlobalMapOptions::First::kCopy;
  const GridGeometry geometry{0.1, {-6.0, -6.0}, 120, 120};
  EXPECT_TRUE(
      map.integrate(Grid<float>(geometry, 0.0F), Grid<float>(geometry, derivative), {}, copy));
  return map;
}

// Sets single cells by integrating a map of one cell.
void set_derivative(GlobalMap& map, Cell cell, float derivative) {
  GlobalMapOptions replace;
  replace.alpha = 1.0;
  const GridGeometry one{0.1, {0.1 * cell.x, 0.1 * cell.y}, 1, 1};
  EXPECT_TRUE(map.integrate(Grid<float>(one, 0.0F), Grid<float>(one, derivative), {}, replace));
}

CostMap costs_of(GlobalMap& map, const CostOptions& options = {}) {
  CostMap costs(options);
  costs.update(map, map.take_changes());
  return costs;
}

// The knots of METHODS 8.2 without the cap raised.
CostOptions capped_at_100() {
  CostOptions options;
  options.knots.pop_back();
  return options;
}

TEST(Interpolate, HoldsTheEndsAndIsLinearBetween) {
  const Knots knots = CostOptions{}.knots;
  EXPECT_EQ(interpolate(knots, -1.0), 1.0);
  EXPECT_EQ(interpolate(knots, 0.04), 1.0);
  EXPECT_NEAR(interpolate(knots, 0.10), 10.5, 1e-12);
  EXPECT_NEAR(interpolate(knots, 0.16), 20.0, 1e-12);
  EXPECT_NEAR(interpolate(knots, 0.40), 60.0, 1e-12);
  EXPECT_NEAR(interpolate(knots, 0.64), 100.0, 1e-12);
  EXPECT_EQ(interpolate(knots, 50.0), 1000.0);
  EXPECT_EQ(interpolate({{{1.0, 7.0}}}, 0.0), 7.0);
}

// METHODS 10.3: a constant field is invariant under the averaging.
TEST(PaperR, ConstantFieldKeepsItsCost) {
  GlobalMap map = uniform_map(0.10F);
  const CostMap costs = costs_of(map);
  EXPECT_NEAR(costs.resolution_m(), 0.3, 1e-12);
  for (int y = -16; y < 16; ++y) {
    for (int x = -16; x < 16; ++x) EXPECT_NEAR(costs.at({x, y}), 10.5, 1e-4);
  }
}

// A single cell of cost 100 counts 1/144 of the window: 1 becomes 1.69. Its Sobel ring of eight
// cells raises that to 6.5: averaging dilutes thin obstacles.
TEST(PaperR, SingleLethalCellIsDilutedToOneInAHundredAndFortyFour) {
  GlobalMap map = uniform_map(0.0F);
  set_derivative(map, {1, 1}, 10.0F);  // the middle of cost cell (0, 0)
  CostMap costs = costs_of(map, capped_at_100());
  EXPECT_NEAR(costs.at({0, 0}), 1.0 + 99.0 / 144.0, 1e-5);
  // The window is 12 cells wide: seen from 1 cell of 0.3 m away it still counts in full.
  EXPECT_NEAR(costs.at({1, 1}), 1.0 + 99.0 / 144.0, 1e-5);
  // From two away it lies on the half-weighted border; beyond, it does not count.
  EXPECT_NEAR(costs.at({2, 0}), 1.0 + 0.5 * 99.0 / 144.0, 1e-5);
  EXPECT_NEAR(costs.at({2, 2}), 1.0 + 0.25 * 99.0 / 144.0, 1e-5);
  EXPECT_NEAR(costs.at({3, 0}), 1.0, 1e-5);
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 3; ++x) {
      set_derivative(map, {x, y}, x == 1 && y == 1 ? 0.0F : 10.0F);
    }
  }
  costs.update(map, map.take_changes());
  EXPECT_NEAR(costs.at({0, 0}), 1.0 + 8 * 99.0 / 144.0, 1e-5);  // 6.5
}

TEST(PaperR, PostStaysDearWithTheDefaultKnots) {
  GlobalMap map = uniform_map(0.0F);
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 3; ++x) {
      if (x != 1 || y != 1) set_derivative(map, {x, y}, 1.8F);
    }
  }
  const CostMap costs = costs_of(map);
  EXPECT_NEAR(costs.at({0, 0}), 1.0 + 8 * 999.0 / 144.0, 1e-3);
  EXPECT_GT(costs.at({0, 0}), 10 * CostOptions{}.unexplored_cost);
}

// "This cost is higher than the cost associated with good terrain."
TEST(PaperR, UnexploredCostsMoreThanGoodGroundAndIsMixedByArea) {
  GlobalMap map = uniform_map(0.0F);
  const CostMap costs = costs_of(map);
  EXPECT_FLOAT_EQ(costs.at({0, 0}), 1.0F);
  // The cell whose window is half outside the measured square of 12 m: x = 6.0 m is the border of
  // cost cells 19 and 20; the window of cell 20 (centre 6.15) reaches from 5.55 to 6.75.
  EXPECT_NEAR(costs.at({20, 0}), (0.45 * 1.0 + 0.75 * 5.0) / 1.2, 1e-5);
  EXPECT_TRUE(std::isnan(costs.at({22, 0})));
  const Grid<float> grid = costs.grid();
  EXPECT_EQ(grid.geometry.columns, 44);  // 12 m and two cells on either side
  EXPECT_NEAR(grid.geometry.origin.x(), -6.6, 1e-9);
}

TEST(CostMap, UpdatesEqualComputingAnewToTheBit) {
  std::mt19937 random(23);
  std::uniform_real_distribution<float> value(0.0F, 2.0F);
  for (int cells_per_side : {1, 2, 3, 5}) {
    CostOptions options;
    options.cells_per_side = cells_per_side;
    options.window_m = 0.7;
    GlobalMap map;
    CostMap updated(options);
    for (int round = 0; round < 12; ++round) {
      for (int i = 0; i < 40; ++i) {
        set_derivative(map,
                       {static_cast<int>(random() % 90) - 45, static_cast<int>(random() % 90) - 45},
                       value(random));
      }
      updated.update(map, map.take_changes());
    }
    auto reread = GlobalMap::from_layers(map.layers());
    ASSERT_TRUE(reread);
    CostMap anew(options);
    anew.update(*reread, reread->take_changes());
    const Grid<float> a = updated.grid(), b = anew.grid();
    ASSERT_EQ(a.geometry, b.geometry);
    for (std::size_t i = 0; i < a.values.size(); ++i) {
      ASSERT_TRUE(a.values[i] == b.values[i] ||
                  (std::isnan(a.values[i]) && std::isnan(b.values[i])));
    }
  }
}

// The mean by its definition: integrate the cost over the square, cell by cell.
TEST(CostMap, EqualsTheAreaWeightedMean) {
  std::mt19937 random(5);
  GlobalMap map;
  for (int y = -20; y < 20; ++y) {
    for (int x = -20; x < 20; ++x) {
      if (random() % 4 != 0)
        set_derivative(map, {x, y}, static_cast<float>(random() % 100) / 50.0F);
    }
  }
  for (int k : {2, 3}) {
    CostOptions options;
    options.cells_per_side = k;
    options.window_m = 1.0;
    const CostMap costs = costs_of(map, options);
    auto reread = GlobalMap::from_layers(map.layers());  // makes all cells count as changed again
    ASSERT_TRUE(reread);
    map = std::move(*reread);
    for (int y = -5; y < 5; ++y) {
      for (int x = -5; x < 5; ++x) {
        const double cx = 0.1 * k * (x + 0.5), cy = 0.1 * k * (y + 0.5);
        double sum = 0.0;
        for (int j = -60; j < 60; ++j) {
          for (int i = -60; i < 60; ++i) {
            const auto overlap = [](double low, double centre) {
              return std::max(0.0, std::min(low + 0.1, centre + 0.5) - std::max(low, centre - 0.5));
            };
            const GroundCell* cell = map.find({i, j});
            const double cost = cell != nullptr && cell->explored()
                                    ? interpolate(options.knots, cell->derivative)
                                    : options.unexplored_cost;
            sum += overlap(0.1 * i, cx) * overlap(0.1 * j, cy) * cost;
          }
        }
        EXPECT_NEAR(costs.at({x, y}), sum, 1e-3 * sum);
      }
    }
  }
}

TEST(CostMap, ObstacleListsAreMergedAsMaximumAndTakenBack) {
  GlobalMap map = uniform_map(0.0F);
  CostMap costs = costs_of(map);
  ASSERT_TRUE(costs.set_obstacles(ObstacleList::kBump, {{{0.6, 0.0}, 0.45, 1000.0}}));
  ASSERT_TRUE(costs.set_obstacles(ObstacleList::kSlip, {{{0.6, 0.0}, 0.9, 30.0}}));
  const auto at = [&](double x, double y) {
    return costs.at(GridGeometry{0.3, {0, 0}, 0, 0}.cell_at({x, y}));
  };
  EXPECT_EQ(at(0.65, 0.05), 1000.0F);
  EXPECT_EQ(at(1.25, 0.05), 30.0F);
  EXPECT_EQ(at(3.05, 0.05), 1.0F);
  ASSERT_TRUE(costs.set_obstacles(ObstacleList::kBump, {}));
  EXPECT_EQ(at(0.65, 0.05), 30.0F);  // the slip list still holds it
  ASSERT_TRUE(costs.set_obstacles(ObstacleList::kSlip, {}));
  EXPECT_EQ(at(0.65, 0.05), 1.0F);
  // An obstacle where nothing was ever seen counts, too, and a cheap one lowers nothing.
  ASSERT_TRUE(costs.set_obstacles(ObstacleList::kForbidden,
                                  {{{40.0, 0.0}, 0.2, 70.0}, {{0.0, 0.0}, 0.2, 0.5}}));
  EXPECT_EQ(at(40.05, 0.05), 70.0F);
  EXPECT_EQ(at(0.05, 0.05), 1.0F);
  EXPECT_GT(costs.grid().geometry.columns, 130);
}

// A disc touches the cells that a point of it lies in: the corner (0.3, 0.3) of cell (1, 1) is
// 0.2121 m from the disc's centre.
TEST(CostMap, DiscsCountInTheCellsThatTheyTouch) {
  for (const auto& [radius_m, touches] : {std::pair(0.205, false), {0.211, false}, {0.213, true}}) {
    CostMap costs;
    ASSERT_TRUE(costs.set_obstacles(ObstacleList::kBump, {{{0.15, 0.15}, radius_m, 70.0}}));
    EXPECT_EQ(costs.at({0, 0}), 70.0F);
    EXPECT_EQ(costs.at({1, 0}), 70.0F);
    EXPECT_EQ(costs.at({0, -1}), 70.0F);
    EXPECT_EQ(costs.at({1, 1}) == 70.0F, touches) << radius_m;
    EXPECT_EQ(costs.at({-1, -1}) == 70.0F, touches) << radius_m;
  }
}

// Where the robot stands, known or not.
TEST(CostMap, ReachMakesThePlacePartOfTheGrid) {
  GlobalMap map = uniform_map(0.0F);
  CostMap costs = costs_of(map);
  const Eigen::Vector2d place(-20.0, 31.0);
  EXPECT_FALSE(costs.grid().geometry.contains(costs.grid().geometry.cell_at(place)));
  costs.reach(place);
  const Grid<float> grid = costs.grid();
  const Cell cell = grid.geometry.cell_at(place);
  ASSERT_TRUE(grid.geometry.contains(cell));
  EXPECT_TRUE(std::isnan(grid[cell]));
}

TEST(CostMap, RefusesDiscsThatCannotBe) {
  CostMap costs;
  EXPECT_FALSE(costs.set_obstacles(ObstacleList::kBump, {{{0.0, 0.0}, 100.1, 1.0}}));
  EXPECT_FALSE(costs.set_obstacles(ObstacleList::kBump, {{{0.0, 0.0}, -0.1, 1.0}}));
  EXPECT_FALSE(costs.set_obstacles(ObstacleList::kBump, {{{0.0, 0.0}, 0.5, -1.0}}));
  EXPECT_FALSE(costs.set_obstacles(ObstacleList::kBump, {{{0.0, -2e12}, 0.5, 1.0}}));
  EXPECT_FALSE(costs.set_obstacles(ObstacleList::kBump, {{{std::nan(""), 0.0}, 0.5, 1.0}}));
  EXPECT_FALSE(costs.set_obstacles(ObstacleList::kBump, {{{0.0, 0.0}, 1e9, 1.0}}));
  EXPECT_FALSE(costs.set_obstacles(ObstacleList::kBump, {{{0.0, 0.0}, 0.5, std::nan("")}}));
  EXPECT_TRUE(std::isnan(costs.at({0, 0})));
  EXPECT_EQ(costs.grid().values.size(), 0U);
}

TEST(CostMap, LayerHasTheCostsAndSaysWhatUnexploredCosts) {
  GlobalMap map = uniform_map(0.10F);
  CostOptions options;
  options.unexplored_cost = 7.5;
  options.window_m = 0.9;
  const CostMap costs = costs_of(map, options);
  MapLayers layers = map.layers();
  costs.add_layer(layers);
  EXPECT_EQ(layers.numbers.at("unexplored_cost"), 7.5);
  EXPECT_EQ(layers.numbers.at("cost_window_m"), 0.9);
  const MapLayer* layer = layers.find("cost");
  ASSERT_NE(layer, nullptr);
  const Grid<float>& grid = layer->grid;
  ASSERT_EQ(grid.geometry, costs.grid().geometry);
  int known = 0;
  for (int y = 0; y < grid.geometry.rows; ++y) {
    for (int x = 0; x < grid.geometry.columns; ++x) {
      const Eigen::Vector2d p = grid.geometry.centre({x, y});
      const float cost = costs.at(GridGeometry{0.3, {0.0, 0.0}, 0, 0}.cell_at(p));
      const float written = grid[{x, y}];
      EXPECT_TRUE(written == cost || (std::isnan(cost) && std::isnan(written)));
      known += std::isnan(cost) ? 0 : 1;
    }
  }
  EXPECT_EQ(known, 42 * 42);  // 12 m and the one cell on either side whose window reaches in
}

TEST(CostMap, PlacesAndDiscsThatWouldMakeTheGridTooLargeAreLeftOut) {
  GlobalMap map = uniform_map(0.0F);
  CostMap costs({}, 0.1, 1);  // 262144 cells
  costs.update(map, map.take_changes());
  const GridGeometry before = costs.grid().geometry;
  for (const Eigen::Vector2d& place :
       {Eigen::Vector2d(1e7, 1e7), Eigen::Vector2d(std::nan(""), 0.0), Eigen::Vector2d(1e300, 0.0),
        Eigen::Vector2d(200.0, 200.0)}) {
    EXPECT_FALSE(costs.can_reach(place)) << place.transpose();
    costs.reach(place);
    EXPECT_EQ(costs.grid().geometry, before);
  }
  EXPECT_TRUE(costs.can_reach({50.0, 0.0}));
  const Status refused =
      costs.set_obstacles(ObstacleList::kBump, {{{0.0, 0.0}, 0.5, 9.0}, {{1e6, 1e6}, 0.5, 9.0}});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kTooLarge);
  EXPECT_NE(refused.error().what.find("(1e+06, 1e+06)"), std::string::npos);
  EXPECT_EQ(costs.at({0, 0}), 1.0F) << "the list stays as it was";
  // Two discs that are each alone in reach, but not together.
  CostMap alone({}, 0.1, 1);
  EXPECT_TRUE(alone.set_obstacles(ObstacleList::kBump, {{{1e6, 1e6}, 0.5, 9.0}}));
  EXPECT_FALSE(alone.set_obstacles(ObstacleList::kSlip, {{{-1e6, 0.0}, 0.5, 9.0}}));
}

TEST(CostMap, ClearForgetsTheGroundAndKeepsTheObstacles) {
  GlobalMap map = uniform_map(0.0F);
  CostMap costs = costs_of(map);
  ASSERT_TRUE(costs.set_obstacles(ObstacleList::kBump, {{{1.35, 0.15}, 0.1, 70.0}}));
  costs.clear();
  EXPECT_EQ(costs.grid().values.size(), 1U);
  EXPECT_EQ(costs.at({4, 0}), 70.0F);
  ASSERT_TRUE(costs.set_obstacles(ObstacleList::kBump, {}));
  EXPECT_TRUE(std::isnan(costs.at({0, 0})));
}

TEST(CostOptions, WindowsLeaveNoGroundBetweenThemAndAreBounded) {
  CostOptions options;
  EXPECT_TRUE(covers_ground(options, 0.1));
  options.window_m = 0.3;
  EXPECT_TRUE(covers_ground(options, 0.1)) << "just as wide as a cell";
  options.window_m = 0.29;
  EXPECT_FALSE(covers_ground(options, 0.1));
  options.window_m = 1.2;
  EXPECT_TRUE(covers_ground(options, 0.0024));
  EXPECT_FALSE(covers_ground(options, 0.001));
}

TEST(CostOptions, CostsThatFallOrAreNegativeAreRefused) {
  CostOptions options;
  EXPECT_TRUE(check_options(options));
  options.knots = {{{0.0, 1.0}}, {{1.0, 5.0}}, {{2.0, 5.0}}};
  EXPECT_TRUE(check_options(options)) << "level is not falling";
  options.knots[2][1] = 4.0;
  EXPECT_EQ(check_options(options).error().where, "knots");
  options.knots = {{{0.0, -1.0}}, {{1.0, 5.0}}};
  EXPECT_EQ(check_options(options).error().where, "knots");
  options.knots.clear();
  EXPECT_EQ(check_options(options).error().where, "knots");
  options = {};
  options.unexplored_cost = 0.9;
  EXPECT_EQ(check_options(options).error().where, "unexplored_cost, knots");
}

}  // namespace
}  // namespace tread
