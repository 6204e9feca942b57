// Internal to slam: poses as Ceres moves them.
#pragma once

#include <ceres/manifold.h>

#include <array>

#include "tread/geometry/pose.hpp"

namespace tread {

// t, then the quaternion x y z w. A step is (dt, w) with t + dt, R exp(w). Costs give their
// derivatives by the step in the first six columns: this manifold hands these through.
class PoseManifold : public ceres::Manifold {
 public:
  [[nodiscard]] int AmbientSize() const override { return 7; }
  [[nodiscard]] int TangentSize() const override { return 6; }
  bool Plus(const double* x, const double* delta, double* sum) const override {
    const Eigen::Map<const Eigen::Vector3d> t(x), dt(delta), w(delta + 3);
    const Eigen::Map<const Eigen::Quaterniond> q(x + 3);
    Eigen::Map<Eigen::Vector3d> t_sum(sum);
    Eigen::Map<Eigen::Quaterniond> q_sum(sum + 3);
    t_sum = t + dt;
    q_sum = (q * Eigen::Quaterniond(so3_exp(w))).normalized();
    return true;
  }
  bool PlusJacobian(const double*, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, 7, 6, Eigen::RowMajor>> J(jacobian);
    J.setZero();
    J.topRows<6>().setIdentity();
    return true;
  }
  bool Minus(const double* y, const double* x, double* difference) const override {
    const Eigen::Map<const Eigen::Vector3d> from(x), to(y);
    const Eigen::Map<const Eigen::Quaterniond> a(x + 3), b(y + 3);
    Eigen::Map<Vector6d> out(difference);
    out.head<3>() = to - from;
    out.tail<3>() = so3_log((a.conjugate() * b).normalized().toRotationMatrix());
    return true;
  }
  bool MinusJacobian(const double*, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, 6, 7, Eigen::RowMajor>> J(jacobian);
    J.setZero();
    J.leftCols<6>().setIdentity();
    return true;
  }
};

using PoseBlock = std::array<double, 7>;

[[nodiscard]] inline PoseBlock block_of(const Isometry3d& T) {
  PoseBlock block{};
  Eigen::Map<Eigen::Vector3d>(block.data()) = T.translation();
  Eigen::Map<Eigen::Quaterniond>(block.data() + 3) = Eigen::Quaterniond(T.linear()).normalized();
  return block;
}
[[nodiscard]] inline Isometry3d pose_of(const PoseBlock& block) {
  Isometry3d T = Isometry3d::Identity();
  T.translation() = Eigen::Map<const Eigen::Vector3d>(block.data());
  T.linear() = Eigen::Map<const Eigen::Quaterniond>(block.data() + 3).toRotationMatrix();
  return T;
}

}  // namespace tread
