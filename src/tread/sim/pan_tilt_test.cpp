#include "tread/sim/pan_tilt.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "tread/sim/random.hpp"

namespace tread {
namespace {

constexpr double kDegree = M_PI / 180.0;
constexpr double kEps = 1e-9;

std::int64_t ns(double seconds) {
  return std::llround(1e9 * seconds);
}

TEST(PanTilt, AtFullSpeedATickIsTwoPointFourTwoDegrees) {
  PanTilt head(PanTiltOptions{});
  head.command({100.0 * kDegree, 0.0});
  head.advance(ns(0.3));
  std::vector<double> pans;
  for (int tick = 20; tick < 30; ++tick) {
    head.advance(ns(tick / 60.0));
    pans.push_back(head.pan_rad() / kDegree);
  }
  for (std::size_t i = 1; i < pans.size(); ++i) {
    EXPECT_NEAR(pans[i] - pans[i - 1], 145.0 / 60.0, 1e-6);
    EXPECT_NEAR(pans[i] - pans[i - 1], 2.42, 0.005);
  }
  EXPECT_NEAR(head.pan_rate_rad_per_s(), 145.0 * kDegree, kEps);
}

TEST(PanTilt, NothingMovesBeforeTheTickAndTheDeadTime) {
  PanTiltOptions options;
  options.dead_time_s = 0.030;
  PanTilt head(options);
  head.advance(ns(0.020));
  head.command({0.5, 0.2});  // taken at the tick at 33.3 ms
  head.advance(ns(2.0 / 60.0 + 0.030));
  EXPECT_EQ(head.pan_rad(), 0.0);
  EXPECT_EQ(head.tilt_rad(), 0.0);
  head.advance(ns(2.0 / 60.0 + 0.032));
  EXPECT_NEAR(head.pan_rad(), 0.5 * 60.0 * 0.002 * 0.002, 1e-9) << "a t^2 / 2";
  EXPECT_NEAR(head.tilt_rad(), 0.5 * 60.0 * 0.002 * 0.002, 1e-9);
  head.advance(ns(3.0));
  EXPECT_EQ(head.pan_rad(), 0.5);
  EXPECT_EQ(head.tilt_rad(), 0.2);
  EXPECT_EQ(head.pan_rate_rad_per_s(), 0.0);
}

TEST(PanTilt, OnlyTheLastCommandBeforeATickCounts) {
  PanTilt head(PanTiltOptions{});
  head.advance(ns(0.001));
  head.command({1.0, 0.0});
  head.command({-1.0, 0.0});
  head.advance(ns(0.1));
  EXPECT_LT(head.pan_rad(), 0.0);
}

TEST(PanTilt, ALongWayTakesTheTimeOfTheTrapezium) {
  PanTiltOptions options;
  options.dead_time_s = 0.0;
  PanTilt head(options);
  head.command({2.0, 0.0});
  const double v = options.speed_rad_per_s, a = options.acceleration_rad_per_s2;
  const double arrival_s = 2.0 / v + v / a;
  head.advance(ns(arrival_s / 2.0));
  EXPECT_NEAR(head.pan_rad(), 1.0, 1e-8) << "half way at half time";
  head.advance(ns(arrival_s - 0.001));
  EXPECT_NEAR(head.pan_rad(), 2.0 - 0.5 * a * 1e-6, 1e-8);
  head.advance(ns(arrival_s) + 1);
  EXPECT_EQ(head.pan_rad(), 2.0);
}

TEST(PanTilt, StaysWithinItsLimitsNoseDownAndUpApart) {
  PanTilt head(PanTiltOptions{});
  head.command({10.0, 10.0});
  head.advance(ns(5.0));
  EXPECT_NEAR(head.pan_rad() / kDegree, 159.0, kEps);
  EXPECT_NEAR(head.tilt_rad() / kDegree, 47.0, kEps) << "nose down";
  head.command({-10.0, -10.0});
  head.advance(ns(10.0));
  EXPECT_NEAR(head.pan_rad() / kDegree, -159.0, kEps);
  EXPECT_NEAR(head.tilt_rad() / kDegree, -31.0, kEps) << "nose up";
  const PanTilt beyond(PanTiltOptions{}, {0.0, 9.0});
  EXPECT_NEAR(beyond.tilt_rad() / kDegree, 47.0, kEps);
}

TEST(PanTilt, WhatIsNotFiniteLeavesTheAxisAsItWas) {
  PanTilt head(PanTiltOptions{});
  head.command({0.5, 0.3});
  head.command({std::numeric_limits<double>::quiet_NaN(), 0.1});
  head.command({0.7, std::numeric_limits<double>::infinity()});
  head.advance(ns(5.0));
  EXPECT_EQ(head.pan_rad(), 0.7);
  EXPECT_EQ(head.tilt_rad(), 0.1);
}

// Random commands at random times; what it does in between is looked at every millisecond.
TEST(PanTilt, NeverFasterNorHarderNorFartherThanItCan) {
  const PanTiltOptions options;
  const double v = options.speed_rad_per_s, a = options.acceleration_rad_per_s2;
  PanTilt head(options);
  Random random(4);
  double pan = 0.0, rate = 0.0, fastest = 0.0;
  for (int ms = 1; ms <= 60'000; ++ms) {
    if (random.uniform() < 0.01) {
      head.command({random.uniform(-4.0, 4.0), random.uniform(-1.0, 1.0)});
    }
    head.advance(ms * 1'000'000LL);
    EXPECT_LE(std::abs(head.pan_rad()), options.pan_limit_rad);
    EXPECT_LE(head.tilt_rad(), options.nose_down_limit_rad);
    EXPECT_GE(head.tilt_rad(), -options.nose_up_limit_rad);
    ASSERT_LE(std::abs(head.pan_rate_rad_per_s()), v * (1.0 + kEps)) << ms;
    ASSERT_LE(std::abs(head.pan_rate_rad_per_s() - rate), 0.001 * a * (1.0 + 1e-6)) << ms;
    // Rate and position belong together.
    ASSERT_NEAR(head.pan_rad() - pan, 0.0005 * (rate + head.pan_rate_rad_per_s()), 0.5e-6 * a)
        << ms;
    pan = head.pan_rad();
    rate = head.pan_rate_rad_per_s();
    fastest = std::max(fastest, std::abs(rate));
  }
  EXPECT_NEAR(fastest, v, kEps) << "it did use what it can";
}

TEST(PanTilt, WhenItIsAskedDoesNotMatter) {
  const auto run = [](int step_ms) {
    PanTilt head(PanTiltOptions{});
    std::vector<double> seen;
    for (int ms = 0; ms <= 3000; ms += step_ms) {
      head.advance(ms * 1'000'000LL);
      if (ms % 100 == 0) {
        seen.insert(seen.end(), {head.pan_rad(), head.tilt_rad(), head.pan_rate_rad_per_s()});
      }
      if (ms % 300 == 0) head.command({(ms / 300 % 3 - 1) * 1.5, (ms / 300 % 2) * 0.5});
    }
    return seen;
  };
  EXPECT_EQ(run(1), run(100));
  EXPECT_EQ(run(5), run(50));
}

// METHODS of head stabilisation reckon with what a dead time leaves of a sine: here the unit
// follows one slow enough not to be limited, and lags by dead time and half a tick.
TEST(PanTilt, FollowsASineWithItsDelay) {
  PanTiltOptions options;
  options.acceleration_rad_per_s2 = 1000.0;
  PanTilt head(options);
  constexpr double kAmplitude = 0.1, kW = 2.0 * M_PI * 1.65;
  double s = 0.0, c = 0.0, count = 0.0;
  for (int ms = 0; ms < 20'000; ++ms) {
    const double t = 1e-3 * ms;
    head.command({0.0, kAmplitude * std::sin(kW * t)});
    head.advance(ms * 1'000'000LL);
    if (ms < 2000) continue;
    s += head.tilt_rad() * std::sin(kW * t);
    c += head.tilt_rad() * std::cos(kW * t);
    count += 0.5;
  }
  const double gain = std::hypot(s, c) / count / kAmplitude;
  const double delay_s = -std::atan2(c, s) / kW;
  EXPECT_NEAR(gain, 1.0, 0.03);
  EXPECT_NEAR(delay_s, 0.030 + 0.5 / 60.0, 0.012) << "and the way of one tick";
  EXPECT_GT(delay_s, 0.030);
}

TEST(PanTilt, TellsItsAnglesInSteps) {
  PanTiltOptions options;
  options.step_rad = 0.01;
  const PanTilt head(options, {0.1234, -0.3333});
  EXPECT_NEAR(head.measure().pan_rad, 0.12, 1e-12);
  EXPECT_NEAR(head.measure().tilt_rad, -0.33, 1e-12);
  EXPECT_EQ(head.pan_rad(), 0.1234);
}

TEST(PanTiltOptions, WhatCannotBeIsRefused) {
  EXPECT_TRUE(check_options(PanTiltOptions{}));
  PanTiltOptions options;
  OptionSet set = describe(options);
  for (const OptionField& field : std::vector<OptionField>(set.fields())) {
    for (const char* text : {"-1", "nan", "inf", "x"}) {
      EXPECT_FALSE(set.set(field.name, text)) << field.name << " " << text;
    }
  }
}

}  // namespace
}  // namespace tread
