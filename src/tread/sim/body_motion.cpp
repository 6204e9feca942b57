#include "tread/sim/body_motion.hpp"

namespace tread {

BodyMotion at_mount(const BodyMotion& motion, const Isometry3d& T_body_mount) {
  const Eigen::Matrix3d& R = motion.T_world_body.linear();
  const Eigen::Vector3d &r = T_body_mount.translation(), &w = motion.rate_rad_per_s,
                        &dw = motion.rate_change_rad_per_s2;
  const Eigen::Matrix3d to_mount = T_body_mount.linear().transpose();
  return {motion.T_world_body * T_body_mount, motion.velocity_m_per_s + R * w.cross(r),
          motion.acceleration_m_per_s2 + R * (dw.cross(r) + w.cross(w.cross(r))), to_mount * w,
          to_mount * dw};
}

Isometry3d pose_after(const BodyMotion& motion, double time_s) {
  Isometry3d T = motion.T_world_body;
  T.translation() += time_s * motion.velocity_m_per_s;
  T.linear() = T.linear() * so3_exp(time_s * motion.rate_rad_per_s);
  return T;
}

}  // namespace tread
