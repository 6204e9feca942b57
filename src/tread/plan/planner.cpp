// Search, then the straight rest, then fewer points. What is measured to leave a point out is the
// integral of the cost along the lines (line_cost), of the path and of its shortcut alike.
#include "tread/plan/planner.hpp"

#include <fmt/format.h>

#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <optional>

#include "tread/plan/a_star.hpp"
#include "tread/plan/line_cost.hpp"

namespace tread {
namespace {

using Points = std::vector<Eigen::Vector2d>;

std::optional<Cell> cell_on_map(const GridGeometry& geometry, const Eigen::Vector2d& p) {
  // Before cell_at, which must not be asked for places too far away to number.
  const Eigen::Vector2d u = (p - geometry.origin) / geometry.resolution_m;
  if (!(u.x() >= 0.0 && u.y() >= 0.0 && u.x() < geometry.columns && u.y() < geometry.rows)) {
    return std::nullopt;
  }
  return geometry.cell_at(p);
}

bool lethal(const Grid<float>& cost, Cell c, const GridSearchOptions& options) {
  return CellCharge(options).lethal(cost[c]);
}

std::string place(const Eigen::Vector2d& p) {
  return fmt::format("({:.2f}, {:.2f})", p.x(), p.y());
}

// "cost 80 of 50", with a word about where the cost is from if nothing is known about the cell
std::string cost_text(float value, const GridSearchOptions& options) {
  if (!std::isnan(value)) return fmt::format("cost {:.3g}, lethal from {:g}", value, options.lethal_cost);
  return fmt::format("unexplored, cost {:.3g}, lethal from {:g}", options.unexplored_cost,
                     options.lethal_cost);
}

// The centre nearest to a point of all cells for which chosen(cell) holds; the first in order of
// rows of equally near ones.
template <class Chosen>
std::optional<Eigen::Vector2d> nearest_centre(const GridGeometry& geometry,
                                              const Eigen::Vector2d& to, const Chosen& chosen) {
  std::optional<Eigen::Vector2d> nearest;
  double best = std::numeric_limits<double>::infinity();
  for (int y = 0; y < geometry.rows; ++y) {
    for (int x = 0; x < geometry.columns; ++x) {
      const Eigen::Vector2d centre = geometry.centre({x, y});
      const double distance = (centre - to).norm();
      if (distance >= best || !chosen(Cell{x, y})) continue;
      best = distance;
      nearest = centre;
    }
  }
  return nearest;
}

std::string nearest_free_text(const Grid<float>& cost, const Eigen::Vector2d& to,
                              const GridSearchOptions& options) {
  const auto free =
      nearest_centre(cost.geometry, to, [&](Cell c) { return !lethal(cost, c, options); });
  return free ? "the nearest free place is " + place(*free)
              : std::string("no place of the map is free: raise lethal_cost or map other ground");
}

// All cells that can be reached. Straight steps are enough: a diagonal one is allowed only where
// two straight ones lead to the same cell.
Grid<char> reachable_from(const Grid<float>& cost, Cell start, const GridSearchOptions& options) {
  constexpr std::array<Cell, 4> kSteps = {Cell{1, 0}, Cell{0, 1}, Cell{-1, 0}, Cell{0, -1}};
  Grid<char> reached(cost.geometry, 0);
  std::vector<Cell> waiting = {start};
  reached[start] = 1;
  while (!waiting.empty()) {
    const Cell c = waiting.back();
    waiting.pop_back();
    for (const Cell& step : kSteps) {
      const Cell next{c.x + step.x, c.y + step.y};
      if (!cost.geometry.contains(next) || reached[next] != 0 || lethal(cost, next, options)) {
        continue;
      }
      reached[next] = 1;
      waiting.push_back(next);
    }
  }
  return reached;
}

Plan no_plan(PlanStatus status, std::string reason) {
  Plan plan;
  plan.status = status;
  plan.reason = std::move(reason);
  return plan;
}

// What forbids a plan before any search, if anything does.
std::optional<Plan> refuse(const Grid<float>& cost, const Eigen::Vector2d& start,
                           const Eigen::Vector2d& goal, const GridSearchOptions& options) {
  const GridGeometry& geometry = cost.geometry;
  if (geometry.columns <= 0 || geometry.rows <= 0) {
    return no_plan(PlanStatus::kMapEmpty,
                   "the cost map has no cells: map some ground before planning");
  }
  const auto start_cell = cell_on_map(geometry, start);
  if (!start_cell) {
    const Eigen::Vector2d upper =
        geometry.origin + geometry.resolution_m * Eigen::Vector2d(geometry.columns, geometry.rows);
    return no_plan(
        PlanStatus::kStartOutside,
        fmt::format("the start {} is not on the map, which spans {} to {}; {}", place(start),
                    place(geometry.origin), place(upper), nearest_free_text(cost, start, options)));
  }
  const auto blocked = [&](const char* what, const Eigen::Vector2d& p, Cell c) {
    return fmt::format("the {} {} lies in an obstacle ({}); {}", what, place(p),
                       cost_text(cost[c], options), nearest_free_text(cost, p, options));
  };
  if (lethal(cost, *start_cell, options)) {
    return no_plan(PlanStatus::kStartBlocked, blocked("start", start, *start_cell));
  }
  const float unknown = std::numeric_limits<float>::quiet_NaN();
  const auto goal_cell = cell_on_map(geometry, goal);
  if (goal_cell && lethal(cost, *goal_cell, options)) {
    return no_plan(PlanStatus::kGoalBlocked, blocked("goal", goal, *goal_cell));
  }
  if (!goal_cell && CellCharge(options).lethal(unknown)) {
    return no_plan(
        PlanStatus::kGoalBlocked,
        fmt::format("the goal {} lies beyond the map in an obstacle ({}); lower unexplored_cost "
                    "below lethal_cost; {}",
                    place(goal), cost_text(unknown, options),
                    nearest_free_text(cost, goal, options)));
  }
  return std::nullopt;
}

std::string unreachable_text(const Grid<float>& cost, const Eigen::Vector2d& start,
                             const Eigen::Vector2d& goal, bool beyond,
                             const GridSearchOptions& options) {
  const Grid<char> reached = reachable_from(cost, cost.geometry.cell_at(start), options);
  const auto nearest = nearest_centre(cost.geometry, goal, [&](Cell c) { return reached[c] != 0; });
  return fmt::format(
      "obstacles (cost {:g} and above) part the start {} from {} {}; the nearest "
      "place that can be reached is {}",
      options.lethal_cost, place(start), beyond ? "all exits of the map to the goal" : "the goal",
      place(goal), place(nearest.value_or(start)));
}

Points full_path(const GridGeometry& geometry, const GridPath& found, const Eigen::Vector2d& start,
                 const Eigen::Vector2d& goal) {
  Points points = {start};
  if (start != goal) {
    for (const Cell& c : found.cells) {
      if (geometry.centre(c) != points.back()) points.push_back(geometry.centre(c));
    }
    if (points.size() > 1 && points.back() == goal) points.pop_back();
  }
  points.push_back(goal);
  return points;
}

// Leaves out what points of a path it can. Searches far ahead by doubling, so that a path of n
// points takes some n log n cells of lines instead of n squared.
class Shortener {
 public:
  Shortener(const Grid<float>& cost, const Points& path, const PlannerOptions& options,
            const GridSearchOptions& search)
      : cost_(cost), path_(path), search_(search), allowed_(1.0 + options.shortcut_tolerance) {
    so_far_.push_back(0.0);
    for (std::size_t i = 1; i < path.size(); ++i) {
      so_far_.push_back(so_far_.back() + line_cost(cost, path[i - 1], path[i], search));
    }
  }
  [[nodiscard]] double path_cost() const { return so_far_.back(); }

  [[nodiscard]] Points waypoints() const {
    std::vector<std::size_t> kept = {0};
    while (kept.back() + 1 < path_.size()) kept.push_back(furthest(kept.back()));
    // What a point far ahead forbids, one still further may allow: until nothing can be left out.
    for (bool changed = true; changed;) {
      changed = false;
      for (std::size_t k = 1; k + 1 < kept.size();) {
        if (!replaceable(kept[k - 1], kept[k + 1])) {
          ++k;
          continue;
        }
        kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(k));
        changed = true;
      }
    }
    Points points;
    for (const std::size_t i : kept) points.push_back(path_[i]);
    return points;
  }

 private:
  // May the straight line stand for the path from point i to point j?
  [[nodiscard]] bool replaceable(std::size_t i, std::size_t j) const {
    if (!line_is_clear(cost_, path_[i], path_[j], search_)) return false;
    const double rounding = 1e-12 * so_far_[j];
    return line_cost(cost_, path_[i], path_[j], search_) <=
           allowed_ * (so_far_[j] - so_far_[i]) + rounding;
  }

  [[nodiscard]] std::size_t furthest(std::size_t i) const {
    const std::size_t last = path_.size() - 1;
    std::size_t reached = i + 1;
    std::size_t step = 1;
    for (; reached < last; step *= 2) {
      const std::size_t next = std::min(reached + step, last);
      if (!replaceable(i, next)) break;
      reached = next;
    }
    for (; step > 0 && reached < last; step /= 2) {
      const std::size_t next = std::min(reached + step, last);
      if (replaceable(i, next)) reached = next;
    }
    return reached;
  }

  const Grid<float>& cost_;
  const Points& path_;
  const GridSearchOptions& search_;
  double allowed_;
  std::vector<double> so_far_;  // cost of the path up to each point
};

}  // namespace

OptionSet describe(PlannerOptions& options) {
  OptionSet set;
  set.add("lethal_cost", options.lethal_cost, "cells of this cost and above are never entered",
          0.001, 1e9);
  set.add("unexplored_cost", options.unexplored_cost,
          "cost of cells nothing is known about, and of the ground beyond the map", 0.001, 1e9);
  set.add("shortcut_tolerance", options.shortcut_tolerance,
          "a waypoint is left out if the straight line costs at most this fraction more", 0.0, 1.0);
  set.require({"unexplored_cost", "lethal_cost"},
              "unexplored ground must cost at most what is lethal",
              [&options] { return options.unexplored_cost <= options.lethal_cost; });
  return set;
}

const char* to_string(PlanStatus status) {
  switch (status) {
    case PlanStatus::kFound:
      return "found";
    case PlanStatus::kMapEmpty:
      return "map empty";
    case PlanStatus::kStartOutside:
      return "start outside";
    case PlanStatus::kStartBlocked:
      return "start blocked";
    case PlanStatus::kGoalBlocked:
      return "goal blocked";
    case PlanStatus::kUnreachable:
      return "unreachable";
  }
  return "?";
}

Plan plan_waypoints(const Grid<float>& cost, const Eigen::Vector2d& start,
                    const Eigen::Vector2d& goal, const PlannerOptions& options,
                    const Context& context) {
  const ScopedTimer timer(context, "plan/waypoints");
  assert(start.allFinite() && goal.allFinite());
  const GridSearchOptions search{options.lethal_cost, options.unexplored_cost};
  if (auto refused = refuse(cost, start, goal, search)) return *std::move(refused);

  const GridGeometry& geometry = cost.geometry;
  const Cell start_cell = geometry.cell_at(start);
  const auto goal_cell = cell_on_map(geometry, goal);
  const GridPath found = goal_cell ? search_grid(cost, start_cell, *goal_cell, search)
                                   : search_grid_to_exit(cost, start_cell, goal, search);
  Plan plan;
  plan.goal_beyond_map = !goal_cell;
  plan.expanded = found.expanded;
  if (!found.found) {
    plan.status = PlanStatus::kUnreachable;
    plan.reason = unreachable_text(cost, start, goal, plan.goal_beyond_map, search);
    return plan;
  }
  plan.status = PlanStatus::kFound;
  plan.path = full_path(geometry, found, start, goal);
  const Shortener shortener(cost, plan.path, options, search);
  plan.cost = shortener.path_cost();
  plan.waypoints = shortener.waypoints();
  for (std::size_t i = 1; i < plan.waypoints.size(); ++i) {
    plan.length_m += (plan.waypoints[i] - plan.waypoints[i - 1]).norm();
  }
  return plan;
}

}  // namespace tread
