#include "tread/sim/world.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

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

// The part of the upright line over a place that is inside a convex body given by half spaces.
class UprightLine {
 public:
  UprightLine(const Isometry3d& T_world_solid, const Eigen::Vector2d& place)
      : origin_(T_world_solid.linear().transpose() *
                (Eigen::Vector3d(place.x(), place.y(), 0.0) - T_world_solid.translation())),
        up_(T_world_solid.linear().transpose() * Eigen::Vector3d::UnitZ()) {}

  // n . p <= d
  void cut(const Eigen::Vector3d& n, double d) {
    const double along = n.dot(up_), room = d - n.dot(origin_);
    if (std::abs(along) < 1e-12) {
      if (room < 0.0) high_ = -std::numeric_limits<double>::infinity();
    } else if (along > 0.0) {
      high_ = std::min(high_, room / along);
    } else {
      low_ = std::max(low_, room / along);
    }
  }
  // |S p| <= 1 with S diagonal.
  void cut_round(const Eigen::Vector3d& scale) {
    const Eigen::Vector3d o = scale.cwiseProduct(origin_), u = scale.cwiseProduct(up_);
    const double a = u.squaredNorm(), b = o.dot(u), c = o.squaredNorm() - 1.0;
    if (a < 1e-18) {
      if (c > 0.0) high_ = -std::numeric_limits<double>::infinity();
      return;
    }
    const double root = b * b - a * c;
    if (root < 0.0) {
      high_ = -std::numeric_limits<double>::infinity();
      return;
    }
    low_ = std::max(low_, (-b - std::sqrt(root)) / a);
    high_ = std::min(high_, (-b + std::sqrt(root)) / a);
  }
  [[nodiscard]] std::optional<double> top() const {
    return low_ <= high_ && std::isfinite(high_) ? std::optional(high_) : std::nullopt;
  }

 private:
  Eigen::Vector3d origin_, up_;
  double low_ = -std::numeric_limits<double>::infinity();
  double high_ = std::numeric_limits<double>::infinity();
};

std::optional<double> top_of(const World& world, const Solid& solid, const Eigen::Vector2d& place) {
  if ((place - solid.T_world_solid.translation().head<2>()).squaredNorm() >
      1.01 * solid.half_m.squaredNorm() * (solid.shape == Solid::Shape::kHull ? 1.5 : 1.0)) {
    return std::nullopt;
  }
  UprightLine line(solid.T_world_solid, place);
  switch (solid.shape) {
    case Solid::Shape::kBox:
      for (int i = 0; i < 3; ++i) {
        line.cut(Eigen::Vector3d::Unit(i), solid.half_m(i));
        line.cut(-Eigen::Vector3d::Unit(i), solid.half_m(i));
      }
      break;
    case Solid::Shape::kCylinder:
      line.cut(Eigen::Vector3d::UnitZ(), solid.half_m.z());
      line.cut(-Eigen::Vector3d::UnitZ(), solid.half_m.z());
      line.cut_round({1.0 / solid.half_m.x(), 1.0 / solid.half_m.y(), 0.0});
      break;
    case Solid::Shape::kEllipsoid:
      line.cut_round(solid.half_m.cwiseInverse());
      break;
    case Solid::Shape::kHull: {
      const Mesh& hull = world.hulls[static_cast<std::size_t>(solid.hull)];
      const auto corner = [&](std::int32_t i) -> Eigen::Vector3d {
        return hull.vertices[static_cast<std::size_t>(i)].cast<double>().cwiseProduct(solid.half_m);
      };
      for (const auto& [a, b, c] : hull.triangles) {
        const Eigen::Vector3d n = (corner(b) - corner(a)).cross(corner(c) - corner(a));
        line.cut(n, n.dot(corner(a)));
      }
      break;
    }
  }
  return line.top();
}

struct Top {
  double height = kNone;
  const Solid* solid = nullptr;
};

Top top_at(const World& world, const Eigen::Vector2d& place) {
  Top top{ground_height(world, place), nullptr};
  if (std::isnan(top.height)) return top;
  for (const Solid& solid : world.solids) {
    const auto height = top_of(world, solid, place);
    if (height && *height > top.height) top = {*height, &solid};
  }
  return top;
}

}  // namespace

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
