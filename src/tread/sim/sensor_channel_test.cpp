#include "tread/sim/sensor_channel.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

namespace tread {
namespace {

constexpr double kForEver = std::numeric_limits<double>::infinity();
constexpr std::int64_t kSecond_ns = 1'000'000'000;

SensorChannelSetup setup_of(std::span<const Fault> faults = {}, std::uint64_t seed = 1) {
  return {"head", seed, faults, 0};
}

// Sends the number of the sample as its pan angle; gives all that has arrived until an end.
std::vector<HeadState> run(const SensorChannelOptions& options, double seconds,
                           const SensorChannelSetup& setup = setup_of(),
                           std::int64_t step_ns = 10'000'000) {
  SensorChannel<HeadState> channel(options, setup);
  std::vector<HeadState> all;
  int number = 0;
  const auto end_ns = static_cast<std::int64_t>(seconds * 1e9);
  for (std::int64_t now_ns = 0; now_ns <= end_ns; now_ns += step_ns) {
    while (const auto time_ns = channel.due(now_ns)) {
      channel.push(*time_ns, {0, static_cast<double>(number++), 0.25});
    }
    for (const HeadState& state : channel.arrived(now_ns)) all.push_back(state);
  }
  return all;
}

std::vector<int> numbers_of(const std::vector<HeadState>& states) {
  std::vector<int> numbers;
  for (const HeadState& state : states) numbers.push_back(static_cast<int>(state.pan_rad));
  return numbers;
}

TEST(SensorChannel, SamplesAtItsRateWithoutDrift) {
  SensorChannelOptions options;
  options.rate_hz = 60.0;
  options.phase = 0.5;
  ChannelTiming timing(options, setup_of());
  EXPECT_FALSE(timing.due(8'333'332));
  EXPECT_EQ(timing.due(8'333'333).value(), 8'333'333);
  EXPECT_FALSE(timing.due(8'333'333)) << "given once";
  std::int64_t last_ns = 0, count = 1;
  while (const auto time_ns = timing.due(3600 * kSecond_ns)) {
    last_ns = *time_ns;
    ++count;
  }
  EXPECT_EQ(count, 60 * 3600);
  EXPECT_EQ(last_ns, 3600 * kSecond_ns - 8'333'333) << "an hour later still in step";
}

TEST(SensorChannel, StampsAreOfItsClock) {
  SensorChannelOptions options;
  options.clock_offset_s = 0.25;
  options.clock_drift_ppm = 100.0;
  const Fault jump[] = {{"head", FaultKind::kClockJump, 5.0, kForEver, -2.0}};
  SensorChannelSetup setup = setup_of(jump);
  setup.epoch_ns = 1'700'000'000 * kSecond_ns;
  const ChannelTiming timing(options, setup);
  EXPECT_EQ(timing.stamp_ns(0), setup.epoch_ns + 250'000'000);
  EXPECT_EQ(timing.stamp_ns(4 * kSecond_ns), setup.epoch_ns + 4'250'400'000);
  EXPECT_EQ(timing.stamp_ns(10 * kSecond_ns), setup.epoch_ns + 8'251'000'000) << "jumped back by 2";
}

TEST(SensorChannel, ArrivesAfterLatencyAndJitterInOrder) {
  SensorChannelOptions options;
  options.rate_hz = 100.0;
  options.latency_s = 0.05;
  SensorChannel<HeadState> exact(options, setup_of());
  exact.push(*exact.due(0), {});
  EXPECT_TRUE(exact.arrived(49'999'999).empty());
  EXPECT_EQ(exact.arrived(50'000'000).size(), 1U);
  EXPECT_TRUE(exact.arrived(kSecond_ns).empty()) << "given once";

  options.jitter_s = 0.03;  // of three periods
  ChannelTiming timing(options, setup_of());
  std::int64_t last_ns = 0;
  double sum_s = 0.0;
  for (int i = 0; i < 10'000; ++i) {
    const std::int64_t time_ns = *timing.due(1000 * kSecond_ns);
    const std::int64_t arrival_ns = timing.arrival_ns(time_ns).value();
    EXPECT_GE(arrival_ns, last_ns);
    EXPECT_GE(arrival_ns, time_ns + 50'000'000);
    EXPECT_LE(arrival_ns, time_ns + 80'000'000);
    last_ns = arrival_ns;
    sum_s += 1e-9 * static_cast<double>(arrival_ns - time_ns);
  }
  EXPECT_GT(sum_s / 10'000, 0.065) << "who waits for another comes later than the mean of 15 ms";
  const auto all = numbers_of(run(options, 3.0));
  EXPECT_TRUE(std::is_sorted(all.begin(), all.end()));
}

TEST(SensorChannel, LosesItsShareAndNoMore) {
  SensorChannelOptions options;
  options.rate_hz = 1000.0;
  options.loss = 0.1;
  const auto some = run(options, 20.0);
  EXPECT_NEAR(static_cast<double>(some.size()), 18'000.0, 4.0 * std::sqrt(20'000 * 0.1 * 0.9));
  options.loss = 1.0;
  EXPECT_TRUE(run(options, 1.0).empty());
  options.loss = 0.0;
  EXPECT_EQ(run(options, 1.0).size(), 1001U);
}

TEST(SensorChannel, TheStepsOfTheSimulatorDoNotMatter) {
  SensorChannelOptions options;
  options.rate_hz = 37.0;
  options.latency_s = 0.02;
  options.jitter_s = 0.05;
  options.loss = 0.2;
  const auto fine = run(options, 10.0, setup_of(), 1'000'000);
  const auto coarse = run(options, 10.0, setup_of(), 1'000'000'000);
  ASSERT_GT(fine.size(), 200U);
  ASSERT_EQ(fine.size(), coarse.size());
  for (std::size_t i = 0; i < fine.size(); ++i) {
    EXPECT_EQ(fine[i].stamp_ns, coarse[i].stamp_ns);
    EXPECT_EQ(fine[i].pan_rad, coarse[i].pan_rad);
  }
  EXPECT_NE(numbers_of(fine), numbers_of(run(options, 10.0, setup_of({}, 2)))) << "another seed";
}

// 10 Hz; the fault is from 1 s to 2 s: samples 10 to 19.
std::vector<HeadState> with_fault(FaultKind kind, double amount = 0.0, double from_s = 1.0) {
  const Fault faults[] = {{"head", kind, from_s, from_s + 1.0, amount},
                          {"imu", FaultKind::kDead, 0.0, kForEver, 0.0}};
  SensorChannelOptions options;
  options.rate_hz = 10.0;
  return run(options, 3.0, setup_of(faults));
}

TEST(SensorChannel, ADeadSensorSendsNothing) {
  const auto numbers = numbers_of(with_fault(FaultKind::kDead));
  EXPECT_EQ(numbers.size(), 21U);
  EXPECT_EQ(numbers[9], 9);
  EXPECT_EQ(numbers[10], 20);
}

TEST(SensorChannel, AStuckSensorRepeatsItsValuesWithNewStamps) {
  const auto states = with_fault(FaultKind::kStuck);
  ASSERT_EQ(states.size(), 31U);
  for (std::size_t i = 0; i < states.size(); ++i) {
    EXPECT_EQ(states[i].stamp_ns, static_cast<std::int64_t>(i) * 100'000'000);
    EXPECT_EQ(states[i].pan_rad, i >= 10 && i < 20 ? 9.0 : static_cast<double>(i));
  }
  const auto from_start = with_fault(FaultKind::kStuck, 0.0, 0.0);
  EXPECT_EQ(from_start[9].pan_rad, 0.0) << "no sample before: the first one";
  EXPECT_EQ(from_start[10].pan_rad, 10.0);
}

TEST(SensorChannel, AFrozenSensorSendsTheVerySameSample) {
  const auto states = with_fault(FaultKind::kFrozen);
  ASSERT_EQ(states.size(), 31U);
  for (std::size_t i = 10; i < 20; ++i) {
    EXPECT_EQ(states[i].stamp_ns, 900'000'000);
    EXPECT_EQ(states[i].pan_rad, 9.0);
  }
  EXPECT_EQ(states[20].pan_rad, 20.0);
}

TEST(SensorChannel, ShuffledSamplesComeOutOfOrderAndAllOfThem) {
  const auto numbers = numbers_of(with_fault(FaultKind::kShuffled, 0.5));
  ASSERT_EQ(numbers.size(), 31U);
  EXPECT_FALSE(std::is_sorted(numbers.begin(), numbers.end()));
  EXPECT_EQ(std::set<int>(numbers.begin(), numbers.end()).size(), 31U);
  EXPECT_TRUE(std::is_sorted(numbers.begin(), numbers.begin() + 10)) << "in order before";
  EXPECT_TRUE(std::is_sorted(numbers.end() - 5, numbers.end())) << "and after";
}

TEST(SensorChannel, AClockThatJumpedGoesBackAtTheEndOfTheFault) {
  const auto states = with_fault(FaultKind::kClockJump, 0.5);
  EXPECT_EQ(states[9].stamp_ns, 900'000'000);
  EXPECT_EQ(states[10].stamp_ns, 1'500'000'000);
  EXPECT_EQ(states[20].stamp_ns, 2'000'000'000);
}

TEST(SensorChannel, ASaturatedSensorClipsToAShareOfItsRange) {
  const Fault faults[] = {{"imu", FaultKind::kSaturated, 1.0, 2.0, 0.5}};
  ImuSample full;
  full.gyro_rad_per_s.setConstant(4.0);
  full.accel_m_per_s2.setConstant(40.0);
  SensorChannelOptions options;
  options.rate_hz = 1.0;
  SensorChannel<ImuSample> channel(options, {"imu", 1, faults, 0}, full);
  while (const auto time_ns = channel.due(2 * kSecond_ns)) {
    channel.push(*time_ns, {0, {3.0, -3.0, 1.0}, {9.81, -30.0, 25.0}});
  }
  const auto samples = channel.arrived(2 * kSecond_ns);
  ASSERT_EQ(samples.size(), 3U);
  EXPECT_EQ(samples[1].gyro_rad_per_s, Eigen::Vector3d(2.0, -2.0, 1.0));
  EXPECT_EQ(samples[1].accel_m_per_s2, Eigen::Vector3d(9.81, -20.0, 20.0));
  EXPECT_EQ(samples[2].gyro_rad_per_s, Eigen::Vector3d(3.0, -3.0, 1.0));
}

TEST(SensorChannel, AFaultChangesNothingButItsOwnSamples) {
  SensorChannelOptions options;
  options.rate_hz = 50.0;
  options.jitter_s = 0.01;
  options.loss = 0.3;
  const Fault faults[] = {{"head", FaultKind::kDead, 1.0, 2.0, 0.0}};
  const auto whole = numbers_of(run(options, 4.0));
  std::vector<int> expected;
  std::copy_if(whole.begin(), whole.end(), std::back_inserter(expected),
               [](int number) { return number < 50 || number >= 100; });
  EXPECT_LT(expected.size(), whole.size());
  EXPECT_EQ(numbers_of(run(options, 4.0, setup_of(faults))), expected);
}

StereoFrame grey_frame(const std::string& name, std::uint8_t value) {
  StereoFrame frame;
  frame.name = name;
  frame.left = Image<std::uint8_t>(4, 3, value);
  frame.right = Image<std::uint8_t>(4, 3, static_cast<std::uint8_t>(value / 2));
  frame.left_colour = Image<Rgb>(4, 3, Rgb{value, 10, 200});
  return frame;
}

TEST(SensorChannel, CamerasStickAndSaturateToo) {
  const Fault faults[] = {{"camera0", FaultKind::kStuck, 1.0, 2.0, 0.0},
                          {"camera0", FaultKind::kSaturated, 2.0, 3.0, 0.2}};
  SensorChannelOptions options;
  options.rate_hz = 1.0;
  SensorChannel<StereoFrame> channel(options, {"camera0", 1, faults, 0});
  for (int i = 0; i < 4; ++i) {
    channel.push(*channel.due(4 * kSecond_ns),
                 grey_frame(std::to_string(i), static_cast<std::uint8_t>(100 + i)));
  }
  const auto frames = channel.arrived(4 * kSecond_ns);
  ASSERT_EQ(frames.size(), 4U);
  EXPECT_EQ(frames[1].left(0, 0), 100);
  EXPECT_EQ(frames[1].left_colour(0, 0).r, 100);
  EXPECT_EQ(frames[1].name, "1");
  EXPECT_EQ(frames[1].stamp_ns, kSecond_ns);
  EXPECT_EQ(frames[2].left(3, 2), 51);
  EXPECT_EQ(frames[2].right(3, 2), 51);
  EXPECT_EQ(frames[2].left_colour(3, 2), (Rgb{51, 10, 51}));
  EXPECT_EQ(frames[3].left(3, 2), 103);
}

TEST(SensorChannel, ClippingKnowsEveryKindOfValue) {
  WheelSample wheels{0, 100.0, -100.0, 30.0, -30.0};
  clip_values(wheels, {0, 0.0, 0.0, 20.0, 40.0}, 0.5);
  EXPECT_EQ(wheels.left_rad, 100.0) << "an encoder counts on";
  EXPECT_EQ(wheels.left_current_a, 10.0);
  EXPECT_EQ(wheels.right_current_a, -20.0);
  LegSample legs, full;
  legs.position_rad.fill(2.0);
  legs.velocity_rad_per_s.fill(-9.0);
  legs.torque_nm.fill(99.0);
  legs.foot_force_n.fill({-500.0, 0.0, 700.0});
  full.velocity_rad_per_s.fill(12.0);
  full.foot_force_n.fill({100.0, 100.0, 1000.0});
  clip_values(legs, full, 0.5);
  EXPECT_EQ(legs.position_rad[11], 2.0);
  EXPECT_EQ(legs.velocity_rad_per_s[11], -6.0);
  EXPECT_EQ(legs.torque_nm[11], 99.0) << "a range that is not known clips nothing";
  EXPECT_EQ(legs.foot_force_n[3], Eigen::Vector3d(-50.0, 0.0, 500.0));
}

TEST(SensorChannelOptions, WhatCannotBeIsRefused) {
  EXPECT_TRUE(check_options(SensorChannelOptions{}));
  for (const auto& [name, text] :
       {std::pair("rate_hz", "0"), std::pair("rate_hz", "nan"), std::pair("phase", "1.5"),
        std::pair("latency_s", "-0.1"), std::pair("jitter_s", "-1"), std::pair("loss", "1.01"),
        std::pair("clock_offset_s", "inf"), std::pair("clock_drift_ppm", "1e9")}) {
    SensorChannelOptions options;
    OptionSet set = describe(options);
    EXPECT_FALSE(set.set(name, text)) << name;
  }
  SensorChannelOptions bad;
  bad.rate_hz = -1.0;
  ASSERT_FALSE(check_options(bad));
  EXPECT_NE(check_options(bad).error().message().find("rate_hz"), std::string::npos);
}

}  // namespace
}  // namespace tread
