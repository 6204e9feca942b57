// A simulated robot: which body it has, what it carries where, and how well that works. Described
// options, so that files, the command line and tests all set the same fields.
#pragma once

#include "tread/core/options.hpp"
#include "tread/geometry/stereo_rig.hpp"
#include "tread/robot/rover_model.hpp"
#include "tread/robot/walker_model.hpp"
#include "tread/sim/bump_sensor.hpp"
#include "tread/sim/camera_view.hpp"
#include "tread/sim/gnss_sensor.hpp"
#include "tread/sim/image_sensor.hpp"
#include "tread/sim/imu_sensor.hpp"
#include "tread/sim/leg_sensor.hpp"
#include "tread/sim/pan_tilt.hpp"
#include "tread/sim/physics_model.hpp"
#include "tread/sim/wheel_sensor.hpp"

namespace tread {

// A place on the body and where it looks: forward, down by the pitch, to the left by the yaw.
struct MountOptions {
  double forward_m = 0.0, left_m = 0.0, up_m = 0.0;
  double yaw_rad = 0.0, pitch_rad = 0.0;
  [[nodiscard]] bool operator==(const MountOptions&) const = default;
};
[[nodiscard]] OptionSet describe(MountOptions& options);
// Body axes at that place, T_body_mount.
[[nodiscard]] Isometry3d pose_of(const MountOptions& options);

// Two parallel cameras, alike.
struct StereoHeadOptions {
  int width_px = 640, height_px = 480;
  double focal_px = 333.33;
  double baseline_m = 0.12;
  enum class Lens { kPinhole, kBrown, kKannalaBrandt };
  Lens lens = Lens::kPinhole;                     // the images come rectified
  double k1 = 0.0, k2 = 0.0, k3 = 0.0, k4 = 0.0;  // k1 k2 p1 p2, or k1 to k4, as OpenCV has them
  MountOptions mount;  // of the middle between the cameras; of one that turns, at angles 0
  [[nodiscard]] bool operator==(const StereoHeadOptions&) const = default;
};
[[nodiscard]] OptionSet describe(StereoHeadOptions& options);

struct CameraSetup {
  SensorChannelOptions channel = {.rate_hz = 10.0, .latency_s = 0.03};
  double readout_s = 0.0;  // from the first row to the last; 0: global shutter
  RenderOptions render;
  ImageSensorOptions sensor;
};
[[nodiscard]] OptionSet describe(CameraSetup& options);

struct RobotSetup {
  enum class Kind { kRover, kWalker };
  Kind kind = Kind::kRover;
  RoverModelOptions rover;
  WalkerModelOptions walker;
  StandOptions stand;
  PhysicsOptions physics;
  int heads = 1;  // 1 or 2
  StereoHeadOptions head, second_head;
  bool head_turns = false;  // the first head is on the pan-tilt unit
  PanTiltOptions pan_tilt;
  HeadCommand head_start;
  CameraSetup camera;  // of all heads
  bool has_imu = true, has_gnss = true;
  ImuSensorOptions imu;
  MountOptions imu_mount;
  GnssSensorOptions gnss;
  MountOptions antenna_mount;
  WheelSensorOptions wheels;
  LegSensorOptions legs;
  BumpSensorOptions bump;
};
[[nodiscard]] OptionSet describe(RobotSetup& setup);

// Paper R's rover: two heads that look a little to both sides, IMU, GPS, wheels, bumper.
[[nodiscard]] RobotSetup rover_setup();
// Paper Q's walker: one head on its pan-tilt unit, IMU, legs.
[[nodiscard]] RobotSetup walker_setup();

// How high the walker's HAA axes are above the ground below a body that stands at ease.
[[nodiscard]] double stand_height_m(const WalkerModelOptions& options);
// The rig of a head as a robot knows it: cameras, mount on the body at rest, IMU.
[[nodiscard]] StereoRig rig_of(const RobotSetup& setup, int head);
// Left camera on the body when the pan-tilt unit is at these angles (a head that does not turn is
// where it is).
[[nodiscard]] Isometry3d T_body_left(const RobotSetup& setup, int head, const HeadCommand& angles);

}  // namespace tread
