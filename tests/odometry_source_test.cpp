// Simulated drives, whose poses are known, placed by visual odometry instead.
#include "tread/pipeline/odometry_source.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "tread/sim/course.hpp"
#include "tread/sim/simulated_source.hpp"

namespace tread {
namespace {

using Lens = StereoHeadOptions::Lens;

std::unique_ptr<StereoSource> drive(Lens lens, bool has_imu) {
  const auto course = parse_course(
      "tread_course: 1\nsize_m: [12, 8]\norigin_m: [-3, -4]\nground: {surface: gravel}\n"
      "route_m: [[1, 0], [2, 0.5]]\n",
      "made.yaml");
  EXPECT_TRUE(course) << course.error().message();
  RobotSetup setup = rover_setup();
  setup.has_imu = has_imu;
  setup.head.width_px = 320;
  setup.head.height_px = 240;
  setup.head.focal_px = 240.0;
  setup.head.lens = lens;
  if (lens == Lens::kBrown) setup.head.k1 = -0.15;
  auto source = open_simulated_source(*course, setup, {});
  EXPECT_TRUE(source) << source.error().message();
  return std::move(*source);
}

struct Way {
  std::vector<Isometry3d> poses;
  int unplaced = 0;
};
Way way_of(StereoSource& source) {
  Way way;
  for (auto frame = source.next(); frame && *frame; frame = source.next()) {
    if ((*frame)->T_world_left) {
      way.poses.push_back(*(*frame)->T_world_left);
    } else {
      ++way.unplaced;
    }
  }
  return way;
}

// The course is level and the rover starts at its origin: both worlds are one.
TEST(OdometrySource, FindsThePosesOfASimulatedDrive) {
  for (const auto& [lens, has_imu] : {std::pair(Lens::kPinhole, true), {Lens::kBrown, false}}) {
    const Way truth = way_of(*drive(lens, has_imu));
    auto placed = with_odometry(drive(lens, has_imu));
    ASSERT_TRUE(placed) << placed.error().message();
    EXPECT_TRUE((*placed)->has_poses());
    EXPECT_TRUE(is_placed_by_odometry(**placed));
    const Way way = way_of(**placed);
    EXPECT_EQ(way.unplaced, 0);
    ASSERT_EQ(way.poses.size(), truth.poses.size());
    for (std::size_t i = 0; i < way.poses.size(); ++i) {
      const Isometry3d error = truth.poses[i].inverse() * way.poses[i];
      EXPECT_LT(error.translation().norm(), 0.03) << i;
      EXPECT_LT(so3_log(error.linear()).norm(), 0.02) << i;
    }
  }
}

TEST(OdometrySource, OthersAreNotPlacedByIt) {
  EXPECT_FALSE(is_placed_by_odometry(*drive(Lens::kPinhole, true)));
}

}  // namespace
}  // namespace tread
