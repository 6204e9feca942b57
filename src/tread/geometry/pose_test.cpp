#include "tread/geometry/pose.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

namespace tread {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

std::vector<Vector3d> rotation_vectors() {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  std::vector<Vector3d> vectors = {Vector3d::Zero(), {1e-9, 0, 0}, {0, 2e-5, -1e-5}};
  for (double angle : {1e-6, 9e-5, 1.1e-4, 9e-3, 1.1e-2, 0.5, 2.0, 3.0, 3.14}) {
    vectors.push_back(angle *
                      Vector3d(normal(random), normal(random), normal(random)).normalized());
  }
  return vectors;
}

TEST(So3, LogInvertsExp) {
  for (const Vector3d& w : rotation_vectors()) {
    EXPECT_LT((so3_log(so3_exp(w)) - w).norm(), 1e-9) << w.transpose();
    EXPECT_LT((so3_exp(w) * so3_exp(w).transpose() - Matrix3d::Identity()).norm(), 1e-12);
  }
  const Vector3d half_turn(0, std::numbers::pi, 0);
  EXPECT_NEAR(so3_log(so3_exp(half_turn)).norm(), std::numbers::pi, 1e-9);
}

TEST(So3, LeftJacobianIsTheDerivativeOfExp) {
  const double h = 1e-6;
  for (const Vector3d& w : rotation_vectors()) {
    Matrix3d numeric;
    for (int i = 0; i < 3; ++i) {
      const Vector3d step = h * Vector3d::Unit(i);
      numeric.col(i) =
          so3_log(so3_exp(w + step) * so3_exp(Vector3d(w - step)).transpose()) / (2.0 * h);
    }
    EXPECT_LT((numeric - so3_left_jacobian(w)).norm(), 1e-7) << w.transpose();
    EXPECT_LT((so3_left_jacobian(w) * so3_left_jacobian_inverse(w) - Matrix3d::Identity()).norm(),
              1e-9);
  }
}

TEST(Se3, LogInvertsExpAndLeftJacobianIsTheDerivative) {
  const double h = 1e-6;
  for (const Vector3d& w : rotation_vectors()) {
    Vector6d twist;
    twist << 0.3, -1.2, 2.0, w;
    EXPECT_LT((se3_log(se3_exp(twist)) - twist).norm(), 1e-8);
    Matrix6d numeric;
    for (int i = 0; i < 6; ++i) {
      const Vector6d step = h * Vector6d::Unit(i);
      numeric.col(i) =
          se3_log(se3_exp(twist + step) * se3_exp(Vector6d(twist - step)).inverse()) / (2.0 * h);
    }
    EXPECT_LT((numeric - se3_left_jacobian(twist)).norm(), 1e-6) << w.transpose();
  }
}

// The left Jacobian is the power series of ad / (n + 1)!, summed here to the last digit: both the
// closed forms and the series near 0 are held to that.
TEST(Se3, LeftJacobianIsItsPowerSeries) {
  const Vector3d v(0.3, -1.2, 2.0), axis = Vector3d(0.2, -0.5, 0.84).normalized();
  for (const double angle : {0.0, 1e-6, 9.9e-5, 1.1e-4, 1e-3, 9.9e-3, 1.1e-2, 0.3, 2.0}) {
    Vector6d twist;
    twist << v, angle * axis;
    Matrix6d ad = Matrix6d::Zero();
    ad.topLeftCorner<3, 3>() = ad.bottomRightCorner<3, 3>() = hat(angle * axis);
    ad.topRightCorner<3, 3>() = hat(v);
    Matrix6d sum = Matrix6d::Identity(), term = Matrix6d::Identity();
    for (int n = 1; n < 40; ++n) {
      term = term * ad / (n + 1);
      sum += term;
    }
    EXPECT_LT((se3_left_jacobian(twist) - sum).norm(), 1e-11) << angle;
  }
}

TEST(Se3, AdjointMovesATwistAcross) {
  Vector6d twist, small;
  twist << 0.5, 0.2, -0.7, 0.4, -1.0, 0.3;
  small << 0.01, 0.02, -0.03, 0.02, 0.01, -0.01;
  const Isometry3d T = se3_exp(twist);
  const Isometry3d left = se3_exp(se3_adjoint(T) * small) * T;
  EXPECT_LT((left.matrix() - (T * se3_exp(small)).matrix()).norm(), 1e-12);
}

TEST(YawPitchRoll, RoundTripAndSigns) {
  for (double yaw : {-3.0, -0.4, 0.0, 1.7}) {
    for (double pitch : {-1.5, -0.2, 0.0, 1.0}) {
      for (double roll : {-2.0, 0.0, 0.3}) {
        const YawPitchRoll angles = yaw_pitch_roll(rotation_from_yaw_pitch_roll(yaw, pitch, roll));
        EXPECT_NEAR(angles.yaw_rad, yaw, 1e-12);
        EXPECT_NEAR(angles.pitch_rad, pitch, 1e-12);
        EXPECT_NEAR(angles.roll_rad, roll, 1e-12);
      }
    }
  }
  // Paper R, Eq. 1: a positive angle turns (1, 0, 0) into (cos, 0, -sin): the nose goes down.
  const Vector3d nose = rotation_from_yaw_pitch_roll(0, 0.3, 0) * Vector3d::UnitX();
  EXPECT_NEAR(nose.x(), std::cos(0.3), 1e-15);
  EXPECT_NEAR(nose.z(), -std::sin(0.3), 1e-15);
  // At pitch pi/2 the rotation is still reproduced.
  const Matrix3d down = rotation_from_yaw_pitch_roll(0.7, std::numbers::pi / 2, 0.2);
  const YawPitchRoll angles = yaw_pitch_roll(down);
  EXPECT_LT((rotation_from_yaw_pitch_roll(angles.yaw_rad, angles.pitch_rad, angles.roll_rad) - down)
                .norm(),
            1e-7);
}

TEST(OpticalAxes, ForwardIsZAndLeftIsMinusX) {
  EXPECT_EQ(R_body_optical() * Vector3d::UnitZ(), Vector3d::UnitX());
  EXPECT_EQ(R_body_optical() * Vector3d::UnitX(), -Vector3d::UnitY());
  EXPECT_EQ(R_body_optical() * Vector3d::UnitY(), -Vector3d::UnitZ());
}

TEST(IsRigid, RefusesWhatIsNoMotion) {
  Isometry3d T = Isometry3d::Identity();
  EXPECT_TRUE(is_rigid(T));
  T.linear() *= 1.1;
  EXPECT_FALSE(is_rigid(T));
  T.linear() = -Matrix3d::Identity();
  EXPECT_FALSE(is_rigid(T));
  T = Isometry3d::Identity();
  T.translation().x() = std::nan("");
  EXPECT_FALSE(is_rigid(T));
}

}  // namespace
}  // namespace tread
