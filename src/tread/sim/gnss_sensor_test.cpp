#include "tread/sim/gnss_sensor.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace tread {
namespace {

using Eigen::Vector3d;

constexpr std::int64_t kSecond_ns = 1'000'000'000;

GnssSensorOptions perfect() {
  GnssSensorOptions options;
  options.white_m = options.drift_m = 0.0;
  options.drop_outs_per_h = options.jumps_per_h = 0.0;
  return options;
}

// Errors of a receiver that does not move, once every `period_s`.
std::vector<Vector3d> errors_of(const GnssSensorOptions& options, int count, double period_s,
                                std::uint64_t seed = 1) {
  GnssSensor sensor(options, Vector3d::Zero(), seed);
  std::vector<Vector3d> errors;
  for (int i = 0; i < count; ++i) {
    const auto fix = sensor.measure(std::llround(1e9 * period_s * i), Isometry3d::Identity());
    if (fix) errors.push_back(fix->position_m);
  }
  return errors;
}

// Mean of products `lag` apart, over the axes x and y.
double covariance(const std::vector<Vector3d>& errors, std::size_t lag) {
  double sum = 0.0;
  for (std::size_t i = lag; i < errors.size(); ++i) {
    sum += 0.5 * errors[i].head<2>().dot(errors[i - lag].head<2>());
  }
  return sum / static_cast<double>(errors.size() - lag);
}

TEST(GnssSensor, WithoutErrorsItTellsWhereTheAntennaIs) {
  Isometry3d T_world_body = Isometry3d::Identity();
  T_world_body.linear() = rotation_from_yaw_pitch_roll(M_PI / 2.0, 0.0, 0.0);
  T_world_body.translation() = Vector3d(10.0, 20.0, 1.0);
  GnssSensor sensor(perfect(), Vector3d(0.5, 0.0, 0.8), 1);
  for (int i = 0; i < 100; ++i) {
    const auto fix = sensor.measure(i * kSecond_ns, T_world_body);
    ASSERT_TRUE(fix);
    EXPECT_LT((fix->position_m - Vector3d(10.0, 20.5, 1.8)).norm(), 1e-12);
  }
}

// With a drift that forgets in 20 s, ten hours have 1800 independent stretches.
TEST(GnssSensor, TheErrorHasTheSpreadAndTheMemoryAskedFor) {
  GnssSensorOptions options = perfect();
  options.white_m = 0.5;
  options.drift_m = 2.0;
  options.drift_time_s = 20.0;
  const auto errors = errors_of(options, 100'000, 1.0);
  ASSERT_EQ(errors.size(), 100'000U);
  const double white2 = 0.25, drift2 = 4.0;
  EXPECT_NEAR(covariance(errors, 0), white2 + drift2, 0.05 * (white2 + drift2));
  for (const std::size_t lag : {1U, 5U, 20U, 40U}) {
    const double expected = drift2 * std::exp(-static_cast<double>(lag) / 20.0);
    EXPECT_NEAR(covariance(errors, lag), expected, 0.05 * drift2) << lag;
  }
  EXPECT_NEAR(covariance(errors, 200), 0.0, 0.05 * drift2) << "forgotten";
  EXPECT_NEAR(covariance(errors, 0) - covariance(errors, 1),
              white2 + drift2 * (1.0 - std::exp(-1.0 / 20.0)), 0.03)
      << "white";
  options.white_m = 0.0;  // then neighbours tell the time constant to 1.5 %
  const auto slow = errors_of(options, 100'000, 1.0);
  EXPECT_NEAR(-1.0 / std::log(covariance(slow, 1) / covariance(slow, 0)), 20.0, 1.0);
  double up2 = 0.0, level_up = 0.0;
  for (const Vector3d& error : errors) {
    up2 += error.z() * error.z();
    level_up += error.x() * error.z();
  }
  EXPECT_NEAR(std::sqrt(up2 / 100'000), 1.5 * std::sqrt(4.25), 0.05 * 1.5 * std::sqrt(4.25));
  EXPECT_NEAR(level_up / 100'000, 0.0, 0.1 * 1.5 * 4.25) << "axes are independent";
}

// The spectrum of the drift: sampled every dt, with a = exp(-dt / tau),
//   S(f) = dt sigma^2 (1 - a^2) / |1 - a exp(-2 pi i f dt)|^2.
TEST(GnssSensor, TheSpectrumIsThatOfAFirstOrderProcess) {
  GnssSensorOptions options = perfect();
  options.drift_m = 2.0;
  options.drift_time_s = 10.0;
  constexpr std::size_t kLength = 512, kPieces = 160;
  const auto errors = errors_of(options, kLength * kPieces, 1.0, 4);
  const double a = std::exp(-0.1);
  for (const int k : {16, 32, 64, 128, 200}) {
    double power = 0.0;
    for (std::size_t piece = 0; piece < kPieces; ++piece) {
      std::array<double, 4> sums{};  // cosine and sine of x and y, under a Hann window
      for (std::size_t i = 0; i < kLength; ++i) {
        const double t = static_cast<double>(i) / kLength;
        const double window = 0.5 - 0.5 * std::cos(2.0 * M_PI * t);
        const Vector3d& e = errors[piece * kLength + i];
        const double c = window * std::cos(2.0 * M_PI * k * t);
        const double s = window * std::sin(2.0 * M_PI * k * t);
        sums[0] += c * e.x(), sums[1] += s * e.x(), sums[2] += c * e.y(), sums[3] += s * e.y();
      }
      for (const double sum : sums) power += 0.5 * sum * sum;
    }
    power /= kPieces * kLength * 0.375;  // 0.375: mean of the squared window
    const double w = 2.0 * M_PI * k / kLength;
    const double expected = 4.0 * (1.0 - a * a) / (1.0 - 2.0 * a * std::cos(w) + a * a);
    EXPECT_NEAR(power / expected, 1.0, 4.0 / std::sqrt(2.0 * kPieces)) << k;
  }
}

TEST(GnssSensor, TheDriftDoesNotDependOnHowOftenItIsAsked) {
  GnssSensorOptions options = perfect();
  options.drift_m = 2.0;
  options.drift_time_s = 20.0;
  const auto slow = errors_of(options, 20'000, 7.0), fast = errors_of(options, 100'000, 0.5);
  EXPECT_NEAR(covariance(slow, 0), 4.0, 0.25);
  EXPECT_NEAR(covariance(slow, 2), 4.0 * std::exp(-0.7), 0.25);
  EXPECT_NEAR(covariance(fast, 28), 4.0 * std::exp(-0.7), 0.25);
}

TEST(GnssSensor, DropOutsComeAndLastAsAskedFor) {
  GnssSensorOptions options = perfect();
  options.drop_outs_per_h = 60.0;
  options.drop_out_s = 12.0;
  GnssSensor sensor(options, Vector3d::Zero(), 2);
  constexpr double kHours = 40.0, kPeriod_s = 0.25;
  const auto count = static_cast<int>(kHours * 3600.0 / kPeriod_s);
  int silent = 0, begun = 0;
  bool before = true;
  for (int i = 0; i < count; ++i) {
    const bool fix =
        sensor.measure(std::llround(1e9 * kPeriod_s * i), Isometry3d::Identity()).has_value();
    silent += fix ? 0 : 1;
    begun += before && !fix ? 1 : 0;
    before = fix;
  }
  // A spell begins once in a minute of fixes, so that a whole round takes 72 s: 2000 rounds.
  const double rounds = kHours * 3600.0 / 72.0;
  EXPECT_NEAR(begun, rounds, 4.0 * std::sqrt(rounds));
  EXPECT_NEAR(silent * kPeriod_s / begun, 12.0, 4.0 * 12.0 / std::sqrt(rounds) + kPeriod_s);
}

TEST(GnssSensor, MultipathJumpsStaysAndIsNotReported) {
  GnssSensorOptions options = perfect();
  options.white_m = 0.1;
  options.jumps_per_h = 36.0;  // once in 100 s, and then for 25 s
  options.jump_m = 8.0;
  options.jump_s = 25.0;
  GnssSensor sensor(options, Vector3d::Zero(), 3);
  constexpr int kCount = 200'000;
  int off = 0, begun = 0, moved = 0;
  double jump2 = 0.0;
  Vector3d before = Vector3d::Zero();
  for (int i = 0; i < kCount; ++i) {
    const auto fix = sensor.measure(i * kSecond_ns, Isometry3d::Identity());
    ASSERT_TRUE(fix);
    EXPECT_NEAR(fix->sigma_level_m, 0.1, 1e-12);
    EXPECT_NEAR(fix->sigma_up_m, 0.15, 1e-12);
    const bool is_off = fix->position_m.norm() > 1.0, was_off = before.norm() > 1.0;
    off += is_off ? 1 : 0;
    if (is_off && !was_off) {
      ++begun;
      jump2 += 0.5 * fix->position_m.head<2>().squaredNorm();
    } else if (is_off && (fix->position_m - before).norm() > 1.5) {
      ++moved;
    }
    before = fix->position_m;
  }
  const double rounds = kCount / 125.0;  // seconds; 1600
  EXPECT_NEAR(begun, rounds, 4.0 * std::sqrt(rounds));
  EXPECT_NEAR(static_cast<double>(off) / kCount, 0.2, 0.03);
  EXPECT_NEAR(std::sqrt(jump2 / begun), 8.0, 0.6);
  EXPECT_LT(moved, off / 1000) << "it stays where it jumped to; another seldom follows at once";
}

TEST(GnssSensor, UnderTreesItIsWorseAndThenSilent) {
  GnssSensorOptions options = perfect();
  options.white_m = 0.5;
  options.least_sky = 0.3;
  GnssSensor sensor(options, Vector3d::Zero(), 5);
  double open2 = 0.0, half2 = 0.0;
  for (int i = 0; i < 20'000; ++i) {
    const double sky = i % 2 == 0 ? 1.0 : 0.5;
    const auto fix = sensor.measure(i * kSecond_ns, Isometry3d::Identity(), sky);
    ASSERT_TRUE(fix);
    (i % 2 == 0 ? open2 : half2) += 0.5 * fix->position_m.head<2>().squaredNorm() / 10'000;
    EXPECT_NEAR(fix->sigma_level_m, 0.5 / sky, 1e-12) << "and it says so";
  }
  EXPECT_NEAR(std::sqrt(open2), 0.5, 0.02);
  EXPECT_NEAR(std::sqrt(half2), 1.0, 0.04);
  for (const double sky : {0.29, 0.0, -1.0, std::nan("")}) {
    EXPECT_FALSE(sensor.measure(20'001 * kSecond_ns, Isometry3d::Identity(), sky)) << sky;
  }
  EXPECT_TRUE(sensor.measure(20'002 * kSecond_ns, Isometry3d::Identity(), 0.3));
}

TEST(GnssSensor, TheDefaultIsLagrsThreeMetres) {
  double sum2 = 0.0;
  constexpr int kReceivers = 3000;
  GnssSensorOptions options;
  for (std::uint64_t seed = 0; seed < kReceivers; ++seed) {
    GnssSensor sensor(options, Vector3d::Zero(), seed);
    const auto fix = sensor.measure(0, Isometry3d::Identity());
    ASSERT_TRUE(fix);
    sum2 += 0.5 * fix->position_m.head<2>().squaredNorm();
    EXPECT_NEAR(fix->sigma_level_m, 3.0, 0.02);
  }
  EXPECT_NEAR(std::sqrt(sum2 / kReceivers), 3.0, 4.0 * 3.0 / std::sqrt(4.0 * kReceivers));
}

TEST(GnssSensor, OneSeedOneReceiver) {
  const GnssSensorOptions options;
  EXPECT_EQ(errors_of(options, 500, 1.0, 6), errors_of(options, 500, 1.0, 6));
  EXPECT_NE(errors_of(options, 500, 1.0, 6), errors_of(options, 500, 1.0, 7));
}

TEST(GnssSensorOptions, WhatCannotBeIsRefused) {
  EXPECT_TRUE(check_options(GnssSensorOptions{}));
  for (const char* name :
       {"white_m", "drift_m", "drift_time_s", "up_factor", "drop_outs_per_h", "drop_out_s",
        "jumps_per_h", "jump_m", "jump_s", "least_sky", "report", "channel.loss"}) {
    GnssSensorOptions options;
    for (const char* text : {"-1", "nan", "inf", "x"}) {
      EXPECT_FALSE(describe(options).set(name, text)) << name << " " << text;
    }
    EXPECT_EQ(options, GnssSensorOptions{});
  }
}

}  // namespace
}  // namespace tread
