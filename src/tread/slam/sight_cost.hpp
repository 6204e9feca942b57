// Internal to slam: the residual of bundle adjustment.
#pragma once

#include <ceres/sized_cost_function.h>

#include "tread/slam/stereo_sight.hpp"

namespace tread {

// What a keyframe sees of a point, less what it should see, in sigma.
class SightCost : public ceres::SizedCostFunction<3, 7, 3> {
 public:
  SightCost(const RectifiedRig& rig, const StereoSight& sight, double sigma_px)
      : rig_(rig), sight_(sight), scale_(1.0 / sigma_px) {}

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const Eigen::Map<const Eigen::Vector3d> t(parameters[0]), p(parameters[1]);
    const Eigen::Map<const Eigen::Quaterniond> q(parameters[0] + 3);
    const Eigen::Matrix3d R_camera_world = q.toRotationMatrix().transpose();
    const Eigen::Vector3d in_camera = R_camera_world * (p - t);
    if (!(in_camera.z() > kLeastDepth_m)) return false;
    Eigen::Matrix3d J;
    const Eigen::Vector3d r = sight_residual(rig_, in_camera, sight_, &J);
    Eigen::Map<Eigen::Vector3d> out(residuals);
    out = scale_ * r;
    if (jacobians == nullptr) return true;
    J *= scale_;
    const Eigen::Matrix3d J_world = J * R_camera_world;
    if (jacobians[0] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 3, 7, Eigen::RowMajor>> J_pose(jacobians[0]);
      J_pose.leftCols<3>() = -J_world;
      J_pose.middleCols<3>(3) = J * hat(in_camera);
      J_pose.col(6).setZero();
    }
    if (jacobians[1] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> J_point(jacobians[1]);
      J_point = J_world;
    }
    return true;
  }

 private:
  const RectifiedRig& rig_;
  StereoSight sight_;
  double scale_;
};

}  // namespace tread
