#include "tread/terrain/local_map.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "tread/geometry/pose.hpp"

namespace tread {
namespace {

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

// Cells from `low` on to hold a length, which begins and ends at cell corners up to rounding.
int first_cell(double low_m, double resolution_m) {
  return static_cast<int>(std::floor(low_m / resolution_m + 1e-9));
}
int end_cell(double high_m, double resolution_m) {
  return static_cast<int>(std::ceil(high_m / resolution_m - 1e-9));
}

}  // namespace

LevelArea view_from_above(const RectifiedRig& rig, const Eigen::Isometry3d& T_level_points,
                          double depth_m) {
  LevelArea area(T_level_points.translation().head<2>());
  for (const double u : {-0.5, rig.size.width - 0.5}) {
    for (const double v : {-0.5, rig.size.height - 0.5}) {
      area.extend((T_level_points * rig.point(u, v, depth_m)).head<2>());
    }
  }
  return area;
}

GridGeometry local_cells(const LevelArea& area, double resolution_m) {
  if (area.isEmpty()) return {resolution_m, {0.0, 0.0}, 0, 0};
  const int x = first_cell(area.min().x(), resolution_m);
  const int y = first_cell(area.min().y(), resolution_m);
  return {resolution_m,
          {x * resolution_m, y * resolution_m},
          end_cell(area.max().x(), resolution_m) - x,
          end_cell(area.max().y(), resolution_m) - y};
}

bool local_map_fits(const LevelArea& area, double resolution_m) {
  constexpr double kMostCells = double{1 << 30} / 28.0;
  const Eigen::Vector2d cells = area.sizes() / resolution_m;
  return cells.x() * cells.y() <= kMostCells;
}

OptionSet describe(LocalMapOptions& options) {
  OptionSet set;
  set.add("resolution_m", options.resolution_m, "side of a cell, m", 0.001, 10.0);
  set.add("min_points", options.min_points, "points that a known cell has at least", 1, 1000);
  set.add_choice(
      "height", options.height, "height of a cell: mean or maximum of its points",
      {{"mean", LocalMapOptions::Height::kMean}, {"max", LocalMapOptions::Height::kMax}});
  set.add("max_height_m", options.max_height_m, "points higher than this are left out, m");
  set.add("min_height_m", options.min_height_m, "points lower than this are left out, m");
  set.add("overhead_m", options.overhead_m,
          "points this much above the ground known below them are left out, m; 0: none are", 0.0,
          1e4);
  set.require({"min_height_m", "max_height_m"}, "the lowest must be less than the highest",
              [&options] { return options.min_height_m < options.max_height_m; });
  return set;
}

Eigen::Matrix3d R_level_body(const Eigen::Matrix3d& R_world_body) {
  const YawPitchRoll angles = yaw_pitch_roll(R_world_body);
  return rotation_from_yaw_pitch_roll(0.0, angles.pitch_rad, angles.roll_rad);
}

const Grid<float>& LocalMapBuilder::build(std::span<const Eigen::Vector3f> points,
                                          const Eigen::Isometry3d& T_level_points,
                                          const GridGeometry& geometry,
                                          const LocalMapOptions& options,
                                          const LocalMapHints& hints, const Context& context) {
  const ScopedTimer timer(context, "terrain/local");
  sums_.geometry = heights_.geometry = geometry;
  sums_.values.assign(geometry.size(), Sum{});
  heights_.values.assign(geometry.size(), kUnknown);

  const Eigen::Matrix3f R = T_level_points.linear().cast<float>();
  const Eigen::Vector3f t = T_level_points.translation().cast<float>();
  const auto low = static_cast<float>(options.min_height_m);
  const auto high = static_cast<float>(options.max_height_m);
  const auto scale = static_cast<float>(1.0 / geometry.resolution_m);
  const Eigen::Vector2f origin = geometry.origin.cast<float>();
  const bool under = hints.known != nullptr && options.overhead_m > 0.0;
  const bool weighed = !hints.sigma_m.empty();
  assert(!weighed || hints.sigma_m.size() == points.size());
  const auto overhead = static_cast<float>(options.overhead_m);
  const bool take_max = options.height == LocalMapOptions::Height::kMax;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3f p = R * points[i] + t;
    // Comparisons are false for what is not finite.
    if (!(p.z() >= low && p.z() <= high)) continue;
    const float x = (p.x() - origin.x()) * scale;
    const float y = (p.y() - origin.y()) * scale;
    if (!(x >= 0.0F && y >= 0.0F && x < static_cast<float>(geometry.columns) &&
          y < static_cast<float>(geometry.rows))) {
      continue;
    }
    const Cell cell{static_cast<int>(x), static_cast<int>(y)};
    // False for a ground that is not known.
    if (under && p.z() > (*hints.known)[cell] + overhead) continue;
    Sum& sum = sums_[cell];
    if (!take_max) {
      const float weight = weighed ? 1.0F / (hints.sigma_m[i] * hints.sigma_m[i]) : 1.0F;
      sum.height += weight * p.z();
      sum.weight += weight;
    } else if (sum.points == 0 || p.z() > sum.height) {
      sum.height = p.z();
    }
    ++sum.points;
  }
  for (std::size_t i = 0; i < sums_.values.size(); ++i) {
    const Sum& sum = sums_.values[i];
    if (sum.points < options.min_points) continue;
    heights_.values[i] = static_cast<float>(take_max ? sum.height : sum.height / sum.weight);
  }
  return heights_;
}

void sobel_squared(const Grid<float>& height, Grid<float>& derivative, const Context& context) {
  const ScopedTimer timer(context, "terrain/derivative");
  const GridGeometry& geometry = height.geometry;
  derivative.geometry = geometry;
  derivative.values.assign(geometry.size(), kUnknown);
  for (int y = 1; y + 1 < geometry.rows; ++y) {
    for (int x = 1; x + 1 < geometry.columns; ++x) {
      const float nw = height[{x - 1, y + 1}], n = height[{x, y + 1}], ne = height[{x + 1, y + 1}];
      const float w = height[{x - 1, y}], c = height[{x, y}], e = height[{x + 1, y}];
      const float sw = height[{x - 1, y - 1}], s = height[{x, y - 1}], se = height[{x + 1, y - 1}];
      const float sx = ne + 2.0F * e + se - nw - 2.0F * w - sw;
      const float sy = nw + 2.0F * n + ne - sw - 2.0F * s - se;
      // NaN spreads from any of the eight; the centre has no weight and is asked for itself.
      if (!std::isnan(c)) derivative[{x, y}] = sx * sx + sy * sy;
    }
  }
}

}  // namespace tread
