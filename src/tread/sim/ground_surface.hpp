// The ground of a world as rays meet it: triangles over the cells, as world.hpp cuts them.
#pragma once

#include <cstdint>
#include <vector>

#include "tread/sim/ground_kernel.hpp"
#include "tread/sim/ray_tracer.hpp"
#include "tread/sim/world.hpp"

namespace tread {

// Axes: those of the world about `centre`.
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
  // Where a ray meets the triangle of a square (the tracer's part) that lies at `rough`: of one
  // ray, what meet_ground() does for many.
  [[nodiscard]] Hit hit(std::uint32_t part, const Eigen::Vector3d& origin,
                        const Eigen::Vector3d& direction, double rough) const;
  // As meet_ground() wants it.
  [[nodiscard]] GroundView view() const;

 private:
  [[nodiscard]] float height(int x, int y) const {
    return vertices_[static_cast<std::size_t>(y) * columns_ + static_cast<std::size_t>(x)].height;
  }

  std::size_t columns_ = 0, rows_ = 0;
  double resolution_m_ = 1.0;
  Eigen::Vector2d first_ = Eigen::Vector2d::Zero();  // the centre of cell (0, 0)
  std::vector<GroundVertex> vertices_;               // at the centres of the cells
};

}  // namespace tread
