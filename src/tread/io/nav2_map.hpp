// The cost layer as the images and descriptions that Nav2's map server reads; see map_files.hpp
// for the two encodings and why there are two.
#pragma once

#include <string>

#include "tread/core/grid.hpp"
#include "tread/core/result.hpp"

namespace tread {

struct Nav2Files {
  std::string map_pgm;
  std::string map_yaml;
  std::string cost_pgm;
  std::string cost_yaml;
};

// The contents of the files; the descriptions name nav2_map.pgm and nav2_cost.pgm beside them.
// Fails if lethal_cost is not above 1 or the grid has no cells.
[[nodiscard]] Result<Nav2Files> make_nav2_files(const Grid<float>& cost, double lethal_cost);

}  // namespace tread
