#include "tread/slam/compare_views.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "rendered_scene.hpp"

namespace tread {
namespace {

using bench::Sensor;

DepthLevel plane_at(float depth_m, int width = 80, int height = 60) {
  DepthLevel level;
  level.resize({70.0F, 70.0F, 39.5F, 29.5F}, width, height);
  level.depth = Image<float>(width, height, depth_m);
  return level;
}

Isometry3d shifted(double x, double y, double z) {
  Isometry3d T = Isometry3d::Identity();
  T.translation() = Eigen::Vector3d(x, y, z);
  return T;
}

TEST(CompareViews, OverlapOfPlanesIsWhatGeometrySays) {
  const DepthNoise noise;
  const DepthLevel near = plane_at(1.5F), far = plane_at(2.0F);
  const Isometry3d same = Isometry3d::Identity();
  const Overlap itself = overlap_of(far, far, same, noise, 3.0);
  EXPECT_EQ(itself.known, 80 * 60);
  EXPECT_EQ(itself.seen, 80 * 60);
  EXPECT_EQ(itself.agree, 80 * 60);
  EXPECT_EQ(itself.through, 0);
  // The nearer one lies where the other camera looked through.
  const Overlap before = overlap_of(near, far, same, noise, 3.0);
  EXPECT_EQ(before.agree, 0);
  EXPECT_EQ(before.through, 80 * 60);
  // The farther one is only hidden.
  const Overlap behind = overlap_of(far, near, same, noise, 3.0);
  EXPECT_EQ(behind.agree, 0);
  EXPECT_EQ(behind.through, 0);
  EXPECT_EQ(behind.seen, 80 * 60);
  // Half a metre nearer, the far wall is where the near one is.
  EXPECT_GT(overlap_of(near, far, shifted(0, 0, 0.5), noise, 3.0).agree, 0);
  EXPECT_EQ(overlap_of(near, far, shifted(0, 0, 0.5), noise, 3.0).through, 0);
  // Beside by half of what the image shows at 2 m: half of it is seen.
  const Overlap half = overlap_of(far, far, shifted(2.0 * 40.0 / 70.0, 0, 0), noise, 3.0);
  EXPECT_EQ(half.seen, 40 * 60);
  EXPECT_EQ(half.agree, half.seen);
  // Turned away, or without any depth: nothing.
  Isometry3d away = same;
  away.linear() = so3_exp({0.0, 3.14159, 0.0});
  EXPECT_EQ(overlap_of(far, far, away, noise, 3.0).seen, 0);
  const DepthLevel none = plane_at(std::numeric_limits<float>::quiet_NaN());
  EXPECT_EQ(overlap_of(none, far, same, noise, 3.0).known, 0);
  EXPECT_EQ(overlap_of(far, none, same, noise, 3.0).seen, 0);
}

AlignFrame frame_of(const bench::Scene& scene, const Isometry3d& T, unsigned seed) {
  Sensor sensor;
  sensor.noise = DepthNoise{};
  AlignFrame frame;
  frame.depth[0].resize(sensor.camera, sensor.width, sensor.height);
  frame.depth[0].depth = bench::render(scene, sensor, T, seed).depth;
  NormalFinder().build_pyramid(sensor.noise, frame.depth);
  return frame;
}

Isometry3d in_room(double x, double y, double yaw_deg) {
  return bench::camera_at({x, y, 1.0}, yaw_deg, 15.0, 0.0);
}

PlaceMatch match_at(const Isometry3d& T_place_query) {
  PlaceMatch match;
  match.found = true;
  match.T_place_query = T_place_query;
  match.covariance = 4e-4 * Matrix6d::Identity();
  return match;
}

// Goal: from 3 cm and a degree off to 3 mm.
TEST(CompareViews, DepthPutsRightWhatCornersSay) {
  const bench::Scene room = bench::room_corner();
  const Isometry3d T_place = in_room(0.0, 0.0, 30.0), T_frame = in_room(0.3, -0.2, 40.0);
  const AlignFrame place = frame_of(room, T_place, 1), frame = frame_of(room, T_frame, 2);
  const Isometry3d truth = T_place.inverse() * T_frame;
  Vector6d off;
  off << 0.02, -0.015, 0.015, 0.008, -0.012, 0.01;
  const auto found = compare_views(frame, place.depth, match_at(truth * se3_exp(off)), {}, {}, {});
  ASSERT_TRUE(found);
  EXPECT_LT((truth.inverse() * found->T_place_frame).translation().norm(), 0.003);
  EXPECT_LT(so3_log((truth.inverse() * found->T_place_frame).linear()).norm(), 0.002);
  EXPECT_LT(found->covariance.diagonal().head<3>().sum(), 0.01 * 0.01);
}

TEST(CompareViews, WhatIsNotTheSameSurfaceIsRefused) {
  const bench::Scene room = bench::room_corner();
  const Isometry3d T_place = in_room(0.0, 0.0, 30.0);
  const AlignFrame place = frame_of(room, T_place, 1), frame = frame_of(room, T_place, 2);
  const Isometry3d same = Isometry3d::Identity();
  ASSERT_TRUE(compare_views(frame, place.depth, match_at(same), {}, {}, {}));
  // Half a metre off: what depth would make of it is far from what was said.
  EXPECT_FALSE(compare_views(frame, place.depth, match_at(shifted(0.5, 0, 0)), {}, {}, {}));
  EXPECT_FALSE(compare_views(frame, place.depth, match_at(shifted(0, 0, 0.5)), {}, {}, {}));
  // Other surfaces.
  const AlignFrame ground = frame_of(bench::flat_ground(true), T_place, 3);
  EXPECT_FALSE(compare_views(ground, place.depth, match_at(same), {}, {}, {}));
  EXPECT_FALSE(compare_views(frame, ground.depth, match_at(same), {}, {}, {}));
  const AlignFrame stairs = frame_of(bench::stairs(0.3, 0.15), in_room(-1.0, 0.0, 0.0), 4);
  EXPECT_FALSE(compare_views(frame, stairs.depth, match_at(same), {}, {}, {}));
  // No overlap, and nothing at all.
  Isometry3d away = same;
  away.linear() = so3_exp({0.0, 1.5, 0.0});
  EXPECT_FALSE(compare_views(frame, place.depth, match_at(away), {}, {}, {}));
  AlignFrame nothing = frame;
  nothing.depth[0].depth = Image<float>(320, 240, std::numeric_limits<float>::quiet_NaN());
  NormalFinder().build_pyramid({}, nothing.depth);
  EXPECT_FALSE(compare_views(nothing, place.depth, match_at(same), {}, {}, {}));
}

}  // namespace
}  // namespace tread
