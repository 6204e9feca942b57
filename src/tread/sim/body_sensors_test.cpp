// Wheels, legs and bumper.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "tread/sim/bump_sensor.hpp"
#include "tread/sim/leg_sensor.hpp"
#include "tread/sim/wheel_sensor.hpp"

namespace tread {
namespace {

constexpr std::int64_t kMillisecond_ns = 1'000'000;

TEST(WheelSensor, CountsWholeStepsFromZeroAndNeverLosesOne) {
  WheelSensorOptions options;
  options.steps_per_turn = 100;
  const double step = 2.0 * std::numbers::pi / 100.0;
  WheelSensor sensor(options, 3);
  EXPECT_EQ(sensor.measure({}).left_rad, 0.0);
  double last = 0.0;
  for (int i = 0; i < 5000; ++i) {
    const double angle = 0.01 * i;
    const WheelSample sample = sensor.measure({0, angle, -angle, 0.0, 0.0});
    EXPECT_LT(std::abs(sample.left_rad - angle), step);
    EXPECT_LT(std::abs(sample.right_rad + angle), step);
    EXPECT_NEAR(std::remainder(sample.left_rad, step), 0.0, 1e-9);
    EXPECT_GE(sample.left_rad, last);
    last = sample.left_rad;
  }
  EXPECT_EQ(sensor.measure({}).right_rad, 0.0) << "back where it was";
}

TEST(WheelSensor, CurrentsHaveTheNoiseAndTheOffsetAskedFor) {
  WheelSensorOptions options;
  options.current_noise_a = 0.5;
  options.current_offset_a = 2.0;
  options.current_step_a = 0.0;
  double offsets2 = 0.0;
  constexpr int kUnits = 300, kSamples = 400;
  double noise2 = 0.0;
  for (std::uint64_t seed = 0; seed < kUnits; ++seed) {
    WheelSensor sensor(options, seed);
    double sum = 0.0, sum2 = 0.0;
    for (int i = 0; i < kSamples; ++i) {
      const double error = sensor.measure({0, 0.0, 0.0, 7.0, -7.0}).left_current_a - 7.0;
      sum += error;
      sum2 += error * error;
    }
    const double mean = sum / kSamples;
    offsets2 += mean * mean / kUnits;
    noise2 += (sum2 / kSamples - mean * mean) / kUnits;
  }
  EXPECT_NEAR(std::sqrt(offsets2), 2.0, 4.0 * 2.0 / std::sqrt(2.0 * kUnits));
  EXPECT_NEAR(std::sqrt(noise2), 0.5, 0.01);
}

TEST(WheelSensor, CurrentsAreClippedAndRounded) {
  WheelSensorOptions options;
  options.current_noise_a = options.current_offset_a = 0.0;
  options.current_step_a = 0.5;
  options.current_range_a = 10.0;
  WheelSensor sensor(options, 1);
  const WheelSample sample = sensor.measure({0, 0.0, 0.0, 99.0, -1.3});
  EXPECT_EQ(sample.left_current_a, 10.0);
  EXPECT_EQ(sample.right_current_a, -1.5);
  EXPECT_EQ(sensor.full_scale().right_current_a, 10.0);
}

LegSensorOptions perfect_legs() {
  LegSensorOptions options;
  options.position_offset_rad = 0.0;
  options.torque_noise_nm = options.torque_offset_nm = 0.0;
  options.foot_force_noise_n = options.foot_force_offset_n = 0.0;
  return options;
}

LegSample all_joints_at(double position_rad) {
  LegSample sample;
  sample.position_rad.fill(position_rad);
  return sample;
}

TEST(LegSensor, PositionsAreRoundedToTheEncoder) {
  LegSensorOptions options = perfect_legs();
  options.steps_per_turn = 1000;
  LegSensor sensor(options, 1);
  const double step = 2.0 * std::numbers::pi / 1000.0;
  for (const double q : {0.0, 0.4, -1.234, 2.0}) {
    const LegSample sample = sensor.measure(0, all_joints_at(q));
    EXPECT_LE(std::abs(sample.position_rad[7] - q), 0.5001 * step);
    EXPECT_NEAR(std::remainder(sample.position_rad[7], step), 0.0, 1e-12);
  }
}

TEST(LegSensor, VelocitiesAreLowPassedDifferences) {
  LegSensorOptions options = perfect_legs();
  options.steps_per_turn = 10'000'000;
  options.velocity_cutoff_hz = 20.0;
  LegSensor sensor(options, 1);
  EXPECT_EQ(sensor.measure(0, all_joints_at(0.5)).velocity_rad_per_s[0], 0.0);
  // From rest to 3 rad/s: v = 3 (1 - exp(-2 pi f t)).
  for (int i = 1; i <= 100; ++i) {
    const LegSample sample =
        sensor.measure(i * 2 * kMillisecond_ns, all_joints_at(0.5 + 3.0 * 0.002 * i));
    const double expected = 3.0 * (1.0 - std::exp(-2.0 * std::numbers::pi * 20.0 * 0.002 * i));
    EXPECT_NEAR(sample.velocity_rad_per_s[11], expected, 1e-3) << i;
  }
  options.velocity_cutoff_hz = 0.0;
  options.velocity_range_rad_per_s = 4.0;
  LegSensor plain(options, 1);
  (void)plain.measure(0, all_joints_at(0.0));
  EXPECT_NEAR(plain.measure(2 * kMillisecond_ns, all_joints_at(0.006)).velocity_rad_per_s[5], 3.0,
              1e-3);
  EXPECT_EQ(plain.measure(4 * kMillisecond_ns, all_joints_at(-1.0)).velocity_rad_per_s[5], -4.0);
}

// A joint that moves slowly over an encoder's steps: rounding is the noise, of step / sqrt(12) at
// each end of the difference.
TEST(LegSensor, VelocitiesHaveTheNoiseOfTheEncoder) {
  LegSensorOptions options = perfect_legs();
  options.steps_per_turn = 80'000;
  options.velocity_cutoff_hz = 0.0;
  LegSensor sensor(options, 1);
  const double step = 2.0 * std::numbers::pi / 80'000.0;
  double sum2 = 0.0;
  constexpr int kCount = 20'000;
  (void)sensor.measure(0, all_joints_at(0.0));
  for (int i = 1; i <= kCount; ++i) {
    const double t = 0.002 * i, q = 0.3 * std::sin(1.7 * t);
    const double before = 0.3 * std::sin(1.7 * (t - 0.002));
    const LegSample sample = sensor.measure(i * 2 * kMillisecond_ns, all_joints_at(q));
    sum2 += std::pow(sample.velocity_rad_per_s[3] - (q - before) / 0.002, 2);
  }
  const double expected = step / 0.002 * std::sqrt(2.0 / 12.0);
  EXPECT_NEAR(std::sqrt(sum2 / kCount), expected, 0.05 * expected);
}

TEST(LegSensor, TorquesAndForcesHaveTheNoiseAndOffsetAskedFor) {
  LegSensorOptions options;
  options.torque_noise_nm = 2.0;
  options.torque_offset_nm = 5.0;
  options.foot_force_noise_n = 7.0;
  options.foot_force_offset_n = 20.0;
  options.position_offset_rad = 0.01;
  constexpr int kUnits = 100, kSamples = 100;
  double torque_noise2 = 0.0, torque_offset2 = 0.0, force_noise2 = 0.0, force_offset2 = 0.0;
  double zero2 = 0.0;
  LegSample truth;
  truth.torque_nm.fill(40.0);
  truth.foot_force_n.fill({0.0, -30.0, 200.0});
  for (std::uint64_t seed = 0; seed < kUnits; ++seed) {
    LegSensor sensor(options, seed);
    double torque = 0.0, torque2 = 0.0, force = 0.0, force2 = 0.0;
    for (int i = 0; i < kSamples; ++i) {
      const LegSample sample = sensor.measure(i * 2 * kMillisecond_ns, truth);
      const double t = sample.torque_nm[4] - 40.0, f = sample.foot_force_n[2].z() - 200.0;
      torque += t / kSamples, torque2 += t * t / kSamples;
      force += f / kSamples, force2 += f * f / kSamples;
      if (i > 0) continue;
      for (const double q : sample.position_rad) zero2 += q * q / (kUnits * kLegJoints);
    }
    torque_offset2 += torque * torque / kUnits;
    torque_noise2 += (torque2 - torque * torque) / kUnits;
    force_offset2 += force * force / kUnits;
    force_noise2 += (force2 - force * force) / kUnits;
  }
  const double wide = 4.0 / std::sqrt(2.0 * kUnits), narrow = 4.0 / std::sqrt(2.0 * 1e4);
  EXPECT_NEAR(std::sqrt(torque_offset2), 5.0, 5.0 * wide);
  EXPECT_NEAR(std::sqrt(force_offset2), 20.0, 20.0 * wide);
  EXPECT_NEAR(std::sqrt(torque_noise2), 2.0, 2.0 * narrow + 0.02);
  EXPECT_NEAR(std::sqrt(force_noise2), 7.0, 7.0 * narrow + 0.07);
  EXPECT_NEAR(std::sqrt(zero2), 0.01, 0.01 * 4.0 / std::sqrt(2.0 * kUnits * kLegJoints));
}

TEST(LegSensor, EverythingIsClippedToItsRange) {
  LegSensorOptions options = perfect_legs();
  options.torque_range_nm = 100.0;
  options.foot_force_range_n = 500.0;
  LegSensor sensor(options, 1);
  LegSample truth;
  truth.torque_nm.fill(-1000.0);
  truth.foot_force_n.fill({0.0, 0.0, 9000.0});
  const LegSample sample = sensor.measure(0, truth);
  EXPECT_EQ(sample.torque_nm[0], -100.0);
  EXPECT_EQ(sample.foot_force_n[0], Eigen::Vector3d(0.0, 0.0, 500.0));
  EXPECT_EQ(sensor.full_scale().torque_nm[0], 100.0);
  EXPECT_EQ(sensor.full_scale().foot_force_n[3].x(), 500.0);
  EXPECT_EQ(sensor.full_scale().velocity_rad_per_s[3], options.velocity_range_rad_per_s);
}

TEST(LegSensor, OneSeedOneRobot) {
  const auto torques_of = [](std::uint64_t seed) {
    LegSensor sensor({}, seed);
    (void)sensor.measure(0, {});
    return sensor.measure(kMillisecond_ns, {}).torque_nm;
  };
  EXPECT_EQ(torques_of(1), torques_of(1));
  EXPECT_NE(torques_of(1), torques_of(2));
}

TEST(BumpSensor, TellsOfAChangeOnceItHasLasted) {
  BumpSensorOptions options;
  options.debounce_s = 0.02;
  BumpSensor sensor(options);
  std::vector<std::pair<int, bool>> events;  // ms
  for (int ms = 0; ms < 300; ms += 5) {
    // Free; bounces; pressed from 60 on with a gap at 100 that is too short; free from 200 on.
    const bool touches = ms == 40 || ms == 50 || (ms >= 60 && ms < 200 && ms != 100);
    if (const auto event = sensor.look(ms * kMillisecond_ns, touches)) {
      events.emplace_back(ms, event->pressed);
    }
  }
  const std::vector<std::pair<int, bool>> expected = {{80, true}, {220, false}};
  EXPECT_EQ(events, expected);
  options.debounce_s = 0.0;
  EXPECT_TRUE(BumpSensor(options).look(0, true)) << "at once";
}

TEST(BodySensorOptions, WhatCannotBeIsRefused) {
  EXPECT_TRUE(check_options(WheelSensorOptions{}));
  EXPECT_TRUE(check_options(LegSensorOptions{}));
  EXPECT_TRUE(check_options(BumpSensorOptions{}));
  const auto refuses_all = [](OptionSet set) {
    for (const OptionField& field : std::vector<OptionField>(set.fields())) {
      if (field.name == "channel.clock_offset_s" || field.name == "channel.clock_drift_ppm") {
        continue;  // may be below 0
      }
      for (const char* text : {"-1", "nan", "inf", "x"}) {
        EXPECT_FALSE(set.set(field.name, text)) << field.name << " " << text;
      }
    }
  };
  WheelSensorOptions wheels;
  LegSensorOptions legs;
  BumpSensorOptions bump;
  refuses_all(describe(wheels));
  refuses_all(describe(legs));
  refuses_all(describe(bump));
}

}  // namespace
}  // namespace tread
