// What the tests of planning compare with: slow code that shares nothing with the planner but the
// rules, and random maps.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "tread/core/grid.hpp"
#include "tread/plan/a_star.hpp"

namespace tread::testing {

inline constexpr double kNever = std::numeric_limits<double>::infinity();

inline Grid<float> filled_grid(int columns, int rows, float value, double resolution_m = 1.0,
                               const Eigen::Vector2d& origin = Eigen::Vector2d::Zero()) {
  return Grid<float>(GridGeometry{resolution_m, origin, columns, rows}, value);
}

// What a cell costs, infinity if it must not be entered or is no cell of the grid.
inline double oracle_cost(const Grid<float>& grid, Cell c, const GridSearchOptions& options) {
  if (c.x < 0 || c.y < 0 || c.x >= grid.geometry.columns || c.y >= grid.geometry.rows) {
    return kNever;
  }
  const double value = std::isnan(grid[c]) ? options.unexplored_cost : double{grid[c]};
  if (value >= options.lethal_cost) return kNever;
  return std::max(value, double{kSmallestCost});
}

// Metres times mean cost of a step to one of eight neighbours, infinity if it is not allowed.
inline double oracle_step(const Grid<float>& grid, Cell from, int dx, int dy,
                          const GridSearchOptions& options) {
  const double beside_x = oracle_cost(grid, {from.x + dx, from.y}, options);
  const double beside_y = oracle_cost(grid, {from.x, from.y + dy}, options);
  if (std::isinf(beside_x) || std::isinf(beside_y)) return kNever;
  const double mean =
      (oracle_cost(grid, from, options) + oracle_cost(grid, {from.x + dx, from.y + dy}, options)) /
      2.0;
  return grid.geometry.resolution_m * std::hypot(dx, dy) * mean;
}

// Dijkstra: the least cost from start to every cell, infinity where there is no way.
inline Grid<double> oracle_costs(const Grid<float>& grid, Cell start,
                                 const GridSearchOptions& options) {
  Grid<double> least(grid.geometry, kNever);
  if (std::isinf(oracle_cost(grid, start, options))) return least;
  std::set<std::pair<double, Cell>> waiting = {{0.0, start}};
  least[start] = 0.0;
  while (!waiting.empty()) {
    const auto [so_far, c] = *waiting.begin();
    waiting.erase(waiting.begin());
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        if (dx == 0 && dy == 0) continue;
        const double total = so_far + oracle_step(grid, c, dx, dy, options);
        const Cell next{c.x + dx, c.y + dy};
        if (std::isinf(total) || total >= least[next]) continue;
        waiting.erase({least[next], next});
        least[next] = total;
        waiting.insert({total, next});
      }
    }
  }
  return least;
}

// The part of the segment from a to b (in cells) within the closed square of cell c grown by
// `margin`, as fractions; none if first > second.
inline std::pair<double, double> part_in_cell(const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                                              Cell c, double margin) {
  std::pair<double, double> part = {0.0, 1.0};
  const Eigen::Vector2d low(c.x - margin, c.y - margin);
  const Eigen::Vector2d high(c.x + 1 + margin, c.y + 1 + margin);
  for (int axis = 0; axis < 2; ++axis) {
    const double d = b[axis] - a[axis];
    if (d == 0.0) {
      if (a[axis] < low[axis] || a[axis] > high[axis]) return {1.0, 0.0};
      continue;
    }
    const double one = (low[axis] - a[axis]) / d;
    const double other = (high[axis] - a[axis]) / d;
    part.first = std::max(part.first, std::min(one, other));
    part.second = std::min(part.second, std::max(one, other));
  }
  return part;
}

enum class Terrain { kWeights, kObstacles, kUnknownParts, kWideRange, kOddValues };

inline Grid<float> random_grid(int columns, int rows, Terrain terrain, unsigned seed,
                               double resolution_m = 1.0,
                               const Eigen::Vector2d& origin = Eigen::Vector2d::Zero()) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(0.0F, 1.0F);
  Grid<float> grid = filled_grid(columns, rows, 1.0F, resolution_m, origin);
  const float unknown = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  const float odd[] = {0.0F, -3.0F, infinity, -infinity, unknown, 50.0F, 49.99F, 1.0F, 1.0F, 1.0F};
  for (float& value : grid.values) {
    const float chance = unit(random);
    const float u = unit(random);
    switch (terrain) {
      case Terrain::kWeights:
        value = 1.0F + 20.0F * u;
        break;
      case Terrain::kObstacles:
        value = chance < 0.3F ? 80.0F : 1.0F;
        break;
      case Terrain::kUnknownParts:
        value = chance < 0.3F ? unknown : chance < 0.45F ? 60.0F : 1.0F + 9.0F * u;
        break;
      case Terrain::kWideRange:
        value = chance < 0.1F ? 60.0F : std::pow(10.0F, -3.0F + 4.5F * u);
        break;
      case Terrain::kOddValues:
        value = odd[static_cast<std::size_t>(u * 9.999F)];
        break;
    }
  }
  return grid;
}

inline constexpr Terrain kAllTerrains[] = {Terrain::kWeights, Terrain::kObstacles,
                                           Terrain::kUnknownParts, Terrain::kWideRange,
                                           Terrain::kOddValues};

}  // namespace tread::testing
