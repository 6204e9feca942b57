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

constexpr float kEndless = std::numeric_limits<float>::infinity();

// The largest value within `reach` before and behind each, by the two passes of van Herk (1992):
// three comparisons a value, whatever the reach. What is beyond the ends counts as endless.
void running_maximum(std::vector<float>& row, int reach, std::vector<float>& work) {
  const auto window = static_cast<std::size_t>(2 * reach + 1), count = row.size();
  const std::size_t padded =
      (count + 2 * static_cast<std::size_t>(reach) + window - 1) / window * window;
  work.assign(2 * padded, kEndless);
  float* const ahead = work.data();
  float* const back = work.data() + padded;
  for (std::size_t i = 0; i < count; ++i) ahead[i + static_cast<std::size_t>(reach)] = row[i];
  std::copy(ahead, ahead + padded, back);
  for (std::size_t i = 0; i < padded; ++i) {
    if (i % window != 0) ahead[i] = std::max(ahead[i], ahead[i - 1]);
    const std::size_t j = padded - 1 - i;
    if (j % window != window - 1 && j + 1 < padded) back[j] = std::max(back[j], back[j + 1]);
  }
  for (std::size_t i = 0; i < count; ++i) row[i] = std::max(back[i], ahead[i + window - 1]);
}

// Of a square of cells around each.
Grid<float> maximum_around(Grid<float> values, int reach) {
  const GridGeometry& g = values.geometry;
  std::vector<float> row, work;
  for (int y = 0; y < g.rows; ++y) {
    row.resize(static_cast<std::size_t>(g.columns));
    for (int x = 0; x < g.columns; ++x) row[static_cast<std::size_t>(x)] = values[{x, y}];
    running_maximum(row, reach, work);
    for (int x = 0; x < g.columns; ++x) values[{x, y}] = row[static_cast<std::size_t>(x)];
  }
  for (int x = 0; x < g.columns; ++x) {
    row.resize(static_cast<std::size_t>(g.rows));
    for (int y = 0; y < g.rows; ++y) row[static_cast<std::size_t>(y)] = values[{x, y}];
    running_maximum(row, reach, work);
    for (int y = 0; y < g.rows; ++y) values[{x, y}] = row[static_cast<std::size_t>(y)];
  }
  return values;
}

// Largest difference of height within `reach` cells along x and y; what is unknown or beyond the
// map counts as a fall without end.
Grid<float> largest_steps(const Grid<float>& height, int reach) {
  Grid<float> up = height, down = height;
  for (std::size_t i = 0; i < height.values.size(); ++i) {
    const bool known = std::isfinite(height.values[i]);
    up.values[i] = known ? height.values[i] : kEndless;
    down.values[i] = known ? -height.values[i] : kEndless;
  }
  up = maximum_around(std::move(up), reach);
  down = maximum_around(std::move(down), reach);
  for (std::size_t i = 0; i < height.values.size(); ++i) {
    const float h = height.values[i];
    up.values[i] = std::isfinite(h) ? std::max(up.values[i] - h, down.values[i] + h) : kEndless;
  }
  return up;
}

// Distance of each cell to the nearest bad one along its column, then the smallest of those along
// its row with the way there (the first two passes of Meijster 2000, squared distances in cells);
// beyond the map all is bad.
Grid<float> distance_to_bad(const Grid<float>& steps, float largest_step, int farthest) {
  const GridGeometry& g = steps.geometry;
  Grid<float> along(g);
  for (int x = 0; x < g.columns; ++x) {
    for (int pass = 0; pass < 2; ++pass) {
      float distance = 0.0F;
      for (int k = 0; k < g.rows; ++k) {
        const Cell c{x, pass == 0 ? k : g.rows - 1 - k};
        distance = steps[c] <= largest_step ? distance + 1.0F : 0.0F;
        along[c] = pass == 0 ? distance : std::min(along[c], distance);
      }
    }
  }
  Grid<float> nearest(g);
  for (int y = 0; y < g.rows; ++y) {
    for (int x = 0; x < g.columns; ++x) {
      const auto beside = static_cast<float>(std::min(x, g.columns - 1 - x) + 1);
      float best = std::min(along[{x, y}] * along[{x, y}], beside * beside);
      for (int d = 1; d <= farthest && static_cast<float>(d * d) < best; ++d) {
        for (const int other : {x - d, x + d}) {
          if (other < 0 || other >= g.columns) continue;
          const float a = along[{other, y}];
          best = std::min(best, a * a + static_cast<float>(d * d));
        }
      }
      nearest[{x, y}] = std::sqrt(best);
    }
  }
  return nearest;
}

// Slopes of planes that fit squares of cells best, from sums over the map: for cells that lie
// evenly about the middle the normal equations are diagonal.
class PlaneSlopes {
 public:
  PlaneSlopes(const Grid<float>& height, int reach)
      : geometry_(height.geometry), reach_(reach), width_(geometry_.columns + 1) {
    for (std::vector<double>* sums : {&h_, &xh_, &yh_}) {
      sums->assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(geometry_.rows + 1),
                   0.0);
    }
    for (int y = 0; y < geometry_.rows; ++y) {
      double h = 0.0, xh = 0.0, yh = 0.0;
      for (int x = 0; x < geometry_.columns; ++x) {
        const float value = height[{x, y}];
        const double known = std::isfinite(value) ? static_cast<double>(value) : 0.0;
        h += known;
        xh += x * known;
        yh += y * known;
        h_[at(x + 1, y + 1)] = h_[at(x + 1, y)] + h;
        xh_[at(x + 1, y + 1)] = xh_[at(x + 1, y)] + xh;
        yh_[at(x + 1, y + 1)] = yh_[at(x + 1, y)] + yh;
      }
    }
  }
  // The square about a cell must lie on the map.
  [[nodiscard]] double slope(Cell c) const {
    const double side = 2.0 * reach_ + 1.0;
    const double squares = side * side * (side * side - 1.0) / 12.0;  // of the distances along x
    const double h = sum(h_, c);
    const double sx = sum(xh_, c) - c.x * h, sy = sum(yh_, c) - c.y * h;
    return squares > 0.0 ? std::atan(std::hypot(sx, sy) / (squares * geometry_.resolution_m)) : 0.0;
  }

 private:
  [[nodiscard]] std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(x);
  }
  [[nodiscard]] double sum(const std::vector<double>& sums, Cell c) const {
    const int x0 = c.x - reach_, x1 = c.x + reach_ + 1, y0 = c.y - reach_, y1 = c.y + reach_ + 1;
    return sums[at(x1, y1)] - sums[at(x0, y1)] - sums[at(x1, y0)] + sums[at(x0, y0)];
  }

  GridGeometry geometry_;
  int reach_, width_;
  std::vector<double> h_, xh_, yh_;
};

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
  const auto largest_step = static_cast<float>(options.largest_step_m);
  const double radius = options.radius_m / g.resolution_m;
  const Grid<float> clear = distance_to_bad(largest_steps(height, reach), largest_step,
                                            static_cast<int>(std::ceil(radius)) + 1);
  // The square that the circle holds.
  const PlaneSlopes planes(height, static_cast<int>(radius * std::sqrt(0.5)));
  Grid<float> free(g, kNone);
  for (int y = 0; y < g.rows; ++y) {
    for (int x = 0; x < g.columns; ++x) {
      const Cell c{x, y};
      if (!std::isfinite(height[c])) continue;
      const bool good = static_cast<double>(clear[c]) > radius;
      free[c] = good && planes.slope(c) <= options.largest_slope_rad ? 1.0F : 0.0F;
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
