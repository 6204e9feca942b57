// How a simulated body moves at one time: what its inertial sensors feel.
#pragma once

#include <Eigen/Core>

#include "tread/geometry/pose.hpp"

namespace tread {

struct BodyMotion {
  Isometry3d T_world_body = Isometry3d::Identity();
  // Of the origin of the body, in world axes; at rest both are zero.
  Eigen::Vector3d velocity_m_per_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d acceleration_m_per_s2 = Eigen::Vector3d::Zero();
  // Of the turn, in body axes.
  Eigen::Vector3d rate_rad_per_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d rate_change_rad_per_s2 = Eigen::Vector3d::Zero();
};

// The motion of other axes fixed to the body.
[[nodiscard]] BodyMotion at_mount(const BodyMotion& motion, const Isometry3d& T_body_mount);
// Where it was or will be a little earlier or later, going on as it does.
[[nodiscard]] Isometry3d pose_after(const BodyMotion& motion, double time_s);

}  // namespace tread
