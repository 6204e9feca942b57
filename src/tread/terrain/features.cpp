// Slope, step and roughness of a height map.
//
//   slope      the normal is the direction of least scatter of the known cells within
//              normal_radius_m; 1 - angle(normal, up) / slope_critical_rad
//   step       h = largest - smallest height within step_radius_m of a cell; then over the cells
//              within step_second_radius_m, with largest h and the count of h > step_critical_m:
//              s = min(largest, count / step_critical_cells * largest); 1 - s / step_critical_m
//   roughness  r^2 = sum of squared distances from the plane through the mean with that normal,
//              over the cells within roughness_radius_m, divided by n - 1;
//              1 - r / roughness_critical_m
//
// all cut to [0, 1]. The sum of squared distances along a unit normal is the quadratic form of the
// scatter matrix, so one pass over a window serves the normal and the roughness alike.
// Frame: that of the grid, z up. Two readings of ours: a normal is unknown where the known cells
// lie on one line (the filters we follow call such ground level), and an exact plane keeps its
// slope (there it is called level as well).
#include "tread/terrain/features.hpp"

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "tread/core/parallel.hpp"

namespace tread {
namespace {

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
constexpr int kRowsPerChunk = 8;

// The cells within a radius, row by row: columns -half to half of row y, seen from the centre.
struct WindowRow {
  int y = 0;
  int half = 0;
  [[nodiscard]] bool operator==(const WindowRow&) const = default;
};
using Window = std::vector<WindowRow>;

// The cells whose centres lie within the radius, but at least within `least_cells`. The slack makes
// a radius of whole cells include its last cell in spite of rounding.
Window disc(double radius_m, double resolution_m, double least_cells) {
  const double radius = std::max(radius_m / resolution_m, least_cells) + 1e-6;
  const int reach = static_cast<int>(radius);
  Window window;
  for (int y = -reach; y <= reach; ++y) {
    window.push_back({y, static_cast<int>(std::sqrt(radius * radius - y * y))});
  }
  return window;
}

// Calls body(x, y, value) for the known cells of the window that are on the grid, x and y in cells
// from the centre.
template <class Body>
void for_window(const Grid<float>& grid, Cell centre, const Window& window, const Body& body) {
  const GridGeometry& g = grid.geometry;
  for (const WindowRow& row : window) {
    const int y = centre.y + row.y;
    if (y < 0 || y >= g.rows) continue;
    const int first = std::max(-row.half, -centre.x);
    const int last = std::min(row.half, g.columns - 1 - centre.x);
    const float* values = &grid[{centre.x, y}];
    for (int x = first; x <= last; ++x) {
      if (std::isfinite(values[x])) body(x, row.y, values[x]);
    }
  }
}

// Scatter of the known points of a window about their mean.
struct Scatter {
  int count = 0;
  Eigen::Matrix3d about_mean = Eigen::Matrix3d::Zero();
};

// Positions are taken relative to the centre, so that no digits are lost far from the origin.
Scatter scatter_at(const Grid<float>& height, Cell centre, const Window& window) {
  const double z0 = height[centre];
  // Sums over the window, x and y in cells. Plain numbers: this loop is all of the cost.
  int count = 0;
  double x = 0, y = 0, z = 0, xx = 0, xy = 0, yy = 0, xz = 0, yz = 0, zz = 0;
  for_window(height, centre, window, [&](int u, int v, float value) {
    const double w = value - z0;
    ++count;
    x += u, y += v, z += w;
    xx += u * u, xy += u * v, yy += v * v;
    xz += u * w, yz += v * w, zz += w * w;
  });
  const Eigen::Vector3d sum(x, y, z);
  Eigen::Matrix3d squares;
  squares << xx, xy, xz, xy, yy, yz, xz, yz, zz;
  const Eigen::Vector3d scale(height.geometry.resolution_m, height.geometry.resolution_m, 1.0);
  const Eigen::Matrix3d in_cells = squares - sum * sum.transpose() / count;
  return {count, scale.asDiagonal() * in_cells * scale.asDiagonal()};
}

// The unit normal, pointing up; nothing where the points lie on one line or are too few.
std::optional<Eigen::Vector3d> normal_of(const Scatter& scatter) {
  if (scatter.count < 3) return std::nullopt;
  // Cells on one line have one line of centres, whatever their heights.
  const Eigen::Matrix2d ground = scatter.about_mean.topLeftCorner<2, 2>();
  const double size = ground.trace();
  if (ground.determinant() <= 1e-9 * size * size) return std::nullopt;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(scatter.about_mean);
  const Eigen::Vector3d normal = solver.eigenvectors().col(0);  // eigenvalues increase
  return normal.z() < 0.0 ? Eigen::Vector3d(-normal) : normal;
}

// 1 for nothing bad, 0 from `critical` on.
float rate(double value, double critical) {
  return static_cast<float>(std::clamp(1.0 - value / critical, 0.0, 1.0));
}

struct Windows {
  Window normal, roughness, step, step_second;
};

void rate_slope_and_roughness(const Grid<float>& height, Cell c, const Windows& windows,
                              const FeatureOptions& options, TerrainFeatures& features) {
  const Scatter scatter = scatter_at(height, c, windows.normal);
  const std::optional<Eigen::Vector3d> normal = normal_of(scatter);
  if (!normal) return;
  const double angle = std::atan2(normal->head<2>().norm(), normal->z());
  features.slope[c] = rate(angle, options.slope_critical_rad);
  const Scatter around =
      windows.roughness == windows.normal ? scatter : scatter_at(height, c, windows.roughness);
  if (around.count < 2) return;
  const double squares = std::max(0.0, normal->dot(around.about_mean * *normal));
  features.roughness[c] =
      rate(std::sqrt(squares / (around.count - 1)), options.roughness_critical_m);
}

// Largest difference of heights within the window of a known cell.
float height_range(const Grid<float>& height, Cell centre, const Window& window) {
  float low = height[centre], high = low;
  for_window(height, centre, window, [&](int, int, float value) {
    low = std::min(low, value);
    high = std::max(high, value);
  });
  return high - low;
}

float rate_step(const Grid<float>& ranges, Cell centre, const Window& window,
                const FeatureOptions& options) {
  double largest = 0.0;
  int critical = 0;
  for_window(ranges, centre, window, [&](int, int, float range) {
    largest = std::max<double>(largest, range);
    if (range > options.step_critical_m) ++critical;
  });
  const double share = static_cast<double>(critical) / options.step_critical_cells;
  return rate(std::min(1.0, share) * largest, options.step_critical_m);
}

// Calls body(cell) for the cells of known height.
template <class Body>
void for_known_cells(const Context& context, const Grid<float>& height, const Body& body) {
  parallel_chunks(context, 0, height.geometry.rows, kRowsPerChunk, [&](int first, int last) {
    for (int y = first; y < last; ++y) {
      for (int x = 0; x < height.geometry.columns; ++x) {
        if (std::isfinite(height[{x, y}])) body(Cell{x, y});
      }
    }
  });
}

}  // namespace

OptionSet describe(FeatureOptions& options) {
  OptionSet set;
  set.add("normal_radius_m", options.normal_radius_m,
          "cells within it give the surface normal, at least 1.5 cells", 1e-3, 10.0);
  set.add("slope_critical_rad", options.slope_critical_rad, "slope that is rated 0", 1e-3, 1.5708);
  set.add("step_radius_m", options.step_radius_m,
          "first window, largest height difference, at least 1 cell", 1e-3, 10.0);
  set.add("step_second_radius_m", options.step_second_radius_m,
          "second window, counts the differences above the critical one, at least 1 cell", 1e-3,
          10.0);
  set.add("step_critical_m", options.step_critical_m, "step height that is rated 0", 1e-4, 100.0);
  set.add("step_critical_cells", options.step_critical_cells,
          "cells above the critical step height that make a step count in full", 1, 1000000);
  set.add("roughness_radius_m", options.roughness_radius_m,
          "cells within it give the roughness, at least 1.5 cells", 1e-3, 10.0);
  set.add("roughness_critical_m", options.roughness_critical_m, "roughness that is rated 0", 1e-4,
          100.0);
  return set;
}

TerrainFeatures terrain_features(const Grid<float>& height, const FeatureOptions& options,
                                 const Context& context) {
  const ScopedTimer timer(context, "terrain/features");
  const GridGeometry& geometry = height.geometry;
  const double resolution = geometry.resolution_m;
  const Windows windows{disc(options.normal_radius_m, resolution, 1.5),
                        disc(options.roughness_radius_m, resolution, 1.5),
                        disc(options.step_radius_m, resolution, 1.0),
                        disc(options.step_second_radius_m, resolution, 1.0)};
  const Grid<float> unknown(geometry, kUnknown);
  TerrainFeatures features{unknown, unknown, unknown, unknown};
  Grid<float> ranges = unknown;
  for_known_cells(context, height,
                  [&](Cell c) { ranges[c] = height_range(height, c, windows.step); });
  for_known_cells(context, height, [&](Cell c) {
    rate_slope_and_roughness(height, c, windows, options, features);
    features.step[c] = rate_step(ranges, c, windows.step_second, options);
    features.traversability[c] = (features.slope[c] + features.step[c] + features.roughness[c]) / 3;
  });
  return features;
}

}  // namespace tread
