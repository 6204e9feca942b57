#include "tread/terrain/global_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tread/terrain/local_map.hpp"

namespace tread {
namespace {

constexpr double kFarthestCells = 1e9;  // keeps cell numbers within 32 bits

constexpr std::int64_t kBytesPerCell = 3 * sizeof(float);  // the three layers

CellRect only(Cell c) {
  return {c, {c.x + 1, c.y + 1}};
}

// The rectangle of world cells that a turned local map covers.
CellRect covered_cells(const GridGeometry& local, const LevelPose& pose, double resolution_m) {
  const Eigen::Rotation2Dd R(pose.yaw_rad);
  const Eigen::Vector2d extent = local.resolution_m * Eigen::Vector2d(local.columns, local.rows);
  Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::max());
  Eigen::Vector2d high = -low;
  for (int corner = 0; corner < 4; ++corner) {
    const Eigen::Vector2d p =
        local.origin + extent.cwiseProduct(Eigen::Vector2d(corner & 1, corner >> 1));
    const Eigen::Vector2d world = R * p + pose.position.head<2>();
    low = low.cwiseMin(world);
    high = high.cwiseMax(world);
  }
  const auto cell = [resolution_m](double v) {
    return static_cast<int>(std::floor(v / resolution_m));
  };
  return {{cell(low.x()), cell(low.y())}, {cell(high.x()) + 1, cell(high.y()) + 1}};
}

bool within_reach(const LevelPose& pose, double resolution_m) {
  return pose.position.allFinite() && std::isfinite(pose.yaw_rad) &&
         pose.position.cwiseAbs().maxCoeff() <= kFarthestCells * resolution_m;
}

Status check_input(const Grid<float>& height, const Grid<float>& derivative, const LevelPose& pose,
                   double resolution_m) {
  if (!within_reach(pose, resolution_m)) {
    return fail(ErrorCode::kBadValue,
                "the pose of a local map is not finite or more than 1e9 cells from the origin",
                "terrain", "Check the localisation");
  }
  if (height.geometry != derivative.geometry || height.geometry.resolution_m != resolution_m) {
    return fail(ErrorCode::kBadArgument,
                "local height, local derivative and global map have different cells", "terrain",
                "Use one resolution");
  }
  return {};
}

Status check_growth(const CellRect& grown, int max_map_mib) {
  constexpr std::int64_t kMiB = 1 << 20;
  if (grown.size() <= max_map_mib * kMiB / kBytesPerCell) return {};
  return fail(ErrorCode::kTooLarge,
              fmt::format("the map would grow to {} x {} cells, {} MiB; global.max_map_mib is {}",
                          std::int64_t{grown.last.x} - grown.first.x,
                          std::int64_t{grown.last.y} - grown.first.y,
                          grown.size() / (kMiB / kBytesPerCell), max_map_mib),
              "terrain", "Check the poses; raise it, or use larger cells, if they are right");
}

}  // namespace

OptionSet describe(GlobalMapOptions& options) {
  OptionSet set;
  set.add("alpha", options.alpha, "weight of a new derivative in the low-pass", 0.001, 1.0);
  set.add_choice(
      "first", options.first, "a cell's first derivative: low-passed from 0, or copied",
      {{"filter", GlobalMapOptions::First::kFilter}, {"copy", GlobalMapOptions::First::kCopy}});
  set.add("max_map_mib", options.max_map_mib,
          "most that the layers of the map may take, MiB at 12 bytes a cell", 1, 1 << 20);
  return set;
}

Cell GlobalMap::cell_at(const Eigen::Vector2d& p) const {
  return GridGeometry{resolution_m_, {0.0, 0.0}, 0, 0}.cell_at(p);
}

void GlobalMap::note_change(Cell cell, GroundCell& ground) {
  if (ground.changed) return;
  ground.changed = true;
  changes_.push_back(cell);
}

Status GlobalMap::integrate(const Grid<float>& height, const Grid<float>& derivative,
                            const LevelPose& pose, const GlobalMapOptions& options,
                            const Context& context) {
  if (Status ok = check_input(height, derivative, pose, resolution_m_); !ok) return ok;
  const ScopedTimer timer(context, "terrain/global");
  const GridGeometry& local = height.geometry;
  const CellRect covered = covered_cells(local, pose, resolution_m_);
  if (Status ok = check_growth(bounds_.united(covered), options.max_map_mib); !ok) return ok;
  const double c = std::cos(pose.yaw_rad), s = std::sin(pose.yaw_rad);
  const auto alpha = static_cast<float>(options.alpha);
  for (int y = covered.first.y; y < covered.last.y; ++y) {
    for (int x = covered.first.x; x < covered.last.x; ++x) {
      const double wx = (x + 0.5) * resolution_m_ - pose.position.x();
      const double wy = (y + 0.5) * resolution_m_ - pose.position.y();
      const Cell from = local.cell_at({c * wx + s * wy, -s * wx + c * wy});
      if (!local.contains(from) || std::isnan(height[from])) continue;
      GroundCell& ground = cells_.touch({x, y});
      bounds_ = bounds_.united(only({x, y}));
      ground.height_m = height[from] + static_cast<float>(pose.position.z());
      const float measured = derivative[from];
      if (std::isnan(measured)) continue;
      const bool copy = !ground.explored() && options.first == GlobalMapOptions::First::kCopy;
      const float value = copy ? measured : (1.0F - alpha) * ground.derivative + alpha * measured;
      if (!ground.explored() || value != ground.derivative) note_change({x, y}, ground);
      ground.derivative = value;
      if (ground.measurements < std::numeric_limits<std::uint16_t>::max()) ++ground.measurements;
    }
  }
  return {};
}

void GlobalMap::heights_below(const GridGeometry& local, const LevelPose& pose,
                              Grid<float>& heights, const Context& context) const {
  const ScopedTimer timer(context, "terrain/below");
  heights.geometry = local;
  heights.values.assign(local.size(), std::numeric_limits<float>::quiet_NaN());
  if (!within_reach(pose, resolution_m_)) return;
  const Eigen::Vector2d step =
      Eigen::Rotation2Dd(pose.yaw_rad) * Eigen::Vector2d(local.resolution_m, 0.0);
  for (int y = 0; y < local.rows; ++y) {
    const Eigen::Vector2d first =
        Eigen::Rotation2Dd(pose.yaw_rad) * local.centre({0, y}) + pose.position.head<2>();
    for (int x = 0; x < local.columns; ++x) {
      const GroundCell* ground = cells_.find(cell_at(first + x * step));
      if (ground == nullptr) continue;
      heights[{x, y}] = ground->height_m - static_cast<float>(pose.position.z());
    }
  }
}

std::vector<Cell> GlobalMap::take_changes() {
  for (const Cell& cell : changes_) cells_.touch(cell).changed = false;
  std::vector<Cell> taken;
  std::swap(taken, changes_);
  return taken;
}

GridGeometry GlobalMap::bounds_geometry() const {
  return {resolution_m_, resolution_m_ * Eigen::Vector2d(bounds_.first.x, bounds_.first.y),
          bounds_.columns(), bounds_.rows()};
}

Grid<float> GlobalMap::derivative_of_heights() const {
  Grid<float> derivative;
  sobel_squared(layers().find("height")->grid, derivative);
  return derivative;
}

MapLayers GlobalMap::layers() const {
  constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
  MapLayers map;
  map.layers = {{"height", "m", "last measured height above world z = 0", {}},
                {"derivative", "m^2", "low-passed squared Sobel derivative of local heights", {}},
                {"explored", "1", "1 where a derivative has been measured", {}}};
  for (MapLayer& layer : map.layers) {
    layer.grid = Grid<float>(bounds_geometry(), layer.name == "explored" ? 0.0F : kUnknown);
  }
  for (const auto& [tile, data] : cells_.tiles()) {
    constexpr int kSide = TiledGrid<GroundCell>::kTileCells;
    for (int i = 0; i < kSide * kSide; ++i) {
      const Cell world{tile.x * kSide + i % kSide, tile.y * kSide + i / kSide};
      if (!bounds_.contains(world)) continue;
      const GroundCell& ground = (*data)[static_cast<std::size_t>(i)];
      const Cell c{world.x - bounds_.first.x, world.y - bounds_.first.y};
      map.layers[0].grid[c] = ground.height_m;
      if (!ground.explored()) continue;
      map.layers[1].grid[c] = ground.derivative;
      map.layers[2].grid[c] = 1.0F;
    }
  }
  return map;
}

Result<GlobalMap> GlobalMap::from_layers(const MapLayers& layers) {
  const MapLayer* height = layers.find("height");
  const MapLayer* derivative = layers.find("derivative");
  for (const auto& [name, layer] : {std::pair{"height", height}, {"derivative", derivative}}) {
    if (layer != nullptr) continue;
    return fail(ErrorCode::kNotFound, fmt::format("the map has no layer '{}'", name), "map",
                "Give a map that 'tread map' has written");
  }
  const GridGeometry& geometry = height->grid.geometry;
  if (geometry != derivative->grid.geometry) {
    return fail(ErrorCode::kBadFormat, "the layers 'height' and 'derivative' have different cells",
                "map", "Give layers of one geometry");
  }
  const Eigen::Vector2d end =
      geometry.origin + geometry.resolution_m * Eigen::Vector2d(geometry.columns, geometry.rows);
  const double farthest = kFarthestCells * geometry.resolution_m;
  if (!(geometry.resolution_m > 0.0) || !(geometry.origin.cwiseAbs().maxCoeff() <= farthest) ||
      !(end.cwiseAbs().maxCoeff() <= farthest)) {
    return fail(ErrorCode::kBadValue, "the layers lie more than 1e9 cells from the origin", "map",
                "Give a map that 'tread map' has written");
  }
  GlobalMap map(geometry.resolution_m);
  const Cell first{static_cast<int>(std::lround(geometry.origin.x() / geometry.resolution_m)),
                   static_cast<int>(std::lround(geometry.origin.y() / geometry.resolution_m))};
  for (int y = 0; y < geometry.rows; ++y) {
    for (int x = 0; x < geometry.columns; ++x) {
      const float h = height->grid[{x, y}], d = derivative->grid[{x, y}];
      if (std::isnan(h)) continue;
      const Cell cell{first.x + x, first.y + y};
      GroundCell& ground = map.cells_.touch(cell);
      map.bounds_ = map.bounds_.united(only(cell));
      ground.height_m = h;
      if (std::isnan(d)) continue;
      ground.derivative = d;
      ground.measurements = 1;
      map.note_change(cell, ground);
    }
  }
  return map;
}

}  // namespace tread
