// Small worlds made by hand, for the tests of the simulator.
#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>

#include "tread/sim/world.hpp"

namespace tread::testing {

// Ground of one material about the origin, with a height at each centre of its cells.
inline World world_with_ground(
    Surface surface, double side_m = 20.0, double resolution_m = 0.1,
    const std::function<double(double, double)>& height = [](double, double) { return 0.0; }) {
  World world;
  const int cells = static_cast<int>(std::lround(side_m / resolution_m));
  const GridGeometry geometry{resolution_m, Eigen::Vector2d::Constant(-0.5 * cells * resolution_m),
                              cells, cells};
  world.ground = Grid<float>(geometry);
  for (int y = 0; y < cells; ++y) {
    for (int x = 0; x < cells; ++x) {
      const Eigen::Vector2d place = geometry.centre({x, y});
      world.ground[{x, y}] = static_cast<float>(height(place.x(), place.y()));
    }
  }
  world.ground_surface = Grid<std::uint8_t>(geometry);
  world.ground_materials = {material_of(surface, Season::kSummer, 7)};
  return world;
}

inline Solid make_solid(Solid::Shape shape, const Eigen::Vector3d& centre,
                        const Eigen::Vector3d& half_m, Surface surface = Surface::kConcrete) {
  Solid solid;
  solid.name = "thing";
  solid.shape = shape;
  solid.T_world_solid.translation() = centre;
  solid.half_m = half_m;
  solid.material = material_of(surface, Season::kSummer, 3);
  return solid;
}

// A regular eight-sided body about the origin whose corners are one metre away.
inline Mesh octahedron() {
  Mesh mesh;
  for (int axis = 0; axis < 3; ++axis) {
    mesh.vertices.push_back(Eigen::Vector3f::Unit(axis));
    mesh.vertices.push_back(-Eigen::Vector3f::Unit(axis));
  }
  for (std::int32_t z = 4; z < 6; ++z) {
    for (std::int32_t y = 2; y < 4; ++y) {
      for (std::int32_t x = 0; x < 2; ++x) {
        const bool even = (x + y + z) % 2 == 0;
        mesh.triangles.push_back(even ? std::array{x, y, z} : std::array{x, z, y});
      }
    }
  }
  return mesh;
}

// A camera at a place that looks along `yaw`, down by `pitch`: its optical axes in the world.
inline Isometry3d camera_pose(const Eigen::Vector3d& place, double yaw_deg, double pitch_deg,
                              double roll_deg = 0.0) {
  constexpr double kRad = std::numbers::pi / 180.0;
  Isometry3d T = Isometry3d::Identity();
  T.linear() = rotation_from_yaw_pitch_roll(kRad * yaw_deg, kRad * pitch_deg, kRad * roll_deg) *
               R_body_optical();
  T.translation() = place;
  return T;
}

inline std::shared_ptr<const World> shared(World world) {
  return std::make_shared<const World>(std::move(world));
}

}  // namespace tread::testing
