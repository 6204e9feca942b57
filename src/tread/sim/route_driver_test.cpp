#include "tread/sim/route_driver.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace tread {
namespace {

using Eigen::Vector2d;

World along(const std::vector<Vector2d>& route) {
  World world;
  world.route_m = route;
  world.goal_m = route.empty() ? Vector2d::Zero() : route.back();
  return world;
}

// A point that does what it is told, exactly.
struct Driven {
  double seconds = 0.0;
  Vector2d end;
  double farthest_off_m = 0.0;
};
Driven drive(RouteDriver& driver, const std::vector<Vector2d>& corners, double speed_share = 1.0) {
  constexpr double kStep_s = 0.02;
  Vector2d p = Vector2d::Zero();
  double yaw = 0.0;
  Driven driven;
  std::size_t passed = 0;
  while (!driver.done() && driven.seconds < 300.0) {
    Isometry3d T = Isometry3d::Identity();
    T.linear() = rotation_from_yaw_pitch_roll(yaw, 0.0, 0.0);
    T.translation() << p, 0.0;
    const DriveCommand command = driver.drive(driven.seconds, T);
    yaw += kStep_s * speed_share * command.yaw_rate_rad_per_s;
    p += kStep_s * speed_share * command.speed_m_per_s * Vector2d(std::cos(yaw), std::sin(yaw));
    driven.seconds += kStep_s;
    if (passed < corners.size() && (p - corners[passed]).norm() < 0.6) ++passed;
  }
  EXPECT_EQ(passed, corners.size()) << "it cut a corner";
  driven.end = p;
  return driven;
}

TEST(RouteDriver, FollowsCornersToTheEnd) {
  const std::vector<Vector2d> route{{4, 0}, {4, 3}, {0, 3}};
  RouteDriver driver(along(route), {});
  EXPECT_NEAR(driver.length_m(), 11.0, 1e-12);
  const Driven driven = drive(driver, {{4, 0}, {4, 3}});
  EXPECT_TRUE(driver.arrived());
  EXPECT_LT((driven.end - Vector2d(0, 3)).norm(), 0.3);
  EXPECT_NEAR(driven.seconds, 11.0 / 0.5, 8.0);
}

TEST(RouteDriver, ARoundTripIsDrivenAndEndsWhereItBegan) {
  const std::vector<Vector2d> route{{3, 0}, {3, 3}, {0, 3}, {0, 0}};
  RouteDriver driver(along(route), {});
  const Driven driven = drive(driver, {{3, 0}, {3, 3}, {0, 3}});
  EXPECT_TRUE(driver.arrived());
  EXPECT_LT(driven.end.norm(), 0.3);
}

TEST(RouteDriver, TurnsRoundWhereTheRouteDoes) {
  RouteDriver driver(along({{4, 0}, {1, 0}}), {});
  const Driven driven = drive(driver, {{4, 0}});
  EXPECT_TRUE(driver.arrived());
  EXPECT_LT((driven.end - Vector2d(1, 0)).norm(), 0.3);
}

TEST(RouteDriver, GivesUpWhenItComesNoFurther) {
  RouteDriver driver(along({{4, 0}}), {});
  const Driven driven = drive(driver, {}, 0.0);
  EXPECT_TRUE(driver.stuck());
  EXPECT_FALSE(driver.arrived());
  EXPECT_NEAR(driven.seconds, 1.0 + 6.0, 0.1);
}

TEST(RouteDriver, StandsStillFirstAndAtTheEnd) {
  RouteDriver driver(along({{4, 0}}), {});
  EXPECT_EQ(driver.drive(0.5, Isometry3d::Identity()).speed_m_per_s, 0.0);
  EXPECT_GT(driver.drive(1.5, Isometry3d::Identity()).speed_m_per_s, 0.0);
}

}  // namespace
}  // namespace tread
