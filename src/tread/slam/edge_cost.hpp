// Internal to slam: the residual of a pose graph's edge, for Ceres.
#pragma once

#include <ceres/sized_cost_function.h>

#include <Eigen/Cholesky>

#include "tread/slam/pose_block.hpp"
#include "tread/slam/pose_graph.hpp"

namespace tread {

// In sigma. Poses are blocks of PoseManifold: a step (dt, w) is the twist (R^T dt, w).
class EdgeCost : public ceres::SizedCostFunction<6, 7, 7> {
 public:
  explicit EdgeCost(const PoseEdge& edge)
      : T_a_b_(edge.T_a_b), whiten_(edge.information.llt().matrixU()) {}

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const Isometry3d T_a = pose_at(parameters[0]), T_b = pose_at(parameters[1]);
    const EdgeResidual edge = edge_residual(T_a_b_, T_a, T_b);
    Eigen::Map<Vector6d> out(residuals);
    out = whiten_ * edge.r;
    if (jacobians == nullptr) return true;
    if (jacobians[0] != nullptr) hand_out(edge.J_a, T_a, jacobians[0]);
    if (jacobians[1] != nullptr) hand_out(edge.J_b, T_b, jacobians[1]);
    return true;
  }

 private:
  static Isometry3d pose_at(const double* block) {
    Isometry3d T = Isometry3d::Identity();
    T.translation() = Eigen::Map<const Eigen::Vector3d>(block);
    T.linear() = Eigen::Map<const Eigen::Quaterniond>(block + 3).toRotationMatrix();
    return T;
  }
  void hand_out(const Matrix6d& J, const Isometry3d& T, double* jacobian) const {
    Eigen::Map<Eigen::Matrix<double, 6, 7, Eigen::RowMajor>> to(jacobian);
    const Matrix6d whitened = whiten_ * J;
    to.leftCols<3>() = whitened.leftCols<3>() * T.linear().transpose();
    to.middleCols<3>(3) = whitened.rightCols<3>();
    to.col(6).setZero();
  }

  Isometry3d T_a_b_;
  Matrix6d whiten_;
};

}  // namespace tread
