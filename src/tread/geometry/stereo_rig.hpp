// Two cameras and what they see together: depth from disparity and how finely (paper Q, Eq. 1, 2).
#pragma once

#include <optional>
#include <string>

#include "tread/geometry/camera.hpp"
#include "tread/geometry/pose.hpp"

namespace tread {

// Where the left camera sits on the robot. The body frame is x forward, y left, z up with its
// origin on the ground below the robot's reference point.
struct CameraMount {
  Isometry3d T_body_left = Isometry3d::Identity();  // left optical axes into body
  bool assumed = false;                             // nobody measured it: results say so
};

// An inertial measurement unit fixed to the cameras. The noise is that of a calibration or a data
// sheet (Allan deviation); the defaults are twice that of EuRoC's ADIS16448, an ordinary MEMS IMU.
struct Imu {
  Isometry3d T_imu_left = Isometry3d::Identity();  // left optical axes into the IMU's, metres
  double gyro_noise = 3.4e-4;                      // white noise, rad/s/sqrt(Hz)
  double accel_noise = 4e-3;                       // white noise, m/s^2/sqrt(Hz)
  double gyro_walk = 3.9e-5;                       // random walk of the bias, rad/s^2/sqrt(Hz)
  double accel_walk = 6e-3;                        // random walk of the bias, m/s^3/sqrt(Hz)
  double rate_hz = 200.0;                          // samples a second
};

// Two calibrated cameras as they are, before rectification, and perhaps an IMU.
struct StereoRig {
  std::string name;
  ImageSize size;
  CameraModel left;
  CameraModel right;
  Isometry3d T_left_right = Isometry3d::Identity();  // right optical axes into left, metres
  bool rectified = false;  // the images come rectified: rows correspond, no distortion
  std::optional<CameraMount> mount;
  std::optional<Imu> imu;
};

// A rectified pair: both image planes are one plane, a point is on the same row v in both, and
// its column differs by the disparity d = u_left - u_right, pixels.
struct RectifiedRig {
  ImageSize size;
  double fx_px = 0.0;
  double fy_px = 0.0;
  double cx_px = 0.0;  // of the left image
  double cy_px = 0.0;
  double cx_offset_px = 0.0;  // cx_right - cx_left; disparity at infinity is minus this
  double baseline_m = 0.0;

  // Z = b f / (d + cx_offset); infinite at or below the disparity of infinity. Eq. 1.
  [[nodiscard]] double depth_m(double disparity_px) const;
  // Its inverse, for Z > 0.
  [[nodiscard]] double disparity_px(double depth_m) const;
  // The change of depth for a change of disparity by `step_px` at a depth: r = step Z^2 / (b f).
  // Paper Q prints the disparity itself in place of its step (Eq. 2), which would make r = Z.
  [[nodiscard]] double depth_resolution_m(double depth_m, double step_px = 0.25) const;
  // The point seen at pixel (u, v) of the left image at a depth, left optical axes. Eq. 1.
  [[nodiscard]] Eigen::Vector3d point(double u, double v, double depth_m) const;
  // The pixel and disparity at which a point in front of the camera is seen.
  [[nodiscard]] Eigen::Vector3d pixel_and_disparity(const Eigen::Vector3d& p) const;
};

// Sizes, camera parameters, baseline above zero, rigid poses, noise and rate of the IMU above zero.
[[nodiscard]] Status check_rig(const StereoRig& rig);
// A rigid T_imu_left, noises and rate above zero. Errors name the field: "imu.gyro_noise".
[[nodiscard]] Status check_imu(const Imu& imu);

// The rectified rig of a rig whose images come rectified; an error if its cameras contradict that
// (rotation, different focal lengths, distortion, baseline not along x).
[[nodiscard]] Result<RectifiedRig> rectified_rig(const StereoRig& rig);

// The rig of the same images shrunk by a whole factor (core/shrink.hpp).
[[nodiscard]] StereoRig shrunk(const StereoRig& rig, int factor);

// Mount of a camera `height_m` above the ground that looks forward, down by `pitch_rad`.
[[nodiscard]] CameraMount level_mount(double height_m, double pitch_rad, bool assumed);

// Paper Q's camera, a Bumblebee2 with 2.5 mm lenses on 4.8 x 3.6 mm sensors, 12 cm baseline, as
// rectified images of `width` (1024 or 640) pixels: f = 2.5 / 4.8 width, 4:3.
[[nodiscard]] StereoRig bumblebee2(int width);

// Rigs known by name: "bumblebee2-1024", "bumblebee2-640". Empty if there is none of that name.
[[nodiscard]] std::optional<StereoRig> named_rig(const std::string& name);

}  // namespace tread
