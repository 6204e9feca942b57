// The simulated world: the one description that physics, rendered cameras and the true maps are
// made from. Plain data; course.hpp makes it from a file. World axes: x east, y north, z up,
// metres.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tread/core/grid.hpp"
#include "tread/geometry/mesh.hpp"
#include "tread/geometry/pose.hpp"
#include "tread/sim/surface.hpp"

namespace tread {

// A rigid convex thing that stands where it is.
struct Solid {
  enum class Shape {
    kBox,        // half_m: half its sides
    kCylinder,   // along z; half_m: radius, radius, half its height
    kEllipsoid,  // half_m: half its axes
    kHull,       // World::hulls[hull], scaled by half_m
  };
  std::string name;  // as the course calls it: "objects[1].pallet (line 9)"
  Shape shape = Shape::kBox;
  Isometry3d T_world_solid = Isometry3d::Identity();
  Eigen::Vector3d half_m = Eigen::Vector3d::Constant(0.5);
  int hull = 0;
  Material material;
};

// Leaves, crowns and blades of grass: they are seen, but a robot goes through them.
struct Foliage {
  std::string name;
  Mesh mesh;  // in the world; without colours
  Material material;
};

// Someone who walks to and fro along a line, with feet on the ground.
struct Person {
  std::string name;
  std::vector<Eigen::Vector2d> path_m;  // at least two places
  double speed_m_per_s = 1.2;
  double height_m = 1.75;
  double ahead_s = 0.0;  // so far on its way at the start, as time
  Material clothes;
};

struct Sun {
  double azimuth_rad = 0.8;    // where it stands, from x to y
  double elevation_rad = 0.9;  // above the horizon; not above it: no sun
  double strength = 1.0;       // of its light; 1 a clear day
  double sky = 0.35;           // light from the sky all round, in the same unit
};

struct RobotPlace {
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();
  double yaw_rad = 0.0;
};

struct World {
  std::string name;
  std::uint64_t seed = 0;
  // Heights of the ground at the CENTRES of the cells, which are the corners of its triangles: the
  // square of the centres (x, y) (x+1, y) (x, y+1) (x+1, y+1) is cut from (x+1, y) to (x, y+1).
  // Between and at the centres, and nowhere else, there is ground.
  Grid<float> ground;
  Grid<std::uint8_t> ground_surface;  // index into ground_materials, of the same cells
  std::vector<Material> ground_materials;
  std::vector<Mesh> hulls;  // convex, of about unit radius about the origin, outward triangles
  std::vector<Solid> solids;
  std::vector<Foliage> foliage;
  std::vector<Person> people;
  Sun sun;
  RobotPlace start;
  Eigen::Vector2d goal_m = Eigen::Vector2d::Zero();
  std::vector<Eigen::Vector2d> route_m;  // places to go through, from start to goal
};

// The way that a course is meant to be crossed: start, route, and the goal if there is no route or
// it ends elsewhere; no place twice in a row.
[[nodiscard]] std::vector<Eigen::Vector2d> way_of(const World& world);

// The height of the ground (without solids) on its triangles; NaN outside.
[[nodiscard]] double ground_height(const World& world, const Eigen::Vector2d& place);
// Its upward normal there, unit length; straight up outside.
[[nodiscard]] Eigen::Vector3d ground_normal(const World& world, const Eigen::Vector2d& place);
// The material of the ground nearest to a place, also from outside.
[[nodiscard]] const Material& ground_material(const World& world, const Eigen::Vector2d& place);
// The highest point of the ground and of all solids above a place; NaN outside the ground. Exact.
[[nodiscard]] double top_height(const World& world, const Eigen::Vector2d& place);
// What that point is of.
[[nodiscard]] const Material& top_material(const World& world, const Eigen::Vector2d& place);

// The parts of a person as solids in its own axes (x forward, z up, origin on the ground), and
// where they are at a time, T_world_part, in the same order: legs and arms swing.
[[nodiscard]] std::vector<Solid> person_parts(const Person& person);
[[nodiscard]] std::vector<Isometry3d> person_pose(const World& world, const Person& person,
                                                  double time_s);

}  // namespace tread
