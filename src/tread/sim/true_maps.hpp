// What a perfect robot would know of a world: the maps that others are scored by.
#pragma once

#include "tread/core/grid.hpp"
#include "tread/core/options.hpp"
#include "tread/sim/world.hpp"

namespace tread {

struct TrueMapOptions {
  double clearance_m = 1.2;  // what hangs higher above the ground is no obstacle: boughs, lintels
};

// The highest point of ground and solids below the clearance at the centre of each cell; NaN off
// the ground. Leaves and grass do not count: a robot goes through them.
[[nodiscard]] Grid<float> true_height(const World& world, const GridGeometry& geometry,
                                      const TrueMapOptions& options = {});

// How a robot of one size stands on the ground.
struct TraverseOptions {
  double radius_m = 0.58;        // of the circle around it
  double largest_step_m = 0.12;  // up or down within step_length_m
  double step_length_m = 0.15;
  double largest_slope_rad = 0.44;  // of the plane that fits the square in its circle
};
[[nodiscard]] OptionSet describe(TraverseOptions& options);

// 1 where the robot may stand with its middle, 0 where it may not: a step or slope within its
// circle is too large, or the ground ends; NaN off the ground.
[[nodiscard]] Grid<float> true_traversable(const Grid<float>& height,
                                           const TraverseOptions& options = {});

// The cells of a world at a resolution: those that lie on its ground as a whole.
[[nodiscard]] GridGeometry map_geometry(const World& world, double resolution_m);

}  // namespace tread
