#include "tread/terrain/cost_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tread {
namespace {

constexpr double kMostWindowCells = 500.0;
constexpr double kMostRadiusCells = 2000.0;

CellRect only(Cell c) {
  return {c, {c.x + 1, c.y + 1}};
}

bool costs_rise(const Knots& knots) {
  double before = 0.0;
  for (const auto& knot : knots) {
    if (knot[1] < before) return false;
    before = knot[1];
  }
  return true;
}

// The cells that a disc may touch.
CellRect cells_around(const Obstacle& disc, double resolution_m) {
  const GridGeometry geometry{resolution_m, {0.0, 0.0}, 0, 0};
  const Eigen::Vector2d reach = Eigen::Vector2d::Constant(disc.radius_m);
  const Cell low = geometry.cell_at(disc.centre - reach);
  const Cell high = geometry.cell_at(disc.centre + reach);
  return {low, {high.x + 1, high.y + 1}};
}

// Farther away cells cannot be numbered.
bool is_near(const Eigen::Vector2d& place, double resolution_m) {
  return place.allFinite() && place.cwiseAbs().maxCoeff() < 1e9 * resolution_m;
}

}  // namespace

OptionSet describe(CostOptions& options) {
  OptionSet set;
  set.add("knots", options.knots, "cost over squared derivative, piecewise linear");
  set.add("unexplored_cost", options.unexplored_cost, "cost of ground without derivative", 0.001,
          1e6);
  set.add("window_m", options.window_m, "side of the square that is averaged over, m", 0.001,
          100.0);
  set.add("cells_per_side", options.cells_per_side, "ground cells along a cost cell", 1, 64);
  set.require({"knots"}, "costs must be 0 or more and must not fall as the ground gets rougher",
              [&options] { return costs_rise(options.knots); });
  set.require({"unexplored_cost", "knots"}, "unexplored ground must not cost less than good ground",
              [&options] {
                return options.knots.empty() || options.unexplored_cost >= options.knots[0][1];
              });
  return set;
}

bool covers_ground(const CostOptions& options, double ground_resolution_m) {
  const double cells = options.window_m / ground_resolution_m;
  return cells >= options.cells_per_side - 1e-9 && cells <= kMostWindowCells + 1e-9;
}

double interpolate(const Knots& knots, double x) {
  if (x <= knots.front()[0]) return knots.front()[1];
  for (std::size_t i = 1; i < knots.size(); ++i) {
    if (x > knots[i][0]) continue;
    const auto& a = knots[i - 1];
    const auto& b = knots[i];
    return a[1] + (b[1] - a[1]) * (x - a[0]) / (b[0] - a[0]);
  }
  return knots.back()[1];
}

CostMap::CostMap(const CostOptions& options, double ground_resolution_m, int max_grid_mib)
    : options_(options),
      ground_resolution_m_(ground_resolution_m),
      max_grid_cells_((std::int64_t{max_grid_mib} << 20) /
                      static_cast<std::int64_t>(sizeof(float))) {
  const double centre = 0.5 * options_.cells_per_side;
  const double half = 0.5 * options_.window_m / ground_resolution_m_;
  first_offset_ = static_cast<int>(std::floor(centre - half + 1e-9));
  const int last = static_cast<int>(std::ceil(centre + half - 1e-9));
  for (int i = first_offset_; i < last; ++i) {
    weights_.push_back(std::min(i + 1.0, centre + half) - std::max<double>(i, centre - half));
  }
}

// The cost cells whose window a ground cell touches.
CellRect CostMap::window_cells(Cell ground) const {
  const int first = first_offset_;
  const int count = static_cast<int>(weights_.size());
  const int k = options_.cells_per_side;
  // k X + first <= ground < k X + first + count
  const auto low = [&](int g) { return floor_div(g - first - count, k) + 1; };
  const auto high = [&](int g) { return floor_div(g - first, k) + 1; };
  return {{low(ground.x), low(ground.y)}, {high(ground.x), high(ground.y)}};
}

bool CostMap::has_room_for(const CellRect& bounds) const {
  return bounds_.united(bounds).size() <= max_grid_cells_;
}

void CostMap::update(const GlobalMap& ground, std::span<const Cell> changes,
                     const Context& context) {
  const ScopedTimer timer(context, "terrain/cost");
  // Cost cells to compute anew, gathered in one rectangle a tile.
  std::map<Cell, CellRect> blocks;
  const auto mark = [&](Cell cell) {
    CostCell& cost = cells_.touch(cell);
    if (cost.stale) return;
    cost.stale = true;
    CellRect& block = blocks.try_emplace(cells_.tile_of(cell), CellRect{cell, cell}).first->second;
    block.first = {std::min(block.first.x, cell.x), std::min(block.first.y, cell.y)};
    block.last = {std::max(block.last.x, cell.x + 1), std::max(block.last.y, cell.y + 1)};
  };
  CellRect before;
  for (const Cell& change : changes) {
    const CellRect touched = window_cells(change);
    if (touched == before) continue;  // neighbours mostly touch the same cells
    before = touched;
    for (int y = touched.first.y; y < touched.last.y; ++y) {
      for (int x = touched.first.x; x < touched.last.x; ++x) mark({x, y});
    }
  }
  for (const auto& [tile, block] : blocks) refresh(ground, block);
}

// Weighted means of a block of cost cells, along x and then along y. Every cell is summed in the
// same order whatever the block, so that updates and full computations agree to the bit.
void CostMap::refresh(const GlobalMap& ground, const CellRect& block) {
  const int taps = static_cast<int>(weights_.size());
  const int k = options_.cells_per_side;
  const int ground_rows = k * (block.rows() - 1) + taps;
  const int ground_columns = k * (block.columns() - 1) + taps;
  const Cell ground_first{k * block.first.x + first_offset_, k * block.first.y + first_offset_};

  std::vector<double> costs(static_cast<std::size_t>(ground_columns));
  std::vector<double> along_x(static_cast<std::size_t>(ground_rows) *
                              static_cast<std::size_t>(block.columns()));
  double total_weight = 0.0;
  for (double w : weights_) total_weight += w;
  total_weight *= total_weight;
  for (int j = 0; j < ground_rows; ++j) {
    for (int i = 0; i < ground_columns; ++i) {
      const GroundCell* cell = ground.find({ground_first.x + i, ground_first.y + j});
      costs[static_cast<std::size_t>(i)] = cell != nullptr && cell->explored()
                                               ? interpolate(options_.knots, cell->derivative)
                                               : options_.unexplored_cost;
    }
    for (int x = 0; x < block.columns(); ++x) {
      double sum = 0.0;
      for (int t = 0; t < taps; ++t) {
        sum += weights_[static_cast<std::size_t>(t)] * costs[static_cast<std::size_t>(k * x + t)];
      }
      along_x[static_cast<std::size_t>(j * block.columns() + x)] = sum;
    }
  }
  for (int y = 0; y < block.rows(); ++y) {
    for (int x = 0; x < block.columns(); ++x) {
      const Cell cell{block.first.x + x, block.first.y + y};
      CostCell& cost = cells_.touch(cell);
      if (!cost.stale) continue;
      double sum = 0.0;
      for (int t = 0; t < taps; ++t) {
        sum += weights_[static_cast<std::size_t>(t)] *
               along_x[static_cast<std::size_t>((k * y + t) * block.columns() + x)];
      }
      cost.stale = false;
      cost.ground = static_cast<float>(sum / total_weight);
      bounds_ = bounds_.united(only(cell));
    }
  }
}

void CostMap::raise(const Obstacle& obstacle, bool clear) {
  const GridGeometry geometry{resolution_m(), {0.0, 0.0}, 0, 0};
  const CellRect around = cells_around(obstacle, resolution_m());
  const double half = 0.5 * resolution_m();
  for (int y = around.first.y; y < around.last.y; ++y) {
    for (int x = around.first.x; x < around.last.x; ++x) {
      // Distance from the centre of the disc to the nearest point of the cell.
      const Eigen::Vector2d offset =
          (obstacle.centre - geometry.centre({x, y})).cwiseAbs() - Eigen::Vector2d::Constant(half);
      if (offset.cwiseMax(0.0).norm() > obstacle.radius_m) continue;
      CostCell& cell = cells_.touch({x, y});
      bounds_ = bounds_.united(only({x, y}));
      cell.obstacle = clear ? 0.0F : std::max(cell.obstacle, static_cast<float>(obstacle.cost));
    }
  }
}

Status CostMap::set_obstacles(ObstacleList list, std::vector<Obstacle> obstacles) {
  for (const Obstacle& disc : obstacles) {
    const bool sound = is_near(disc.centre, resolution_m()) && disc.radius_m >= 0.0 &&
                       disc.radius_m <= 100.0 &&
                       disc.radius_m <= kMostRadiusCells * resolution_m() && disc.cost >= 0.0;
    if (sound) continue;
    return fail(ErrorCode::kBadValue, "a disc with a centre, radius or cost that cannot be",
                "obstacles",
                "Give finite centres, radii of 0 to 100 m and 2000 cells, costs of 0 or more");
  }
  CellRect reached;
  for (const Obstacle& disc : obstacles) {
    reached = reached.united(cells_around(disc, resolution_m()));
    if (has_room_for(reached)) continue;
    return fail(ErrorCode::kTooLarge,
                fmt::format("a disc at ({:g}, {:g}) is so far from the map that a grid with both "
                            "would take more than {} MiB",
                            disc.centre.x(), disc.centre.y(),
                            max_grid_cells_ * static_cast<std::int64_t>(sizeof(float)) >> 20),
                "obstacles", "Leave out what is far away");
  }
  for (const Obstacle& old : obstacles_[list]) raise(old, true);
  obstacles_[list] = std::move(obstacles);
  // Also the other lists: their discs may lie below a cleared one.
  for (const auto& [name, discs] : obstacles_) {
    for (const Obstacle& disc : discs) raise(disc, false);
  }
  return {};
}

bool CostMap::can_reach(const Eigen::Vector2d& place) const {
  return is_near(place, resolution_m()) &&
         has_room_for(only(GridGeometry{resolution_m(), {0.0, 0.0}, 0, 0}.cell_at(place)));
}

void CostMap::reach(const Eigen::Vector2d& place) {
  if (!can_reach(place)) return;
  bounds_ = bounds_.united(only(GridGeometry{resolution_m(), {0.0, 0.0}, 0, 0}.cell_at(place)));
}

void CostMap::clear() {
  cells_ = {};
  bounds_ = {};
  for (const auto& [list, discs] : obstacles_) {
    for (const Obstacle& disc : discs) raise(disc, false);
  }
}

float CostMap::at(Cell cell) const {
  const CostCell* found = cells_.find(cell);
  if (found == nullptr) return std::numeric_limits<float>::quiet_NaN();
  if (found->obstacle <= 0.0F) return found->ground;
  return std::isnan(found->ground) ? found->obstacle : std::max(found->ground, found->obstacle);
}

Grid<float> CostMap::grid() const {
  Grid<float> grid(GridGeometry{resolution_m(),
                                resolution_m() * Eigen::Vector2d(bounds_.first.x, bounds_.first.y),
                                bounds_.columns(), bounds_.rows()});
  for (int y = 0; y < bounds_.rows(); ++y) {
    for (int x = 0; x < bounds_.columns(); ++x) {
      grid[{x, y}] = at({bounds_.first.x + x, bounds_.first.y + y});
    }
  }
  return grid;
}

void CostMap::add_layer(MapLayers& map) const {
  map.layers.push_back(
      {"cost", "1", "what it costs to be there, mean over the robot's square", grid()});
  map.numbers["unexplored_cost"] = options_.unexplored_cost;
  map.numbers["cost_window_m"] = options_.window_m;
}

}  // namespace tread
