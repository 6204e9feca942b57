#include "tread/sim/ground_surface.hpp"

#include <algorithm>
#include <cmath>

namespace tread {

GroundSurface::GroundSurface(const World& world, const Eigen::Vector2d& centre)
    : columns_(static_cast<std::size_t>(world.ground.geometry.columns)),
      rows_(static_cast<std::size_t>(world.ground.geometry.rows)),
      resolution_m_(world.ground.geometry.resolution_m),
      first_(world.ground.geometry.centre({0, 0}) - centre) {
  const int columns = world.ground.geometry.columns, rows = world.ground.geometry.rows;
  vertices_.resize(world.ground.values.size());
  const auto step = static_cast<float>(resolution_m_);
  std::size_t i = 0;
  for (int y = 0; y < rows; ++y) {
    const int south = std::max(y - 1, 0), north = std::min(y + 1, rows - 1);
    for (int x = 0; x < columns; ++x, ++i) {
      const int west = std::max(x - 1, 0), east = std::min(x + 1, columns - 1);
      GroundVertex& vertex = vertices_[i];
      vertex.height = world.ground[{x, y}];
      vertex.slope_x = (world.ground[{east, y}] - world.ground[{west, y}]) /
                       (step * static_cast<float>(east - west));
      vertex.slope_y = (world.ground[{x, north}] - world.ground[{x, south}]) /
                       (step * static_cast<float>(north - south));
      vertex.look = world.ground_surface[{x, y}];
      for (int v = south; v <= north; ++v) {
        for (int u = west; u <= east; ++u) {
          if (world.ground_surface[{u, v}] != world.ground_surface[{x, y}]) {
            vertex.look |= kGroundBorder;
          }
        }
      }
    }
  }
}

GroundView GroundSurface::view() const {
  return {vertices_.data(),
          static_cast<std::int32_t>(columns_),
          static_cast<std::int32_t>(rows_),
          resolution_m_,
          first_.x(),
          first_.y()};
}

void GroundSurface::give_to(RayTracer& tracer, RayTracer::Layer layer, std::uint32_t id,
                            std::uint32_t mask) const {
  const int columns = static_cast<int>(columns_), rows = static_cast<int>(rows_);
  RayTracer::Vertices vertices;
  vertices.reserve(vertices_.size());
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      const Eigen::Vector2d place = first_ + resolution_m_ * Eigen::Vector2d(x, y);
      vertices.emplace_back(static_cast<float>(place.x()), static_cast<float>(place.y()),
                            height(x, y));
    }
  }
  std::vector<std::array<std::uint32_t, 4>> quads;
  quads.reserve(static_cast<std::size_t>(columns - 1) * static_cast<std::size_t>(rows - 1));
  const auto across = static_cast<std::uint32_t>(columns);
  for (std::uint32_t y = 0; y + 1 < static_cast<std::uint32_t>(rows); ++y) {
    for (std::uint32_t x = 0; x + 1 < across; ++x) {
      const std::uint32_t corner = y * across + x;
      // The tracer cuts from the second corner to the fourth.
      quads.push_back({corner, corner + 1, corner + across + 1, corner + across});
    }
  }
  tracer.add_quads(layer, id, mask, vertices, quads);
}

GroundSurface::Hit GroundSurface::hit(std::uint32_t part, const Eigen::Vector3d& origin,
                                      const Eigen::Vector3d& direction, double rough) const {
  const int x = static_cast<int>(part % (columns_ - 1)),
            y = static_cast<int>(part / (columns_ - 1));
  const Eigen::Vector2d corner = first_ + resolution_m_ * Eigen::Vector2d(x, y);
  const Eigen::Vector2d in_square =
      (origin.head<2>() + rough * direction.head<2>() - corner) / resolution_m_;
  const double h10 = static_cast<double>(height(x + 1, y)),
               h01 = static_cast<double>(height(x, y + 1));
  Eigen::Vector2d slope;
  double h = 0.0;  // of the plane of the triangle above `corner`
  if (in_square.x() + in_square.y() <= 1.0) {
    h = static_cast<double>(height(x, y));
    slope = Eigen::Vector2d(h10 - h, h01 - h) / resolution_m_;
  } else {
    const double h11 = static_cast<double>(height(x + 1, y + 1));
    slope = Eigen::Vector2d(h11 - h01, h11 - h10) / resolution_m_;
    h = h10 + h01 - h11;
  }
  const double above = origin.z() - h - slope.dot(origin.head<2>() - corner);
  const double falls = slope.dot(direction.head<2>()) - direction.z();
  const double distance = std::abs(falls) > 1e-9 ? above / falls : rough;
  return {distance, Eigen::Vector3d(-slope.x(), -slope.y(), 1.0).normalized()};
}

}  // namespace tread
