// What a robot can be told and what it tells: one interface for hardware and simulation. Nothing
// behind it may know which of the two it is.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "tread/core/result.hpp"
#include "tread/geometry/samples.hpp"
#include "tread/geometry/stereo_rig.hpp"

namespace tread {

// Wheels: speed of the point between the driven wheels along body x, and turn about z.
struct DriveCommand {
  double speed_m_per_s = 0.0;
  double yaw_rate_rad_per_s = 0.0;
};

// Legs: each joint is a spring and damper about a target, and a torque beside it (impedance
// control). Order: left front, right front, left hind, right hind; of each HAA, HFE, KFE.
struct JointCommand {
  std::array<double, kLegJoints> position_rad{};
  std::array<double, kLegJoints> velocity_rad_per_s{};
  std::array<double, kLegJoints> torque_nm{};
  std::array<double, kLegJoints> stiffness_nm_per_rad{};
  std::array<double, kLegJoints> damping_nm_s_per_rad{};
};

// The head's pan-tilt unit: where it shall look. Pan turns left, tilt lowers the nose.
struct HeadCommand {
  double pan_rad = 0.0;
  double tilt_rad = 0.0;
};

// What is left out goes on as it was told last.
struct RobotCommand {
  std::optional<DriveCommand> drive = {};
  std::optional<JointCommand> joints = {};
  std::optional<HeadCommand> head = {};
};

// A pair of images, and which of the robot's stereo heads took it.
struct HeadFrame {
  int head = 0;
  StereoFrame frame;
};

// What arrived since the last time, each kind in the order of arrival. A sample's stamp is when it
// was measured; it may arrive later, and samples of different kinds with different delays.
struct SensorBatch {
  std::int64_t now_ns = 0;  // the robot's clock at the end of the batch
  std::vector<HeadFrame> frames;
  std::vector<ImuSample> imu;
  std::vector<GnssFix> gnss;
  std::vector<WheelSample> wheels;
  std::vector<LegSample> legs;
  std::vector<HeadState> head;
  std::vector<BumpEvent> bumps;
};

class Robot {
 public:
  Robot() = default;
  virtual ~Robot() = default;
  Robot(const Robot&) = delete;
  Robot& operator=(const Robot&) = delete;

  // The stereo heads, each with its mount on the body (at rest, for a head that turns).
  [[nodiscard]] virtual const std::vector<StereoRig>& heads() const = 0;
  // From now on. An error if the robot has no such part, or a value is not finite.
  [[nodiscard]] virtual Status command(const RobotCommand& command) = 0;
  // Lets `duration_ns` go by and gives what arrived in it. An error only if the robot as a whole is
  // gone; a sensor that fails just sends nothing.
  [[nodiscard]] virtual Result<SensorBatch> advance(std::int64_t duration_ns) = 0;
};

}  // namespace tread
