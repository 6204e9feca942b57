#include "tread/robot/rover_model.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace tread {
namespace {

TEST(RoverModel, WheelSpeedsAreThoseOfRolling) {
  const RoverModelOptions options;
  const WheelSpeeds straight = wheel_speeds(options, {0.8, 0.0});
  EXPECT_DOUBLE_EQ(straight.left_rad_per_s * options.wheel_radius_m, 0.8);
  EXPECT_DOUBLE_EQ(straight.right_rad_per_s * options.wheel_radius_m, 0.8);
  const WheelSpeeds left = wheel_speeds(options, {0.0, 0.5});
  EXPECT_NEAR(left.right_rad_per_s * options.wheel_radius_m, 0.5 * 0.55 / 2.0, 1e-12);
  EXPECT_NEAR(left.left_rad_per_s, -left.right_rad_per_s, 1e-12);
}

TEST(RoverModel, WheelSpeedsAndDriveAreInverse) {
  for (const auto drive :
       {RoverModelOptions::Drive::kDifferential, RoverModelOptions::Drive::kSkid}) {
    RoverModelOptions options;
    options.drive = drive;
    for (const double v : {-1.2, -0.3, 0.0, 0.7}) {
      for (const double w : {-1.0, 0.0, 0.4}) {
        const DriveCommand back = drive_of(options, wheel_speeds(options, {v, w}));
        EXPECT_NEAR(back.speed_m_per_s, v, 1e-12);
        EXPECT_NEAR(back.yaw_rate_rad_per_s, w, 1e-12);
      }
    }
  }
}

TEST(RoverModel, CommandsAreCutToTheTopSpeeds) {
  const RoverModelOptions options;
  const DriveCommand cut = limited(options, {5.0, -3.0});
  EXPECT_EQ(cut.speed_m_per_s, 1.2);
  EXPECT_EQ(cut.yaw_rate_rad_per_s, -1.0);
  EXPECT_EQ(limited(options, {-0.5, 0.25}).speed_m_per_s, -0.5);
}

TEST(RoverModel, FourWheelsMustScrubToTurn) {
  RoverModelOptions options;
  options.drive = RoverModelOptions::Drive::kSkid;
  options.track_m = 0.5;
  options.wheelbase_m = 0.5;
  EXPECT_NEAR(turning_track_m(options), 1.0, 1e-12);
  EXPECT_NEAR(front_axle_m(options), 0.25, 1e-12);
  options.drive = RoverModelOptions::Drive::kDifferential;
  EXPECT_EQ(turning_track_m(options), 0.5);
  EXPECT_EQ(front_axle_m(options), 0.0);
}

TEST(RoverModel, MotorsFadeTowardsTheirFreeSpeed) {
  const RoverModelOptions options;
  const double free = options.free_speed_m_per_s / options.wheel_radius_m;
  EXPECT_NEAR(motor_torque_limit_nm(options, 0.0, true), 45.0, 1e-9);
  EXPECT_NEAR(motor_torque_limit_nm(options, 0.5 * free, true), 45.0, 1e-9);
  EXPECT_NEAR(motor_torque_limit_nm(options, 0.75 * free, true), 22.5, 1e-9);
  EXPECT_EQ(motor_torque_limit_nm(options, 1.2 * free, true), 0.0);
  EXPECT_NEAR(motor_torque_limit_nm(options, 1.2 * free, false), -45.0, 1e-9) << "it can brake";
}

TEST(RoverModel, OptionsAreChecked) {
  RoverModelOptions options;
  EXPECT_TRUE(check_options(options));
  OptionSet set = describe(options);
  ASSERT_TRUE(set.set("drive", "skid"));
  EXPECT_EQ(options.drive, RoverModelOptions::Drive::kSkid);
  EXPECT_FALSE(set.set("drive", "tracks"));
  options.overhang_m = 0.1;
  ASSERT_FALSE(check_options(options));
  EXPECT_NE(check_options(options).error().message().find("overhang_m"), std::string::npos);
  options = {};
  options.mass_kg = 10.0;
  EXPECT_FALSE(check_options(options));
  options = {};
  options.centre_behind_m = 0.7;
  EXPECT_FALSE(check_options(options));
}

}  // namespace
}  // namespace tread
