// Straight lines over a grid of costs: which cells they touch, and what they cost. Points are in
// metres in the frame of the grid; ground outside the grid is free and has the unexplored cost.
// Cost: one visit per cell that the line crosses inside the grid, however long it is outside.
#pragma once

#include <Eigen/Core>

#include "tread/core/grid.hpp"
#include "tread/plan/a_star.hpp"

namespace tread {

// Does the line touch no lethal cell? Touched are all cells that share a point with it, so both
// cells beside a corner it passes through, and those on both sides of an edge it runs along. Lines
// within 1e-6 cells of an edge or corner are taken to be on it, because points of maps far from
// their origin are no more exact. Of both ends only the cell that holds the point is looked at: a
// start on the edge of an obstacle does not block every line that leads away from it.
[[nodiscard]] bool line_is_clear(const Grid<float>& cost, const Eigen::Vector2d& from,
                                 const Eigen::Vector2d& to, const GridSearchOptions& options);

// Integral of the cells' charged cost along the line, cost x metres, exact in each cell. Infinite
// if the line crosses a lethal cell. A step between centres of neighbours costs what search_grid
// charges for it.
[[nodiscard]] double line_cost(const Grid<float>& cost, const Eigen::Vector2d& from,
                               const Eigen::Vector2d& to, const GridSearchOptions& options);

}  // namespace tread
