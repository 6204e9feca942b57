// People as simulations of crowds draw them: an upright body of nine rigid parts whose legs and
// arms swing with the way they have gone.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "tread/sim/world.hpp"

namespace tread {
namespace {

constexpr double kStride = 0.8;  // way of two steps / height
constexpr double kSwing = 0.45;  // of a leg each way, rad

// A part hangs from a joint; sizes are shares of the height.
struct Part {
  const char* name;
  Solid::Shape shape;
  Eigen::Vector3d joint;   // about which it swings
  Eigen::Vector3d centre;  // from the joint
  Eigen::Vector3d half;
  double swing;  // share of kSwing, sign by side
  bool skin;
};

const std::array<Part, 7>& parts() {
  using enum Solid::Shape;
  static const std::array<Part, 7> kParts = {{
      {"left leg", kCylinder, {0, 0.055, 0.48}, {0, 0, -0.24}, {0.045, 0.045, 0.24}, 1.0, false},
      {"right leg", kCylinder, {0, -0.055, 0.48}, {0, 0, -0.24}, {0.045, 0.045, 0.24}, -1.0, false},
      {"trunk", kEllipsoid, {0, 0, 0.64}, {0, 0, 0}, {0.075, 0.125, 0.20}, 0.0, false},
      {"left arm", kCylinder, {0, 0.15, 0.80}, {0, 0, -0.18}, {0.028, 0.028, 0.18}, -0.7, false},
      {"right arm", kCylinder, {0, -0.15, 0.80}, {0, 0, -0.18}, {0.028, 0.028, 0.18}, 0.7, false},
      {"neck", kCylinder, {0, 0, 0.85}, {0, 0, 0}, {0.03, 0.03, 0.04}, 0.0, true},
      {"head", kEllipsoid, {0, 0, 0.935}, {0, 0, 0}, {0.055, 0.045, 0.065}, 0.0, true},
  }};
  return kParts;
}

Isometry3d part_pose(const Part& part, double height_m, double swing_rad) {
  Isometry3d T = Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(swing_rad * part.swing, Eigen::Vector3d::UnitY()).matrix();
  T.translation() = height_m * (part.joint + T.linear() * part.centre);
  return T;
}

// Place and heading after a way along the line and back again.
struct OnPath {
  Eigen::Vector2d place;
  double yaw_rad;
};

OnPath on_path(const std::vector<Eigen::Vector2d>& path, double way_m) {
  double length = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i) length += (path[i] - path[i - 1]).norm();
  if (length <= 0.0) return {path.front(), 0.0};
  double rest = std::fmod(way_m, 2.0 * length);
  if (rest < 0.0) rest += 2.0 * length;
  const bool back = rest > length;
  if (back) rest = 2.0 * length - rest;
  for (std::size_t i = 1; i < path.size(); ++i) {
    const Eigen::Vector2d step = path[i] - path[i - 1];
    const double part = step.norm();
    if (rest <= part || i + 1 == path.size()) {
      const Eigen::Vector2d ahead = back ? Eigen::Vector2d(-step) : step;
      const double share = part > 0.0 ? std::min(rest / part, 1.0) : 0.0;
      return {path[i - 1] + share * step, std::atan2(ahead.y(), ahead.x())};
    }
    rest -= part;
  }
  return {path.back(), 0.0};
}

}  // namespace

std::vector<Solid> person_parts(const Person& person) {
  std::vector<Solid> solids;
  for (const Part& part : parts()) {
    Solid solid;
    solid.name = person.name + " " + part.name;
    solid.shape = part.shape;
    solid.half_m = person.height_m * part.half;
    solid.T_world_solid = part_pose(part, person.height_m, 0.0);
    solid.material = part.skin ? material_of(Surface::kSkin, Season::kSummer, person.clothes.seed)
                               : person.clothes;
    solids.push_back(std::move(solid));
  }
  return solids;
}

std::vector<Isometry3d> person_pose(const World& world, const Person& person, double time_s) {
  const double way = person.speed_m_per_s * (time_s + person.ahead_s);
  const OnPath at = on_path(person.path_m, way);
  const double height = ground_height(world, at.place);
  Isometry3d T_world_person = Isometry3d::Identity();
  T_world_person.linear() = rotation_from_yaw_pitch_roll(at.yaw_rad, 0.0, 0.0);
  T_world_person.translation() << at.place, std::isnan(height) ? 0.0 : height;
  const double swing =
      kSwing * std::sin(2.0 * std::numbers::pi * way / (kStride * person.height_m));
  std::vector<Isometry3d> poses;
  for (const Part& part : parts()) {
    poses.push_back(T_world_person * part_pose(part, person.height_m, swing));
  }
  return poses;
}

}  // namespace tread
