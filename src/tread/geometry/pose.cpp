#include "tread/geometry/pose.hpp"

#include <algorithm>
#include <cmath>

namespace tread {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Below this angle the closed forms lose digits to cancellation and series are used.
constexpr double kSmallAngle = 1e-4;

// sin(t)/t, (1-cos t)/t^2, (t-sin t)/t^3
struct Coefficients {
  double a, b, c;
};

Coefficients coefficients(double t) {
  if (t < kSmallAngle) {
    const double t2 = t * t;
    return {1.0 - t2 / 6.0, 0.5 - t2 / 24.0, 1.0 / 6.0 - t2 / 120.0};
  }
  const double s = std::sin(0.5 * t);
  return {std::sin(t) / t, 2.0 * s * s / (t * t), (t - std::sin(t)) / (t * t * t)};
}

}  // namespace

Matrix3d hat(const Vector3d& w) {
  Matrix3d m;
  m << 0.0, -w.z(), w.y(), w.z(), 0.0, -w.x(), -w.y(), w.x(), 0.0;
  return m;
}

Matrix3d so3_exp(const Vector3d& w) {
  const auto [a, b, c] = coefficients(w.norm());
  const Matrix3d W = hat(w);
  return Matrix3d::Identity() + a * W + b * W * W;
}

Vector3d so3_log(const Matrix3d& R) {
  // Through the quaternion: well conditioned at all angles, pi included.
  Eigen::Quaterniond q(R);
  q.normalize();
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  const double n = q.vec().norm();
  const double scale = n < 1e-9 ? 2.0 / q.w() : 2.0 * std::atan2(n, q.w()) / n;
  return scale * q.vec();
}

Matrix3d so3_left_jacobian(const Vector3d& w) {
  const auto [a, b, c] = coefficients(w.norm());
  const Matrix3d W = hat(w);
  return Matrix3d::Identity() + b * W + c * W * W;
}

Matrix3d so3_left_jacobian_inverse(const Vector3d& w) {
  const double t = w.norm();
  const Matrix3d W = hat(w);
  const double d = t < kSmallAngle
                       ? 1.0 / 12.0 + t * t / 720.0
                       : (1.0 - 0.5 * t * std::cos(0.5 * t) / std::sin(0.5 * t)) / (t * t);
  return Matrix3d::Identity() - 0.5 * W + d * W * W;
}

Isometry3d se3_exp(const Vector6d& twist) {
  Isometry3d T = Isometry3d::Identity();
  const Vector3d v = twist.head<3>(), w = twist.tail<3>();
  T.linear() = so3_exp(w);
  T.translation() = so3_left_jacobian(w) * v;
  return T;
}

Vector6d se3_log(const Isometry3d& T) {
  Vector6d twist;
  twist.tail<3>() = so3_log(T.linear());
  twist.head<3>() = so3_left_jacobian_inverse(twist.tail<3>()) * T.translation();
  return twist;
}

Matrix6d se3_left_jacobian(const Vector6d& twist) {
  const Vector3d v = twist.head<3>(), w = twist.tail<3>();
  const double t = w.norm();
  const double t2 = t * t;
  // Barfoot (7.86b); series below the angle at which t^5 cancels.
  double q1 = 1.0 / 6.0, q2 = 1.0 / 24.0, q3 = 1.0 / 120.0;
  if (t > 1e-2) {
    q1 = (t - std::sin(t)) / (t2 * t);
    q2 = (t2 + 2.0 * std::cos(t) - 2.0) / (2.0 * t2 * t2);
    q3 = (2.0 * t - 3.0 * std::sin(t) + t * std::cos(t)) / (2.0 * t2 * t2 * t);
  } else {
    q1 -= t2 / 120.0;
    q2 -= t2 / 720.0;
    q3 -= t2 / 2520.0;
  }
  const Matrix3d V = hat(v), W = hat(w);
  const Matrix3d Q = 0.5 * V + q1 * (W * V + V * W + W * V * W) +
                     q2 * (W * W * V + V * W * W - 3.0 * W * V * W) +
                     q3 * (W * V * W * W + W * W * V * W);
  Matrix6d J = Matrix6d::Zero();
  J.topLeftCorner<3, 3>() = so3_left_jacobian(w);
  J.bottomRightCorner<3, 3>() = J.topLeftCorner<3, 3>();
  J.topRightCorner<3, 3>() = Q;
  return J;
}

Matrix6d se3_adjoint(const Isometry3d& T) {
  Matrix6d A = Matrix6d::Zero();
  A.topLeftCorner<3, 3>() = T.linear();
  A.bottomRightCorner<3, 3>() = T.linear();
  A.topRightCorner<3, 3>() = hat(T.translation()) * T.linear();
  return A;
}

Matrix3d rotation_from_yaw_pitch_roll(double yaw_rad, double pitch_rad, double roll_rad) {
  return (Eigen::AngleAxisd(yaw_rad, Vector3d::UnitZ()) *
          Eigen::AngleAxisd(pitch_rad, Vector3d::UnitY()) *
          Eigen::AngleAxisd(roll_rad, Vector3d::UnitX()))
      .toRotationMatrix();
}

YawPitchRoll yaw_pitch_roll(const Matrix3d& R) {
  YawPitchRoll angles;
  const double cos_pitch = std::hypot(R(0, 0), R(1, 0));
  angles.pitch_rad = std::atan2(-R(2, 0), cos_pitch);
  if (cos_pitch < 1e-9) {
    angles.yaw_rad = std::atan2(-R(0, 1), R(1, 1));
    return angles;
  }
  angles.yaw_rad = std::atan2(R(1, 0), R(0, 0));
  angles.roll_rad = std::atan2(R(2, 1), R(2, 2));
  return angles;
}

Matrix3d R_body_optical() {
  Matrix3d R;
  R << 0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0;
  return R;
}

bool is_rigid(const Isometry3d& T, double tolerance) {
  if (!T.matrix().allFinite()) return false;
  const Matrix3d R = T.linear();
  return (R * R.transpose() - Matrix3d::Identity()).cwiseAbs().maxCoeff() <= tolerance &&
         R.determinant() > 0.0;
}

}  // namespace tread
