#include "tread/sim/ground_surface.hpp"

#include <algorithm>
#include <cmath>

#include "tread/sim/hash_noise_kernel.hpp"

namespace tread {

GroundSurface::GroundSurface(const World& world, const Eigen::Vector2d& centre)
    : world_(&world),
      columns_(static_cast<std::size_t>(world.ground.geometry.columns)),
      resolution_m_(world.ground.geometry.resolution_m),
      first_(world.ground.geometry.centre({0, 0}) - centre) {
  const int columns = world.ground.geometry.columns, rows = world.ground.geometry.rows;
  slopes_.resize(world.ground.values.size());
  is_border_.resize(world.ground.values.size());
  const auto material = [&](int x, int y) { return world.ground_surface[{x, y}]; };
  std::size_t i = 0;
  for (int y = 0; y < rows; ++y) {
    const int south = std::max(y - 1, 0), north = std::min(y + 1, rows - 1);
    for (int x = 0; x < columns; ++x, ++i) {
      const int west = std::max(x - 1, 0), east = std::min(x + 1, columns - 1);
      const auto step = static_cast<float>(resolution_m_);
      slopes_[i] = {
          (height(east, y) - height(west, y)) / (step * static_cast<float>(east - west)),
          (height(x, north) - height(x, south)) / (step * static_cast<float>(north - south))};
      const std::uint8_t own = material(x, y);
      for (int v = south; v <= north; ++v) {
        for (int u = west; u <= east; ++u)
          if (material(u, v) != own) is_border_[i] = 1;
      }
    }
  }
}

void GroundSurface::give_to(RayTracer& tracer, RayTracer::Layer layer, std::uint32_t id,
                            std::uint32_t mask) const {
  const int columns = world_->ground.geometry.columns, rows = world_->ground.geometry.rows;
  RayTracer::Vertices vertices;
  vertices.reserve(world_->ground.values.size());
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

Eigen::Vector3f GroundSurface::smooth_normal(const Eigen::Vector2d& place,
                                             const Eigen::Vector3d& flat) const {
  const GridGeometry& cells = world_->ground.geometry;
  const Eigen::Vector2d p = (place - first_) * (1.0 / resolution_m_);
  const int x = std::clamp(static_cast<int>(p.x()), 0, cells.columns - 2),
            y = std::clamp(static_cast<int>(p.y()), 0, cells.rows - 2);
  const auto a = static_cast<float>(p.x() - x), b = static_cast<float>(p.y() - y);
  const Eigen::Vector2f* low =
      &slopes_[static_cast<std::size_t>(y) * columns_ + static_cast<std::size_t>(x)];
  const Eigen::Vector2f* high = low + columns_;
  const Eigen::Vector2f west = low[0] + b * (high[0] - low[0]),
                        east = low[1] + b * (high[1] - low[1]);
  const Eigen::Vector2f slope = west + a * (east - west);
  const Eigen::Vector3f smooth = Eigen::Vector3f(-slope.x(), -slope.y(), 1.0F) /
                                 std::sqrt(1.0F + slope.squaredNorm()),
                        hard = flat.cast<float>();
  const float share = smooth_step(0.85F, 0.97F, smooth.dot(hard));
  if (share >= 1.0F) return smooth;
  return (hard + share * (smooth - hard)).normalized();
}

int GroundSurface::material(const Eigen::Vector2d& place) const {
  const GridGeometry& cells = world_->ground.geometry;
  const auto cell = [&](const Eigen::Vector2d& p) -> std::size_t {
    const int x = std::clamp(static_cast<int>(std::floor(p.x() + 0.5)), 0, cells.columns - 1),
              y = std::clamp(static_cast<int>(std::floor(p.y() + 0.5)), 0, cells.rows - 1);
    return static_cast<std::size_t>(y) * columns_ + static_cast<std::size_t>(x);
  };
  const Eigen::Vector2d p = (place - first_) / resolution_m_;
  std::size_t at = cell(p);
  if (is_border_[at] != 0) {
    const auto x = static_cast<float>(p.x()), y = static_cast<float>(p.y());
    at = cell(p + 0.9 * Eigen::Vector2d(static_cast<double>(fbm(1.3F * x, 1.3F * y, 4, 0.7F, 1U)),
                                        static_cast<double>(fbm(1.3F * x, 1.3F * y, 4, 0.7F, 2U))));
  }
  return world_->ground_surface.values[at];
}

}  // namespace tread
