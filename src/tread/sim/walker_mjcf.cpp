#include "tread/sim/walker_mjcf.hpp"

#include <fmt/format.h>

#include <iterator>

namespace tread {
namespace {

constexpr double kHipRadiusM = 0.06, kUpperRadiusM = 0.045, kLowerRadiusM = 0.018;
constexpr const char* kPart = R"(contype="0" conaffinity="1" friction="0 0 0")";

// A rod along z that hangs from the origin of its body.
std::string rod_inertia(double length_m, double mass_kg, double radius_m) {
  const double across = mass_kg * length_m * length_m / 12.0 + mass_kg * radius_m * radius_m / 4.0;
  const double along = mass_kg * radius_m * radius_m / 2.0;
  return fmt::format(R"(<inertial pos="0 0 {}" mass="{}" diaginertia="{} {} {}"/>)",
                     -0.5 * length_m, mass_kg, across, across, along);
}

std::string joint(const WalkerModelOptions& options, int leg, int which, const char* axis) {
  const auto [low, high] = joint_limits(options, leg, which);
  return fmt::format(
      R"(<joint type="hinge" axis="{}" range="{} {}" armature="{}" damping="1" solreflimit="0.004 1" solimplimit="0.95 0.99 0.01"/>)",
      axis, low, high, options.joint_inertia_kg_m2);
}

std::string capsule(int leg, const char* link, double from_m, double to_m, double radius_m) {
  return fmt::format(R"(<geom name="{} {}" type="capsule" fromto="0 0 {} 0 0 {}" size="{}" {}/>)",
                     leg_name(leg), link, -from_m, -to_m, radius_m, kPart);
}

std::string leg_bodies(const WalkerModelOptions& options, int leg) {
  const Eigen::Vector3d hip = hip_position(options, leg);
  std::string text = fmt::format(R"(<body pos="{} {} {}">)", hip.x(), hip.y(), hip.z());
  // A positive angle of HAA swings either foot inwards, HFE and KFE swing it back.
  text += joint(options, leg, 0, is_left(leg) ? "-1 0 0" : "1 0 0");
  text += rod_inertia(options.hip_m, options.hip_kg, kHipRadiusM);
  text += fmt::format(R"(<geom name="{} hip" type="sphere" size="{}" pos="0 0 {}" {}/>)",
                      leg_name(leg), kHipRadiusM, -options.hip_m, kPart);
  text += fmt::format(R"(<body pos="0 0 {}">)", -options.hip_m);
  text += joint(options, leg, 1, "0 1 0") +
          rod_inertia(options.upper_m, options.upper_kg, kUpperRadiusM);
  text += capsule(leg, "upper leg", 0.0, options.upper_m - 0.02, kUpperRadiusM);
  text += fmt::format(R"(<body pos="0 0 {}">)", -options.upper_m);
  text += joint(options, leg, 2, "0 1 0") +
          rod_inertia(options.lower_m, options.lower_kg, kLowerRadiusM);
  text += capsule(leg, "lower leg", 0.02, options.lower_m - 0.01, kLowerRadiusM);
  text += fmt::format(
      R"(<geom name="{}" type="sphere" size="{}" pos="0 0 {}" contype="0" conaffinity="1" priority="1"/>)",
      foot_part(leg), options.foot_radius_m, -options.lower_m);
  return text + "</body></body></body>\n";
}

// A prism along x with its wide side up.
std::string trunk_mesh(const WalkerModelOptions& options) {
  std::string vertices;
  const double low = -options.trunk_below_m;
  for (const double x : {-0.5, 0.5}) {
    for (const double y : {-0.5, 0.5}) {
      vertices += fmt::format("{} {} {} {} {} {} ", x * options.trunk_length_m,
                              y * options.trunk_bottom_width_m, low, x * options.trunk_length_m,
                              y * options.trunk_top_width_m, low + options.trunk_height_m);
    }
  }
  return "<mesh name=\"trunk\" vertex=\"" + vertices + "\"/>";
}

}  // namespace

std::string foot_part(int leg) {
  return std::string(leg_name(leg)) + " foot";
}

RobotMjcf walker_mjcf(const WalkerModelOptions& options) {
  const Eigen::Vector3d &c = options.trunk_centre_m, &I = options.trunk_inertia_kg_m2;
  RobotMjcf robot;
  robot.assets = trunk_mesh(options);
  robot.bodies = "<body name=\"walker\"><freejoint/>";
  robot.bodies += fmt::format(R"(<inertial pos="{} {} {}" mass="{}" diaginertia="{} {} {}"/>)",
                              c.x(), c.y(), c.z(), options.trunk_kg, I.x(), I.y(), I.z());
  robot.bodies += fmt::format("<geom name=\"trunk\" type=\"mesh\" mesh=\"trunk\" {}/>\n", kPart);
  for (int leg = 0; leg < kLegs; ++leg) robot.bodies += leg_bodies(options, leg);
  robot.bodies += "</body>";
  return robot;
}

}  // namespace tread
