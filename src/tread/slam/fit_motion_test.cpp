#include "tread/slam/fit_motion.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <random>

#include "tread/slam/pose_block.hpp"
#include "tread/slam/sight_cost.hpp"

namespace tread {
namespace {

RectifiedRig euroc_like_rig() {
  RectifiedRig rig;
  rig.size = {752, 480};
  rig.fx_px = 435.0;
  rig.fy_px = 437.0;
  rig.cx_px = 367.2;
  rig.cy_px = 252.2;
  rig.cx_offset_px = 3.0;
  rig.baseline_m = 0.11;
  return rig;
}

Isometry3d some_pose() {
  Vector6d twist;
  twist << 1.0, -2.0, 0.5, 0.3, -0.8, 0.2;
  return se3_exp(twist);
}

// Points in front of a camera at T, seen with noise; every `blind`-th not by the right camera.
std::vector<SeenPoint> seen_points(const RectifiedRig& rig, const Isometry3d& T, int count,
                                   double sigma_px, std::mt19937& random, int blind = 0) {
  std::uniform_real_distribution<double> u(20.0, 730.0), v(20.0, 460.0), z(1.5, 12.0);
  std::normal_distribution<double> noise(0.0, sigma_px);
  std::vector<SeenPoint> points;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d q = rig.point(u(random), v(random), z(random));
    const Eigen::Vector3d s = stereo_projection(rig, q);
    SeenPoint point{T * q, {s.x() + noise(random), s.y() + noise(random), s.z() + noise(random)}};
    if (blind > 0 && i % blind == 0) point.sight.u_right = std::nan("");
    points.push_back(point);
  }
  return points;
}

double error_m(const Isometry3d& a, const Isometry3d& b) {
  return (a.translation() - b.translation()).norm();
}
double error_rad(const Isometry3d& a, const Isometry3d& b) {
  return so3_log(a.linear().transpose() * b.linear()).norm();
}

TEST(StereoSight, ProjectionAgreesWithTheRigAndGivesThePointBack) {
  const RectifiedRig rig = euroc_like_rig();
  const Eigen::Vector3d q(0.7, -0.4, 3.2);
  const Eigen::Vector3d s = stereo_projection(rig, q);
  const Eigen::Vector3d of_rig = rig.pixel_and_disparity(q);
  EXPECT_NEAR(s.x(), of_rig.x(), 1e-12);
  EXPECT_NEAR(s.y(), of_rig.y(), 1e-12);
  EXPECT_NEAR(s.x() - s.z(), of_rig.z(), 1e-12);
  EXPECT_LT((point_of(rig, {s.x(), s.y(), s.z()}) - q).norm(), 1e-12);
}

TEST(StereoSight, JacobiansAreTheDerivatives) {
  const RectifiedRig rig = euroc_like_rig();
  const Isometry3d T = some_pose();
  constexpr double kStep = 1e-6;
  for (const Eigen::Vector3d& q : {Eigen::Vector3d(0.7, -0.4, 3.2), Eigen::Vector3d(-2.0, 1.0, 1.2),
                                   Eigen::Vector3d(0, 0, 9)}) {
    Eigen::Matrix3d J, numeric;
    (void)stereo_projection(rig, q, &J);
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d d = kStep * Eigen::Vector3d::Unit(i);
      numeric.col(i) =
          (stereo_projection(rig, q + d) - stereo_projection(rig, q - d)) / (2 * kStep);
    }
    EXPECT_LT((J - numeric).norm(), 1e-5 * J.norm());

    const Eigen::Vector3d p = T * q;
    Eigen::Matrix<double, 3, 6> by_twist;
    for (int i = 0; i < 6; ++i) {
      const Vector6d d = kStep * Vector6d::Unit(i);
      by_twist.col(i) =
          ((T * se3_exp(d)).inverse() * p - (T * se3_exp(Vector6d(-d))).inverse() * p) /
          (2 * kStep);
    }
    EXPECT_LT((point_by_twist(q) - by_twist).norm(), 1e-7);
  }
}

TEST(SightCost, JacobiansAreTheDerivativesByTheStepOfTheManifold) {
  const RectifiedRig rig = euroc_like_rig();
  const Eigen::Vector3d p = some_pose() * Eigen::Vector3d(0.3, -0.2, 2.5);
  const PoseManifold manifold;
  constexpr double kStep = 1e-6;
  for (const bool has_right : {true, false}) {
    StereoSight sight{370.0, 250.0, 350.0};
    if (!has_right) sight.u_right = std::nan("");
    const SightCost cost(rig, sight, 0.4);
    const auto residual = [&](const PoseBlock& pose, const Eigen::Vector3d& point) {
      Eigen::Vector3d r;
      const double* parameters[] = {pose.data(), point.data()};
      EXPECT_TRUE(cost.Evaluate(parameters, r.data(), nullptr));
      return r;
    };
    PoseBlock pose = block_of(some_pose());
    Eigen::Matrix<double, 3, 7, Eigen::RowMajor> J_pose;
    Eigen::Matrix<double, 3, 3, Eigen::RowMajor> J_point;
    Eigen::Vector3d r;
    const double* parameters[] = {pose.data(), p.data()};
    double* jacobians[] = {J_pose.data(), J_point.data()};
    ASSERT_TRUE(cost.Evaluate(parameters, r.data(), jacobians));
    EXPECT_EQ(r.z() == 0.0, !has_right);
    for (int i = 0; i < 6; ++i) {
      Vector6d d = kStep * Vector6d::Unit(i);
      PoseBlock ahead{}, behind{};
      manifold.Plus(pose.data(), d.data(), ahead.data());
      d = -d;
      manifold.Plus(pose.data(), d.data(), behind.data());
      const Eigen::Vector3d numeric = (residual(ahead, p) - residual(behind, p)) / (2 * kStep);
      EXPECT_LT((J_pose.col(i) - numeric).norm(), 1e-4 * J_pose.norm()) << i;
    }
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d d = kStep * Eigen::Vector3d::Unit(i);
      const Eigen::Vector3d numeric = (residual(pose, p + d) - residual(pose, p - d)) / (2 * kStep);
      EXPECT_LT((J_point.col(i) - numeric).norm(), 1e-4 * J_point.norm()) << i;
    }
  }
}

TEST(PoseManifold, MinusInvertsPlus) {
  const PoseManifold manifold;
  const PoseBlock pose = block_of(some_pose());
  const Vector6d step = (Vector6d() << 0.3, -0.2, 1.0, 0.4, -0.9, 0.6).finished();
  PoseBlock moved{};
  manifold.Plus(pose.data(), step.data(), moved.data());
  Vector6d back;
  manifold.Minus(moved.data(), pose.data(), back.data());
  EXPECT_LT((back - step).norm(), 1e-12);
  EXPECT_LT(error_m(pose_of(pose), some_pose()) + error_rad(pose_of(pose), some_pose()), 1e-7);
}

TEST(FitMotion, IsExactWithoutNoise) {
  const RectifiedRig rig = euroc_like_rig();
  std::mt19937 random(1);
  const auto points = seen_points(rig, some_pose(), 60, 0.0, random, 5);
  Vector6d off;
  off << 0.2, -0.1, 0.3, 0.05, -0.08, 0.1;
  const MotionFit fit =
      fit_motion(rig, points, some_pose() * se3_exp(off), Matrix6d::Zero(), {}, 7);
  ASSERT_TRUE(fit.found);
  EXPECT_EQ(fit.inliers, 60);
  EXPECT_LT(error_m(fit.T_world_camera, some_pose()), 1e-9);
  EXPECT_LT(error_rad(fit.T_world_camera, some_pose()), 1e-9);
}

TEST(FitMotion, SeesThroughAsManyOutliersAsInliers) {
  const RectifiedRig rig = euroc_like_rig();
  std::mt19937 random(2);
  std::uniform_real_distribution<double> anywhere(0.0, 480.0);
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    auto points = seen_points(rig, some_pose(), 200, 0.3, random);
    // A car that passes: a third of the points moves as one, some more at random.
    for (std::size_t i = 0; i < 66; ++i) {
      points[i].sight.u += 9.0;
      points[i].sight.u_right += 7.0;
    }
    for (std::size_t i = 66; i < 100; ++i) {
      points[i].sight = {anywhere(random), anywhere(random), anywhere(random)};
    }
    Vector6d off;
    off << 0.1, 0.05, 0.2, 0.01, -0.02, 0.02;
    const MotionFit fit =
        fit_motion(rig, points, some_pose() * se3_exp(off), Matrix6d::Zero(), {}, seed);
    ASSERT_TRUE(fit.found);
    EXPECT_GE(fit.inliers, 90);
    EXPECT_LE(fit.inliers, 105);
    EXPECT_LT(error_m(fit.T_world_camera, some_pose()), 0.02);
    EXPECT_LT(error_rad(fit.T_world_camera, some_pose()), 0.003);
  }
}

TEST(FitMotion, CovarianceIsThatOfTheError) {
  const RectifiedRig rig = euroc_like_rig();
  std::mt19937 random(3);
  FitMotionOptions options;
  options.sigma_px = 0.4;
  double sum = 0.0;
  constexpr int kRuns = 300;
  for (int run = 0; run < kRuns; ++run) {
    const auto points = seen_points(rig, some_pose(), 80, options.sigma_px, random);
    const MotionFit fit = fit_motion(rig, points, some_pose(), Matrix6d::Zero(), options, 1);
    ASSERT_TRUE(fit.found);
    const Vector6d e = se3_log(some_pose().inverse() * fit.T_world_camera);
    sum += e.dot(fit.covariance.ldlt().solve(e));
  }
  // Chi squared with six degrees of freedom; the robust weights and the gate cost some efficiency.
  EXPECT_NEAR(sum / kRuns, 6.0, 1.2);
}

TEST(FitMotion, SaysSoWhenTooFewAgree) {
  const RectifiedRig rig = euroc_like_rig();
  std::mt19937 random(4);
  EXPECT_FALSE(fit_motion(rig, {}, some_pose(), Matrix6d::Zero(), {}, 1).found);
  EXPECT_FALSE(fit_motion(rig, seen_points(rig, some_pose(), 8, 0.1, random), some_pose(),
                          Matrix6d::Zero(), {}, 1)
                   .found);
  std::uniform_real_distribution<double> anywhere(0.0, 480.0);
  auto nonsense = seen_points(rig, some_pose(), 100, 0.1, random);
  for (SeenPoint& p : nonsense) p.sight = {anywhere(random), anywhere(random), anywhere(random)};
  const MotionFit fit = fit_motion(rig, nonsense, some_pose(), Matrix6d::Zero(), {}, 1);
  EXPECT_FALSE(fit.found);
  EXPECT_TRUE(fit.T_world_camera.matrix().allFinite());
  // Points that are all one leave directions open.
  auto one = seen_points(rig, some_pose(), 1, 0.0, random);
  one.resize(50, one.front());
  EXPECT_FALSE(fit_motion(rig, one, some_pose(), Matrix6d::Zero(), {}, 1).found);
}

TEST(FitMotion, WhatWasKnownBeforeTakesPart) {
  const RectifiedRig rig = euroc_like_rig();
  std::mt19937 random(5);
  const auto points = seen_points(rig, some_pose(), 30, 0.4, random);
  const MotionFit alone = fit_motion(rig, points, some_pose(), Matrix6d::Zero(), {}, 1);
  const MotionFit sure = fit_motion(rig, points, some_pose(), 1e8 * Matrix6d::Identity(), {}, 1);
  ASSERT_TRUE(alone.found && sure.found);
  EXPECT_LT(error_m(sure.T_world_camera, some_pose()), 1e-3);
  EXPECT_LT(error_m(sure.T_world_camera, some_pose()), error_m(alone.T_world_camera, some_pose()));
  EXPECT_LT(sure.covariance.trace(), 1e-7);
}

TEST(FitMotion, IsAFunctionOfItsSeed) {
  const RectifiedRig rig = euroc_like_rig();
  std::mt19937 random(6);
  const auto points = seen_points(rig, some_pose(), 100, 0.5, random);
  const auto once = fit_motion(rig, points, some_pose(), Matrix6d::Zero(), {}, 11);
  const auto again = fit_motion(rig, points, some_pose(), Matrix6d::Zero(), {}, 11);
  EXPECT_EQ(once.T_world_camera.matrix(), again.T_world_camera.matrix());
}

}  // namespace
}  // namespace tread
