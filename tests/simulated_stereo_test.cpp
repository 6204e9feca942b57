// The stereo of this project on rendered images: what the simulator shows must be as good to match
// as real ground, and no better than the camera allows.
#include <gtest/gtest.h>

#include <cmath>

#include "sim_worlds.hpp"
#include "tread/sim/camera_view.hpp"
#include "tread/sim/image_sensor.hpp"
#include "tread/stereo/depth.hpp"
#include "tread/stereo/stereo_matcher.hpp"

namespace tread {
namespace {

// Paper Q's camera at 1024 px, the middle of its image.
StereoRig middle_of_bumblebee2() {
  StereoRig rig = bumblebee2(1024);
  rig.size = {512, 384};
  auto& left = std::get<PinholeCamera>(rig.left);
  left.cx = 0.5 * (rig.size.width - 1);
  left.cy = 0.5 * (rig.size.height - 1);
  rig.right = rig.left;
  return rig;
}

struct StereoScore {
  double rms_m = 0.0;    // of depths that were found
  double density = 0.0;  // of pixels that could be
};

StereoScore match_ground(Surface surface, double distance_m, double tilt_deg) {
  const StereoRig rig = middle_of_bumblebee2();
  const RectifiedRig rectified = rectified_rig(rig).value();
  const Scene scene =
      std::move(Scene::make(testing::shared(testing::world_with_ground(surface))).value());
  const CameraRays rays = make_camera_rays(rig.left, rig.size).value();
  ImageSensorOptions sensor_options;
  sensor_options.vignetting = 0.3;
  const ImageSensor sensor = ImageSensor::make(sensor_options, rays).value();
  const Isometry3d T_world_left =
      testing::camera_pose({0.013, -0.021, distance_m}, 17.0, 90.0 - tilt_deg);
  CameraView left_view, right_view;
  EXPECT_TRUE(render(scene, rays, CameraShot::still(T_world_left), {}, left_view));
  EXPECT_TRUE(
      render(scene, rays, CameraShot::still(T_world_left * rig.T_left_right), {}, right_view));
  Image<std::uint8_t> left, right;
  const Exposure exposure = sensor.meter(left_view);
  EXPECT_TRUE(sensor.expose(left_view, exposure, {1, 0, 0}, left));
  EXPECT_TRUE(sensor.expose(right_view, exposure, {1, 0, 1}, right));
  StereoMatcher matcher;
  StereoOptions options;
  options.sad.num_disparities = 96;
  const auto disparity = matcher.match(left, right, options);
  EXPECT_TRUE(disparity);
  Image<float> depth;
  depth_image(*disparity, rectified, {0.3, 20.0}, depth);
  double squares = 0.0, known = 0.0, all = 0.0;
  for (int v = 0; v < depth.height; ++v) {
    for (int u = 0; u < depth.width; ++u) {
      const auto truth = static_cast<double>(left_view.depth(u, v));
      if (u < rectified.disparity_px(truth)) continue;
      ++all;
      const auto z = static_cast<double>(depth(u, v));
      if (std::isnan(z)) continue;
      ++known;
      squares += (z - truth) * (z - truth);
    }
  }
  return {std::sqrt(squares / std::max(known, 1.0)), known / all};
}

// Issue: depth error within twice that of a quarter pixel, 4, 15 and 35 mm, at 1, 2 and 3 m.
TEST(SimulatedStereo, DepthOfEverySurfaceIsAsFineAsTheCamera) {
  const RectifiedRig rig = rectified_rig(middle_of_bumblebee2()).value();
  for (const Surface surface : {Surface::kSoil, Surface::kGravel, Surface::kSand, Surface::kGrass,
                                Surface::kConcrete, Surface::kPlanks, Surface::kRock}) {
    for (const double distance_m : {1.0, 2.0, 3.0}) {
      const StereoScore score = match_ground(surface, distance_m, 0.0);
      EXPECT_LT(score.rms_m, 2.0 * rig.depth_resolution_m(distance_m))
          << name_of(surface) << " " << distance_m << " m";
      EXPECT_GT(score.density, 0.7) << name_of(surface) << " " << distance_m << " m";
    }
  }
}

TEST(SimulatedStereo, SlantedGroundIsMatchedToo) {
  const RectifiedRig rig = rectified_rig(middle_of_bumblebee2()).value();
  for (const Surface surface : {Surface::kSoil, Surface::kGrass, Surface::kConcrete}) {
    // The middle of the image 2 m away.
    const StereoScore score = match_ground(surface, 1.0, 60.0);
    EXPECT_LT(score.rms_m, 3.0 * rig.depth_resolution_m(2.0)) << name_of(surface);
    EXPECT_GT(score.density, 0.7) << name_of(surface);
  }
}

// What has no texture has no depth.
TEST(SimulatedStereo, PlainSurfacesAreNotMatched) {
  EXPECT_LT(match_ground(Surface::kPlain, 2.0, 0.0).density, 0.3);
}

}  // namespace
}  // namespace tread
