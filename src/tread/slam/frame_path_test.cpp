#include "tread/slam/frame_path.hpp"

#include <gtest/gtest.h>

namespace tread {
namespace {

Isometry3d some(double x, double turn) {
  Isometry3d T = Isometry3d::Identity();
  T.linear() = so3_exp({0.1, turn, -0.2});
  T.translation() = Eigen::Vector3d(x, -2.0 * x, 0.5);
  return T;
}

TEST(FramePath, FramesGoAlongWithWhatHoldsThem) {
  FramePath path;
  path.add(10, FramePath::kWorld, some(1.0, 0.3));
  path.add(20, 0, some(0.1, 0.0));
  path.add(30, 5, some(0.2, 0.1));
  const auto at = [](std::int64_t anchor) { return some(static_cast<double>(anchor), 0.7); };
  const Trajectory poses = path.poses(at);
  ASSERT_EQ(poses.size(), 3U);
  EXPECT_EQ(poses[1].stamp_ns, 20);
  EXPECT_TRUE(poses[0].pose.isApprox(some(1.0, 0.3)));
  EXPECT_TRUE(poses[1].pose.isApprox(at(0) * some(0.1, 0.0)));
  EXPECT_TRUE(poses[2].pose.isApprox(at(5) * some(0.2, 0.1)));
  // An anchor goes, another holds its frames where they were.
  path.move_anchor(5, 0, at(0).inverse() * at(5));
  const Trajectory after = path.poses(at);
  EXPECT_TRUE(after[2].pose.isApprox(poses[2].pose));
  const auto moved = [&](std::int64_t anchor) { return some(3.0, 0.0) * at(anchor); };
  EXPECT_TRUE(path.poses(moved)[2].pose.isApprox(some(3.0, 0.0) * poses[2].pose));
  EXPECT_TRUE(path.poses(moved)[0].pose.isApprox(poses[0].pose));
  path.move_anchor(0, FramePath::kWorld, at(0));
  EXPECT_TRUE(path.poses(moved)[2].pose.isApprox(poses[2].pose)) << "nothing moves the world";
}

TEST(FramePath, AVeryLongOneIsThinnedOutWhereItIsOld) {
  FramePath path;
  constexpr auto kMost = static_cast<std::int64_t>(FramePath::kMost);
  for (std::int64_t i = 0; i <= kMost; ++i) path.add(i, FramePath::kWorld, some(0.0, 0.0));
  EXPECT_EQ(path.size(), FramePath::kMost * 3 / 4 + 1);
  const Trajectory poses = path.poses([](std::int64_t) { return Isometry3d::Identity(); });
  EXPECT_EQ(poses[0].stamp_ns, 0);
  EXPECT_EQ(poses[1].stamp_ns, 2);
  EXPECT_EQ(poses[poses.size() - 2].stamp_ns, kMost - 1);
  EXPECT_EQ(poses.back().stamp_ns, kMost);
}

}  // namespace
}  // namespace tread
