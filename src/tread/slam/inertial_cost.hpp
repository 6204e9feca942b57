// Internal to slam: what an IMU says about two keyframes, as Ceres minimises it.
#pragma once

#include <ceres/sized_cost_function.h>

#include <Eigen/Cholesky>

#include "tread/slam/imu_preintegration.hpp"

namespace tread {

// Residuals (Forster et al. 2017, Eq. 37, 45): rotation, velocity, position, then the change of
// both biases, in sigma. Parameters: the camera's pose (PoseBlock) and (v, gyro bias, accelerometer
// bias) at the start, the same at the end, gravity in the world.
class InertialCost : public ceres::SizedCostFunction<15, 7, 9, 7, 9, 3> {
 public:
  InertialCost(const ImuPreintegration& measured, const Isometry3d& T_camera_imu)
      : measured_(measured), T_camera_imu_(T_camera_imu) {
    // A little is added: integration is not exact, and nothing is mounted without any play.
    Eigen::Matrix<double, 9, 9> covariance = measured.covariance();
    covariance.diagonal().array() += 1e-9;
    root_information_ = covariance.inverse().llt().matrixU();
    const double root_time = std::sqrt(std::max(measured.seconds(), 1e-3));
    bias_scale_ << Eigen::Vector3d::Constant(1.0 / (measured.imu().gyro_walk * root_time)),
        Eigen::Vector3d::Constant(1.0 / (measured.imu().accel_walk * root_time));
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    using Eigen::Matrix3d;
    using Eigen::Vector3d;
    const Body a = body_of(parameters[0]), b = body_of(parameters[2]);
    const Eigen::Map<const Eigen::Matrix<double, 9, 1>> from(parameters[1]), to(parameters[3]);
    const Eigen::Map<const Vector3d> gravity(parameters[4]);
    const Vector3d v_a = from.head<3>(), v_b = to.head<3>();
    const ImuBias bias{from.segment<3>(3), from.tail<3>()};
    const double dt = measured_.seconds();
    const ImuPreintegration::Motion m = measured_.motion_with(bias);
    const Matrix3d Rt = a.R.transpose();
    const Vector3d r_turn = so3_log(m.R.transpose() * Rt * b.R);
    const Vector3d dv = Rt * (v_b - v_a - gravity * dt);
    const Vector3d dp = Rt * (b.p - a.p - v_a * dt - 0.5 * dt * dt * gravity);
    Eigen::Map<Eigen::Matrix<double, 15, 1>> r(residuals);
    Eigen::Matrix<double, 9, 1> plain;
    plain << r_turn, dv - m.v, dp - m.p;
    r.head<9>() = root_information_ * plain;
    r.tail<6>() = bias_scale_.cwiseProduct(to.tail<6>() - from.tail<6>());
    if (jacobians == nullptr) return true;

    const Matrix3d by_turn = so3_left_jacobian_inverse(-r_turn);
    if (jacobians[0] != nullptr) {
      Eigen::Matrix<double, 9, 6> J = Eigen::Matrix<double, 9, 6>::Zero();  // by (p, turn) of a
      J.block<3, 3>(0, 3) = -by_turn * b.R.transpose() * a.R;
      J.block<3, 3>(3, 3) = hat(dv);
      J.block<3, 3>(6, 0) = -Rt;
      J.block<3, 3>(6, 3) = hat(dp);
      give_pose(a, J, jacobians[0]);
    }
    if (jacobians[1] != nullptr) {
      Eigen::Matrix<double, 9, 9> J = Eigen::Matrix<double, 9, 9>::Zero();
      J.block<3, 3>(3, 0) = -Rt;
      J.block<3, 3>(6, 0) = -dt * Rt;
      const ImuPreintegration::BiasJacobian& by_bias = measured_.by_bias();
      J.block<6, 6>(3, 3) = -by_bias.bottomRows<6>();
      const Vector3d shift =
          by_bias.block<3, 3>(0, 0) * (bias.gyro_rad_per_s - measured_.bias().gyro_rad_per_s);
      J.block<3, 3>(0, 3) =
          -by_turn * so3_exp(-r_turn) * so3_left_jacobian(-shift) * by_bias.block<3, 3>(0, 0);
      Eigen::Map<Eigen::Matrix<double, 15, 9, Eigen::RowMajor>> out(jacobians[1]);
      out.setZero();
      out.topRows<9>() = root_information_ * J;
      out.bottomRightCorner<6, 6>() = (-bias_scale_).asDiagonal();
    }
    if (jacobians[2] != nullptr) {
      Eigen::Matrix<double, 9, 6> J = Eigen::Matrix<double, 9, 6>::Zero();
      J.block<3, 3>(0, 3) = by_turn;
      J.block<3, 3>(6, 0) = Rt;
      give_pose(b, J, jacobians[2]);
    }
    if (jacobians[3] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 15, 9, Eigen::RowMajor>> out(jacobians[3]);
      out.setZero();
      out.block<9, 3>(0, 0) = root_information_.middleCols<3>(3) * Rt;
      out.bottomRightCorner<6, 6>() = bias_scale_.asDiagonal();
    }
    if (jacobians[4] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 15, 3, Eigen::RowMajor>> out(jacobians[4]);
      out.setZero();
      out.topRows<9>() = -root_information_.middleCols<3>(3) * dt * Rt -
                         root_information_.rightCols<3>() * (0.5 * dt * dt) * Rt;
    }
    return true;
  }

 private:
  struct Body {
    Eigen::Matrix3d R;  // of the IMU in the world
    Eigen::Vector3d p;
    Eigen::Matrix3d R_camera;
  };
  [[nodiscard]] Body body_of(const double* block) const {
    const Eigen::Map<const Eigen::Vector3d> t(block);
    const Eigen::Map<const Eigen::Quaterniond> q(block + 3);
    Body body;
    body.R_camera = q.toRotationMatrix();
    body.R = body.R_camera * T_camera_imu_.linear();
    body.p = t + body.R_camera * T_camera_imu_.translation();
    return body;
  }
  // From derivatives by place and turn of the IMU to those by the step of the camera's PoseBlock.
  void give_pose(const Body& body, const Eigen::Matrix<double, 9, 6>& J, double* out) const {
    Eigen::Matrix<double, 6, 6> chain = Eigen::Matrix<double, 6, 6>::Zero();
    chain.topLeftCorner<3, 3>().setIdentity();
    chain.topRightCorner<3, 3>() = -body.R_camera * hat(T_camera_imu_.translation());
    chain.bottomRightCorner<3, 3>() = T_camera_imu_.linear().transpose();
    Eigen::Map<Eigen::Matrix<double, 15, 7, Eigen::RowMajor>> J_pose(out);
    J_pose.setZero();
    J_pose.topLeftCorner<9, 6>() = root_information_ * J * chain;
  }

  ImuPreintegration measured_;
  Isometry3d T_camera_imu_;
  Eigen::Matrix<double, 9, 9> root_information_;
  Vector6d bias_scale_;
};

// What is known of the biases to begin with: they are small.
class BiasPriorCost : public ceres::SizedCostFunction<6, 9> {
 public:
  explicit BiasPriorCost(const ImuBias& expected) {
    expected_ << expected.gyro_rad_per_s, expected.accel_m_per_s2;
  }
  static constexpr double kGyroSigma = 0.05, kAccelSigma = 0.15;  // rad/s, m/s^2
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const Eigen::Map<const Vector6d> bias(parameters[0] + 3);
    Vector6d scale;
    scale << Eigen::Vector3d::Constant(1.0 / kGyroSigma),
        Eigen::Vector3d::Constant(1.0 / kAccelSigma);
    Eigen::Map<Vector6d> r(residuals);
    r = scale.cwiseProduct(bias - expected_);
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    Eigen::Map<Eigen::Matrix<double, 6, 9, Eigen::RowMajor>> J(jacobians[0]);
    J.setZero();
    J.rightCols<6>() = scale.asDiagonal();
    return true;
  }

 private:
  Vector6d expected_;
};

}  // namespace tread
