// Rotations and rigid motions: exponential, logarithm and Jacobians (Barfoot 2017, chapter 7).
// A pose is an Eigen::Isometry3d named T_a_b: it maps coordinates in frame b into frame a.
// A twist is (v, w): translation part first, then rotation, metres and radians.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>

namespace tread {

using Eigen::Isometry3d;
using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

// hat(w) * p = w x p
[[nodiscard]] Eigen::Matrix3d hat(const Eigen::Vector3d& w);

// Rotation by |w| radians about w. Exact near zero and near pi.
[[nodiscard]] Eigen::Matrix3d so3_exp(const Eigen::Vector3d& w);
// The rotation vector of R, length at most pi. R must be a rotation (orthonormal to 1e-6).
[[nodiscard]] Eigen::Vector3d so3_log(const Eigen::Matrix3d& R);
// so3_exp(w + d) = so3_exp(J d) so3_exp(w) to first order in d.
[[nodiscard]] Eigen::Matrix3d so3_left_jacobian(const Eigen::Vector3d& w);
[[nodiscard]] Eigen::Matrix3d so3_left_jacobian_inverse(const Eigen::Vector3d& w);

[[nodiscard]] Isometry3d se3_exp(const Vector6d& twist);
[[nodiscard]] Vector6d se3_log(const Isometry3d& T);
// se3_exp(t + d) = se3_exp(J d) se3_exp(t) to first order in d.
[[nodiscard]] Matrix6d se3_left_jacobian(const Vector6d& twist);
// T exp(d) T^-1 = exp(Ad_T d)
[[nodiscard]] Matrix6d se3_adjoint(const Isometry3d& T);

// Rz(yaw) Ry(pitch) Rx(roll): intrinsic yaw, pitch, roll. With x forward, y left, z up a positive
// pitch lowers the nose (paper R, Eq. 1) and a positive yaw turns left.
[[nodiscard]] Eigen::Matrix3d rotation_from_yaw_pitch_roll(double yaw_rad, double pitch_rad,
                                                           double roll_rad);
struct YawPitchRoll {
  double yaw_rad = 0.0;
  double pitch_rad = 0.0;  // -pi/2 to pi/2
  double roll_rad = 0.0;
};
// The inverse; at pitch +-pi/2, where yaw and roll are one, roll is zero.
[[nodiscard]] YawPitchRoll yaw_pitch_roll(const Eigen::Matrix3d& R);

// The rotation from camera optical axes (x right, y down, z forward) to body axes (x forward,
// y left, z up) of a camera that looks straight ahead.
[[nodiscard]] Eigen::Matrix3d R_body_optical();

// True if all entries are finite and the linear part is a rotation to within `tolerance`.
[[nodiscard]] bool is_rigid(const Isometry3d& T, double tolerance = 1e-3);

struct StampedPose {
  std::int64_t stamp_ns = 0;
  Isometry3d pose = Isometry3d::Identity();
};

}  // namespace tread
