// Cameras that move while they take an image: rolling shutter, motion blur.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sim_worlds.hpp"
#include "tread/sim/camera_view.hpp"

namespace tread {
namespace {

using Shape = Solid::Shape;
using testing::camera_pose;
using testing::make_solid;
using testing::shared;
using testing::world_with_ground;

constexpr double kRad = std::numbers::pi / 180.0;

Scene scene_of(World world) {
  return std::move(Scene::make(shared(std::move(world))).value());
}
PinholeCamera pinhole(int width, int height, double f) {
  return {f, f, 0.5 * (width - 1), 0.5 * (height - 1), 0.0};
}
CameraView view_of(const Scene& scene, const CameraModel& camera, const ImageSize& size,
                   const CameraShot& shot, const RenderOptions& options = {}) {
  const CameraRays rays = make_camera_rays(camera, size).value();
  CameraView view;
  const Status done = render(scene, rays, shot, options, view);
  EXPECT_TRUE(done) << done.error().message();
  return view;
}
RenderOptions depth_only() {
  RenderOptions options;
  options.light = false;
  return options;
}

// A camera that pans while its rows are read out leans a post by focal length x way of the pan.
TEST(CameraShot, RollingShutterLeansWhatStandsUpright) {
  World world = world_with_ground(Surface::kSoil);
  world.solids = {make_solid(Shape::kBox, {5.0, 0.0, 0.0}, {0.05, 0.05, 9.0})};
  const Scene scene = scene_of(std::move(world));
  constexpr double kF = 300.0, kPanDeg = 4.0;
  const CameraModel camera = pinhole(120, 101, kF);
  CameraShot shot;
  shot.T_world_start = camera_pose({0, 0, 2}, -0.5 * kPanDeg, 0.0);
  shot.T_world_end = camera_pose({0, 0, 2}, 0.5 * kPanDeg, 0.0);
  const auto column = [&](const CameraView& view, int v) {
    double sum = 0.0, count = 0.0;
    for (int u = 0; u < 120; ++u) {
      if (view.depth(u, v) < 5.2F && view.depth(u, v) > 4.8F) {
        sum += u;
        ++count;
      }
    }
    return sum / count;
  };
  shot.readout_s = 0.03;
  const CameraView rolling = view_of(scene, camera, {120, 101}, shot, depth_only());
  for (const int v : {0, 25, 50, 75, 100}) {
    const double yaw = (v / 100.0 - 0.5) * kPanDeg * kRad;  // to the left: things move right
    EXPECT_NEAR(column(rolling, v), 59.5 + kF * std::tan(yaw), 0.6) << v;
  }
  // All rows half way.
  shot.readout_s = 0.0;
  const CameraView global = view_of(scene, camera, {120, 101}, shot, depth_only());
  for (const int v : {0, 50, 100}) EXPECT_NEAR(column(global, v), 59.5, 0.6);
}

// An edge that a pan drags over the image becomes a ramp as wide as the way.
TEST(CameraShot, MotionBlurIsAsWideAsTheWay) {
  World world = world_with_ground(Surface::kSoil);
  world.solids = {make_solid(Shape::kBox, {5.0, 0.0, 2.0}, {0.1, 9.0, 9.0}, Surface::kPlain),
                  make_solid(Shape::kBox, {4.7, 9.0, 2.0}, {0.1, 9.0, 9.0}, Surface::kPlain)};
  world.solids[1].material.albedo.setConstant(0.05F);
  world.sun.azimuth_rad = std::numbers::pi;
  const Scene scene = scene_of(std::move(world));
  constexpr double kF = 400.0, kPanDeg = 2.0;
  RenderOptions options;
  options.shadows = false;
  const auto ramp = [&](int samples, double pan_deg) {
    options.samples = samples;
    CameraShot shot;
    shot.T_world_start = camera_pose({0, 0, 2}, -0.5 * pan_deg, 0.0);
    shot.T_world_end = camera_pose({0, 0, 2}, 0.5 * pan_deg, 0.0);
    shot.exposure_s = 0.01;
    const CameraView view = view_of(scene, pinhole(120, 9, kF), {120, 9}, shot, options);
    const float dark = view.grey(0, 4), bright = view.grey(119, 4);
    EXPECT_GT(bright, 3.0F * dark);
    int within = 0;
    for (int u = 0; u < 120; ++u) {
      const float share = (view.grey(u, 4) - dark) / (bright - dark);
      within += share > 0.1F && share < 0.9F ? 1 : 0;
    }
    return within;
  };
  const double way = kF * std::tan(kPanDeg * kRad);
  EXPECT_NEAR(ramp(64, kPanDeg), 0.8 * way, 1.5);
  EXPECT_NEAR(ramp(64, 2.0 * kPanDeg), 1.6 * way, 2.5);
  EXPECT_LE(ramp(1, kPanDeg), 0);
  // Several samples of a camera at rest smooth the edge within one pixel.
  EXPECT_LE(ramp(16, 0.0), 1);
}

}  // namespace
}  // namespace tread
