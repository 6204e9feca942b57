#include "tread/slam/imu_preintegration.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>

#include "tread/slam/inertial_cost.hpp"
#include "tread/slam/pose_block.hpp"

namespace tread {
namespace {

using Eigen::Vector3d;

const Vector3d kGravity(0.0, 0.0, -9.81);

// A motion with a formula: position and rotation as functions of time.
Isometry3d pose_at_time(double t) {
  Isometry3d T = Isometry3d::Identity();
  T.translation() = Vector3d(0.8 * std::sin(1.1 * t), 0.5 * std::cos(0.7 * t), 0.2 * t * t);
  T.linear() = so3_exp(Vector3d(0.3 * std::sin(0.9 * t), 0.4 * std::sin(0.5 * t), 0.6 * t));
  return T;
}
Vector3d velocity_at(double t) {
  return {0.88 * std::cos(1.1 * t), -0.35 * std::sin(0.7 * t), 0.4 * t};
}

// What an IMU that moves so measures, without errors.
std::vector<ImuSample> samples_of_motion(double seconds, double rate_hz) {
  std::vector<ImuSample> samples;
  const int count = static_cast<int>(seconds * rate_hz) + 1;
  for (int i = 0; i < count; ++i) {
    const double t = i / rate_hz;
    constexpr double h = 1e-5;
    const Eigen::Matrix3d R = pose_at_time(t).linear();
    ImuSample sample;
    sample.stamp_ns = static_cast<std::int64_t>(std::llround(t * 1e9));
    sample.gyro_rad_per_s =
        so3_log(pose_at_time(t - h).linear().transpose() * pose_at_time(t + h).linear()) / (2 * h);
    const Vector3d acceleration(-0.968 * std::sin(1.1 * t), -0.245 * std::cos(0.7 * t), 0.4);
    sample.accel_m_per_s2 = R.transpose() * (acceleration - kGravity);
    samples.push_back(sample);
  }
  return samples;
}

InertialState state_at(double t) {
  return {pose_at_time(t), velocity_at(t), {}};
}

TEST(ImuPreintegration, FollowsAMotionWithAFormula) {
  const auto samples = samples_of_motion(2.0, 200.0);
  ImuPreintegration motion(Imu{}, {});
  motion.integrate(samples, 0, 2'000'000'000);
  EXPECT_NEAR(motion.seconds(), 2.0, 1e-9);
  const InertialState end = motion.predict(state_at(0.0), kGravity);
  EXPECT_LT((end.T_world_imu.translation() - pose_at_time(2.0).translation()).norm(), 2e-4);
  EXPECT_LT((end.velocity_m_per_s - velocity_at(2.0)).norm(), 2e-4);
  EXPECT_LT(so3_log(end.T_world_imu.linear().transpose() * pose_at_time(2.0).linear()).norm(),
            1e-4);
}

TEST(ImuPreintegration, IntervalsAddUpAndEndBetweenSamples) {
  const auto samples = samples_of_motion(2.0, 200.0);
  ImuPreintegration whole(Imu{}, {}), parts(Imu{}, {});
  whole.integrate(samples, 3'000'000, 1'503'000'000);
  parts.integrate(samples, 3'000'000, 777'777'777);
  parts.integrate(samples, 777'777'777, 1'503'000'000);
  EXPECT_NEAR(parts.seconds(), 1.5, 1e-12);
  EXPECT_LT((whole.motion().p - parts.motion().p).norm(), 1e-6);
  const InertialState end = parts.predict(state_at(0.003), kGravity);
  EXPECT_LT((end.T_world_imu.translation() - pose_at_time(1.503).translation()).norm(), 2e-4);
}

TEST(ImuPreintegration, NothingOfNothing) {
  ImuPreintegration motion(Imu{}, {});
  motion.integrate({}, 0, 1'000'000'000);
  EXPECT_EQ(motion.seconds(), 0.0);
  motion.integrate(samples_of_motion(1.0, 100.0), 500, 500);
  EXPECT_EQ(motion.seconds(), 0.0);
}

TEST(ImuPreintegration, BiasJacobianIsTheDerivative) {
  const auto samples = samples_of_motion(1.0, 200.0);
  const ImuBias bias{{0.02, -0.01, 0.03}, {0.1, 0.05, -0.08}};
  ImuPreintegration motion(Imu{}, bias);
  motion.integrate(samples, 0, 1'000'000'000);
  constexpr double h = 1e-5;
  for (int i = 0; i < 6; ++i) {
    ImuBias more = bias, less = bias;
    (i < 3 ? more.gyro_rad_per_s(i) : more.accel_m_per_s2(i - 3)) += h;
    (i < 3 ? less.gyro_rad_per_s(i) : less.accel_m_per_s2(i - 3)) -= h;
    const auto a = motion.again(more).motion(), b = motion.again(less).motion();
    Eigen::Matrix<double, 9, 1> numeric;
    numeric << so3_log(b.R.transpose() * a.R), a.v - b.v, a.p - b.p;
    numeric /= 2 * h;
    EXPECT_LT((numeric - motion.by_bias().col(i)).norm(), 1e-4) << i;
  }
  const ImuBias near{{0.022, -0.012, 0.029}, {0.11, 0.04, -0.07}};
  const auto exact = motion.again(near).motion(), linear = motion.motion_with(near);
  EXPECT_LT((exact.p - linear.p).norm() + (exact.v - linear.v).norm(), 1e-4);
}

TEST(ImuPreintegration, CovarianceIsThatOfTheErrors) {
  Imu imu;
  imu.gyro_noise = 2e-3;
  imu.accel_noise = 2e-2;
  const double rate = 200.0;
  const auto exact = samples_of_motion(1.0, rate);
  ImuPreintegration truth(imu, {});
  truth.integrate(exact, 0, 1'000'000'000);
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  double sum = 0.0;
  constexpr int kRuns = 400;
  for (int run = 0; run < kRuns; ++run) {
    auto samples = exact;
    for (ImuSample& s : samples) {
      for (int i = 0; i < 3; ++i) {
        s.gyro_rad_per_s(i) += imu.gyro_noise * std::sqrt(rate) * normal(random);
        s.accel_m_per_s2(i) += imu.accel_noise * std::sqrt(rate) * normal(random);
      }
    }
    ImuPreintegration noisy(imu, {});
    noisy.integrate(samples, 0, 1'000'000'000);
    Eigen::Matrix<double, 9, 1> e;
    e << so3_log(truth.motion().R.transpose() * noisy.motion().R),
        noisy.motion().v - truth.motion().v, noisy.motion().p - truth.motion().p;
    sum += e.dot(truth.covariance().ldlt().solve(e));
  }
  EXPECT_NEAR(sum / kRuns, 9.0, 0.9);
}

TEST(InertialCost, IsZeroForTheTruthAndItsJacobiansAreTheDerivatives) {
  Isometry3d T_camera_imu = Isometry3d::Identity();
  T_camera_imu.linear() = so3_exp(Vector3d(0.2, -1.2, 0.4));
  T_camera_imu.translation() = Vector3d(0.05, -0.02, 0.07);
  const auto samples = samples_of_motion(1.0, 200.0);
  const ImuBias bias{{0.01, -0.02, 0.005}, {0.05, 0.1, -0.05}};
  auto biased = samples;
  for (ImuSample& s : biased) {
    s.gyro_rad_per_s += bias.gyro_rad_per_s;
    s.accel_m_per_s2 += bias.accel_m_per_s2;
  }
  ImuPreintegration measured(Imu{}, {{0.008, -0.018, 0.004}, {0.04, 0.12, -0.04}});
  measured.integrate(biased, 0, 800'000'000);
  const InertialCost cost(measured, T_camera_imu);

  std::array<PoseBlock, 2> poses = {block_of(pose_at_time(0.0) * T_camera_imu.inverse()),
                                    block_of(pose_at_time(0.8) * T_camera_imu.inverse())};
  std::array<Eigen::Matrix<double, 9, 1>, 2> motions;
  motions[0] << velocity_at(0.0), bias.gyro_rad_per_s, bias.accel_m_per_s2;
  motions[1] << velocity_at(0.8), bias.gyro_rad_per_s, bias.accel_m_per_s2;
  Vector3d gravity = kGravity;
  Eigen::Matrix<double, 15, 1> r;
  const std::array<double*, 5> parameters = {poses[0].data(), motions[0].data(), poses[1].data(),
                                             motions[1].data(), gravity.data()};
  ASSERT_TRUE(cost.Evaluate(parameters.data(), r.data(), nullptr));
  EXPECT_LT(r.norm(), 1.0);  // the integral is that good, in sigma

  // Somewhere else, so that nothing is zero by chance.
  const PoseManifold manifold;
  const Vector6d off = (Vector6d() << 0.01, -0.02, 0.015, 0.01, 0.02, -0.01).finished();
  PoseBlock moved{};
  manifold.Plus(poses[1].data(), off.data(), moved.data());
  poses[1] = moved;
  motions[1].head<3>() += Vector3d(0.02, 0.03, -0.01);
  Eigen::Matrix<double, 15, 7, Eigen::RowMajor> J0, J2;
  Eigen::Matrix<double, 15, 9, Eigen::RowMajor> J1, J3;
  Eigen::Matrix<double, 15, 3, Eigen::RowMajor> J4;
  std::array<double*, 5> jacobians = {J0.data(), J1.data(), J2.data(), J3.data(), J4.data()};
  ASSERT_TRUE(cost.Evaluate(parameters.data(), r.data(), jacobians.data()));
  const auto column = [&](int block, int i) {
    constexpr double h = 1e-6;
    std::array<Eigen::Matrix<double, 15, 1>, 2> ends;
    for (const int side : {0, 1}) {
      const double step = side == 0 ? h : -h;
      auto poses_here = poses;
      auto motions_here = motions;
      Vector3d gravity_here = gravity;
      if (block == 0 || block == 2) {
        const Vector6d d = step * Vector6d::Unit(i);
        const auto k = static_cast<std::size_t>(block / 2);
        manifold.Plus(poses[k].data(), d.data(), poses_here[k].data());
      } else if (block == 4) {
        gravity_here(i) += step;
      } else {
        motions_here[static_cast<std::size_t>(block / 2)](i) += step;
      }
      const std::array<const double*, 5> here = {poses_here[0].data(), motions_here[0].data(),
                                                 poses_here[1].data(), motions_here[1].data(),
                                                 gravity_here.data()};
      EXPECT_TRUE(cost.Evaluate(here.data(), ends[static_cast<std::size_t>(side)].data(), nullptr));
    }
    return Eigen::Matrix<double, 15, 1>((ends[0] - ends[1]) / (2 * h));
  };
  const auto check = [&](int block, const auto& J, int columns) {
    for (int i = 0; i < columns; ++i) {
      const Eigen::Matrix<double, 15, 1> numeric = column(block, i);
      EXPECT_LT((numeric - J.col(i)).norm(), 1e-4 * (1.0 + numeric.norm())) << block << ' ' << i;
    }
  };
  check(0, J0, 6);
  check(1, J1, 9);
  check(2, J2, 6);
  check(3, J3, 9);
  check(4, J4, 3);
}

TEST(BiasPriorCost, JacobianIsTheDerivative) {
  const BiasPriorCost cost({{0.01, 0.0, -0.01}, {0.1, 0.2, 0.3}});
  Eigen::Matrix<double, 9, 1> x;
  x << 1, 2, 3, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6;
  Vector6d r;
  Eigen::Matrix<double, 6, 9, Eigen::RowMajor> J;
  const double* parameters[] = {x.data()};
  double* jacobians[] = {J.data()};
  ASSERT_TRUE(cost.Evaluate(parameters, r.data(), jacobians));
  for (int i = 0; i < 9; ++i) {
    const Eigen::Matrix<double, 9, 1> moved = x + 1e-3 * Eigen::Matrix<double, 9, 1>::Unit(i);
    Vector6d other;
    const double* there[] = {moved.data()};
    ASSERT_TRUE(cost.Evaluate(there, other.data(), nullptr));
    EXPECT_LT(((other - r) / 1e-3 - J.col(i)).norm(), 1e-6);
  }
}

}  // namespace
}  // namespace tread
