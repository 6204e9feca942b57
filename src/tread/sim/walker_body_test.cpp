#include "tread/sim/walker_body.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>
#include <thread>

#include "physics_worlds.hpp"
#include "tread/sim/imu_sensor.hpp"

namespace tread {
namespace {

using test::block;
using test::stairs_world;
using test::stones_world;

constexpr double kGravity = 9.81;

std::unique_ptr<WalkerBody> walker_on(const World& world, const RobotPlace& place = {}) {
  auto walker = WalkerBody::place(world, {}, place);
  if (!walker) throw std::runtime_error(walker.error().message());
  return std::move(*walker);
}

void run(
    WalkerBody& walker, double seconds, const std::function<void()>& look = [] {}) {
  const int steps = static_cast<int>(std::lround(seconds / walker.step_s()));
  for (int i = 0; i < steps; ++i) {
    const Status done = walker.step();
    ASSERT_TRUE(done) << done.error().message();
    look();
  }
}

// Two pallets 1.2 m apart and stones 8 cm lower between them, under the feet at home.
struct Standing {
  double creep_m = 0.0;
  double force_error = 0.0;  // of the sum of contact forces, in weights
};
Standing stand_for_ten_seconds(WalkerBody& walker) {
  std::array<Eigen::Vector3d, kLegs> start;
  for (int leg = 0; leg < kLegs; ++leg) start[static_cast<std::size_t>(leg)] = walker.foot_m(leg);
  const double weight = walker_mass_kg(walker.options()) * kGravity;
  Standing result;
  run(walker, 10.0, [&] {
    const Eigen::Vector3d off = walker.contact_force_n() - weight * Eigen::Vector3d::UnitZ();
    result.force_error = std::max(result.force_error, off.norm() / weight);
  });
  for (int leg = 0; leg < kLegs; ++leg) {
    const double moved = (walker.foot_m(leg) - start[static_cast<std::size_t>(leg)]).norm();
    result.creep_m = std::max(result.creep_m, moved);
  }
  return result;
}

TEST(WalkerBody, StandsStillWhereverFeetFindHold) {
  const struct {
    const char* name;
    World world;
  } worlds[] = {
      {"flat", test::flat_world()},
      {"stones", stones_world()},
      {"stairs", stairs_world()},
      {"rough", test::ground_world(12.0, 0.1, Surface::kGravel, test::rough_height)},
      {"slope", test::slope_world(15.0 * 0.017453, Surface::kConcrete)},
  };
  for (const auto& [name, world] : worlds) {
    const auto walker = walker_on(world);
    const Standing standing = stand_for_ten_seconds(*walker);
    EXPECT_LT(standing.creep_m, 1e-4) << name;
    EXPECT_LT(standing.force_error, 0.001) << name;
    EXPECT_NEAR(walker->time_s(), 10.0, 1e-6);
  }
}

TEST(WalkerBody, FeetAreOnTheStones) {
  const World world = stones_world();
  const auto walker = walker_on(world);
  int on_stones = 0;
  for (const Touch& touch : walker->touches()) {
    on_stones += walker->physics().name_of(touch.other) == "stones" ? 1 : 0;
  }
  EXPECT_EQ(on_stones, 4);
  for (int leg = 0; leg < kLegs; ++leg) {
    EXPECT_NEAR(walker->foot_m(leg).z(), 0.07 + walker->options().foot_radius_m, 0.001);
  }
}

TEST(WalkerBody, ItsFeetAreWhereTheModelSays) {
  const World world = test::flat_world();
  const RobotPlace place{{1.0, -2.0}, 0.7};
  const auto walker = walker_on(world, place);
  const Eigen::Vector3d p = walker->motion().T_world_body.translation();
  EXPECT_LT((p.head<2>() - place.position_m).norm(), 0.005);
  EXPECT_NEAR(p.z(), 0.574 + walker->options().foot_radius_m, 0.003);
  EXPECT_NEAR(yaw_pitch_roll(walker->motion().T_world_body.linear()).yaw_rad, 0.7, 0.005);
  const LegSample legs = walker->legs();
  ASSERT_EQ(walker->touches().size(), 4U);
  for (const Touch& touch : walker->touches()) {
    double nearest = 1.0;
    for (int leg = 0; leg < kLegs; ++leg) {
      const Eigen::Vector3d sole =
          walker->foot_m(leg) - walker->options().foot_radius_m * Eigen::Vector3d::UnitZ();
      nearest = std::min(nearest, (touch.place_m - sole).norm());
    }
    EXPECT_LT(nearest, 0.001) << "kinematics of physics and of the model differ";
  }
  double sum = 0.0;
  for (const Eigen::Vector3d& force : legs.foot_force_n) sum += force.z();
  EXPECT_NEAR(sum, walker_mass_kg(walker->options()) * kGravity, 2.0);
}

TEST(WalkerBody, AtRestAnInertialUnitFeelsWhatHoldsItUp) {
  const World world = test::slope_world(0.2, Surface::kConcrete);
  const auto walker = walker_on(world);
  run(*walker, 1.0);
  Isometry3d T_body_imu = Isometry3d::Identity();
  T_body_imu.linear() = rotation_from_yaw_pitch_roll(0.5, 0.4, 0.3);
  T_body_imu.translation() << 0.3, 0.1, 0.05;
  const ImuSample imu = felt_motion(walker->motion(), T_body_imu);
  const Eigen::Vector3d expected =
      (walker->motion().T_world_body.linear() * T_body_imu.linear()).transpose() *
      Eigen::Vector3d(0.0, 0.0, kGravity);
  EXPECT_LT((imu.accel_m_per_s2 - expected).norm(), 0.01);
  EXPECT_LT(imu.gyro_rad_per_s.norm(), 1e-3);
}

// What the unit says must sum up to the motion, whatever happens in between.
TEST(WalkerBody, InertialSamplesSumUpToTheMotion) {
  const World world = test::flat_world();
  const auto walker = walker_on(world);
  Isometry3d T_body_imu = Isometry3d::Identity();
  T_body_imu.translation() << 0.3, 0.1, 0.05;
  walker->push({150.0, 200.0, 0.0}, 0.3);
  const auto at = [&]() -> Eigen::Vector3d {
    return walker->motion().T_world_body * T_body_imu.translation();
  };
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  Eigen::Vector3d place = at();
  run(*walker, 1.0, [&] {
    const ImuSample imu = felt_motion(walker->motion(), T_body_imu);
    velocity += walker->step_s() * (walker->motion().T_world_body.linear() * imu.accel_m_per_s2 -
                                    kGravity * Eigen::Vector3d::UnitZ());
    place += walker->step_s() * velocity;
  });
  EXPECT_LT((place - at()).norm(), 0.002);
}

TEST(WalkerBody, APushMovesItAndItStaysUp) {
  const World world = test::flat_world();
  const auto walker = walker_on(world);
  const double rest = walker->motion().T_world_body.translation().y();
  double most = 0.0, fastest = 0.0;
  walker->push({0.0, 200.0, 0.0}, 0.2);
  run(*walker, 3.0, [&] {
    most = std::max(most, walker->motion().T_world_body.translation().y() - rest);
    fastest = std::max(fastest, walker->motion().velocity_m_per_s.y());
  });
  EXPECT_GT(fastest, 0.05);
  EXPECT_LT(fastest, 200.0 * 0.2 / walker_mass_kg(walker->options())) << "as if nothing held it";
  EXPECT_GT(most, 0.01);
  EXPECT_GT(walker->motion().T_world_body.translation().z(), 0.55);
  EXPECT_LT(walker->motion().velocity_m_per_s.norm(), 0.01);
}

TEST(WalkerBody, FallsWhenALegIsLimp) {
  const World world = test::flat_world();
  for (int leg = 0; leg < kLegs; ++leg) {
    const auto walker = walker_on(world);
    JointCommand command = walker->command();
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t joint = 3 * static_cast<std::size_t>(leg) + k;
      command.torque_nm[joint] = command.stiffness_nm_per_rad[joint] = 0.0;
      command.damping_nm_s_per_rad[joint] = 0.0;
    }
    ASSERT_TRUE(walker->command(command));
    run(*walker, 3.0);
    const double tilt = std::acos(walker->motion().T_world_body.linear()(2, 2));
    EXPECT_GT(tilt, 0.15) << leg_name(leg);
  }
  const auto walker = walker_on(world);
  ASSERT_TRUE(walker->command(JointCommand{}));
  run(*walker, 3.0);
  EXPECT_LT(walker->motion().T_world_body.translation().z(), 0.35) << "on folded legs";
}

TEST(WalkerBody, JointsKeepToTheirLimitsAndTorques) {
  const World world = test::flat_world();
  const auto walker = walker_on(world);
  for (const double far : {-4.0, 4.0}) {
    JointCommand command = walker->command();
    command.position_rad.fill(far);
    ASSERT_TRUE(walker->command(command));
    run(*walker, 2.0, [&] {
      const LegSample legs = walker->legs();
      for (int i = 0; i < kLegJoints; ++i) {
        const auto k = static_cast<std::size_t>(i);
        const auto [low, high] = joint_limits(walker->options(), i / 3, i % 3);
        ASSERT_GT(legs.position_rad[k], low - 0.05) << i;
        ASSERT_LT(legs.position_rad[k], high + 0.05) << i;
        ASSERT_LE(std::abs(legs.torque_nm[k]),
                  joint_torque_limit_nm(walker->options(), i % 3) + 1e-9);
      }
    });
  }
}

// In the air a joint follows the spring and damper it is told to be.
TEST(WalkerBody, AJointIsTheSpringItIsToldToBe) {
  const World world = test::flat_world();
  const auto walker = walker_on(world);
  JointCommand command = walker->command();
  const LegSample before = walker->legs();
  ASSERT_TRUE(walker->step());
  const LegSample after = walker->legs();
  for (std::size_t k = 0; k < kLegJoints; ++k) {
    const double expected =
        command.torque_nm[k] +
        command.stiffness_nm_per_rad[k] * (command.position_rad[k] - before.position_rad[k]) -
        command.damping_nm_s_per_rad[k] * before.velocity_rad_per_s[k];
    EXPECT_NEAR(after.torque_nm[k], expected, 1e-9);
  }
}

TEST(WalkerBody, SameCommandsSameBits) {
  World world = test::ground_world(10.0, 0.1, Surface::kGravel, test::rough_height);
  test::strew(world, 40, 4.5, 9);
  const auto play = [&](BodyMotion& end, LegSample& legs) {
    const auto walker = walker_on(world);
    walker->push({300.0, -200.0, 50.0}, 0.2);
    run(*walker, 1.0);
    end = walker->motion();
    legs = walker->legs();
  };
  BodyMotion alone, first, second;
  LegSample legs_alone, legs_first, legs_second;
  play(alone, legs_alone);
  std::thread other([&] { play(second, legs_second); });
  play(first, legs_first);
  other.join();
  for (const BodyMotion* motion : {&first, &second}) {
    EXPECT_EQ(motion->T_world_body.matrix(), alone.T_world_body.matrix());
    EXPECT_EQ(motion->velocity_m_per_s, alone.velocity_m_per_s);
  }
  EXPECT_EQ(legs_first.torque_nm, legs_alone.torque_nm);
  EXPECT_EQ(legs_second.torque_nm, legs_alone.torque_nm);
}

void expect_no_place(const World& world, const RobotPlace& place, const std::string& what) {
  const auto walker = WalkerBody::place(world, {}, place);
  ASSERT_FALSE(walker) << what;
  EXPECT_NE(walker.error().message().find(what), std::string::npos) << walker.error().message();
  EXPECT_NE(walker.error().message().find("walker"), std::string::npos);
}

TEST(WalkerBody, BadPlacesAreNamed) {
  World world = test::flat_world();
  expect_no_place(world, {{10.2, 0.0}, 0.0}, "no ground below its left front foot");
  expect_no_place(world, {{std::nan(""), 0.0}, 0.0}, "not finite");
  world.solids = {test::solid_at(Solid::Shape::kEllipsoid, {0.0, 0.0, 0.4}, {0.25, 0.25, 0.5},
                                 Eigen::Vector3d::Zero(), "rocks[7]")};
  expect_no_place(world, {}, "inside rocks[7]");
  expect_no_place(world, {}, "trunk");
  EXPECT_TRUE(WalkerBody::place(world, {}, {{2.0, 0.0}, 0.0}));
  // A wall through the middle between the legs, higher than the trunk.
  world.solids = {block(0.0, 0.0, 0.05, 2.0, 1.0, "wall")};
  expect_no_place(world, {}, "inside wall");
  world.solids = {block(0.37, 0.32, 0.1, 0.1, 0.6, "pillar")};
  expect_no_place(world, {}, "left front foot cannot reach");
}

TEST(WalkerBody, BadCommandsAndOptionsAreRefused) {
  const World world = test::flat_world();
  const auto walker = walker_on(world);
  JointCommand command = walker->command();
  command.position_rad[5] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(walker->command(command));
  command = walker->command();
  command.stiffness_nm_per_rad[0] = -1.0;
  EXPECT_FALSE(walker->command(command));
  WalkerModelOptions options;
  options.lower_m = -0.3;
  EXPECT_FALSE(WalkerBody::place(world, options, {}));
  // Springs that no step can follow.
  command = walker->command();
  command.stiffness_nm_per_rad.fill(1e9);
  command.torque_nm.fill(0.0);
  ASSERT_TRUE(walker->command(command));
  for (int i = 0; i < 1000; ++i) {
    if (!walker->step()) break;
  }
  EXPECT_TRUE(walker->motion().T_world_body.matrix().allFinite());
}

}  // namespace
}  // namespace tread
