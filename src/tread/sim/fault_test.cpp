#include "tread/sim/fault.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace tread {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

TEST(Fault, NamesOfKindsGoBothWays) {
  const auto names = fault_kind_names();
  EXPECT_EQ(names.size(), 6U);
  for (const std::string& name : names) {
    const auto kind = fault_kind_named(name);
    ASSERT_TRUE(kind) << name;
    EXPECT_EQ(name_of(*kind), name);
  }
  EXPECT_EQ(fault_kind_named("clock_jump"), FaultKind::kClockJump);
  EXPECT_FALSE(fault_kind_named("clock jump"));
}

TEST(Fault, EveryKindIsTakenWhereItMakesSense) {
  const Fault faults[] = {{"imu", FaultKind::kDead, 0.0, kInfinity, 0.0},
                          {"gnss", FaultKind::kStuck, 1.0, 2.0, 0.0},
                          {"bump", FaultKind::kFrozen, 1.0, 2.0, 0.0},
                          {"wheels", FaultKind::kSaturated, 1.0, 2.0, 1.0},
                          {"legs", FaultKind::kShuffled, 1.0, 2.0, 0.5},
                          {"head", FaultKind::kClockJump, 1.0, 2.0, -3.0},
                          {"camera1", FaultKind::kSaturated, 0.0, 9.0, 0.5}};
  const Status done = check_faults(faults, 2);
  EXPECT_TRUE(done) << done.error().message();
}

TEST(Fault, WhatCannotBeIsRefusedByName) {
  struct Case {
    Fault fault;
    std::string where, says;
  };
  const Case cases[] = {
      {{"imo", FaultKind::kDead, 0.0, 1.0, 0.0}, ".sensor", "imu"},
      {{"camera2", FaultKind::kDead, 0.0, 1.0, 0.0}, ".sensor", "camera"},
      {{"", FaultKind::kDead, 0.0, 1.0, 0.0}, ".sensor", "gnss, wheels"},
      {{"imu", FaultKind::kDead, -1.0, 1.0, 0.0}, ".from_s", "0 or more"},
      {{"imu", FaultKind::kDead, kNone, 1.0, 0.0}, ".from_s", "0 or more"},
      {{"imu", FaultKind::kDead, 3.0, 3.0, 0.0}, ".until_s", "after"},
      {{"imu", FaultKind::kDead, 3.0, kNone, 0.0}, ".until_s", "after"},
      {{"imu", FaultKind::kDead, 0.0, 1.0, 0.5}, ".amount", "none"},
      {{"imu", FaultKind::kSaturated, 0.0, 1.0, 0.0}, ".amount", "share"},
      {{"imu", FaultKind::kSaturated, 0.0, 1.0, 1.1}, ".amount", "share"},
      {{"imu", FaultKind::kSaturated, 0.0, 1.0, kNone}, ".amount", "share"},
      {{"gnss", FaultKind::kSaturated, 0.0, 1.0, 0.5}, ".kind", "gnss"},
      {{"imu", FaultKind::kShuffled, 0.0, 1.0, 0.0}, ".amount", "seconds"},
      {{"imu", FaultKind::kClockJump, 0.0, 1.0, 0.0}, ".amount", "seconds"},
      {{"imu", FaultKind::kClockJump, 0.0, 1.0, kInfinity}, ".amount", "seconds"},
  };
  for (const Case& c : cases) {
    const Fault faults[] = {{"imu", FaultKind::kDead, 0.0, 1.0, 0.0}, c.fault};
    const Status done = check_faults(faults, 2);
    ASSERT_FALSE(done) << c.where << c.says;
    EXPECT_EQ(done.error().where, "faults[1]" + c.where);
    EXPECT_NE(done.error().message().find(c.says), std::string::npos) << done.error().message();
  }
}

TEST(Fault, AScheduleHoldsOnlyWhatIsOfItsSensor) {
  const Fault faults[] = {{"imu", FaultKind::kSaturated, 1.0, 4.0, 0.5},
                          {"imu", FaultKind::kSaturated, 2.0, 3.0, 0.1},
                          {"gnss", FaultKind::kDead, 0.0, kInfinity, 0.0},
                          {"imu", FaultKind::kClockJump, 5.0, kInfinity, 2.0},
                          {"imu", FaultKind::kClockJump, 6.0, 7.0, -0.5}};
  const FaultSchedule imu(faults, "imu");
  EXPECT_FALSE(imu.has(FaultKind::kDead));
  EXPECT_EQ(imu.find(FaultKind::kSaturated, 0.999), nullptr);
  EXPECT_EQ(imu.find(FaultKind::kSaturated, 1.0)->amount, 0.5);
  EXPECT_EQ(imu.find(FaultKind::kSaturated, 2.5)->amount, 0.1) << "the last of two";
  EXPECT_EQ(imu.find(FaultKind::kSaturated, 3.0)->amount, 0.5);
  EXPECT_EQ(imu.find(FaultKind::kSaturated, 4.0), nullptr) << "the end is outside";
  EXPECT_EQ(imu.clock_jump_s(4.9), 0.0);
  EXPECT_EQ(imu.clock_jump_s(5.0), 2.0);
  EXPECT_EQ(imu.clock_jump_s(6.5), 1.5);
  EXPECT_EQ(imu.clock_jump_s(1e6), 2.0);
  EXPECT_FALSE(FaultSchedule().has(FaultKind::kDead));
}

}  // namespace
}  // namespace tread
