#include "tread/geometry/trajectory_error.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace tread {
namespace {

using Eigen::Vector3d;

constexpr std::int64_t kTenth = 100'000'000;

Isometry3d pose(const Vector3d& translation, const Vector3d& rotation) {
  Isometry3d T = Isometry3d::Identity();
  T.translation() = translation;
  T.linear() = so3_exp(rotation);
  return T;
}

// A winding way of ten seconds.
Trajectory winding() {
  Trajectory path;
  for (int i = 0; i <= 100; ++i) {
    const double t = 0.1 * i;
    path.push_back({i * kTenth, pose({t, std::sin(t), 0.3 * std::cos(2.0 * t)},
                                     {0.1 * std::sin(t), 0.05 * t, 0.4 * std::cos(t)})});
  }
  return path;
}

Trajectory moved(Trajectory path, const Isometry3d& T) {
  for (StampedPose& p : path) p.pose = T * p.pose;
  return path;
}

TEST(AlignPoints, FindsAKnownMotionAndIsTheBestOfItsNeighbours) {
  std::mt19937 random(2);
  std::normal_distribution<double> unit;
  const Isometry3d T = pose({1.0, -2.0, 3.0}, {0.4, -1.1, 2.0});
  std::vector<Vector3d> from, to, noisy;
  for (int i = 0; i < 40; ++i) {
    from.emplace_back(unit(random), unit(random), unit(random));
    to.push_back(T * from.back());
    noisy.push_back(to.back() + 0.1 * Vector3d(unit(random), unit(random), unit(random)));
  }
  const auto found = align_points(from, to);
  ASSERT_TRUE(found);
  EXPECT_LT((found->matrix() - T.matrix()).norm(), 1e-12);
  const auto best = align_points(from, noisy);
  ASSERT_TRUE(best);
  const auto squares = [&](const Isometry3d& by) {
    double sum = 0.0;
    for (std::size_t i = 0; i < from.size(); ++i) sum += (by * from[i] - noisy[i]).squaredNorm();
    return sum;
  };
  for (int axis = 0; axis < 3; ++axis) {
    for (const double step : {-1e-3, 1e-3}) {
      EXPECT_LT(squares(*best), squares(*best * pose(step * Vector3d::Unit(axis), {0, 0, 0})));
      EXPECT_LT(squares(*best), squares(*best * pose({0, 0, 0}, step * Vector3d::Unit(axis))));
    }
  }
}

TEST(AlignPoints, NeverMirrorsAndRefusesWhatDoesNotTell) {
  // Flat points and their mirror image: a turn fits the plane, a mirror would fit too.
  const std::vector<Vector3d> flat = {{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {3, 1, 0}};
  std::vector<Vector3d> mirrored;
  for (const Vector3d& p : flat) mirrored.emplace_back(-p.x(), p.y(), 0.0);
  const auto found = align_points(flat, mirrored);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->linear().determinant(), 1.0, 1e-12);
  EXPECT_FALSE(align_points({{0, 0, 0}, {1, 0, 0}}, {{0, 0, 0}, {1, 0, 0}}));
  EXPECT_FALSE(align_points(flat, {{0, 0, 0}, {1, 0, 0}, {0, 2, 0}}));
  const std::vector<Vector3d> line = {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}};
  EXPECT_FALSE(align_points(line, line));
  const std::vector<Vector3d> point(5, Vector3d(1, 2, 3));
  EXPECT_FALSE(align_points(point, point));
  auto broken = flat;
  broken[1].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(align_points(broken, flat));
}

// Moved as a whole, the estimate is right; shifted every second time, by what it is shifted.
TEST(TrajectoryError, OfKnownCases) {
  const Trajectory truth = winding();
  const auto whole =
      absolute_trajectory_error(moved(truth, pose({5.0, 1.0, -2.0}, {0.2, 0.3, -1.0})), truth);
  ASSERT_TRUE(whole);
  EXPECT_EQ(whole->compared, truth.size());
  EXPECT_LT(whole->largest_m, 1e-12);
  EXPECT_LT(whole->largest_rad, 1e-7);

  Trajectory shaken = truth;
  for (std::size_t i = 0; i < shaken.size(); ++i) {
    shaken[i].pose.translation().z() += i % 2 == 0 ? 0.02 : -0.02;
  }
  const auto error = absolute_trajectory_error(shaken, truth);
  ASSERT_TRUE(error);
  EXPECT_NEAR(error->rmse_m, 0.02, 2e-4);
  EXPECT_NEAR(error->median_m, 0.02, 1e-3);
  EXPECT_NEAR(error->mean_m, 0.02, 2e-4);

  // Drift: one part in a hundred too far, and 0.01 rad a second too much.
  Trajectory drifting = {truth.front()};
  for (std::size_t i = 1; i < truth.size(); ++i) {
    Isometry3d step = truth[i - 1].pose.inverse() * truth[i].pose;
    step.translation() *= 1.01;
    step.linear() = step.linear() * so3_exp(Vector3d(0, 0, 0.001));
    drifting.push_back({truth[i].stamp_ns, drifting.back().pose * step});
  }
  const auto drift = relative_pose_error(drifting, truth, 0.1);
  ASSERT_TRUE(drift);
  EXPECT_EQ(drift->compared, truth.size() - 1);
  EXPECT_NEAR(drift->rmse_rad, 0.001, 1e-9);
  double squares = 0.0;
  for (std::size_t i = 1; i < truth.size(); ++i) {
    squares += (truth[i - 1].pose.inverse() * truth[i].pose).translation().squaredNorm();
  }
  EXPECT_NEAR(drift->rmse_m, 0.01 * std::sqrt(squares / 100.0), 1e-9);
  const auto longer = relative_pose_error(drifting, truth, 1.0);
  ASSERT_TRUE(longer);
  EXPECT_EQ(longer->compared, 91U);
  EXPECT_NEAR(longer->rmse_rad, 0.01, 1e-3);
}

TEST(TrajectoryError, StraightAndStandingTrajectoriesAndMissingTruth) {
  Trajectory straight;
  for (int i = 0; i < 20; ++i) straight.push_back({i * kTenth, pose({0.1 * i, 0, 0}, {0, 0, 0})});
  const Isometry3d T = pose({5.0, 1.0, -2.0}, {0.2, 0.3, -1.0});
  const auto line = absolute_trajectory_error(moved(straight, T), straight);
  ASSERT_TRUE(line);
  EXPECT_LT(line->largest_m, 1e-12);
  Trajectory later = straight;
  for (StampedPose& p : later) p.stamp_ns += 10 * kTenth;
  const auto half = absolute_trajectory_error(later, straight);
  ASSERT_TRUE(half);
  EXPECT_EQ(half->compared, 10U);
  EXPECT_EQ(half->unmatched, 10U);
  for (StampedPose& p : later) p.stamp_ns += 100 * kTenth;
  EXPECT_FALSE(absolute_trajectory_error(later, straight));
  EXPECT_FALSE(absolute_trajectory_error({}, straight));
  EXPECT_FALSE(relative_pose_error(later, straight, 1.0));
  EXPECT_FALSE(relative_pose_error(straight, straight, 0.0));
  EXPECT_FALSE(relative_pose_error(straight, straight, std::nan("")));
  EXPECT_FALSE(relative_pose_error(straight, straight, 100.0));  // longer than both
}

}  // namespace
}  // namespace tread
