// The ground of a world as rays meet it: triangles over the cells, as world.hpp cuts them.
#pragma once

#include <cstdint>
#include <vector>

#include "tread/sim/ray_tracer.hpp"
#include "tread/sim/world.hpp"

namespace tread {

// Axes: those of the world about `centre`. The world must outlive it.
class GroundSurface {
 public:
  GroundSurface() = default;
  GroundSurface(const World& world, const Eigen::Vector2d& centre);

  void give_to(RayTracer& tracer, RayTracer::Layer layer, std::uint32_t id,
               std::uint32_t mask) const;

  struct Hit {
    double distance = 0.0;
    Eigen::Vector3d normal;  // upwards, of the flat triangle
  };
  // Where a ray meets the triangle of a square (the tracer's part) that lies at `rough`.
  [[nodiscard]] Hit hit(std::uint32_t part, const Eigen::Vector3d& origin,
                        const Eigen::Vector3d& direction, double rough) const;
  // The normal of a smooth surface through the heights, for light; `flat`, that of the triangle,
  // where the ground has an edge.
  [[nodiscard]] Eigen::Vector3f smooth_normal(const Eigen::Vector2d& place,
                                              const Eigen::Vector3d& flat) const;
  // Index into ground_materials. Borders between materials are ragged by less than a cell: cells
  // are how the world is written, not how it looks.
  [[nodiscard]] int material(const Eigen::Vector2d& place) const;

 private:
  [[nodiscard]] float height(int x, int y) const {
    return world_->ground
        .values[static_cast<std::size_t>(y) * columns_ + static_cast<std::size_t>(x)];
  }

  const World* world_ = nullptr;
  std::size_t columns_ = 0;
  double resolution_m_ = 1.0;
  Eigen::Vector2d first_ = Eigen::Vector2d::Zero();  // the centre of cell (0, 0)
  std::vector<Eigen::Vector2f> slopes_;              // of the smooth surface, at the centres
  std::vector<std::uint8_t> is_border_;              // cells with another material around
};

}  // namespace tread
