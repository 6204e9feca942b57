#include "tread/geometry/trajectory.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>

namespace tread {
namespace {

using Eigen::Vector3d;

constexpr std::int64_t kSecond = 1'000'000'000;

Isometry3d pose(const Vector3d& translation, const Vector3d& rotation) {
  Isometry3d T = Isometry3d::Identity();
  T.translation() = translation;
  T.linear() = so3_exp(rotation);
  return T;
}

double difference(const Isometry3d& a, const Isometry3d& b) {
  return (a.matrix() - b.matrix()).norm();
}

const Vector3d kAxis = Vector3d(1.0, -2.0, 0.5).normalized();

Trajectory example() {
  return {{10 * kSecond, pose({0, 0, 0}, {0, 0, 0})},
          {10 * kSecond + kSecond / 2, pose({1, 2, -4}, 1.2 * kAxis)},
          {13 * kSecond, pose({5, 5, 5}, {0, 0, 0})}};
}

TEST(Trajectory, SamplesAreReturnedAsTheyAre) {
  for (const StampedPose& sample : example()) {
    const auto found = pose_at(example(), sample.stamp_ns);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->matrix(), sample.pose.matrix());
  }
}

TEST(Trajectory, BetweenSamplesTranslationIsLinearAndRotationAlongTheArc) {
  for (double fraction : {0.001, 0.25, 0.5, 0.9}) {
    const auto stamp = 10 * kSecond + static_cast<std::int64_t>(fraction * 0.5e9);
    const auto found = pose_at(example(), stamp);
    ASSERT_TRUE(found);
    EXPECT_LT(difference(*found, pose(fraction * Vector3d(1, 2, -4), fraction * 1.2 * kAxis)),
              1e-12);
  }
}

TEST(Trajectory, TheShorterArcIsTaken) {
  const double almost = 0.9 * std::numbers::pi;
  const Trajectory path = {{0, pose({0, 0, 0}, {0, 0, almost})},
                           {100, pose({0, 0, 0}, {0, 0, -almost})}};
  const auto middle = pose_at(path, 50);
  ASSERT_TRUE(middle);
  EXPECT_LT(difference(*middle, pose({0, 0, 0}, {0, 0, std::numbers::pi})), 1e-9);
}

TEST(Trajectory, OutsideAndInGapsThereIsNoPose) {
  EXPECT_FALSE(pose_at(example(), 10 * kSecond - 1));
  EXPECT_FALSE(pose_at(example(), 13 * kSecond + 1));
  EXPECT_FALSE(pose_at(example(), 11 * kSecond));  // between samples 2.5 s apart
  EXPECT_TRUE(pose_at(example(), 11 * kSecond, 5 * kSecond / 2));
  EXPECT_FALSE(pose_at(example(), 11 * kSecond, 5 * kSecond / 2 - 1));
  EXPECT_FALSE(pose_at(example(), 10 * kSecond + 1, -1));
  EXPECT_FALSE(pose_at({}, 0));
}

TEST(Trajectory, StampsOfAnyMagnitudeDoNotOverflow) {
  constexpr std::int64_t kFirst = std::numeric_limits<std::int64_t>::min();
  constexpr std::int64_t kLast = std::numeric_limits<std::int64_t>::max();
  const Trajectory path = {{kFirst, pose({0, 0, 0}, {0, 0, 0})},
                           {kLast, pose({2, 0, 0}, {0, 0, 0})}};
  EXPECT_FALSE(pose_at(path, 0, kLast));  // the gap is longer than any that can be asked for
  const Trajectory half = {{-kLast / 2, pose({0, 0, 0}, {0, 0, 0})},
                           {kLast / 2, pose({2, 0, 0}, {0, 0, 0})}};
  const auto middle = pose_at(half, 0, kLast);
  ASSERT_TRUE(middle);
  EXPECT_NEAR(middle->translation().x(), 1.0, 1e-9);
}

}  // namespace
}  // namespace tread
