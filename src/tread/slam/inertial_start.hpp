// What must be known before an IMU can help: which way is down, how fast the camera moves, and how
// far the gyroscope is off. Found from keyframes whose poses are known without it.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "tread/slam/refine_window.hpp"

namespace tread {

// Sets the velocities and gyroscope biases of keyframes (in order, each but the first with the
// motion measured since the one before) so that they fit the poses, accelerometer biases taken as
// zero, and returns gravity in the world, 9.81 m/s^2 long. Linear least squares (after Martinelli
// 2014, with scale known from stereo). Empty, and nothing set, if the keyframes are too few or what
// is found for gravity is not as strong as it must be.
[[nodiscard]] std::optional<Eigen::Vector3d> start_inertia(std::vector<WindowFrame>& frames,
                                                           const Isometry3d& T_camera_imu);

// A world with z up, by what the accelerometer felt: the rotation R_world_camera that turns the
// mean of `samples` up and has the camera look along x. Empty without samples, or if they are not
// of something near rest (mean beyond 9.81 +- 1.5 m/s^2).
[[nodiscard]] std::optional<Eigen::Matrix3d> level_camera(std::span<const ImuSample> samples,
                                                          const Isometry3d& T_camera_imu);

}  // namespace tread
