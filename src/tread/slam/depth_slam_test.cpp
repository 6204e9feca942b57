#include "tread/slam/depth_slam.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "rendered_scene.hpp"
#include "tread/geometry/trajectory_error.hpp"

namespace tread {
namespace {

using bench::RenderedFrame;
using bench::Scene;
using bench::Sensor;

constexpr PinholeCamera kCamera{290.0, 290.0, 159.5, 119.5, 0.0};
constexpr std::int64_t kFrameNs = 33'333'333;

Sensor structured_light() {
  Sensor sensor;
  sensor.noise = DepthNoise{};
  sensor.grey_sigma = 2.0;
  return sensor;
}

struct Drive {
  std::vector<SlamState> states;
  Trajectory estimate, truth;
  double path_m = 0.0;
  [[nodiscard]] double end_error_m() const {
    return (truth.back().pose.inverse() * estimate.back().pose).translation().norm();
  }
  [[nodiscard]] int count(TrackStatus status) const {
    return static_cast<int>(std::count_if(states.begin(), states.end(),
                                          [&](const SlamState& s) { return s.status == status; }));
  }
};

Drive drive(const Scene& scene, const Sensor& sensor, const SlamOptions& options, int frames,
            const std::function<Isometry3d(double)>& pose, int threads = 1, bool grey = true) {
  DepthSlam slam(kCamera, options, pose(0.0));
  Drive out;
  for (int i = 0; i < frames; ++i) {
    const Isometry3d T = pose(i / 30.0);
    const RenderedFrame frame = bench::render(scene, sensor, T, 100U + static_cast<unsigned>(i));
    SlamFrame in{i * kFrameNs, frame.depth};
    if (grey) in.grey = frame.grey;
    const auto state = slam.track(in, {threads, nullptr});
    EXPECT_TRUE(state.has_value()) << state.error().message();
    if (!state) break;
    if (i > 0) out.path_m += (T.translation() - out.truth.back().pose.translation()).norm();
    out.states.push_back(*state);
    out.estimate.push_back({in.stamp_ns, state->T_world_camera});
    out.truth.push_back({in.stamp_ns, T});
  }
  return out;
}

Isometry3d in_room(double t) {
  return bench::camera_at({0.2 * t, 0.1 * std::sin(2.0 * t), 1.0}, 30.0 + 5.0 * std::sin(t), 15.0,
                          3.0 * std::sin(3.0 * t));
}

// Goal: on analytic scenes the pose is off by under a tenth of a voxel after 50 frames.
TEST(DepthSlam, PoseWithinATenthOfAVoxelOnExactScenes) {
  Sensor sensor;
  const auto at_ball = [](double t) {
    return bench::camera_at({-2.0 + 0.02 * std::sin(t), 0.2 * std::sin(t), 0.0}, 0.0, 0.0,
                            5.0 * std::sin(2.0 * t));
  };
  const auto at_stairs = [](double t) {
    return bench::camera_at({-1.2 + 0.2 * t, 0.05 * std::sin(4.0 * t), 1.3},
                            3.0 * std::sin(2.0 * t), 40.0, 2.0 * std::sin(3.0 * t));
  };
  for (const auto& [scene, pose] : std::vector<std::pair<Scene, std::function<Isometry3d(double)>>>{
           {bench::flat_ground(true), bench::walking_camera},
           {bench::room_corner(), in_room},
           {bench::ball(0.8), at_ball},
           {bench::stairs(0.3, 0.15), at_stairs}}) {
    SlamOptions options;
    options.noise = {0.0005, 0.0};
    const Drive found = drive(scene, sensor, options, 50, pose);
    EXPECT_EQ(found.count(TrackStatus::kTracked), 49) << scene.name;
    ::testing::Test::RecordProperty(scene.name + " mm",
                                    std::to_string(1000.0 * found.end_error_m()));
    EXPECT_LT(found.end_error_m(), 0.1 * options.volume.voxel_m) << scene.name;
  }
}

// Goal: 0.9 m above flat textured ground, pitched 40 degrees, 0.5 m/s with sway: at most 0.5 % of
// the path. With the noise of both kinds of sensor.
TEST(DepthSlam, DoesNotSlideOnFlatTexturedGround) {
  for (const bool stereo : {false, true}) {
    Sensor sensor = structured_light();
    SlamOptions options;
    if (stereo) {
      sensor.noise = {0.0, 0.0};
      sensor.stereo_sigma_px = 0.25;
      options.noise = stereo_noise(290.0, 0.12, 0.25);
    }
    const Drive found = drive(bench::flat_ground(true), sensor, options, 60, bench::walking_camera);
    EXPECT_EQ(found.count(TrackStatus::kTracked), 59);
    ::testing::Test::RecordProperty(stereo ? "stereo_percent" : "light_percent",
                                    std::to_string(100.0 * found.end_error_m() / found.path_m));
    EXPECT_LT(found.end_error_m(), 0.005 * found.path_m);
  }
}

// Goal: with the texture removed, flagged within five frames, in every run; nothing is fused then.
TEST(DepthSlam, SaysSoWhenPlainGroundTellsNothing) {
  for (const bool stereo : {false, true}) {
    for (const bool grey : {true, false}) {
      Sensor sensor = structured_light();
      SlamOptions options;
      if (stereo) {
        sensor.noise = {0.0, 0.0};
        sensor.stereo_sigma_px = 0.25;
        options.noise = stereo_noise(290.0, 0.12, 0.25);
      }
      const Drive found =
          drive(bench::flat_ground(false), sensor, options, 20, bench::walking_camera, 1, grey);
      EXPECT_EQ(found.count(TrackStatus::kTracked), 0) << stereo << grey;
      for (std::size_t i = 1; i < found.states.size(); ++i) {
        EXPECT_FALSE(found.states[i].mapped());
        EXPECT_EQ(found.states[i].blocks, 0);
      }
    }
  }
}

// The same with odometry of 1 mm a frame: held, and where it should be.
TEST(DepthSlam, OdometryHoldsWhatTheGroundDoesNotTell) {
  const Sensor sensor = structured_light();
  const Scene ground = bench::flat_ground(false);
  DepthSlam slam(kCamera, {}, bench::walking_camera(0.0));
  Isometry3d before = bench::walking_camera(0.0);
  for (int i = 0; i < 20; ++i) {
    const Isometry3d T = bench::walking_camera(i / 30.0);
    const RenderedFrame frame = bench::render(ground, sensor, T, 7U + static_cast<unsigned>(i));
    SlamFrame in{i * kFrameNs, frame.depth, frame.grey};
    MotionPrior motion;
    motion.T_before_now = before.inverse() * T;
    motion.covariance = 1e-6 * Matrix6d::Identity();
    in.motion = motion;
    before = T;
    const auto state = slam.track(in);
    ASSERT_TRUE(state);
    EXPECT_EQ(state->status, i > 0 ? TrackStatus::kHeld : TrackStatus::kFirst);
    EXPECT_LT((T.inverse() * state->T_world_camera).translation().norm(), 0.004);
  }
}

// Goal: 5 to 10 cm relief without any texture: at most 0.15 % of the path.
TEST(DepthSlam, ReliefAloneHoldsTheCamera) {
  const Drive found =
      drive(bench::rough_ground(0.1, false), structured_light(), {}, 45, bench::walking_camera);
  EXPECT_EQ(found.count(TrackStatus::kTracked), 44);
  ::testing::Test::RecordProperty("percent",
                                  std::to_string(100.0 * found.end_error_m() / found.path_m));
  EXPECT_LT(found.end_error_m(), 0.0015 * found.path_m);
}

TEST(DepthSlam, SameResultForOneAndTwoThreads) {
  const Drive one = drive(bench::room_corner(), structured_light(), {}, 12, in_room, 1);
  const Drive two = drive(bench::room_corner(), structured_light(), {}, 12, in_room, 2);
  for (std::size_t i = 0; i < one.states.size(); ++i) {
    EXPECT_EQ(one.states[i].T_world_camera.matrix(), two.states[i].T_world_camera.matrix()) << i;
    EXPECT_EQ(one.states[i].covariance, two.states[i].covariance);
    EXPECT_EQ(one.states[i].blocks, two.states[i].blocks);
  }
}

// Stairs without texture tell everything but the way along their edges, even where the depth is
// exact and creases fall on pixels in patterns that look like structure.
TEST(DepthSlam, StairsDoNotTellTheWayAlongThem) {
  Scene stairs = bench::stairs(0.3, 0.15);
  stairs.brightness = [](const Eigen::Vector3d&) { return 128.0; };
  SlamOptions options;
  options.noise = {0.0005, 0.0};
  const auto pose = [](double t) {
    return bench::camera_at({-1.0 + 0.2 * t, 0.05 * std::sin(4.0 * t), 1.3},
                            3.0 * std::sin(2.0 * t), 40.0, 2.0 * std::sin(3.0 * t));
  };
  const Drive found = drive(stairs, Sensor{}, options, 20, pose);
  for (std::size_t i = 1; i < found.states.size(); ++i) {
    EXPECT_EQ(found.states[i].status, TrackStatus::kUnobservable) << i;
    ASSERT_GE(found.states[i].alignment.observability.unknown.cols(), 1);
  }
}

// A camera covered for a second while it stands: lost by its own word, the map is not touched, and
// it goes on where it was.
TEST(DepthSlam, ACoveredCameraIsLostAndComesBack) {
  const Sensor sensor = structured_light();
  const Scene room = bench::room_corner();
  DepthSlam slam(kCamera, {}, in_room(0.0));
  int lost = 0;
  for (int i = 0; i < 45; ++i) {
    const bool covered = i >= 10 && i < 40;
    const Isometry3d T = in_room(std::min(i, 10) / 30.0);
    RenderedFrame frame = bench::render(room, sensor, T, static_cast<unsigned>(i));
    if (covered) {
      frame.depth = Image<float>(320, 240, i % 2 == 0 ? 0.0F : 0.08F);
      frame.grey = Image<std::uint8_t>(320, 240, 3);
    }
    const auto state = slam.track({i * kFrameNs, frame.depth, frame.grey});
    ASSERT_TRUE(state);
    if (covered) {
      EXPECT_FALSE(state->mapped()) << i;
      EXPECT_EQ(state->blocks, 0);
      lost += state->status == TrackStatus::kLost ? 1 : 0;
    } else {
      EXPECT_TRUE(state->mapped()) << i;
      EXPECT_LT((T.inverse() * state->T_world_camera).translation().norm(), 0.005) << i;
    }
  }
  EXPECT_EQ(lost, 30);
}

// The same in motion: the camera comes back to where it has been, 17 degrees from where it was
// covered, and is found by what the place looks like; nothing wrong is fused in between.
TEST(DepthSlam, ACameraCoveredInMotionFindsItsWayBack) {
  const Sensor sensor = structured_light();
  const Scene room = bench::room_corner();
  const auto turning = [](double t) {
    return bench::camera_at({0.05 * std::sin(3.0 * t), 0.05 * std::sin(2.0 * t), 1.0},
                            25.0 + 18.0 * std::sin(6.0 * t), 10.0 + 4.0 * std::sin(5.0 * t), 0.0);
  };
  DepthSlam slam(kCamera, {}, turning(0.0));
  int tracked_again = 0, relocalised = 0;
  for (int i = 0; i < 60; ++i) {
    const bool covered = i >= 22 && i < 40;
    const Isometry3d T = turning(i / 30.0);
    RenderedFrame frame = bench::render(room, sensor, T, static_cast<unsigned>(i));
    if (covered) {
      frame.depth = Image<float>(320, 240, 0.0F);
      frame.grey = Image<std::uint8_t>(320, 240, 2);
    }
    const auto state = slam.track({i * kFrameNs, frame.depth, frame.grey});
    ASSERT_TRUE(state);
    if (covered) {
      EXPECT_EQ(state->status, TrackStatus::kLost);
    } else if (state->mapped()) {
      EXPECT_LT((T.inverse() * state->T_world_camera).translation().norm(), 0.005) << i;
      tracked_again += i >= 40 ? 1 : 0;
      relocalised += state->relocalised ? 1 : 0;
    }
  }
  EXPECT_GE(tracked_again, 10);
  EXPECT_GE(relocalised, 1);
}

TEST(DepthSlam, BadInputIsRefusedOrCountsForNothing) {
  const Sensor sensor;
  const RenderedFrame frame = bench::render(bench::room_corner(), sensor, in_room(0.0), 1);
  DepthSlam slam(kCamera, {}, in_room(0.0));
  EXPECT_NE(slam.track({0, {}}).error().message().find("empty"), std::string::npos);
  ASSERT_TRUE(slam.track({100, frame.depth, frame.grey}));
  // Times that repeat or go back, another size, an image that does not fit.
  EXPECT_EQ(slam.track({100, frame.depth}).error().code, ErrorCode::kBadValue);
  EXPECT_EQ(slam.track({50, frame.depth}).error().code, ErrorCode::kBadValue);
  const Image<float> other(100, 80, 1.0F);
  EXPECT_NE(slam.track({200, other}).error().message().find("320 x 240"), std::string::npos);
  const Image<std::uint8_t> small(100, 80);
  EXPECT_EQ(slam.track({200, frame.depth, small}).error().code, ErrorCode::kBadArgument);
  // A motion that is certain to be nothing at all, or that is none.
  SlamFrame certain{200, frame.depth};
  certain.motion = MotionPrior{Isometry3d::Identity(), Matrix6d::Zero()};
  EXPECT_NE(slam.track(certain).error().message().find("covariance"), std::string::npos);
  certain.motion->covariance.setIdentity();
  certain.motion->T_before_now.translation().x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(slam.track(certain).error().code, ErrorCode::kBadValue);
  // Nothing, one value, infinity.
  std::int64_t stamp = 1000;
  for (const float value : {std::numeric_limits<float>::quiet_NaN(), 0.0F, -1.0F, 1e30F,
                            std::numeric_limits<float>::infinity()}) {
    const Image<float> depth(320, 240, value);
    const auto state = slam.track({stamp += kFrameNs, depth, frame.grey});
    ASSERT_TRUE(state) << value;
    EXPECT_FALSE(state->mapped()) << value;
  }
  const Image<float> wall(320, 240, 1.0F);
  const auto flat = slam.track({stamp += kFrameNs, wall, frame.grey});
  ASSERT_TRUE(flat);
  EXPECT_FALSE(flat->mapped());
  // After two seconds of that the camera is still where it was.
  const auto again = slam.track({stamp + 2'000'000'000, frame.depth, frame.grey});
  ASSERT_TRUE(again);
  EXPECT_EQ(again->status, TrackStatus::kTracked);
  EXPECT_LT((in_room(0.0).inverse() * again->T_world_camera).translation().norm(), 0.001);
}

// Images of any size, down to a pixel: some pyramid levels are then empty.
TEST(DepthSlam, SmallImagesAreNoTrap) {
  for (int width = 1; width < 24; ++width) {
    for (const int height : {1, 2, 3, 5, 8, 17}) {
      DepthSlam slam({20.0, 20.0, width / 2.0, height / 2.0, 0.0});
      for (int i = 0; i < 3; ++i) {
        Image<float> depth(width, height, 1.0F + 0.01F * static_cast<float>(i));
        const Image<std::uint8_t> grey(width, height, static_cast<std::uint8_t>(100 + i));
        depth(width / 2, height / 2) = 0.0F;
        const auto state = slam.track({i * kFrameNs, depth, grey});
        ASSERT_TRUE(state) << width << "x" << height;
        EXPECT_TRUE(i == 0 || !state->mapped()) << width << "x" << height;
      }
    }
  }
}

TEST(DepthSlam, FirstFrameWithoutDepthIsNoStart) {
  const Sensor sensor;
  const RenderedFrame frame = bench::render(bench::room_corner(), sensor, in_room(0.0), 1);
  DepthSlam slam(kCamera, {}, in_room(0.0));
  const Image<float> nothing(320, 240, 0.0F);
  const auto first = slam.track({1, nothing});
  ASSERT_TRUE(first);
  EXPECT_EQ(first->status, TrackStatus::kLost);
  const auto second = slam.track({2, frame.depth, frame.grey});
  ASSERT_TRUE(second);
  EXPECT_EQ(second->status, TrackStatus::kFirst);
}

TEST(DepthSlam, WhatItIsMadeWithIsCheckedByTheFirstFrame) {
  Image<float> depth(64, 48, 1.0F);
  const auto refusal = [&](const PinholeCamera& camera, const SlamOptions& options,
                           const Isometry3d& T_world_first = Isometry3d::Identity()) {
    DepthSlam slam(camera, options, T_world_first);
    EXPECT_EQ(slam.volume().size(), 0);
    const auto state = slam.track({0, depth});
    EXPECT_EQ(state.has_value(), slam.track({1, depth}).has_value()) << "and by the others";
    return state ? std::string("taken") : state.error().where;
  };
  const PinholeCamera good{60.0, 60.0, 31.5, 23.5, 0.0};
  EXPECT_EQ(refusal(good, {}), "taken");
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  for (const double bad : {0.0, -60.0, kNan, std::numeric_limits<double>::infinity()}) {
    PinholeCamera camera = good;
    camera.fx = bad;
    EXPECT_EQ(refusal(camera, {}), "camera.fx");
    camera = good;
    camera.fy = bad;
    EXPECT_EQ(refusal(camera, {}), "camera.fy");
  }
  PinholeCamera camera = good;
  camera.cx = kNan;
  EXPECT_EQ(refusal(camera, {}), "camera.cx");
  const auto refused_option = [&](const auto& spoil) {
    SlamOptions options;
    spoil(options);
    return refusal(good, options);
  };
  EXPECT_EQ(refused_option([](SlamOptions& o) { o.volume.voxel_m = 0.0; }), "volume.voxel_m");
  EXPECT_EQ(refused_option([](SlamOptions& o) { o.volume.window_log2 = 60; }),
            "volume.window_log2");
  EXPECT_EQ(refused_option([](SlamOptions& o) { o.align.gate_m = -1.0; }), "align.gate_m");
  EXPECT_EQ(refused_option([](SlamOptions& o) { o.least_matched = kNan; }), "least_matched");
  EXPECT_EQ(refused_option([](SlamOptions& o) { o.photo_points = -5; }), "photo_points");
  Isometry3d sheared = Isometry3d::Identity();
  sheared.linear()(0, 1) = 0.5;
  EXPECT_EQ(refusal(good, {}, sheared), "T_world_first");
}

}  // namespace
}  // namespace tread
