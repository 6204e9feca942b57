// The three classical traversability layers computed from a height map: slope, step height and
// roughness, and their mean. Definitions and defaults are those of the widely used filters of the
// traversability_estimation package (Wermelinger et al. 2016), so that results can be compared.
// 1 is good ground, 0 is bad, NaN is unknown: where the height is unknown, and slope and roughness
// also where fewer than three known cells, or only cells in one line, lie within the radius.
// A radius too small for the cells of the map is widened to reach the eight neighbours (normal,
// roughness) or the four (step).
#pragma once

#include "tread/core/grid.hpp"
#include "tread/core/options.hpp"
#include "tread/core/timer.hpp"

namespace tread {

struct FeatureOptions {
  double normal_radius_m = 0.05;    // cells within it give the surface normal
  double slope_critical_rad = 1.0;  // slope at which the layer reaches 0
  double step_radius_m = 0.04;      // first window: largest height difference
  double step_second_radius_m = 0.04;
  double step_critical_m = 0.12;
  int step_critical_cells = 4;
  double roughness_radius_m = 0.05;
  double roughness_critical_m = 0.05;
};
[[nodiscard]] OptionSet describe(FeatureOptions& options);

struct TerrainFeatures {
  Grid<float> slope;
  Grid<float> step;
  Grid<float> roughness;
  Grid<float> traversability;  // mean of the three
};

// `height` in metres, NaN where unknown. Cost: O(cells x cells in the radius).
[[nodiscard]] TerrainFeatures terrain_features(const Grid<float>& height,
                                               const FeatureOptions& options = {},
                                               const Context& context = {});

}  // namespace tread
