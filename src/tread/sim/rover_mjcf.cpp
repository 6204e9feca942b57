#include "tread/sim/rover_mjcf.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace tread {
namespace {

constexpr const char* kPart = R"(contype="0" conaffinity="1" friction="0 0 0")";
// Round across as well: a cylinder's edge would jump between the corners of rough ground. Friction
// is that of tyre.hpp, none of MuJoCo's.
constexpr const char* kTread =
    R"(contype="0" conaffinity="1" priority="1" condim="1" type="ellipsoid")";
constexpr double kMotorInertia = 0.05;  // kg m^2, of motor and gear on the wheel
constexpr double kBarM = 0.04, kBarHeightM = 0.12;
constexpr double kGapM = 0.02;  // between wheels and box

std::string box(const char* name, const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  const Eigen::Vector3d middle = 0.5 * (low + high), half = 0.5 * (high - low);
  return fmt::format("<geom name=\"{}\" type=\"box\" pos=\"{} {} {}\" size=\"{} {} {}\" {}/>\n",
                     name, middle.x(), middle.y(), middle.z(), half.x(), half.y(), half.z(), kPart);
}

// A disc about the y axis.
std::string disc_inertia(double mass_kg, double radius_m, double width_m) {
  const double along = 0.5 * mass_kg * radius_m * radius_m;
  const double across = mass_kg * (3.0 * radius_m * radius_m + width_m * width_m) / 12.0;
  return fmt::format(R"(<inertial pos="0 0 0" mass="{}" diaginertia="{} {} {}"/>)", mass_kg, across,
                     along, across);
}

std::string rolling(const RoverWheel& wheel, double width_m, double mass_kg) {
  return fmt::format(R"(<joint name="{}" type="hinge" axis="0 1 0" armature="{}"/>)", wheel.name,
                     wheel.driven ? kMotorInertia : 0.001) +
         disc_inertia(mass_kg, wheel.radius_m, width_m) +
         fmt::format("<geom name=\"{}\" size=\"{} {} {}\" {}/>", wheel.name, wheel.radius_m,
                     0.5 * width_m, wheel.radius_m, kTread);
}

std::string wheel_body(const RoverModelOptions& options, const RoverWheel& wheel) {
  const Eigen::Vector3d& p = wheel.hub_m;
  std::string text = fmt::format(R"(<body pos="{} {} {}">)", p.x(), p.y(), p.z());
  if (wheel.driven) {
    text += rolling(wheel, options.wheel_width_m, options.wheel_kg);
  } else {
    // The fork weighs a fifth of the caster; its damping keeps it from fluttering.
    constexpr double kFork = 0.2;
    text += fmt::format(R"(<joint type="hinge" axis="0 0 1" damping="0.3" armature="0.005"/>)");
    text += fmt::format(R"(<inertial pos="0 0 0" mass="{}" diaginertia="0.001 0.001 0.001"/>)",
                        kFork * options.caster_kg);
    text += fmt::format(R"(<body pos="{} 0 0">)", -options.caster_trail_m);
    text += rolling(wheel, 0.5 * wheel.radius_m, (1.0 - kFork) * options.caster_kg) + "</body>";
  }
  return text + "</body>\n";
}

std::string boxes(const RoverModelOptions& options) {
  const double front = front_axle_m(options) + options.overhang_m, back = front - options.length_m;
  const double inner = 0.5 * (options.track_m - options.wheel_width_m) - kGapM;
  const double outer = 0.5 * options.width_m;
  const double low = options.clearance_m, high = options.height_m;
  const double over_wheels =
      std::clamp(2.0 * std::max(options.wheel_radius_m, options.caster_radius_m) + kGapM,
                 low + 0.01, high - 0.01);
  return box("box", {back, -outer, over_wheels}, {front - kBarM, outer, high}) +
         box("underside", {back, -inner, low}, {front - kBarM, inner, over_wheels}) +
         box(kBumperPart, {front - kBarM, -outer, low},
             {front, outer, std::min(low + kBarHeightM, high)});
}

}  // namespace

std::vector<RoverWheel> rover_wheels(const RoverModelOptions& options) {
  const bool skid = options.drive == RoverModelOptions::Drive::kSkid;
  const double front = front_axle_m(options), back = front - options.wheelbase_m;
  const double y = 0.5 * options.track_m;
  // Casters stand further in, so that they can swivel beside the robot's outline.
  const double y_back = skid ? y : std::max(0.05, y - options.caster_trail_m);
  const double r = options.wheel_radius_m, r_back = skid ? r : options.caster_radius_m;
  std::vector<RoverWheel> wheels;
  wheels.push_back({skid ? "left front wheel" : "left wheel", true, true, {front, y, r}, r});
  wheels.push_back({skid ? "right front wheel" : "right wheel", false, true, {front, -y, r}, r});
  wheels.push_back(
      {skid ? "left rear wheel" : "left caster", true, skid, {back, y_back, r_back}, r_back});
  wheels.push_back(
      {skid ? "right rear wheel" : "right caster", false, skid, {back, -y_back, r_back}, r_back});
  return wheels;
}

RobotMjcf rover_mjcf(const RoverModelOptions& options) {
  const std::vector<RoverWheel> wheels = rover_wheels(options);
  double mass = options.mass_kg;
  for (const RoverWheel& wheel : wheels)
    mass -= wheel.driven ? options.wheel_kg : options.caster_kg;
  const Eigen::Vector3d sides(options.length_m, options.width_m,
                              options.height_m - options.clearance_m);
  const Eigen::Vector3d squares = sides.cwiseAbs2() * mass / 12.0;
  RobotMjcf robot;
  robot.bodies = "<body name=\"rover\"><freejoint/>\n";
  robot.bodies +=
      fmt::format(R"(<inertial pos="{} 0 {}" mass="{}" diaginertia="{} {} {}"/>)",
                  front_axle_m(options) - options.centre_behind_m, options.centre_height_m, mass,
                  squares.y() + squares.z(), squares.x() + squares.z(), squares.x() + squares.y());
  robot.bodies += boxes(options);
  for (const RoverWheel& wheel : wheels) robot.bodies += wheel_body(options, wheel);
  robot.bodies += "</body>";
  return robot;
}

}  // namespace tread
