#include "tread/sim/world.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "tread/sim/upright_line.hpp"

namespace tread {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

// The triangle of the ground above a place: its cell, how far into it (0 to 1 both ways).
struct GroundSpot {
  Cell cell;
  double a = 0.0, b = 0.0;
};

std::optional<GroundSpot> spot_at(const GridGeometry& geometry, const Eigen::Vector2d& place) {
  if (geometry.columns < 2 || geometry.rows < 2) return std::nullopt;
  const Eigen::Vector2d p = (place - geometry.centre({0, 0})) / geometry.resolution_m;
  if (!(p.x() >= 0.0 && p.y() >= 0.0 && p.x() <= geometry.columns - 1.0 &&
        p.y() <= geometry.rows - 1.0)) {
    return std::nullopt;
  }
  const int x = std::min(static_cast<int>(p.x()), geometry.columns - 2),
            y = std::min(static_cast<int>(p.y()), geometry.rows - 2);
  return GroundSpot{{x, y}, p.x() - x, p.y() - y};
}

struct Corners {
  double h00, h10, h01, h11;
};

Corners corners_of(const Grid<float>& ground, Cell c) {
  return {ground[c], ground[{c.x + 1, c.y}], ground[{c.x, c.y + 1}], ground[{c.x + 1, c.y + 1}]};
}

struct Top {
  double height = kNone;
  const Solid* solid = nullptr;
};

Top top_at(const World& world, const Eigen::Vector2d& place) {
  Top top{ground_height(world, place), nullptr};
  if (std::isnan(top.height)) return top;
  for (const Solid& solid : world.solids) {
    if ((place - solid.T_world_solid.translation().head<2>()).norm() >
        internal::outer_radius(world, solid)) {
      continue;
    }
    const auto range = internal::height_range(world, solid, place);
    if (range && range->high > top.height) top = {range->high, &solid};
  }
  return top;
}

}  // namespace

std::vector<Eigen::Vector2d> way_of(const World& world) {
  std::vector<Eigen::Vector2d> way{world.start.position_m};
  const auto go = [&way](const Eigen::Vector2d& place) {
    if ((place - way.back()).norm() > 1e-9) way.push_back(place);
  };
  for (const Eigen::Vector2d& place : world.route_m) go(place);
  go(world.goal_m);
  return way;
}

double ground_height(const World& world, const Eigen::Vector2d& place) {
  const auto spot = spot_at(world.ground.geometry, place);
  if (!spot) return kNone;
  const auto [h00, h10, h01, h11] = corners_of(world.ground, spot->cell);
  const double a = spot->a, b = spot->b;
  return a + b <= 1.0 ? h00 + a * (h10 - h00) + b * (h01 - h00)
                      : h11 + (1.0 - a) * (h01 - h11) + (1.0 - b) * (h10 - h11);
}

Eigen::Vector3d ground_normal(const World& world, const Eigen::Vector2d& place) {
  const auto spot = spot_at(world.ground.geometry, place);
  if (!spot) return Eigen::Vector3d::UnitZ();
  const auto [h00, h10, h01, h11] = corners_of(world.ground, spot->cell);
  const bool lower = spot->a + spot->b <= 1.0;
  const double dx = lower ? h10 - h00 : h11 - h01, dy = lower ? h01 - h00 : h11 - h10;
  return Eigen::Vector3d(-dx, -dy, world.ground.geometry.resolution_m).normalized();
}

const Material& ground_material(const World& world, const Eigen::Vector2d& place) {
  const GridGeometry& geometry = world.ground_surface.geometry;
  const Eigen::Vector2d p = (place - geometry.origin) / geometry.resolution_m;
  const auto nearest = [](double v, int size) {
    return static_cast<int>(std::clamp(std::floor(v), 0.0, size - 1.0));
  };
  const Cell cell{nearest(p.x(), geometry.columns), nearest(p.y(), geometry.rows)};
  return world.ground_materials[world.ground_surface[cell]];
}

double top_height(const World& world, const Eigen::Vector2d& place) {
  return top_at(world, place).height;
}

const Material& top_material(const World& world, const Eigen::Vector2d& place) {
  const Top top = top_at(world, place);
  return top.solid != nullptr ? top.solid->material : ground_material(world, place);
}

}  // namespace tread
