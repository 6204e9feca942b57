#include "tread/plan/line_cost.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace tread {
namespace {

constexpr double kTouch = 1e-6;  // cells

Eigen::Vector2d in_cells(const GridGeometry& geometry, const Eigen::Vector2d& p) {
  return (p - geometry.origin) / geometry.resolution_m;
}

// Is the cell that holds this point (in cells) lethal?
bool lethal_at(const Grid<float>& grid, const Eigen::Vector2d& p, const CellCharge& charge) {
  const double x = std::floor(p.x());
  const double y = std::floor(p.y());
  if (!(x >= 0.0 && y >= 0.0 && x < grid.geometry.columns && y < grid.geometry.rows)) return false;
  return charge.lethal(grid[{static_cast<int>(x), static_cast<int>(y)}]);
}

// The whole numbers of [low, high] that name cells of a row of `count`, as first and last.
std::array<int, 2> cells_between(double low, double high, int count) {
  const double first = std::clamp(std::floor(low), 0.0, static_cast<double>(count));
  const double last = std::clamp(std::floor(high), -1.0, static_cast<double>(count - 1));
  return {static_cast<int>(first), static_cast<int>(last)};
}

// The part of a line from a by d (in cells) that lies in the grid, as fractions; empty if first is
// not below second.
std::array<double, 2> part_inside(const GridGeometry& geometry, const Eigen::Vector2d& a,
                                  const Eigen::Vector2d& d) {
  const Eigen::Vector2d size(geometry.columns, geometry.rows);
  std::array<double, 2> part = {0.0, 1.0};
  for (int axis = 0; axis < 2; ++axis) {
    if (d[axis] == 0.0) {
      if (a[axis] < 0.0 || a[axis] >= size[axis]) return {1.0, 0.0};
      continue;
    }
    const double at_low = -a[axis] / d[axis];
    const double at_high = (size[axis] - a[axis]) / d[axis];
    part[0] = std::max(part[0], std::min(at_low, at_high));
    part[1] = std::min(part[1], std::max(at_low, at_high));
  }
  return part;
}

// The fractions at which a line crosses from cell to cell along one axis, in order.
struct Crossings {
  double next;  // fraction of the next crossing, infinity if there is none
  double edge;  // its place, in cells
  double from;
  double by;

  Crossings(double start, double delta, double fraction) : from(start), by(delta) {
    const double here = start + delta * fraction;
    edge = delta > 0.0 ? std::floor(here) + 1.0 : std::ceil(here) - 1.0;
    update();
  }
  void advance() {
    edge += by > 0.0 ? 1.0 : -1.0;
    update();
  }
  void update() { next = by == 0.0 ? std::numeric_limits<double>::infinity() : (edge - from) / by; }
};

}  // namespace

bool line_is_clear(const Grid<float>& cost, const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                   const GridSearchOptions& options) {
  const GridGeometry& geometry = cost.geometry;
  Eigen::Vector2d a = in_cells(geometry, from);
  Eigen::Vector2d b = in_cells(geometry, to);
  const CellCharge charge(options);
  if (lethal_at(cost, a, charge) || lethal_at(cost, b, charge)) return false;
  const bool along_x = std::abs(b.x() - a.x()) >= std::abs(b.y() - a.y());
  const int major = along_x ? 0 : 1;
  const int minor = 1 - major;
  if (a[major] > b[major]) std::swap(a, b);
  const double length = b[major] - a[major];
  if (length <= 4.0 * kTouch) return true;
  const double slope = (b[minor] - a[minor]) / length;
  const double first = a[major] + 2.0 * kTouch;  // leaves out the ends themselves
  const double last = b[major] - 2.0 * kTouch;
  const int major_count = major == 0 ? geometry.columns : geometry.rows;
  const int minor_count = major == 0 ? geometry.rows : geometry.columns;

  const auto columns = cells_between(first - kTouch, last + kTouch, major_count);
  for (int i = columns[0]; i <= columns[1]; ++i) {
    const double at_in = std::clamp(i - kTouch, first, last);
    const double at_out = std::clamp(i + 1.0 + kTouch, first, last);
    const double in = a[minor] + slope * (at_in - a[major]);
    const double out = a[minor] + slope * (at_out - a[major]);
    const auto touched =
        cells_between(std::min(in, out) - kTouch, std::max(in, out) + kTouch, minor_count);
    for (int j = touched[0]; j <= touched[1]; ++j) {
      if (charge.lethal(major == 0 ? cost[{i, j}] : cost[{j, i}])) return false;
    }
  }
  return true;
}

double line_cost(const Grid<float>& cost, const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                 const GridSearchOptions& options) {
  const GridGeometry& geometry = cost.geometry;
  const Eigen::Vector2d a = in_cells(geometry, from);
  const Eigen::Vector2d d = in_cells(geometry, to) - a;
  const double length_m = (to - from).norm();
  const auto [enter, leave] = part_inside(geometry, a, d);
  const auto beyond =
      static_cast<double>(std::max(static_cast<float>(options.unexplored_cost), kSmallestCost));
  if (!(enter < leave)) return beyond * length_m;

  const CellCharge charge(options);
  double sum = beyond * (1.0 - (leave - enter));
  Crossings crossings_x(a.x(), d.x(), enter);
  Crossings crossings_y(a.y(), d.y(), enter);
  for (double t = enter; t < leave;) {
    Crossings& nearer = crossings_x.next <= crossings_y.next ? crossings_x : crossings_y;
    const double end = std::min(nearer.next, leave);
    if (end > t) {
      const Eigen::Vector2d middle = a + 0.5 * (t + end) * d;
      const Cell c{std::clamp(static_cast<int>(std::floor(middle.x())), 0, geometry.columns - 1),
                   std::clamp(static_cast<int>(std::floor(middle.y())), 0, geometry.rows - 1)};
      const auto charged = static_cast<double>(charge(cost[c]));
      // A part too short to be real is rounding at a corner: no lethal cell is crossed there.
      const bool rounding = (end - t) * d.cwiseAbs().maxCoeff() < kTouch;
      if (!(rounding && std::isinf(charged))) sum += (end - t) * charged;
    }
    t = std::max(t, end);
    nearer.advance();
  }
  return sum * length_m;
}

}  // namespace tread
