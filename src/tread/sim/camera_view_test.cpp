// Rendered depth against planes, ellipsoids and boxes worked out here, pixel by pixel; and light
// where it must be.
#include "tread/sim/camera_view.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>

#include "sim_worlds.hpp"
#include "tread/geometry/stereo_rig.hpp"

namespace tread {
namespace {

using Eigen::Vector3d;
using Shape = Solid::Shape;
using testing::camera_pose;
using testing::make_solid;
using testing::shared;
using testing::world_with_ground;

constexpr double kTenthMm = 1e-4;
constexpr double kRad = std::numbers::pi / 180.0;

Scene scene_of(World world) {
  return std::move(Scene::make(shared(std::move(world))).value());
}
PinholeCamera pinhole(int width, int height, double f) {
  return {f, f, 0.5 * (width - 1), 0.5 * (height - 1), 0.0};
}
CameraView view_of(const Scene& scene, const CameraModel& camera, const ImageSize& size,
                   const CameraShot& shot, const RenderOptions& options = {},
                   const Context& context = {}) {
  const CameraRays rays = make_camera_rays(camera, size).value();
  CameraView view;
  const Status done = render(scene, rays, shot, options, view, context);
  EXPECT_TRUE(done) << done.error().message();
  return view;
}
RenderOptions depth_only() {
  RenderOptions options;
  options.light = false;
  return options;
}

// The nearest of flat ground (within its border) and of boxes and ellipsoids that are not turned.
std::optional<double> distance_to(const World& world, const Vector3d& o, const Vector3d& d) {
  double nearest = std::numeric_limits<double>::infinity();
  if (d.z() != 0.0) {
    const double t = -o.z() / d.z();
    const GridGeometry& cells = world.ground.geometry;
    const double border = -cells.origin.x() - 0.5 * cells.resolution_m;
    const Vector3d p = o + t * d;
    if (t > 0.0 && p.head<2>().cwiseAbs().maxCoeff() <= border) nearest = t;
  }
  for (const Solid& solid : world.solids) {
    const Vector3d from = (o - solid.T_world_solid.translation()).cwiseQuotient(solid.half_m),
                   along = d.cwiseQuotient(solid.half_m);
    if (solid.shape == Shape::kEllipsoid) {
      const double a = along.squaredNorm(), b = from.dot(along), c = from.squaredNorm() - 1.0;
      const double root = b * b - a * c;
      if (root >= 0.0 && -b > std::sqrt(root)) {
        nearest = std::min(nearest, (-b - std::sqrt(root)) / a);
      }
      continue;
    }
    double enter = 0.0, leave = nearest;
    for (int i = 0; i < 3; ++i) {
      const double first = (-1.0 - from(i)) / along(i), second = (1.0 - from(i)) / along(i);
      enter = std::max(enter, std::min(first, second));
      leave = std::min(leave, std::max(first, second));
    }
    if (enter < leave) nearest = enter;
  }
  return std::isfinite(nearest) ? std::optional(nearest) : std::nullopt;
}

World plane_ball_and_stairs() {
  World world = world_with_ground(Surface::kConcrete, 30.0, 0.5);
  world.solids = {make_solid(Shape::kEllipsoid, {3.0, 0.8, 0.7}, {0.6, 0.4, 0.5}),
                  make_solid(Shape::kEllipsoid, {5.0, -1.5, 0.8}, {0.8, 0.8, 0.8})};
  for (int i = 0; i < 5; ++i) {
    const double z = 0.085 * (i + 1);
    world.solids.push_back(make_solid(Shape::kBox, {5.0 + 0.29 * i, 1.9, z}, {1.0, 0.9, z}));
  }
  return world;
}

struct NamedCamera {
  const char* name;
  CameraModel model;
  ImageSize size;
};
std::vector<NamedCamera> cameras() {
  BrownCamera brown;
  brown.pinhole = pinhole(161, 123, 90.0);
  brown.lx = 0.01;
  brown.K = {-0.12, 0.03, -0.002, 0.0, 0.0};
  brown.P = {0.001, -0.0007, 0.0, 0.0, 0.0};
  KannalaBrandtCamera wide{70.0, 71.0, 82.0, 58.0, {-0.01, 0.003, -0.001, 0.0002}};
  return {{"pinhole", pinhole(161, 123, 110.0), {161, 123}},
          {"Brown", brown, {161, 123}},
          {"Kannala-Brandt", wide, {161, 123}}};
}

TEST(CameraView, DepthIsThatOfPlaneEllipsoidsAndStairs) {
  const World world = plane_ball_and_stairs();
  const Scene scene = scene_of(world);
  for (const NamedCamera& camera : cameras()) {
    for (const Isometry3d& T :
         {camera_pose({0.0, 0.0, 1.0}, 0.0, 15.0), camera_pose({1.5, 2.0, 2.2}, -8.0, 35.0, 10.0),
          camera_pose({8.5, 3.0, 0.4}, -150.0, -2.0, -20.0)}) {
      const CameraView view =
          view_of(scene, camera.model, camera.size, CameraShot::still(T), depth_only());
      int wrong = 0, known = 0;
      double worst = 0.0;
      for (int v = 0; v < camera.size.height; ++v) {
        for (int u = 0; u < camera.size.width; ++u) {
          const Unprojection seen = unproject(camera.model, Eigen::Vector2d(u, v));
          const auto t = seen.valid ? distance_to(world, T.translation(), T.linear() * seen.bearing)
                                    : std::nullopt;
          const bool in_front = t && seen.bearing.z() > 0.0;
          const auto depth = static_cast<double>(view.depth(u, v));
          if (!in_front || std::isnan(depth)) {
            wrong += in_front != !std::isnan(depth) ? 1 : 0;
            continue;
          }
          const double error = std::abs(depth - *t * seen.bearing.z());
          ++known;
          wrong += error > kTenthMm ? 1 : 0;
          if (error <= kTenthMm) worst = std::max(worst, error);
        }
      }
      EXPECT_GT(known, 5000) << camera.name;
      // A ray through the very edge of a thing may go either way.
      EXPECT_LE(wrong, 1) << camera.name;
      EXPECT_LT(worst, 0.1 * kTenthMm) << camera.name;
    }
  }
}

TEST(CameraView, SkyHasLightAndNoDepth) {
  World world = world_with_ground(Surface::kSoil);
  world.seed = 5;
  const Scene scene = scene_of(std::move(world));
  const CameraView view = view_of(scene, pinhole(64, 48, 60.0), {64, 48},
                                  CameraShot::still(camera_pose({0, 0, 1}, 0.0, -50.0)));
  float low = 1e9F, high = 0.0F;
  for (int v = 0; v < 48; ++v) {
    for (int u = 0; u < 64; ++u) {
      EXPECT_TRUE(std::isnan(view.depth(u, v)));
      low = std::min(low, view.grey(u, v));
      high = std::max(high, view.grey(u, v));
    }
  }
  EXPECT_GT(low, 0.05F);
  EXPECT_GT(high, 1.2F * low) << "clouds";
}

// Pixels that the model of a wide lens has no bearing for, and those that look behind the camera.
TEST(CameraView, PixelsWithoutRayAreDark) {
  const KannalaBrandtCamera wide{12.0, 12.0, 39.5, 39.5, {0.0, 0.0, 0.0, 0.0}};
  const Scene scene = scene_of(world_with_ground(Surface::kSoil));
  const CameraView view =
      view_of(scene, wide, {80, 80}, CameraShot::still(camera_pose({0, 0, 1}, 0.0, 0.0)));
  int none = 0, behind = 0;
  for (int v = 0; v < 80; ++v) {
    for (int u = 0; u < 80; ++u) {
      const Unprojection seen = unproject(CameraModel(wide), Eigen::Vector2d(u, v));
      if (!seen.valid) {
        ++none;
        EXPECT_EQ(view.grey(u, v), 0.0F);
        EXPECT_TRUE(std::isnan(view.depth(u, v)));
      } else if (seen.bearing.z() < 0.0) {
        ++behind;
        EXPECT_GT(view.grey(u, v), 0.0F);
        EXPECT_TRUE(std::isnan(view.depth(u, v)));
      }
    }
  }
  EXPECT_GT(behind, 100);
  EXPECT_GT(none, 100) << "the corners, more than half a turn from the axis";
}

// The place on the ground or on a thing that a pixel shows.
Vector3d seen_at(const CameraModel& camera, const Isometry3d& T, const CameraView& view, int u,
                 int v) {
  const Vector3d bearing = unproject(camera, Eigen::Vector2d(u, v)).bearing;
  return T * (bearing * (static_cast<double>(view.depth(u, v)) / bearing.z()));
}

// A box 0.6 m high under a sun 45 degrees up throws a shadow 0.6 m long, away from the sun.
TEST(CameraView, ShadowOfABoxIsAsLongAsTheBoxIsHigh) {
  World world = world_with_ground(Surface::kPlain);
  world.solids = {make_solid(Shape::kBox, {0.0, 0.0, 0.3}, {0.2, 0.4, 0.3}, Surface::kPlain)};
  world.sun.azimuth_rad = 0.0;
  world.sun.elevation_rad = 45.0 * kRad;
  const Scene scene = scene_of(std::move(world));
  const CameraModel camera = pinhole(200, 160, 300.0);
  const Isometry3d T = camera_pose({-0.6, 0.0, 4.0}, 0.0, 90.0);
  const CameraView view = view_of(scene, camera, {200, 160}, CameraShot::still(T));
  RenderOptions bare;
  bare.shadows = false;
  const CameraView without = view_of(scene, camera, {200, 160}, CameraShot::still(T), bare);
  int dark = 0;
  for (int v = 0; v < 160; ++v) {
    for (int u = 0; u < 200; ++u) {
      const Vector3d p = seen_at(camera, T, view, u, v);
      if (p.z() > 0.01) continue;
      const double along = -0.2 - p.x(), across = std::abs(p.y());
      const double margin =
          std::min({std::abs(along), std::abs(along - 0.6), std::abs(across - 0.4)});
      if (margin < 1e-3) continue;
      const bool in_shadow = along > 0.0 && along < 0.6 && across < 0.4;
      const float share = view.grey(u, v) / without.grey(u, v);
      dark += in_shadow ? 1 : 0;
      if (in_shadow) {
        EXPECT_LT(share, 0.6F) << p.transpose();
      } else {
        EXPECT_EQ(share, 1.0F) << p.transpose();
      }
    }
  }
  EXPECT_GT(dark, 1500);
}

// Lambert: an untextured plane has the light of its slant to the sun, whatever it is seen from.
TEST(CameraView, PlainSurfacesAreAsBrightAsTheSunIsHigh) {
  const CameraModel camera = pinhole(16, 16, 200.0);
  const auto brightness = [&](double elevation_rad, double strength) {
    World world = world_with_ground(Surface::kPlain);
    world.sun.elevation_rad = elevation_rad;
    world.sun.strength = strength;
    world.sun.sky = 0.0;
    const CameraView view = view_of(scene_of(std::move(world)), camera, {16, 16},
                                    CameraShot::still(camera_pose({0, 0, 2}, 0.0, 80.0)));
    return static_cast<double>(view.grey(8, 8));
  };
  const double high = brightness(90.0 * kRad, 1.0);
  EXPECT_NEAR(high, 0.45, 0.01);  // the albedo
  EXPECT_NEAR(brightness(30.0 * kRad, 1.0) / high, 0.5, 1e-3);
  EXPECT_NEAR(brightness(90.0 * kRad, 0.3) / high, 0.3, 1e-3);
  EXPECT_LT(brightness(-5.0 * kRad, 1.0), 1e-6);
}

TEST(CameraView, GreyIsTheBrightnessOfTheColour) {
  const Scene scene = scene_of(plane_ball_and_stairs());
  RenderOptions options;
  const CameraShot shot = CameraShot::still(camera_pose({0.0, 0.0, 1.0}, 0.0, 5.0));
  const CameraView grey = view_of(scene, pinhole(80, 60, 60.0), {80, 60}, shot, options);
  options.colour = true;
  const CameraView colour = view_of(scene, pinhole(80, 60, 60.0), {80, 60}, shot, options);
  EXPECT_TRUE(grey.colour.empty());
  for (int v = 0; v < 60; ++v) {
    for (int u = 0; u < 80; ++u) {
      const LightRgb& c = colour.colour(u, v);
      EXPECT_NEAR(kGreyOf.r * c.r + kGreyOf.g * c.g + kGreyOf.b * c.b, grey.grey(u, v), 1e-5F);
      EXPECT_NEAR(colour.grey(u, v), grey.grey(u, v), 1e-5F);
      EXPECT_EQ(std::bit_cast<std::uint32_t>(colour.depth(u, v)),
                std::bit_cast<std::uint32_t>(grey.depth(u, v)));
    }
  }
}

template <class T>
bool same_bytes(const Image<T>& a, const Image<T>& b) {
  if (!same_size(a, b)) return false;
  for (int v = 0; v < a.height; ++v) {
    if (std::memcmp(a.row(v), b.row(v), sizeof(T) * static_cast<std::size_t>(a.width)) != 0) {
      return false;
    }
  }
  return true;
}

TEST(CameraView, OneAndTwoThreadsGiveTheSameBytes) {
  World world = plane_ball_and_stairs();
  world.ground_materials = {material_of(Surface::kGravel, Season::kAutumn, 1)};
  Person person;
  person.path_m = {{3.0, -1.0}, {3.0, 1.0}};
  world.people = {person};
  const Scene scene = scene_of(std::move(world));
  RenderOptions options;
  options.colour = true;
  options.samples = 3;
  CameraShot shot = CameraShot::still(camera_pose({0.0, 0.0, 1.0}, 0.0, 10.0));
  shot.T_world_end = camera_pose({0.05, 0.0, 1.0}, 2.0, 10.0);
  shot.exposure_s = 0.01;
  shot.readout_s = 0.02;
  // Not a whole number of tiles.
  const CameraView one = view_of(scene, pinhole(183, 121, 120.0), {183, 121}, shot, options);
  for (int i = 0; i < 2; ++i) {
    const CameraView two =
        view_of(scene, pinhole(183, 121, 120.0), {183, 121}, shot, options, Context{2, nullptr});
    EXPECT_TRUE(same_bytes(one.grey, two.grey));
    EXPECT_TRUE(same_bytes(one.colour, two.colour));
    EXPECT_TRUE(same_bytes(one.depth, two.depth));
  }
}

TEST(CameraView, PeopleMoveInThePicture) {
  World world = world_with_ground(Surface::kSoil);
  Person person;
  person.path_m = {{4.0, -2.0}, {4.0, 2.0}};
  person.speed_m_per_s = 1.0;
  world.people = {person};
  Scene scene = scene_of(std::move(world));
  const CameraModel camera = pinhole(160, 120, 100.0);
  const auto column_of_person = [&](double time_s) {
    scene.set_time(time_s);
    const CameraView view =
        view_of(scene, camera, {160, 120}, CameraShot::still(camera_pose({0, 0, 1}, 0.0, 0.0)));
    double sum = 0.0, count = 0.0;
    for (int u = 0; u < 160; ++u) {
      if (view.depth(u, 52) < 4.4F) {
        sum += u;
        ++count;
      }
    }
    return sum / count;
  };
  // y to the left: from right of the image to the left, 25 px a metre.
  EXPECT_NEAR(column_of_person(0.5), 79.5 + 25.0 * 1.5, 3.0);
  EXPECT_NEAR(column_of_person(2.0), 79.5, 3.0);
  EXPECT_NEAR(column_of_person(3.0), 79.5 - 25.0, 3.0);
}

TEST(CameraView, RefusesWhatCannotBe) {
  const Scene scene = scene_of(world_with_ground(Surface::kSoil));
  const CameraRays rays = make_camera_rays(pinhole(16, 16, 20.0), {16, 16}).value();
  CameraView view;
  CameraShot shot;
  RenderOptions options;
  EXPECT_TRUE(render(scene, rays, shot, options, view));
  EXPECT_FALSE(render(scene, {}, shot, options, view));
  options.samples = 0;
  const Status zero = render(scene, rays, shot, options, view);
  ASSERT_FALSE(zero);
  EXPECT_NE(zero.error().message().find("samples"), std::string::npos);
  options.samples = 1;
  shot.exposure_s = -1.0;
  EXPECT_FALSE(render(scene, rays, shot, options, view));
  shot.exposure_s = 0.0;
  shot.T_world_end.linear() *= 1.1;
  EXPECT_FALSE(render(scene, rays, shot, options, view));
  EXPECT_FALSE(make_camera_rays(pinhole(16, 16, 0.0), {16, 16}));
  EXPECT_FALSE(make_camera_rays(pinhole(16, 16, 20.0), {16, 0}));
}

// The sub-pixel rays of a distorted camera, against those of its model.
TEST(CameraRays, BesideIsTheRayOfThatPlace) {
  for (const NamedCamera& camera : cameras()) {
    const CameraRays rays = make_camera_rays(camera.model, camera.size).value();
    for (const Eigen::Vector2i& at : {Eigen::Vector2i(80, 60), {3, 5}, {0, 0}, {160, 122}}) {
      const Vector3d beside = rays.beside(at.x(), at.y(), 0.4, -0.3);
      const Unprojection seen =
          unproject(camera.model, Eigen::Vector2d(at.x() + 0.4, at.y() - 0.3));
      EXPECT_LT((beside - seen.bearing).norm(), 0.01 / 90.0) << camera.name << at.transpose();
    }
    // The solid angle of all pixels together: that of a pinhole image is known.
    if (camera.name != std::string("pinhole")) continue;
    double sum = 0.0;
    for (int v = 0; v < camera.size.height; ++v) {
      for (int u = 0; u < camera.size.width; ++u) {
        const auto side = static_cast<double>(rays.pixels(u, v).spread_rad);
        sum += side * side;
      }
    }
    const double a = 161.0 / 220.0, b = 123.0 / 220.0;
    EXPECT_NEAR(sum, 4.0 * std::asin(a * b / std::sqrt((1.0 + a * a) * (1.0 + b * b))), 0.002);
  }
}

}  // namespace
}  // namespace tread
