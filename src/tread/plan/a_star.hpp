// A* over a grid of costs: eight neighbours, no cutting of corners past lethal cells.
// Paper R, "A* Planning". Cost of a step = its length in metres times the mean cost of both cells;
// heuristic = straight (octile) distance times the smallest cost of all passable cells, which
// never overestimates and is consistent. The order of the search is fixed, so a result is the same
// on every run. A path costs at most 1e-12 of itself more than the best one (rounding).
// Cost: 16 bytes and some 1.3 ns a cell of the grid to begin, then some 60 ns a cell expanded.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "tread/core/grid.hpp"

namespace tread {

// The smallest cost a cell can have. Smaller, zero and negative costs are raised to it: free ground
// would make all detours over it equal, and negative costs have no shortest path.
inline constexpr float kSmallestCost = 1e-3F;

struct GridSearchOptions {
  double lethal_cost = 50.0;     // cells of this cost and above are never entered; 1e30 and above
                                 // is always lethal
  double unexplored_cost = 5.0;  // of cells whose cost is NaN; rounded to float as the map is
};

// What a search charges for a cell with this value: infinity if it is lethal. Works on the bits of
// the floats, which order as integers do, with masks for branches: one obstacle in three would be
// foreseen by no processor, and compilers make vector code of it.
class CellCharge {
 public:
  explicit CellCharge(const GridSearchOptions& options)
      : unexplored_(bits(static_cast<float>(options.unexplored_cost))) {
    float lethal = std::clamp(static_cast<float>(options.lethal_cost), 0.0F, 1e30F);
    // Of a limit between two floats the upper one parts the same floats.
    if (double{lethal} < options.lethal_cost && lethal < 1e30F) {
      lethal = std::nextafter(lethal, 1e30F);
    }
    lethal_ = bits(lethal);
  }
  [[nodiscard]] float operator()(float value) const {
    const std::int32_t known = bits(value);
    const std::int32_t cost = select((known & 0x7fffffff) > kInfinite, unexplored_, known);
    return std::bit_cast<float>(
        select(cost < lethal_, select(cost > kSmallest, cost, kSmallest), kInfinite));
  }
  [[nodiscard]] bool lethal(float value) const { return bits((*this)(value)) == kInfinite; }
  // Of ground without a value.
  [[nodiscard]] float unexplored() const {
    return (*this)(std::numeric_limits<float>::quiet_NaN());
  }

 private:
  [[nodiscard]] static constexpr std::int32_t bits(float value) {
    return std::bit_cast<std::int32_t>(value);
  }
  [[nodiscard]] static std::int32_t select(bool first, std::int32_t a, std::int32_t b) {
    const std::int32_t mask = -static_cast<std::int32_t>(first);
    return (a & mask) | (b & ~mask);
  }
  static constexpr std::int32_t kInfinite =
      std::bit_cast<std::int32_t>(std::numeric_limits<float>::infinity());
  static constexpr std::int32_t kSmallest = std::bit_cast<std::int32_t>(kSmallestCost);

  std::int32_t unexplored_;
  std::int32_t lethal_ = kInfinite;
};

struct GridPath {
  bool found = false;
  std::vector<Cell> cells;   // start to goal, both included; empty if not found
  double cost = 0.0;         // sum over steps (and of the way beyond the grid), cost x metres
  std::size_t expanded = 0;  // cells taken from the queue
};

// Both cells must lie in the grid. A lethal start or goal finds nothing.
[[nodiscard]] GridPath search_grid(const Grid<float>& cost, Cell start, Cell goal,
                                   const GridSearchOptions& options);

// Searches from start to whichever border cell is best to leave by for a goal (metres) outside the
// grid: the cost so far plus the straight distance from its centre to the goal at the unexplored
// cost. Exits are only those border cells from which the straight line goes out of the grid without
// entering another cell, nor touching the corner of a lethal one. Finds nothing where the start or
// unexplored ground is lethal.
[[nodiscard]] GridPath search_grid_to_exit(const Grid<float>& cost, Cell start,
                                           const Eigen::Vector2d& goal,
                                           const GridSearchOptions& options);

}  // namespace tread
