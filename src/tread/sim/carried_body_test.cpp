#include "tread/sim/carried_body.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tread/sim/course.hpp"
#include "tread/sim/imu_sensor.hpp"

namespace tread {
namespace {

using Eigen::Vector3d;

CarriedBody carried(const std::string& body, const CarryOptions& options = {}) {
  const auto course =
      parse_course("tread_course: 1\nsize_m: [20, 12]\norigin_m: [-4, -6]\n" + body, "made.yaml");
  EXPECT_TRUE(course) << course.error().message();
  auto made = CarriedBody::make(*course->world, options);
  EXPECT_TRUE(made) << made.error().message();
  return std::move(*made);
}

TEST(CarriedBody, GoesFromTheStartToTheEndOfTheRoute) {
  const CarriedBody body = carried("route_m: [[6, 0], [10, 3]]\n");
  const BodyMotion start = body.motion(0.0), end = body.motion(body.duration_s() + 1.0);
  EXPECT_NEAR((start.T_world_body.translation() - Vector3d(0, 0, 0)).norm(), 0.0, 0.02);
  EXPECT_NEAR((end.T_world_body.translation() - Vector3d(10, 3, 0)).norm(), 0.0, 0.03);
  for (const BodyMotion& still : {start, end}) {
    EXPECT_NEAR(still.velocity_m_per_s.norm(), 0.0, 1e-9);
    EXPECT_NEAR(still.rate_rad_per_s.norm(), 0.0, 1e-9);
  }
  // Half way along the first line at the speed that was asked for.
  const BodyMotion middle = body.motion(1.0 + 3.0 / 0.5);
  EXPECT_NEAR(middle.velocity_m_per_s.x(), 0.5, 0.01);
  EXPECT_NEAR(middle.T_world_body.translation().z(), 0.0, 1e-9);
  EXPECT_NEAR((middle.T_world_body.linear() - Eigen::Matrix3d::Identity()).norm(), 0.0, 1e-6);
}

TEST(CarriedBody, FollowsTheSlopeNoseUp) {
  const CarriedBody body = carried(
      "ground: {relief: [{ramp: {from_m: [-4, 0], to_m: [16, 0], width_m: 50, rise_m: 4}}]}\n"
      "route_m: [[8, 0]]\n");
  const BodyMotion motion = body.motion(6.0);
  const Vector3d forward = motion.T_world_body.linear().col(0);
  EXPECT_NEAR(std::asin(forward.z()), std::atan(0.2), 1e-3);
  EXPECT_NEAR(motion.T_world_body.translation().z(),
              0.2 * (motion.T_world_body.translation().x() + 4.0), 2e-3);
}

// What the sensors feel, integrated, is the way it goes.
TEST(CarriedBody, MotionIsTheDerivativeOfThePose) {
  CarryOptions options;
  options.gait_hz = 1.65;
  const CarriedBody body = carried(
      "ground: {relief: [{noise: {rms_m: 0.05, longest_m: 4, shortest_m: 0.5}}]}\n"
      "route_m: [[3, 0], [5, 2]]\n",
      options);
  constexpr double kStep_s = 5e-4;
  BodyMotion at = body.motion(0.0);
  Isometry3d T = at.T_world_body;
  Vector3d v = at.velocity_m_per_s;
  double fastest = 0.0;
  const int steps = static_cast<int>(body.duration_s() / kStep_s);
  for (int i = 0; i < steps; ++i) {
    const BodyMotion middle = body.motion((i + 0.5) * kStep_s);
    T.translation() += kStep_s * v + 0.5 * kStep_s * kStep_s * middle.acceleration_m_per_s2;
    v += kStep_s * middle.acceleration_m_per_s2;
    T.linear() = T.linear() * so3_exp(kStep_s * middle.rate_rad_per_s);
    fastest = std::max(fastest, middle.rate_rad_per_s.norm());
  }
  at = body.motion(steps * kStep_s);
  EXPECT_GT(fastest, 0.1);
  EXPECT_NEAR((T.translation() - at.T_world_body.translation()).norm(), 0.0, 2e-3);
  EXPECT_NEAR(so3_log(T.linear().transpose() * at.T_world_body.linear()).norm(), 0.0, 1e-3);
}

TEST(CarriedBody, AtRestAnImuFeelsGravityAlone) {
  const CarriedBody body = carried("route_m: [[6, 0]]\n");
  const ImuSample sample = felt_motion(body.motion(0.3), Isometry3d::Identity());
  EXPECT_NEAR((sample.accel_m_per_s2 - Vector3d(0, 0, 9.81)).norm(), 0.0, 0.01);
  EXPECT_NEAR(sample.gyro_rad_per_s.norm(), 0.0, 1e-9);
}

TEST(CarriedBody, NeedsARoute) {
  const auto course = parse_course("tread_course: 1\nsize_m: [5, 5]\n", "made.yaml");
  ASSERT_TRUE(course);
  const auto body = CarriedBody::make(*course->world, {});
  ASSERT_FALSE(body);
  EXPECT_NE(body.error().message().find("route_m"), std::string::npos);
}

}  // namespace
}  // namespace tread
