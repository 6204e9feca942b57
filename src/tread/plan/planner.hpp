// From a cost map to sparse waypoints: paper R's three-step planner. The search is bounded by the
// known square; beyond it the plan goes straight to the goal.
#pragma once

#include <string>
#include <vector>

#include "tread/core/grid.hpp"
#include "tread/core/options.hpp"
#include "tread/core/timer.hpp"

namespace tread {

struct PlannerOptions {
  double lethal_cost = 50.0;  // cells of this cost and above are never entered, cost units
  // Of cells nothing is known about, and beyond the map. Equal to lethal_cost they are lethal too;
  // above it is a mistake.
  double unexplored_cost = 5.0;
  double shortcut_tolerance = 0.02;  // a waypoint is left out if the straight line costs at most
                                     // this fraction more than the path it replaces
};
[[nodiscard]] OptionSet describe(PlannerOptions& options);

enum class PlanStatus {
  kFound,
  kMapEmpty,      // the cost map has no cells
  kStartOutside,  // the start is not on the map
  kStartBlocked,  // the start is in a lethal cell
  kGoalBlocked,   // the goal is in a lethal cell
  kUnreachable,   // lethal cells part start and goal, or enclose the start
};
[[nodiscard]] const char* to_string(PlanStatus status);

struct Plan {
  PlanStatus status = PlanStatus::kMapEmpty;
  std::string reason;  // one sentence for people: places, costs and what to do; empty if found
  bool goal_beyond_map = false;
  // Start, centres of cells, goal; metres. At least two points if found, equal if the start is the
  // goal, else no two in a row are.
  std::vector<Eigen::Vector2d> path;
  // Points of the path, start to goal, only where the direction must change: none can be left out
  // for the straight line between its neighbours. No line between two touches a lethal cell, nor
  // the corner of one; only the start or the goal itself may lie on the edge of one.
  std::vector<Eigen::Vector2d> waypoints;
  double length_m = 0.0;  // of the waypoints
  double cost = 0.0;      // integral along the path, cost x metres; ground beyond the map at the
                          // unexplored cost. That of the waypoints is at most 1 +
                          // shortcut_tolerance times as much.
  std::size_t expanded = 0;
};

// Never fails as a program: a plan that cannot be is a status with its reason. Start and goal in
// metres in the frame of the grid; they must be finite (assertion). Points on the lower edges of
// the map are on it, points on the upper edges beyond it, as for all cells.
[[nodiscard]] Plan plan_waypoints(const Grid<float>& cost, const Eigen::Vector2d& start,
                                  const Eigen::Vector2d& goal, const PlannerOptions& options,
                                  const Context& context = {});

}  // namespace tread
