// How it is made fast: one flat array of nodes with a border of lethal cells around the grid (no
// bounds are checked), costs prepared once, buckets for the open list, and five of eight neighbours
// tried, which is exact also with weights:
//   With x reached from p, the cells next to both that lie backwards are never reached better
//   through x. After a straight step these are the two beside p: p reaches each by a straight step,
//   (c_p + c_n) / 2 < (c_p + c_x) / 2 + sqrt(2) (c_x + c_n) / 2. After a diagonal step they are
//   the two between p and x: (c_p + c_n) / 2 < sqrt(2) (c_p + c_x) / 2 + (c_x + c_n) / 2.
// The queue is exact only to the width of a bucket, so a cell whose cost falls after its visit is
// visited again, and the search ends when nothing that waits can lead to less. Should visits be
// wasted that way (costs that lie far apart), the queue is told to keep exact order.
// Within, costs are in units of cost x cells; memory is 16 bytes a cell.
#include "tread/plan/a_star.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cstdint>
#include <memory>
#include <numbers>

#include "tread/plan/bucket_queue.hpp"

namespace tread {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr float kLethal = std::numeric_limits<float>::infinity();
constexpr double kStraight = 0.5;  // times the sum of both costs
constexpr double kDiagonal = 0.5 * std::numbers::sqrt2;

// Directions count from east against the clock: even straight, odd diagonal.
constexpr std::array<int, 8> kDx = {1, 1, 0, -1, -1, -1, 0, 1};
constexpr std::array<int, 8> kDy = {0, 1, 1, 1, 0, -1, -1, -1};

struct Node {  // without initial values: each is written once, by prepare()
  double g;    // best cost known from the start
  float cost;
  std::uint8_t direction;  // of the step that led here
  bool open;               // waits in the queue
  bool visited;
};

constexpr Node unseen(float cost) {
  return {kInfinity, cost, 0, false, false};
}

// The grid within a border of lethal cells.
struct Field {
  std::unique_ptr<Node[]> nodes;
  std::ptrdiff_t stride = 0;
  float smallest_cost = kLethal;
  float largest_cost = 0.0F;  // of those that are not lethal

  [[nodiscard]] Node* at(int x, int y) const { return nodes.get() + (y + 1) * stride + x + 1; }
};

Field prepare(const Grid<float>& grid, const GridSearchOptions& options) {
  Field field;
  const int columns = grid.geometry.columns;
  const int rows = grid.geometry.rows;
  field.stride = columns + 2;
  field.nodes = std::make_unique_for_overwrite<Node[]>(static_cast<std::size_t>(field.stride) *
                                                       static_cast<std::size_t>(rows + 2));
  const CellCharge charge(options);
  std::vector<float> costs(static_cast<std::size_t>(columns));
  // Positive floats order as their bits do, and of integers compilers find extremes in vectors.
  constexpr auto kLethalBits = std::bit_cast<std::int32_t>(kLethal);
  std::int32_t smallest = kLethalBits;
  std::int32_t largest = 0;
  for (int y = 0; y < rows; ++y) {
    const float* values = &grid[{0, y}];
    for (std::size_t x = 0; x < costs.size(); ++x) {
      costs[x] = charge(values[x]);
      const auto bits = std::bit_cast<std::int32_t>(costs[x]);
      smallest = std::min(smallest, bits);
      largest = std::max(largest, bits & -static_cast<std::int32_t>(bits < kLethalBits));
    }
    std::transform(costs.begin(), costs.end(), field.at(0, y), unseen);
    *field.at(-1, y) = *field.at(columns, y) = unseen(kLethal);
  }
  std::fill_n(field.at(-1, -1), field.stride, unseen(kLethal));
  std::fill_n(field.at(-1, rows), field.stride, unseen(kLethal));
  field.smallest_cost = std::bit_cast<float>(smallest);
  field.largest_cost = std::bit_cast<float>(largest);
  return field;
}

// A target tells the search what it is for: estimate(x, y), a consistent lower bound of the cost
// still to come, and finish(x, y), the cost to the end from here, infinity if it is not an end.
struct CellTarget {
  Cell goal;
  double smallest_cost;
  [[nodiscard]] double estimate(int x, int y) const {
    const double dx = std::abs(static_cast<double>(x) - goal.x);
    const double dy = std::abs(static_cast<double>(y) - goal.y);
    return smallest_cost * (std::max(dx, dy) + (std::numbers::sqrt2 - 1.0) * std::min(dx, dy));
  }
  [[nodiscard]] double finish(int x, int y) const {
    return x == goal.x && y == goal.y ? 0.0 : kInfinity;
  }
};

struct ExitTarget {
  Eigen::Vector2d goal;  // in cells
  double smallest_cost;  // unexplored ground included
  double unexplored_cost;
  const Field* field;
  int columns;
  int rows;

  [[nodiscard]] double distance(int x, int y) const {
    return (goal - Eigen::Vector2d(x + 0.5, y + 0.5)).norm();
  }
  [[nodiscard]] double estimate(int x, int y) const { return smallest_cost * distance(x, y); }
  [[nodiscard]] double finish(int x, int y) const {
    const bool border = x == 0 || y == 0 || x == columns - 1 || y == rows - 1;
    return border && leaves_grid(x, y) ? unexplored_cost * distance(x, y) : kInfinity;
  }
  // Does the line from the centre to the goal go out of the grid where it goes out of the cell?
  [[nodiscard]] bool leaves_grid(int x, int y) const {
    const double dx = goal.x() - (x + 0.5);
    const double dy = goal.y() - (y + 0.5);
    const int next_x = x + (dx > 0.0 ? 1 : -1);
    const int next_y = y + (dy > 0.0 ? 1 : -1);
    const bool out_by_x = next_x < 0 || next_x >= columns;
    const bool out_by_y = next_y < 0 || next_y >= rows;
    // Through a corner, as far as rounding can tell: the two cells beside it are touched.
    if (std::abs(std::abs(dx) - std::abs(dy)) <= 1e-6 * std::abs(dx)) {
      return (out_by_x || out_by_y) && (out_by_x || passable(next_x, y)) &&
             (out_by_y || passable(x, next_y));
    }
    return std::abs(dx) > std::abs(dy) ? out_by_x : out_by_y;
  }
  [[nodiscard]] bool passable(int x, int y) const { return field->at(x, y)->cost < kLethal; }
};

// Turns from the direction of the last step to the five neighbours tried, in eighths: the two
// straight ones beside, ahead, and the two diagonal ones next to the first two.
constexpr std::array<std::array<std::size_t, 5>, 2> kTurns = {{{2, 6, 0, 1, 7}, {1, 7, 0, 2, 6}}};

struct Step {
  std::ptrdiff_t offset;  // to the node
  double length;          // times the sum of both costs
  int dx;
  int dy;
  std::uint8_t direction;
};

template <class Target>
class Search {
 public:
  Search(const Field& field, const Target& target, Cell start)
      : field_(field),
        target_(target),
        start_(start),
        queue_(target.estimate(start.x, start.y), kBucketWidth * field.smallest_cost,
               // A step adds at most its cost and as much again by its estimate.
               4.0 * kDiagonal * field.largest_cost) {
    for (std::size_t direction = 0; direction < 8; ++direction) {
      for (std::size_t k = 0; k < 5; ++k) {
        const std::size_t d = (direction + kTurns[direction % 2][k]) % 8;
        steps_[direction][k] = {kDy[d] * field.stride + kDx[d], d % 2 == 0 ? kStraight : kDiagonal,
                                kDx[d], kDy[d], static_cast<std::uint8_t>(d)};
      }
    }
  }

  GridPath run() {
    GridPath path;
    leave_start();
    std::size_t again = 0;
    path.expanded = 1;
    while (!queue_.empty()) {
      const QueueEntry entry = queue_.pop();
      Node& node = *field_.at(entry.x, entry.y);
      if (!node.open) continue;
      node.open = false;
      const double estimate = node.g + target_.estimate(entry.x, entry.y);
      if (estimate > best_ + queue_.width()) break;  // so is the rest, whatever the order within
      if (estimate >= best_ * (1.0 - 1e-12)) continue;
      again += node.visited ? 1 : 0;
      if (again > kWasted + path.expanded / 4 && !queue_.ordered()) queue_.order();
      ++path.expanded;
      visit(entry.x, entry.y, node.direction);
    }
    path.found = best_ < kInfinity;
    if (path.found) path.cost = best_;
    if (path.found) path.cells = trace_back();
    return path;
  }

 private:
  static constexpr double kBucketWidth = 0.25;  // times the smallest cost; measured, flat around it
  static constexpr std::size_t kWasted = 1000;  // visits in vain that are not worth a change

  // All eight neighbours, for no step led here.
  void leave_start() {
    Node* const here = field_.at(start_.x, start_.y);
    here->g = 0.0;
    end_at(start_.x, start_.y, 0.0);
    const auto free = [&](std::size_t d) {
      return field_.at(start_.x + kDx[d % 8], start_.y + kDy[d % 8])->cost < kLethal;
    };
    for (std::size_t d = 0; d < 8; ++d) {
      if (!free(d) || (d % 2 != 0 && !(free(d - 1) && free(d + 1)))) continue;
      Node& to = *field_.at(start_.x + kDx[d], start_.y + kDy[d]);
      const double g =
          (d % 2 == 0 ? kStraight : kDiagonal) * (static_cast<double>(here->cost) + to.cost);
      improve(to, start_.x + kDx[d], start_.y + kDy[d], static_cast<std::uint8_t>(d), g);
    }
  }

  // Ends here if that is best, then tries the neighbours that a cell reached in this direction can
  // be the best way to. All are compared before any is changed: one unforeseeable branch, not five.
  void visit(int x, int y, std::size_t direction) {
    Node* const here = field_.at(x, y);
    here->visited = true;
    end_at(x, y, here->g);

    const bool odd = direction % 2 != 0;
    const std::array<Step, 5>& steps = steps_[direction];
    std::array<Node*, 5> to{};
    std::array<double, 5> g{};
    for (std::size_t k = 0; k < 5; ++k) {
      to[k] = here + steps[k].offset;
      g[k] = here->g + steps[k].length * (static_cast<double>(here->cost) + to[k]->cost);
    }
    const bool left = to[0]->cost < kLethal;
    const bool right = to[1]->cost < kLethal;
    // After a diagonal step the two cells between here and there are free, or it had been refused.
    const bool ahead = odd || to[2]->cost < kLethal;
    const std::array<bool, 5> allowed = {true, true, !odd || (left && right), left && ahead,
                                         right && ahead};
    unsigned better = 0;
    for (unsigned k = 0; k < 5; ++k) {  // a lethal cell is never better: both sides are infinite
      better |= (allowed[k] ? 1U : 0U) << k & (g[k] < to[k]->g ? 1U : 0U) << k;
    }
    for (; better != 0; better &= better - 1) {
      const auto k = static_cast<std::size_t>(std::countr_zero(better));
      improve(*to[k], x + steps[k].dx, y + steps[k].dy, steps[k].direction, g[k]);
    }
  }

  void improve(Node& node, int x, int y, std::uint8_t direction, double g) {
    node.g = g;
    node.direction = direction;
    node.open = true;
    queue_.push({g + target_.estimate(x, y), x, y});
  }

  void end_at(int x, int y, double g) {
    const double total = g + target_.finish(x, y);
    if (total >= best_) return;
    best_ = total;
    end_ = {x, y};
  }

  [[nodiscard]] std::vector<Cell> trace_back() const {
    std::vector<Cell> cells = {end_};
    while (cells.back() != start_) {
      const Cell c = cells.back();
      const std::size_t d = field_.at(c.x, c.y)->direction;
      cells.push_back({c.x - kDx[d], c.y - kDy[d]});
    }
    std::reverse(cells.begin(), cells.end());
    return cells;
  }

  const Field& field_;
  const Target& target_;
  Cell start_;
  BucketQueue queue_;
  std::array<std::array<Step, 5>, 8> steps_{};  // by direction of the step before
  double best_ = kInfinity;
  Cell end_;
};

template <class Target>
GridPath run_search(const Field& field, const Target& target, Cell start, double resolution_m) {
  // A goal so far away that its distance is no number has no path that could be compared.
  if (!std::isfinite(target.estimate(start.x, start.y))) return {};
  GridPath path = Search<Target>(field, target, start).run();
  path.cost *= resolution_m;
  return path;
}

}  // namespace

GridPath search_grid(const Grid<float>& cost, Cell start, Cell goal,
                     const GridSearchOptions& options) {
  assert(cost.geometry.contains(start) && cost.geometry.contains(goal));
  const Field field = prepare(cost, options);
  if (field.at(start.x, start.y)->cost == kLethal || field.at(goal.x, goal.y)->cost == kLethal) {
    return {};
  }
  const CellTarget target{goal, field.smallest_cost};
  return run_search(field, target, start, cost.geometry.resolution_m);
}

GridPath search_grid_to_exit(const Grid<float>& cost, Cell start, const Eigen::Vector2d& goal,
                             const GridSearchOptions& options) {
  const GridGeometry& geometry = cost.geometry;
  assert(geometry.contains(start));
  const float beyond = CellCharge(options).unexplored();
  const Field field = prepare(cost, options);
  if (field.at(start.x, start.y)->cost == kLethal || beyond == kLethal) return {};
  const ExitTarget target{(goal - geometry.origin) / geometry.resolution_m,
                          std::min(field.smallest_cost, beyond),
                          beyond,
                          &field,
                          geometry.columns,
                          geometry.rows};
  return run_search(field, target, start, geometry.resolution_m);
}

}  // namespace tread
