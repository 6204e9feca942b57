#include "tread/sim/true_maps.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tread/sim/upright_line.hpp"

namespace tread {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

// The cells of a grid whose centres are within a distance of a place.
CellRect cells_around(const GridGeometry& geometry, const Eigen::Vector2d& place, double radius) {
  const Eigen::Vector2d low = (place.array() - radius - geometry.origin.array()) /
                              geometry.resolution_m,
                        high = (place.array() + radius - geometry.origin.array()) /
                               geometry.resolution_m;
  const auto within = [](double v, int size) {
    return static_cast<int>(std::clamp(std::floor(v), -1.0, static_cast<double>(size)));
  };
  return {
      {std::max(0, within(low.x(), geometry.columns)), std::max(0, within(low.y(), geometry.rows))},
      {std::min(geometry.columns, within(high.x(), geometry.columns) + 1),
       std::min(geometry.rows, within(high.y(), geometry.rows) + 1)}};
}

// Largest difference of height within `reach` cells along x, y and the diagonals; NaN counts as a
// fall without end.
Grid<float> largest_steps(const Grid<float>& height, int reach) {
  Grid<float> steps(height.geometry, 0.0F);
  const GridGeometry& g = height.geometry;
  for (int y = 0; y < g.rows; ++y) {
    for (int x = 0; x < g.columns; ++x) {
      float& step = steps[{x, y}];
      for (int dy = -reach; dy <= reach; ++dy) {
        for (int dx = -reach; dx <= reach; ++dx) {
          const Cell other{x + dx, y + dy};
          const bool known = g.contains(other) && std::isfinite(height[other]);
          step = known ? std::max(step, std::abs(height[other] - height[{x, y}]))
                       : std::numeric_limits<float>::infinity();
        }
      }
    }
  }
  return steps;
}

// Slope of the plane that fits the disc of cells best: for cells that are symmetric about the
// middle the normal equations are diagonal.
double slope_of_disc(const Grid<float>& height, Cell c, const std::vector<Cell>& disc) {
  double sxx = 0.0, sx = 0.0, sy = 0.0;
  for (const Cell& d : disc) {
    const double h = height[{c.x + d.x, c.y + d.y}];
    sx += d.x * h;
    sy += d.y * h;
    sxx += d.x * d.x;
  }
  return sxx > 0.0 ? std::atan(std::hypot(sx, sy) / (sxx * height.geometry.resolution_m)) : 0.0;
}

}  // namespace

OptionSet describe(TraverseOptions& options) {
  OptionSet set;
  set.add("radius_m", options.radius_m, "of the circle around the robot", 0.0, 10.0);
  set.add("largest_step_m", options.largest_step_m, "that it takes, up or down", 0.0, 10.0);
  set.add("step_length_m", options.step_length_m, "way within which a step counts as one", 0.001,
          10.0);
  set.add("largest_slope_rad", options.largest_slope_rad, "of the plane under it", 0.0, 1.6);
  return set;
}

Grid<float> true_height(const World& world, const GridGeometry& geometry,
                        const TrueMapOptions& options) {
  Grid<float> ground(geometry, kNone);
  for (int y = 0; y < geometry.rows; ++y) {
    for (int x = 0; x < geometry.columns; ++x) {
      ground[{x, y}] = static_cast<float>(ground_height(world, geometry.centre({x, y})));
    }
  }
  Grid<float> top = ground;
  for (const Solid& solid : world.solids) {
    const CellRect cells = cells_around(geometry, solid.T_world_solid.translation().head<2>(),
                                        internal::outer_radius(world, solid));
    for (int y = cells.first.y; y < cells.last.y; ++y) {
      for (int x = cells.first.x; x < cells.last.x; ++x) {
        const auto range = internal::height_range(world, solid, geometry.centre({x, y}));
        if (!range || range->low > ground[{x, y}] + options.clearance_m) continue;
        top[{x, y}] = std::max(top[{x, y}], static_cast<float>(range->high));
      }
    }
  }
  return top;
}

Grid<float> true_traversable(const Grid<float>& height, const TraverseOptions& options) {
  const GridGeometry& g = height.geometry;
  const int reach =
      std::max(1, static_cast<int>(std::lround(options.step_length_m / g.resolution_m)));
  const Grid<float> steps = largest_steps(height, reach);
  const int radius = static_cast<int>(options.radius_m / g.resolution_m);
  std::vector<Cell> disc;
  for (int dy = -radius; dy <= radius; ++dy) {
    for (int dx = -radius; dx <= radius; ++dx) {
      if (std::hypot(dx, dy) * g.resolution_m <= options.radius_m) disc.push_back({dx, dy});
    }
  }
  Grid<float> free(g, kNone);
  for (int y = 0; y < g.rows; ++y) {
    for (int x = 0; x < g.columns; ++x) {
      const Cell c{x, y};
      if (!std::isfinite(height[c])) continue;
      const bool good = std::all_of(disc.begin(), disc.end(), [&](const Cell& d) {
        const Cell at{x + d.x, y + d.y};
        return g.contains(at) && steps[at] <= static_cast<float>(options.largest_step_m);
      });
      free[c] = good && slope_of_disc(height, c, disc) <= options.largest_slope_rad ? 1.0F : 0.0F;
    }
  }
  return free;
}

GridGeometry map_geometry(const World& world, double resolution_m) {
  const GridGeometry& ground = world.ground.geometry;
  const Eigen::Vector2d low = ground.centre({0, 0}),
                        high = ground.centre({ground.columns - 1, ground.rows - 1});
  GridGeometry map{resolution_m, low, 0, 0};
  map.columns = static_cast<int>(std::floor((high.x() - low.x()) / resolution_m + 1e-6));
  map.rows = static_cast<int>(std::floor((high.y() - low.y()) / resolution_m + 1e-6));
  return map;
}

}  // namespace tread
