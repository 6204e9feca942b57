#include "tread/sim/imu_sensor.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace tread {
namespace {

using Eigen::Vector3d;

ImuSensorOptions perfect() {
  ImuSensorOptions options;
  options.gyro_noise = options.accel_noise = options.gyro_walk = options.accel_walk = 0.0;
  options.gyro_bias_rad_per_s = options.accel_bias_m_per_s2 = 0.0;
  options.gyro_scale = options.accel_scale = 0.0;
  options.gyro_step_rad_per_s = options.accel_step_m_per_s2 = 0.0;
  return options;
}

Isometry3d mount() {
  Isometry3d T_body_imu = Isometry3d::Identity();
  T_body_imu.linear() = so3_exp({0.4, -1.1, 2.0});
  T_body_imu.translation() = Vector3d(0.3, -0.2, 0.5);
  return T_body_imu;
}

// A body that swings and turns about all axes, by formula.
Isometry3d pose_at(double t) {
  Isometry3d T_world_body = Isometry3d::Identity();
  T_world_body.linear() =
      rotation_from_yaw_pitch_roll(0.7 * std::sin(1.1 * t), 0.4 * std::cos(1.7 * t), 0.5 * t);
  T_world_body.translation() =
      Vector3d(std::sin(2.0 * t), 0.3 * t * t, 0.2 * std::cos(3.0 * t) + 1.0);
  return T_world_body;
}

Vector3d rate_at(double t) {
  constexpr double h = 1e-5;
  return so3_log(pose_at(t - h).linear().transpose() * pose_at(t + h).linear()) / (2.0 * h);
}

BodyMotion motion_at(double t) {
  constexpr double h = 1e-4;
  const auto p = [](double at) -> Vector3d { return pose_at(at).translation(); };
  BodyMotion motion;
  motion.T_world_body = pose_at(t);
  motion.velocity_m_per_s = (p(t + h) - p(t - h)) / (2.0 * h);
  motion.acceleration_m_per_s2 = (p(t + h) - 2.0 * p(t) + p(t - h)) / (h * h);
  motion.rate_rad_per_s = rate_at(t);
  motion.rate_change_rad_per_s2 = (rate_at(t + h) - rate_at(t - h)) / (2.0 * h);
  return motion;
}

TEST(ImuSensor, AtRestItFeelsWhatHoldsItUp) {
  ImuSensor level(perfect(), Isometry3d::Identity(), 1);
  const ImuSample sample = level.measure(0, BodyMotion{});
  EXPECT_EQ(sample.gyro_rad_per_s, Vector3d::Zero());
  EXPECT_EQ(sample.accel_m_per_s2, Vector3d(0.0, 0.0, 9.81));
  BodyMotion falling;
  falling.acceleration_m_per_s2.z() = -9.81;
  EXPECT_LT(level.measure(1, falling).accel_m_per_s2.norm(), 1e-12);
  BodyMotion nose_down;  // x towards the ground: held up against x
  nose_down.T_world_body.linear() = rotation_from_yaw_pitch_roll(0.3, M_PI / 2.0, 0.0);
  EXPECT_LT((level.measure(2, nose_down).accel_m_per_s2 - Vector3d(-9.81, 0, 0)).norm(), 1e-12);
}

// The unit's own path through the world, differentiated, against what the lever arm gives.
TEST(ImuSensor, OffTheCentreItFeelsTheTurn) {
  ImuSensor sensor(perfect(), mount(), 1);
  constexpr double h = 1e-4;
  for (const double t : {0.2, 0.9, 1.7, 3.1}) {
    const auto T_world_imu = [](double at) { return pose_at(at) * mount(); };
    const auto p = [&](double at) -> Vector3d { return T_world_imu(at).translation(); };
    const Vector3d force = (p(t + h) - 2.0 * p(t) + p(t - h)) / (h * h) + Vector3d(0, 0, 9.81);
    const Eigen::Matrix3d R = T_world_imu(t).linear();
    const ImuSample sample = sensor.measure(static_cast<std::int64_t>(t * 1e9), motion_at(t));
    EXPECT_LT((sample.accel_m_per_s2 - R.transpose() * force).norm(), 1e-5) << t;
    const Vector3d turn =
        so3_log(T_world_imu(t - h).linear().transpose() * T_world_imu(t + h).linear()) / (2.0 * h);
    EXPECT_LT((sample.gyro_rad_per_s - turn).norm(), 1e-6) << t;
  }
}

// Overlapping Allan deviation (IEEE 952) of a series at `m` samples of averaging.
double allan_deviation(const std::vector<double>& integral, std::size_t m, double period_s) {
  double sum = 0.0;
  const std::size_t count = integral.size() - 2 * m;
  for (std::size_t i = 0; i < count; ++i) {
    const double d = integral[i + 2 * m] - 2.0 * integral[i + m] + integral[i];
    sum += d * d;
  }
  const double tau = static_cast<double>(m) * period_s;
  return std::sqrt(sum / (2.0 * tau * tau * static_cast<double>(count)));
}

constexpr double kRate_hz = 100.0;

// The integrals over time of the six axes of a unit at rest.
std::array<std::vector<double>, 6> integrals_at_rest(const ImuSensorOptions& options,
                                                     std::size_t samples, std::uint64_t seed) {
  ImuSensor sensor(options, Isometry3d::Identity(), seed);
  std::array<std::vector<double>, 6> integrals;
  for (auto& integral : integrals) integral.reserve(samples + 1), integral.push_back(0.0);
  const BodyMotion rest;
  for (std::size_t i = 0; i < samples; ++i) {
    const ImuSample sample = sensor.measure(static_cast<std::int64_t>(i) * 10'000'000, rest);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<Eigen::Index>(axis);
      const double gravity = axis == 2 ? 9.81 : 0.0;
      integrals[axis].push_back(integrals[axis].back() + sample.gyro_rad_per_s(a) / kRate_hz);
      integrals[axis + 3].push_back(integrals[axis + 3].back() +
                                    (sample.accel_m_per_s2(a) - gravity) / kRate_hz);
    }
  }
  return integrals;
}

// Root mean square over three axes.
double allan_of(const std::array<std::vector<double>, 6>& integrals, std::size_t first,
                std::size_t m) {
  double sum = 0.0;
  for (std::size_t axis = first; axis < first + 3; ++axis) {
    sum += std::pow(allan_deviation(integrals[axis], m, 1.0 / kRate_hz), 2);
  }
  return std::sqrt(sum / 3.0);
}

TEST(ImuSensor, AllanDeviationIsThatOfTheNoiseAndTheWalkAskedFor) {
  ImuSensorOptions options;  // with bias, scale error, range and steps as they are
  options.channel.rate_hz = kRate_hz;
  options.gyro_noise = 2e-3;
  options.gyro_walk = 2e-3;  // both are equal at tau = 1.7 s
  options.accel_noise = 0.02;
  options.accel_walk = 0.02;
  const auto integrals = integrals_at_rest(options, 360'000, 3);  // one hour
  for (const auto& [first, noise, walk] :
       {std::tuple(0U, options.gyro_noise, options.gyro_walk),
        std::tuple(3U, options.accel_noise, options.accel_walk)}) {
    // Where one of them is less than a hundredth of the other's variance.
    for (const std::size_t m : {1U, 3U, 10U}) {
      const double tau = static_cast<double>(m) / kRate_hz;
      EXPECT_NEAR(allan_of(integrals, first, m) * std::sqrt(tau) / noise, 1.0, 0.05) << tau;
    }
    for (const std::size_t m : {2000U, 4000U}) {
      const double tau = static_cast<double>(m) / kRate_hz;
      EXPECT_NEAR(allan_of(integrals, first, m) / (walk * std::sqrt(tau / 3.0)), 1.0, 0.15) << tau;
    }
    const double half = allan_of(integrals, first, 10) / allan_of(integrals, first, 2);
    EXPECT_NEAR(std::log(half) / std::log(5.0), -0.5, 0.02) << "slope of the noise";
    const double up = allan_of(integrals, first, 4000) / allan_of(integrals, first, 1000);
    EXPECT_NEAR(std::log(up) / std::log(4.0), 0.5, 0.12) << "slope of the walk";
    for (const std::size_t m : {50U, 170U, 500U}) {
      const double tau = static_cast<double>(m) / kRate_hz;
      const double expected = std::sqrt(noise * noise / tau + walk * walk * tau / 3.0);
      EXPECT_NEAR(allan_of(integrals, first, m) / expected, 1.0, 0.1) << tau;
    }
  }
}

TEST(ImuSensor, BiasAndScaleAtTheStartAreAsWideAsAskedFor) {
  ImuSensorOptions options = perfect();
  options.gyro_bias_rad_per_s = 0.01;
  options.accel_scale = 0.01;
  double bias2 = 0.0, scale2 = 0.0;
  constexpr int kUnits = 2000;
  for (std::uint64_t seed = 0; seed < kUnits; ++seed) {
    ImuSensor sensor(options, Isometry3d::Identity(), seed);
    const ImuSample sample = sensor.measure(0, BodyMotion{});
    EXPECT_EQ(sample.gyro_rad_per_s, sensor.gyro_bias_rad_per_s());
    EXPECT_EQ(sample.accel_m_per_s2.head<2>(), Eigen::Vector2d::Zero());
    bias2 += sample.gyro_rad_per_s.squaredNorm() / 3.0;
    scale2 += std::pow(sample.accel_m_per_s2.z() / 9.81 - 1.0, 2);
  }
  EXPECT_NEAR(std::sqrt(bias2 / kUnits), 0.01, 4.0 * 0.01 / std::sqrt(6.0 * kUnits));
  EXPECT_NEAR(std::sqrt(scale2 / kUnits), 0.01, 4.0 * 0.01 / std::sqrt(2.0 * kUnits));
}

TEST(ImuSensor, TheBiasThatItTellsIsTheOneInTheSamples) {
  ImuSensorOptions options = perfect();
  options.gyro_walk = 0.1;
  options.accel_walk = 0.5;
  ImuSensor sensor(options, Isometry3d::Identity(), 8);
  for (int i = 0; i < 100; ++i) {
    const ImuSample sample = sensor.measure(i * 5'000'000, BodyMotion{});
    EXPECT_EQ(sample.gyro_rad_per_s, sensor.gyro_bias_rad_per_s());
    EXPECT_LT((sample.accel_m_per_s2 - Vector3d(0, 0, 9.81) - sensor.accel_bias_m_per_s2()).norm(),
              1e-14);
  }
  EXPECT_GT(sensor.accel_bias_m_per_s2().norm(), 0.01);
}

TEST(ImuSensor, ClipsAtItsRangeAndRoundsToItsSteps) {
  ImuSensorOptions options = perfect();
  options.gyro_range_rad_per_s = 2.0;
  options.gyro_step_rad_per_s = 0.25;
  options.accel_range_m_per_s2 = 20.0;
  options.accel_step_m_per_s2 = 0.5;
  ImuSensor sensor(options, Isometry3d::Identity(), 1);
  BodyMotion motion;
  motion.rate_rad_per_s = Vector3d(9.0, -9.0, 0.4);
  motion.acceleration_m_per_s2 = Vector3d(-100.0, 1.3, 0.0);
  const ImuSample sample = sensor.measure(0, motion);
  EXPECT_EQ(sample.gyro_rad_per_s, Vector3d(2.0, -2.0, 0.5));
  EXPECT_EQ(sample.accel_m_per_s2, Vector3d(-20.0, 1.5, 10.0));
  EXPECT_EQ(sensor.full_scale().gyro_rad_per_s, Vector3d::Constant(2.0));
  EXPECT_EQ(sensor.full_scale().accel_m_per_s2, Vector3d::Constant(20.0));
}

TEST(ImuSensor, OneSeedOneUnit) {
  const auto samples_of = [](std::uint64_t seed) {
    ImuSensor sensor({}, mount(), seed);
    std::vector<Vector3d> values;
    for (int i = 0; i < 50; ++i) {
      const ImuSample sample = sensor.measure(i * 5'000'000, motion_at(0.1 * i));
      values.push_back(sample.gyro_rad_per_s);
      values.push_back(sample.accel_m_per_s2);
    }
    return values;
  };
  EXPECT_EQ(samples_of(4), samples_of(4));
  EXPECT_NE(samples_of(4), samples_of(5));
}

TEST(ImuSensor, TheRigSaysWhatTheUnitIs) {
  ImuSensorOptions options;
  options.gyro_noise = 1e-3;
  options.channel.rate_hz = 333.0;
  const Imu imu = imu_of(options, mount());
  EXPECT_EQ(imu.gyro_noise, 1e-3);
  EXPECT_EQ(imu.accel_walk, options.accel_walk);
  EXPECT_EQ(imu.rate_hz, 333.0);
  EXPECT_EQ(imu.T_imu_left.matrix(), mount().matrix());
  EXPECT_TRUE(check_imu(imu));
}

TEST(ImuSensorOptions, WhatCannotBeIsRefused) {
  EXPECT_TRUE(check_options(ImuSensorOptions{}));
  for (const char* name :
       {"gyro_noise", "accel_noise", "gyro_walk", "accel_walk", "gyro_bias_rad_per_s",
        "accel_bias_m_per_s2", "gyro_scale", "accel_scale", "gyro_range_rad_per_s",
        "accel_range_m_per_s2", "gyro_step_rad_per_s", "accel_step_m_per_s2", "channel.rate_hz"}) {
    ImuSensorOptions options;
    for (const char* text : {"-1", "nan", "inf", "x"}) {
      EXPECT_FALSE(describe(options).set(name, text)) << name << " " << text;
    }
    EXPECT_EQ(options, ImuSensorOptions{});
  }
}

}  // namespace
}  // namespace tread
