#include "tread/sim/rover_body.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <thread>

#include "physics_worlds.hpp"

namespace tread {
namespace {

using test::block;
using Drive = RoverModelOptions::Drive;

constexpr double kDegree = std::numbers::pi / 180.0;

std::unique_ptr<RoverBody> rover_on(const World& world, const RobotPlace& place = {},
                                    Drive drive = Drive::kDifferential) {
  RoverModelOptions options;
  options.drive = drive;
  auto rover = RoverBody::place(world, options, place);
  if (!rover) throw std::runtime_error(rover.error().message());
  return std::move(*rover);
}

void run(
    RoverBody& rover, double seconds, const DriveCommand& command,
    const std::function<void()>& look = [] {}) {
  ASSERT_TRUE(rover.command(command));
  const int steps = static_cast<int>(std::lround(seconds / rover.step_s()));
  for (int i = 0; i < steps; ++i) {
    const Status done = rover.step();
    ASSERT_TRUE(done) << done.error().message();
    look();
  }
}

Eigen::Vector3d place_of(const RoverBody& rover) {
  return rover.motion().T_world_body.translation();
}
double yaw_of(const RoverBody& rover) {
  return yaw_pitch_roll(rover.motion().T_world_body.linear()).yaw_rad;
}
// Way by the encoders.
double odometer_m(const RoverBody& rover) {
  const WheelSample wheels = rover.wheels();
  return 0.5 * (wheels.left_rad + wheels.right_rad) * rover.options().wheel_radius_m;
}

// Share of the encoders' way that was lost, driving on at half a metre a second.
double lost_way(const World& world, Drive drive) {
  const auto rover = rover_on(world, {}, drive);
  run(*rover, 1.0, {0.5, 0.0});
  const Eigen::Vector3d start = place_of(*rover);
  const double counted = odometer_m(*rover);
  run(*rover, 4.0, {0.5, 0.0});
  return 1.0 - (place_of(*rover) - start).norm() / (odometer_m(*rover) - counted);
}

TEST(RoverBody, DrivesStraightAsItIsTold) {
  const World world = test::flat_world(Surface::kConcrete);
  for (const Drive drive : {Drive::kDifferential, Drive::kSkid}) {
    const auto rover = rover_on(world, {{-5.0, 1.0}, 0.0}, drive);
    run(*rover, 1.5, {1.0, 0.0});
    const Eigen::Vector3d start = place_of(*rover);
    run(*rover, 5.0, {1.0, 0.0});
    const Eigen::Vector3d end = place_of(*rover);
    EXPECT_NEAR(end.x() - start.x(), 5.0, 0.02 * 5.0);
    EXPECT_NEAR(end.y(), 1.0, 0.02);
    EXPECT_NEAR(yaw_of(*rover), 0.0, 0.01);
    run(*rover, 1.5, {0.0, 0.0});
    EXPECT_LT(rover->motion().velocity_m_per_s.norm(), 1e-3);
    run(*rover, 2.0, {-0.5, 0.0});
    EXPECT_LT(rover->motion().velocity_m_per_s.x(), -0.48);
  }
}

TEST(RoverBody, TurnsAboutTheMiddleOfTheFrontAxle) {
  const World world = test::flat_world(Surface::kConcrete);
  const auto rover = rover_on(world);
  run(*rover, 3.0, {0.0, 0.6});  // casters have swivelled by now
  const Eigen::Vector3d start = place_of(*rover);
  double turned = 0.0, farthest = 0.0;
  run(*rover, 5.0, {0.0, 0.6}, [&] {
    turned += rover->step_s() * rover->motion().rate_rad_per_s.z();
    farthest = std::max(farthest, (place_of(*rover) - start).norm());
  });
  EXPECT_NEAR(turned, 3.0, 0.02 * 3.0);
  EXPECT_LT(farthest, 0.01);
}

TEST(RoverBody, FourWheelsScrubToTurn) {
  const World world = test::flat_world(Surface::kConcrete);
  RoverModelOptions options;
  options.drive = Drive::kSkid;
  options.centre_behind_m = 0.5 * options.wheelbase_m;  // all wheels bear alike
  auto rover = RoverBody::place(world, options, {});
  ASSERT_TRUE(rover);
  run(**rover, 2.0, {0.0, 0.5});
  double turned = 0.0;
  run(**rover, 4.0, {0.0, 0.5},
      [&] { turned += (*rover)->step_s() * (*rover)->motion().rate_rad_per_s.z(); });
  EXPECT_NEAR(turned, 2.0, 0.05 * 2.0);
  EXPECT_LT(place_of(**rover).norm(), 0.05);
}

TEST(RoverBody, EncodersOverestimateTheWayWhereTheGroundIsLoose) {
  const double concrete = lost_way(test::flat_world(Surface::kConcrete), Drive::kDifferential),
               gravel = lost_way(test::flat_world(Surface::kGravel), Drive::kDifferential),
               sand = lost_way(test::flat_world(Surface::kSand), Drive::kDifferential);
  EXPECT_LT(concrete, 0.002);
  EXPECT_GT(gravel, 2.0 * concrete);
  EXPECT_GT(sand, 0.10);
  EXPECT_LT(sand, 0.25);
}

// All four wheels pull alike, so theory is simple: g = (sin a + c cos a) / (mu cos a).
TEST(RoverBody, AndWhereItRises) {
  for (const Surface surface : {Surface::kConcrete, Surface::kGravel, Surface::kSand}) {
    const Footing footing = footing_of(surface);
    for (const double slope : {0.0, 10.0 * kDegree, 15.0 * kDegree}) {
      const double used = (std::tan(slope) + footing.rolling_resistance) / footing.friction;
      const double expected = slip_ratio(footing, used);
      EXPECT_NEAR(lost_way(test::slope_world(slope, surface), Drive::kSkid), expected,
                  0.002 + 0.1 * expected)
          << name_of(surface) << " " << slope;
    }
  }
}

TEST(RoverBody, WheelsSpinWhereFrictionGivesNoMore) {
  const World world = test::slope_world(15.0 * kDegree, Surface::kSand);
  const auto rover = rover_on(world);
  run(*rover, 3.0, {0.8, 0.0});
  EXPECT_GT(odometer_m(*rover), 2.0);
  EXPECT_LT(place_of(*rover).norm(), 0.5);
  EXPECT_GT(rover->slip(true), 0.8);
  EXPECT_GT(rover->slip(false), 0.8);
}

TEST(RoverBody, HoldsOnASlopeWithoutCreeping) {
  for (const double yaw : {0.0, 90.0 * kDegree, 180.0 * kDegree}) {
    const World world = test::slope_world(15.0 * kDegree, Surface::kConcrete);
    const auto rover = rover_on(world, {{0.0, 0.0}, yaw});
    const Eigen::Vector3d start = place_of(*rover);
    run(*rover, 10.0, {});
    EXPECT_LT((place_of(*rover) - start).norm(), 1e-4) << yaw;
  }
}

TEST(RoverBody, SlidesWhereFrictionDoesNotHold) {
  // Friction of sand is 0.5: four braked wheels hold up to 26.6 degrees.
  const World holds = test::slope_world(25.0 * kDegree, Surface::kSand);
  const auto held = rover_on(holds, {}, Drive::kSkid);
  const Eigen::Vector3d start = place_of(*held);
  run(*held, 2.0, {});
  EXPECT_LT((place_of(*held) - start).norm(), 1e-3);
  RoverModelOptions options;
  options.drive = Drive::kSkid;
  const World slides = test::slope_world(29.0 * kDegree, Surface::kSand);
  const auto slid = RoverBody::place(slides, options, {});
  ASSERT_FALSE(slid);
  EXPECT_NE(slid.error().message().find("does not stay"), std::string::npos)
      << slid.error().message();
}

TEST(RoverBody, MotorsDrawWhatTheGroundTakes) {
  const auto current = [](const World& world) {
    const auto rover = rover_on(world);
    run(*rover, 3.0, {0.5, 0.0});
    const WheelSample wheels = rover->wheels();
    EXPECT_NEAR(wheels.left_current_a, wheels.right_current_a, 1.0);
    return wheels.left_current_a + wheels.right_current_a;
  };
  const RoverModelOptions options;
  const double weight = options.mass_kg * 9.81;
  const double per_newton = options.wheel_radius_m / options.torque_nm_per_a;
  EXPECT_NEAR(current(test::flat_world(Surface::kGravel)), 0.05 * weight * per_newton, 0.5);
  const double climb = (std::sin(10.0 * kDegree) + 0.015) * weight * per_newton;
  EXPECT_NEAR(current(test::slope_world(10.0 * kDegree, Surface::kConcrete)), climb, 0.05 * climb);
}

TEST(RoverBody, TheBumperFeelsABox) {
  World world = test::flat_world();
  world.solids = {block(6.5, 0.0, 0.3, 0.5, 0.6, "box")};  // out of reach at first
  const auto rover = rover_on(world);
  EXPECT_FALSE(rover->bumper_pressed());
  double pressed_at = -1.0;
  run(*rover, 7.5, {1.0, 0.0}, [&] {
    if (rover->bumper_pressed() && pressed_at < 0.0) pressed_at = place_of(*rover).x();
  });
  EXPECT_NEAR(pressed_at, 6.2 - rover->options().overhang_m, 0.01);
  EXPECT_TRUE(rover->bumper_pressed());
  EXPECT_LT(place_of(*rover).x(), 6.2 - rover->options().overhang_m + 0.02);
  run(*rover, 1.5, {-0.5, 0.0});
  EXPECT_FALSE(rover->bumper_pressed());
}

TEST(RoverBody, PeoplePushItAndAreFeltButDoNotRollItOver) {
  World world = test::flat_world();
  Person person;
  person.name = "someone";
  person.path_m = {{-4.0, 0.05}, {4.0, 0.05}};
  world.people = {person};
  const auto rover = rover_on(world);
  double most_tilt = 0.0, farthest = 0.0;
  run(*rover, 6.0, {}, [&] {
    most_tilt = std::max(most_tilt, std::acos(rover->motion().T_world_body.linear()(2, 2)));
    farthest = std::max(farthest, place_of(*rover).norm());
  });
  EXPECT_GT(farthest, 0.01);
  EXPECT_LT(most_tilt, 45.0 * kDegree);
  EXPECT_NEAR(rover->motion().T_world_body.linear()(2, 2), 1.0, 0.01);
  world.people.front().path_m = {{2.0, 0.0}, {2.0, 4.0}};
  world.people.front().speed_m_per_s = 0.0;
  const auto other = rover_on(world);
  bool felt = false;
  run(*other, 3.0, {0.8, 0.0}, [&] { felt |= other->bumper_pressed(); });
  EXPECT_TRUE(felt);
}

TEST(RoverBody, ClimbsALowKerbAndNotAHighOne) {
  const auto reached = [](double height_m) {
    World world = test::flat_world();
    world.solids = {block(3.0, 0.0, 2.0, 2.0, height_m, "kerb")};
    const auto rover = rover_on(world);
    run(*rover, 5.0, {0.6, 0.0});
    return place_of(*rover);
  };
  const Eigen::Vector3d low = reached(0.05);
  EXPECT_GT(low.x(), 2.5);
  EXPECT_NEAR(low.z(), 0.05, 0.005);
  const Eigen::Vector3d high = reached(0.15);
  EXPECT_LT(high.x(), 1.0);
  EXPECT_NEAR(high.z(), 0.0, 0.02);
}

TEST(RoverBody, SameCommandsSameBits) {
  World world = test::ground_world(16.0, 0.1, Surface::kGravel, test::rough_height);
  test::strew(world, 60, 7.0, 4);
  const auto play = [&](BodyMotion& end, WheelSample& wheels) {
    const auto rover = rover_on(world);
    run(*rover, 2.0, {1.0, 0.4});
    end = rover->motion();
    wheels = rover->wheels();
  };
  BodyMotion alone, first, second;
  WheelSample wheels_alone, wheels_first, wheels_second;
  play(alone, wheels_alone);
  std::thread other([&] { play(second, wheels_second); });
  play(first, wheels_first);
  other.join();
  for (const BodyMotion* motion : {&first, &second}) {
    EXPECT_EQ(motion->T_world_body.matrix(), alone.T_world_body.matrix());
    EXPECT_EQ(motion->rate_rad_per_s, alone.rate_rad_per_s);
  }
  EXPECT_EQ(wheels_first.left_rad, wheels_alone.left_rad);
  EXPECT_EQ(wheels_second.right_current_a, wheels_alone.right_current_a);
}

TEST(RoverBody, BadPlacesAndCommandsAreNamed) {
  World world = test::flat_world();
  const auto refused = [&](const RobotPlace& place, const std::string& what) {
    const auto rover = RoverBody::place(world, {}, place);
    ASSERT_FALSE(rover) << what;
    EXPECT_NE(rover.error().message().find(what), std::string::npos) << rover.error().message();
    EXPECT_NE(rover.error().message().find("the rover"), std::string::npos);
  };
  refused({{10.05, 0.0}, 0.0}, "no ground below its left wheel");
  refused({{0.0, 0.0}, std::nan("")}, "not finite");
  world.solids = {test::solid_at(Solid::Shape::kEllipsoid, {-0.3, 0.0, 0.2}, {0.2, 0.2, 0.3},
                                 Eigen::Vector3d::Zero(), "rocks[2]")};
  refused({}, "inside rocks[2]");
  world.solids = {block(0.27, 0.0, 0.05, 1.0, 0.5, "wall")};
  refused({}, "inside wall");
  const auto rover = RoverBody::place(world, {}, {{-3.0, 0.0}, 0.0});
  ASSERT_TRUE(rover);
  EXPECT_FALSE((*rover)->command({std::numeric_limits<double>::infinity(), 0.0}));
  EXPECT_FALSE((*rover)->command({0.0, std::nan("")}));
  RoverModelOptions options;
  options.wheel_radius_m = 0.0;
  EXPECT_FALSE(RoverBody::place(world, options, {{-3.0, 0.0}, 0.0}));
}

TEST(RoverBody, OffTheEdgeOfTheWorldItIsLost) {
  const World world = test::flat_world();
  const auto rover = rover_on(world, {{8.5, 0.0}, 0.0});
  ASSERT_TRUE(rover->command({1.0, 0.0}));
  Status done;
  for (int i = 0; i < 3000 && done; ++i) done = rover->step();
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().message().find("fallen off"), std::string::npos);
}

}  // namespace
}  // namespace tread
