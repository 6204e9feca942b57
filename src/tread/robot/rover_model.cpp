#include "tread/robot/rover_model.hpp"

#include <algorithm>
#include <cmath>

namespace tread {
namespace {

void add_body(OptionSet& set, RoverModelOptions& options) {
  set.add("length_m", options.length_m, "of the robot", 0.2, 5.0);
  set.add("width_m", options.width_m, "of the robot", 0.1, 5.0);
  set.add("height_m", options.height_m, "of the top of its box above the ground", 0.1, 3.0);
  set.add("clearance_m", options.clearance_m, "of the box above the ground", 0.01, 1.0);
  set.add("track_m", options.track_m, "between the driven wheels", 0.05, 5.0);
  set.add("wheelbase_m", options.wheelbase_m, "between the axles", 0.1, 5.0);
  set.add("overhang_m", options.overhang_m, "of the bumper before the front axle", 0.0, 2.0);
  set.add("wheel_radius_m", options.wheel_radius_m, "of the driven wheels", 0.03, 1.0);
  set.add("wheel_width_m", options.wheel_width_m, "of the driven wheels", 0.01, 1.0);
  set.add("caster_radius_m", options.caster_radius_m, "of the casters' wheels", 0.02, 1.0);
  set.add("caster_trail_m", options.caster_trail_m, "of a caster's wheel behind its swivel axis",
          0.005, 1.0);
  set.add("mass_kg", options.mass_kg, "of all", 1.0, 5000.0);
  set.add("wheel_kg", options.wheel_kg, "each driven wheel", 0.05, 500.0);
  set.add("caster_kg", options.caster_kg, "each caster", 0.05, 500.0);
  set.add("centre_behind_m", options.centre_behind_m, "mass of the box behind the front axle", -5.0,
          5.0);
  set.add("centre_height_m", options.centre_height_m, "mass of the box above the ground", 0.0, 3.0);
  set.require({"clearance_m", "height_m"}, "the box must have its top above its underside",
              [&options] { return options.clearance_m < options.height_m; });
  set.require(
      {"mass_kg", "wheel_kg", "caster_kg"}, "all must weigh more than the wheels",
      [&options] { return options.mass_kg > 4.0 * (options.wheel_kg + options.caster_kg); });
  set.require({"centre_behind_m", "wheelbase_m"}, "the mass must be between the axles", [&options] {
    return options.centre_behind_m > 0.0 && options.centre_behind_m < options.wheelbase_m;
  });
  set.require({"overhang_m", "wheel_radius_m"}, "the bumper must be before the wheels",
              [&options] { return options.overhang_m > options.wheel_radius_m; });
  set.require({"length_m", "overhang_m", "wheelbase_m"}, "the robot must reach over its rear axle",
              [&options] { return options.length_m >= options.overhang_m + options.wheelbase_m; });
  set.require({"caster_radius_m", "clearance_m", "height_m"},
              "the axles must be below the top of the box", [&options] {
                return std::max(options.caster_radius_m, options.wheel_radius_m) < options.height_m;
              });
}

}  // namespace

OptionSet describe(RoverModelOptions& options) {
  using Drive = RoverModelOptions::Drive;
  OptionSet set;
  set.add_choice("drive", options.drive, "what drives it",
                 {{"differential", Drive::kDifferential}, {"skid", Drive::kSkid}});
  add_body(set, options);
  set.add("top_speed_m_per_s", options.top_speed_m_per_s, "that it can be told", 0.01, 20.0);
  set.add("top_yaw_rate_rad_per_s", options.top_yaw_rate_rad_per_s, "that it can be told", 0.01,
          20.0);
  set.add("acceleration_m_per_s2", options.acceleration_m_per_s2,
          "with which wheels follow what they are told", 0.01, 100.0);
  set.add("torque_nm_per_a", options.torque_nm_per_a, "of a motor, on its wheel", 1e-3, 1e3);
  set.add("current_limit_a", options.current_limit_a, "of a motor's amplifier", 0.1, 1e4);
  set.add("stall_current_a", options.stall_current_a, "of a motor at full voltage", 0.1, 1e4);
  set.add("free_speed_m_per_s", options.free_speed_m_per_s, "at full voltage without load", 0.05,
          50.0);
  set.add("bumper_force_n", options.bumper_force_n, "that presses the bumper", 0.1, 1e4);
  return set;
}

double turning_track_m(const RoverModelOptions& options) {
  const double b = options.track_m;
  if (options.drive == RoverModelOptions::Drive::kDifferential) return b;
  return b + options.wheelbase_m * options.wheelbase_m / b;
}

DriveCommand limited(const RoverModelOptions& options, const DriveCommand& command) {
  return {std::clamp(command.speed_m_per_s, -options.top_speed_m_per_s, options.top_speed_m_per_s),
          std::clamp(command.yaw_rate_rad_per_s, -options.top_yaw_rate_rad_per_s,
                     options.top_yaw_rate_rad_per_s)};
}

WheelSpeeds wheel_speeds(const RoverModelOptions& options, const DriveCommand& command) {
  const auto [v, w] = limited(options, command);
  const double half = 0.5 * turning_track_m(options) * w;
  return {(v - half) / options.wheel_radius_m, (v + half) / options.wheel_radius_m};
}

DriveCommand drive_of(const RoverModelOptions& options, const WheelSpeeds& speeds) {
  const double left = speeds.left_rad_per_s * options.wheel_radius_m,
               right = speeds.right_rad_per_s * options.wheel_radius_m;
  return {0.5 * (left + right), (right - left) / turning_track_m(options)};
}

double front_axle_m(const RoverModelOptions& options) {
  return options.drive == RoverModelOptions::Drive::kDifferential ? 0.0 : 0.5 * options.wheelbase_m;
}

double motor_torque_limit_nm(const RoverModelOptions& options, double speed_rad_per_s,
                             bool forward) {
  const double free = options.free_speed_m_per_s / options.wheel_radius_m;
  const double along = forward ? speed_rad_per_s : -speed_rad_per_s;
  const double current =
      std::clamp(options.stall_current_a * (1.0 - along / free), 0.0, options.current_limit_a);
  return (forward ? 1.0 : -1.0) * options.torque_nm_per_a * current;
}

}  // namespace tread
