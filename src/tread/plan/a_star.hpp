// A* over a grid of costs: eight neighbours, no cutting of corners past lethal cells.
// Paper R, "A* Planning". Cost of a step = its length in metres times the mean cost of both cells;
// heuristic = straight (octile) distance times the smallest cost in the grid, which never
// overestimates. Ties are broken by the order of the cells, so a result is the same on every run.
#pragma once

#include <cstddef>
#include <vector>

#include "tread/core/grid.hpp"

namespace tread {

struct GridSearchOptions {
  double lethal_cost = 50.0;     // cells of this cost and above are never entered
  double unexplored_cost = 5.0;  // of cells whose cost is NaN
};

struct GridPath {
  bool found = false;
  std::vector<Cell> cells;   // start to goal, both included; empty if not found
  double cost = 0.0;         // sum over steps
  std::size_t expanded = 0;  // cells taken from the queue
};

// Both cells must lie in the grid. A lethal start or goal finds nothing.
[[nodiscard]] GridPath search_grid(const Grid<float>& cost, Cell start, Cell goal,
                                   const GridSearchOptions& options);

// Searches from start to whichever border cell is best to leave by for a goal outside the grid:
// the cost so far plus the straight distance to the goal at the unexplored cost. Only border cells
// from which the straight line does not cross the grid again are exits.
[[nodiscard]] GridPath search_grid_to_exit(const Grid<float>& cost, Cell start,
                                           const Eigen::Vector2d& goal,
                                           const GridSearchOptions& options);

}  // namespace tread
