// Worlds made by hand for tests and benchmarks of physics.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string>

#include "tread/sim/random.hpp"
#include "tread/sim/world.hpp"

namespace tread::test {

// Ground of a shape, `size_m` square about the origin, all of one material.
inline World ground_world(double size_m, double cell_m, Surface surface,
                          const std::function<double(double, double)>& height) {
  World world;
  world.name = "ground";
  const int cells = static_cast<int>(std::lround(size_m / cell_m)) + 1;
  const Eigen::Vector2d origin = Eigen::Vector2d::Constant(-0.5 * cell_m * cells);
  world.ground = Grid<float>({cell_m, origin, cells, cells});
  world.ground_surface = Grid<std::uint8_t>(world.ground.geometry, 0);
  world.ground_materials = {material_of(surface, Season::kSummer, 1)};
  for (int y = 0; y < cells; ++y) {
    for (int x = 0; x < cells; ++x) {
      const Eigen::Vector2d p = world.ground.geometry.centre({x, y});
      world.ground[{x, y}] = static_cast<float>(height(p.x(), p.y()));
    }
  }
  return world;
}

inline World flat_world(Surface surface = Surface::kConcrete, double size_m = 20.0,
                        double cell_m = 0.25) {
  return ground_world(size_m, cell_m, surface, [](double, double) { return 0.0; });
}

// Rises along x.
inline World slope_world(double slope_rad, Surface surface, double size_m = 20.0) {
  return ground_world(size_m, 0.25, surface,
                      [=](double x, double) { return x * std::tan(slope_rad); });
}

// Waves and bumps, some 20 cm up and down, steep in places.
inline double rough_height(double x, double y) {
  return 0.08 * std::sin(0.9 * x) * std::cos(0.7 * y) + 0.04 * std::sin(2.9 * x + 1.3 * y) +
         0.02 * std::cos(7.1 * y - 3.3 * x);
}

inline Solid solid_at(Solid::Shape shape, const Eigen::Vector3d& place_m,
                      const Eigen::Vector3d& half_m, const Eigen::Vector3d& turn_rad,
                      const std::string& name, Surface surface = Surface::kConcrete) {
  Solid solid;
  solid.name = name;
  solid.shape = shape;
  solid.T_world_solid.linear() = so3_exp(turn_rad);
  solid.T_world_solid.translation() = place_m;
  solid.half_m = half_m;
  solid.material = material_of(surface, Season::kSummer, 2);
  return solid;
}

// A box on level ground with its top at a height.
inline Solid block(double x, double y, double half_x, double half_y, double top_m,
                   const std::string& name) {
  return solid_at(Solid::Shape::kBox, {x, y, top_m - 0.5}, {half_x, half_y, 0.5},
                  Eigen::Vector3d::Zero(), name);
}

// Two pallets, and between them four stones below the feet of a walker at the origin.
inline World stones_world() {
  World world = flat_world();
  world.solids = {block(1.0, 0.0, 0.4, 0.6, 0.15, "pallets[0]"),
                  block(-1.0, 0.0, 0.4, 0.6, 0.15, "pallets[1]")};
  for (const double x : {-0.36, 0.36}) {
    for (const double y : {-0.32, 0.32}) {
      world.solids.push_back(block(x, y, 0.09, 0.09, 0.07, "stones"));
    }
  }
  return world;
}

// Steps up along x; a walker at the origin has its front feet on one.
inline World stairs_world() {
  World world = flat_world();
  for (int i = 0; i < 6; ++i) {
    world.solids.push_back(block(0.28 * i + 0.9, 0.0, 1.0, 1.0, 0.12 * (i + 1), "stairs"));
  }
  return world;
}

// A polyhedron of about unit radius: an octahedron whose corners are moved a little.
inline Mesh rock_hull(std::uint64_t seed) {
  Random dice(seed);
  Mesh hull;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {1.0, -1.0}) {
      Eigen::Vector3d v = sign * dice.uniform(0.8, 1.1) * Eigen::Vector3d::Unit(axis);
      for (int i = 0; i < 3; ++i) v(i) += dice.uniform(-0.1, 0.1);
      hull.vertices.emplace_back(v.cast<float>());
    }
  }
  hull.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                    {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  return hull;
}

// Solids of every shape, turned every way, strewn over the ground but not near the origin.
inline void strew(World& world, int count, double half_side_m, std::uint64_t seed,
                  double least_m = 0.1, double most_m = 0.5) {
  Random dice(seed);
  for (int i = 0; i < 4; ++i)
    world.hulls.push_back(rock_hull(seed + 10 + static_cast<unsigned>(i)));
  for (int i = 0; i < count; ++i) {
    Eigen::Vector2d p;
    do {
      p = {dice.uniform(-half_side_m, half_side_m), dice.uniform(-half_side_m, half_side_m)};
    } while (p.norm() < 2.0);
    Eigen::Vector3d half(dice.uniform(least_m, most_m), dice.uniform(least_m, most_m),
                         dice.uniform(least_m, most_m));
    const auto shape = static_cast<Solid::Shape>(i % 4);
    if (shape == Solid::Shape::kCylinder) half.y() = half.x();
    const Eigen::Vector3d turn(dice.uniform(-1.5, 1.5), dice.uniform(-1.5, 1.5),
                               dice.uniform(-1.5, 1.5));
    world.solids.push_back(solid_at(shape, {p.x(), p.y(), ground_height(world, p)}, half, turn,
                                    "rocks[" + std::to_string(i) + "]", Surface::kRock));
    world.solids.back().hull = i / 4 % 4;
  }
}

}  // namespace tread::test
