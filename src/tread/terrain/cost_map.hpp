// The cost map of paper R ("The Cost Map"): what it costs a robot to be at a place, in any heading.
// Derivative -> piecewise-linear cost -> mean over a square as large as the robot, at a third of
// the ground's resolution; unexplored ground has a cost of its own; places known to be bad from
// other senses are kept in lists and merged as the maximum.
#pragma once

#include <limits>
#include <map>
#include <span>
#include <vector>

#include "tread/terrain/global_map.hpp"

namespace tread {

struct CostOptions {
  // Cost over squared derivative (m^2), constant beyond the ends. The first three knots are METHODS
  // 8.2 (flat up to a 5 cm step, 100 at 20 cm); the fourth says that a step of 30 cm is beyond any
  // rover: averaging dilutes thin obstacles, and without it a post would look like rough grass.
  // Costs are 0 or more and do not fall.
  Knots knots = {{{0.04, 1.0}}, {{0.16, 20.0}}, {{0.64, 100.0}}, {{1.44, 1000.0}}};
  double unexplored_cost = 5.0;  // of ground without derivative: not below good ground's
  double window_m = 1.2;         // side of the square that is averaged over; paper R: 1.2
  int cells_per_side = 3;        // a cost cell is this many ground cells wide; paper R: 0.3 / 0.1
};
[[nodiscard]] OptionSet describe(CostOptions& options);
// What must hold between these and the side of a ground cell: windows leave no gaps between them,
// in which an obstacle would not be seen, and are at most 500 cells wide.
[[nodiscard]] bool covers_ground(const CostOptions& options, double ground_resolution_m);

// Piecewise-linear, constant before the first and after the last knot. Paper R, Fig. 4.
[[nodiscard]] double interpolate(const Knots& knots, double x);

// A place found bad by something else than the cameras.
struct Obstacle {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  // world, metres
  double radius_m = 0.5;
  double cost = 1000.0;
};
enum class ObstacleList { kBump, kSlip, kForbidden };

class CostMap {
 public:
  // grid() takes at most max_grid_mib, 4 bytes a cell: places and obstacles that would make it
  // larger are refused. The ground itself is bounded by the GlobalMap.
  explicit CostMap(const CostOptions& options = {}, double ground_resolution_m = 0.1,
                   int max_grid_mib = 2048);

  // Brings the costs up to date after the derivative of these ground cells changed. Equal to the
  // bit to computing the whole map anew. Cost: O(cells near the changes).
  void update(const GlobalMap& ground, std::span<const Cell> changes, const Context& context = {});

  // Replaces one of the lists. A cell that a disc touches costs at least the disc's cost. Discs
  // that cannot be (not finite, radius beyond 100 m or 2000 cells, so far away that grid() would be
  // too large) are refused and the list stays as it was.
  [[nodiscard]] Status set_obstacles(ObstacleList list, std::vector<Obstacle> obstacles);

  // Makes grid() reach over this place, known or not: where the robot stands is part of its map
  // even if its cameras cannot see it. Does nothing where can_reach() says no: the place is not
  // finite, or so far away that grid() would be too large.
  void reach(const Eigen::Vector2d& place);
  [[nodiscard]] bool can_reach(const Eigen::Vector2d& place) const;

  // Forgets the ground and the places reached; the lists of obstacles stay.
  void clear();

  // NaN where nothing is known within the window: the planner's unexplored.
  [[nodiscard]] float at(Cell cell) const;
  [[nodiscard]] double resolution_m() const {
    return options_.cells_per_side * ground_resolution_m_;
  }
  // Costs over the smallest rectangle with all known cells: what the planner searches. Copies.
  [[nodiscard]] Grid<float> grid() const;
  [[nodiscard]] const CostOptions& options() const { return options_; }
  // Layer "cost" and the numbers "unexplored_cost", "cost_window_m".
  void add_layer(MapLayers& map) const;

 private:
  struct CostCell {
    float ground = std::numeric_limits<float>::quiet_NaN();
    float obstacle = 0.0F;
    bool stale = false;
  };
  [[nodiscard]] CellRect window_cells(Cell ground) const;
  void refresh(const GlobalMap& ground, const CellRect& block);
  void raise(const Obstacle& obstacle, bool clear);
  [[nodiscard]] bool has_room_for(const CellRect& bounds) const;

  CostOptions options_;
  double ground_resolution_m_;
  std::int64_t max_grid_cells_;
  // Along one axis: how much of each ground cell lies in the window around the centre of a cost
  // cell. The first belongs to ground cell cells_per_side * X + first_offset_. Paper R's window is
  // 12 ground cells around the middle of one: 13 weights, the outer two half.
  std::vector<double> weights_;
  int first_offset_ = 0;
  TiledGrid<CostCell> cells_;
  CellRect bounds_;
  std::map<ObstacleList, std::vector<Obstacle>> obstacles_;
};

}  // namespace tread
