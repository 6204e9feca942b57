// The wheeled robot (LAGR: Jackel and others 2006): 1.0 x 0.6 m, two driven wheels in front and
// casters behind, or four driven wheels. Body axes: x forward, y left, z up; the origin is on the
// ground below the middle between the driven wheels, so with casters below the front axle, about
// which the robot turns while its tail swings out.
// Outline, drive and top speeds are those of LAGR; wheels, masses and motors, which nobody has
// published, those of such a machine.
//
// Of wheels that roll without slipping a side goes v -+ w b / 2, b being the track. Four wheels
// whose axles are L apart must scrub sideways to turn; where friction is Coulomb's and all bear
// the same load, forces along (that turn) and across (that resist) balance when the sides go as
// with a track of b (1 + (L / b)^2).
#pragma once

#include "tread/core/options.hpp"
#include "tread/robot/robot.hpp"

namespace tread {

struct RoverModelOptions {
  enum class Drive {
    kDifferential,  // front wheels driven, rear casters
    kSkid,          // four wheels, the two of a side turn alike
  };
  Drive drive = Drive::kDifferential;
  double length_m = 1.0;
  double width_m = 0.6;
  double height_m = 0.5;      // of the box, top above the ground
  double clearance_m = 0.12;  // of the box above the ground
  double track_m = 0.55;      // between the wheels of a side and the other
  double wheelbase_m = 0.6;   // between the axles; to the swivel axis of the casters
  double overhang_m = 0.25;   // of the bumper before the front axle
  double wheel_radius_m = 0.16;
  double wheel_width_m = 0.10;
  double caster_radius_m = 0.10;
  double caster_trail_m = 0.06;    // of the wheel behind its swivel axis
  double mass_kg = 80.0;           // of all, wheels too
  double wheel_kg = 4.0;           // each driven wheel
  double caster_kg = 1.5;          // each caster
  double centre_behind_m = 0.22;   // of the mass of the box behind the front axle
  double centre_height_m = 0.30;   // of that mass above the ground
  double top_speed_m_per_s = 1.2;  // that it can be told
  double top_yaw_rate_rad_per_s = 1.0;
  double acceleration_m_per_s2 = 2.0;  // with which wheels follow what they are told
  // Motor and gear, on the wheel.
  double torque_nm_per_a = 1.5;
  double current_limit_a = 30.0;    // of the amplifier
  double stall_current_a = 60.0;    // of the motor at full voltage
  double free_speed_m_per_s = 2.0;  // at full voltage without load
  double bumper_force_n = 15.0;     // that presses it
  [[nodiscard]] bool operator==(const RoverModelOptions&) const = default;
};
[[nodiscard]] OptionSet describe(RoverModelOptions& options);

// Of the driven wheels of the two sides, forward positive.
struct WheelSpeeds {
  double left_rad_per_s = 0.0;
  double right_rad_per_s = 0.0;
};
// The track by which speeds of the sides make a turn.
[[nodiscard]] double turning_track_m(const RoverModelOptions& options);
// What lies beyond the robot's top speeds is cut to them, turn and speed each by itself.
[[nodiscard]] DriveCommand limited(const RoverModelOptions& options, const DriveCommand& command);
[[nodiscard]] WheelSpeeds wheel_speeds(const RoverModelOptions& options,
                                       const DriveCommand& command);
[[nodiscard]] DriveCommand drive_of(const RoverModelOptions& options, const WheelSpeeds& speeds);

// Where the front axle is, along x.
[[nodiscard]] double front_axle_m(const RoverModelOptions& options);
// The most that a motor gives its wheel at a speed, with its sign along the turn it is asked for:
// the amplifier limits the current, and so does the voltage that the turning motor induces.
[[nodiscard]] double motor_torque_limit_nm(const RoverModelOptions& options, double speed_rad_per_s,
                                           bool forward);

}  // namespace tread
