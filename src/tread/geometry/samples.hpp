// Time-stamped sensor samples, as every source yields them.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tread/core/image.hpp"
#include "tread/geometry/pose.hpp"

namespace tread {

// What an inertial measurement unit felt, in its own axes.
struct ImuSample {
  std::int64_t stamp_ns = 0;
  Eigen::Vector3d gyro_rad_per_s = Eigen::Vector3d::Zero();
  // The specific force: at rest 9.81 upwards, as what holds the unit pushes it up.
  Eigen::Vector3d accel_m_per_s2 = Eigen::Vector3d::Zero();
};

// A satellite fix, already in a local frame: x east, y north, z up from an agreed origin, metres.
struct GnssFix {
  std::int64_t stamp_ns = 0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  // What the receiver thinks of itself, one standard deviation level and upwards.
  double sigma_level_m = 0.0;
  double sigma_up_m = 0.0;
};

// Encoders and motors of the two driven sides.
struct WheelSample {
  std::int64_t stamp_ns = 0;
  double left_rad = 0.0;  // turned since the start, forward positive, in steps of the encoder
  double right_rad = 0.0;
  double left_current_a = 0.0;  // of the motor, forward torque positive
  double right_current_a = 0.0;
};

inline constexpr int kLegs = 4;        // left front, right front, left hind, right hind
inline constexpr int kLegJoints = 12;  // of each leg HAA, HFE, KFE

// Joints and feet of a robot with four legs.
struct LegSample {
  std::int64_t stamp_ns = 0;
  std::array<double, kLegJoints> position_rad{};
  std::array<double, kLegJoints> velocity_rad_per_s{};
  std::array<double, kLegJoints> torque_nm{};
  std::array<Eigen::Vector3d, kLegs> foot_force_n{};  // of the ground on the foot, body axes
};

// Where the pan-tilt unit of the head is. Pan turns left, tilt lowers the nose.
struct HeadState {
  std::int64_t stamp_ns = 0;
  double pan_rad = 0.0;
  double tilt_rad = 0.0;
};

// The bumper was pressed, or let go.
struct BumpEvent {
  std::int64_t stamp_ns = 0;
  bool pressed = false;
};

// A pair of images taken at one time, as the cameras gave them (not yet rectified).
struct StereoFrame {
  std::int64_t stamp_ns = 0;
  std::string name;  // how messages call it: "000012"
  Image<std::uint8_t> left;
  Image<std::uint8_t> right;
  Image<Rgb> left_colour;                  // empty if the camera is grey
  std::optional<Isometry3d> T_world_left;  // if the source knows: left optical axes into a world
                                           // with z up (REP 103), metres
  // After the frame before, and up to this one's time (the first frame: those of the second before
  // it, to find the vertical from). Empty without an IMU.
  std::vector<ImuSample> imu;
};

// Depth, and colour if there is a colour camera, of one time and of one size.
struct RgbdFrame {
  std::int64_t stamp_ns = 0;                 // of the depth image
  std::string name;                          // how messages call it: "frame-000012"
  Image<float> depth;                        // metres along the optical axis; NaN where unknown
  Image<std::uint8_t> grey;                  // empty without a colour image
  Image<Rgb> rgb;                            // likewise, and if that image is grey
  std::optional<Isometry3d> T_world_camera;  // if the source knows: optical axes of the depth
                                             // camera into the world of the source, metres
};

}  // namespace tread
