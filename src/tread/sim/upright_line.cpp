#include "tread/sim/upright_line.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tread::internal {
namespace {

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
  [[nodiscard]] std::optional<HeightRange> inside() const {
    if (!(low_ <= high_) || !std::isfinite(high_ - low_)) return std::nullopt;
    return HeightRange{low_, high_};
  }

 private:
  Eigen::Vector3d origin_, up_;
  double low_ = -std::numeric_limits<double>::infinity();
  double high_ = std::numeric_limits<double>::infinity();
};

}  // namespace

double outer_radius(const World& world, const Solid& solid) {
  double radius = 0.0;
  switch (solid.shape) {
    case Solid::Shape::kBox:
    case Solid::Shape::kCylinder:
      return solid.half_m.norm();
    case Solid::Shape::kEllipsoid:
      return solid.half_m.maxCoeff();
    case Solid::Shape::kHull:
      for (const Eigen::Vector3f& v : world.hulls[static_cast<std::size_t>(solid.hull)].vertices) {
        radius = std::max(radius, v.cast<double>().cwiseProduct(solid.half_m).norm());
      }
      return radius;
  }
  return radius;
}

std::optional<HeightRange> height_range(const World& world, const Solid& solid,
                                        const Eigen::Vector2d& place) {
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
  return line.inside();
}

}  // namespace tread::internal
