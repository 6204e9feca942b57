// What is known of a motion besides what the frame at hand shows.
#pragma once

#include "tread/core/result.hpp"
#include "tread/geometry/pose.hpp"

namespace tread {

// The motion since the frame before: from an IMU, wheels, legs or visual odometry.
struct MotionPrior {
  Isometry3d T_before_now = Isometry3d::Identity();
  Matrix6d covariance = Matrix6d::Identity();  // of a left twist in axes of the camera now
};

// A rigid motion with a covariance that is symmetric and positive definite.
[[nodiscard]] Status check_motion(const MotionPrior& motion);

}  // namespace tread
