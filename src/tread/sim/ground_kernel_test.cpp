// Many rays at once against one ray at a time, which is other code: GroundSurface::hit.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "instruction_sets.hpp"
#include "sim_worlds.hpp"
#include "tread/sim/hash_noise_kernel.hpp"
#include "tread/sim/scene.hpp"

namespace tread {
namespace {

using Eigen::Vector3d;

World rough_world(double away_m) {
  World world = testing::world_with_ground(Surface::kSoil, 12.0, 0.1, [](double x, double y) {
    return 0.3 * std::sin(1.7 * x) * std::cos(1.9 * y) + (x > 2.0 ? 0.15 : 0.0);
  });
  world.ground_materials.push_back(material_of(Surface::kGrass, Season::kSummer, 1));
  for (int y = 0; y < 120; ++y) {
    for (int x = 70; x < 120; ++x) world.ground_surface[{x, y}] = 1;
  }
  world.ground.geometry.origin += Eigen::Vector2d::Constant(away_m);
  world.ground_surface.geometry = world.ground.geometry;
  return world;
}

// 256 rays from one point, in no order.
RayBatch scattered_rays(const Vector3d& from) {
  RayBatch rays;
  rays.count = RayBatch::kMost;
  for (std::size_t i = 0; i < RayBatch::kMost; ++i) {
    const auto k = static_cast<std::uint32_t>(2 * i);
    const Vector3d d =
        Vector3d(static_cast<double>(signed_unit(hash_mix(k))),
                 static_cast<double>(signed_unit(hash_mix(k + 1))), i % 8 == 0 ? 0.2 : -0.5)
            .normalized();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      rays.origin[axis][i] = from(static_cast<Eigen::Index>(axis));
      rays.direction[axis][i] = d(static_cast<Eigen::Index>(axis));
    }
    rays.spread_rad[i] = i % 32 == 5 ? std::nanf("") : 0.003F;
  }
  return rays;
}

TEST(GroundKernel, ManyRaysMeetWhatOneRayMeets) {
  testing::on_every_target([] {
    for (const double away_m : {0.0, 5000.0}) {
      const auto world = testing::shared(rough_world(away_m));
      const Scene scene = Scene::make(world).value();
      const Vector3d from(away_m + 1.3, away_m - 0.7, 1.5);
      const RayBatch rays = scattered_rays(from);
      SurfaceBatch points;
      scene.cast(rays, points);
      int met = 0, other_material = 0;
      for (std::size_t i = 0; i < RayBatch::kMost; ++i) {
        const Vector3d d(rays.direction[0][i], rays.direction[1][i], rays.direction[2][i]);
        const RayHit hit = scene.cast(from, d);
        if (std::isnan(rays.spread_rad[i]) || hit.kind == HitKind::kNothing) {
          EXPECT_TRUE(std::isnan(points.distance_m[i]));
          EXPECT_EQ(points.material[i], -1);
          continue;
        }
        ++met;
        EXPECT_NEAR(points.distance_m[i], hit.distance_m, 1e-9);
        const Vector3d p = from + hit.distance_m * d;
        const Vector3d smooth(static_cast<double>(points.normal_x[i]),
                              static_cast<double>(points.normal_y[i]),
                              static_cast<double>(points.normal_z[i]));
        EXPECT_NEAR(smooth.norm(), 1.0, 1e-5);
        EXPECT_GT(smooth.dot(hit.normal), 0.8);
        const double facing = std::abs(hit.normal.dot(d));
        EXPECT_NEAR(static_cast<double>(points.footprint_m[i]),
                    0.003 * hit.distance_m / std::sqrt(std::max(facing, 0.02)), 1e-5);
        // Where rays to the sun start: above the ground, by less than a millimetre.
        const Vector3d start =
            Vector3d(static_cast<double>(points.from[0][i]), static_cast<double>(points.from[1][i]),
                     static_cast<double>(points.from[2][i])) +
            Vector3d(std::round(away_m), std::round(away_m), 0.0);
        EXPECT_NEAR((start - p).dot(hit.normal), 2e-4, 1e-4);
        const bool grass = ground_material(*world, p.head<2>()).surface == Surface::kGrass;
        other_material += grass != (points.material[i] == 1) ? 1 : 0;
        // Ragged by less than two cells.
        const double border = away_m + 1.0;
        if (std::abs(p.x() - border) > 0.2) {
          EXPECT_EQ(points.material[i], grass ? 1 : 0);
        }
      }
      EXPECT_GT(met, 150);
      EXPECT_LT(other_material, 12);
    }
  });
}

// A smooth slope has its own normal, though it is made of flat triangles; an edge keeps its edge.
TEST(GroundKernel, LightIsSmoothOnSlopesAndHardAtEdges) {
  World world = testing::world_with_ground(Surface::kSoil, 12.0, 0.1, [](double x, double) {
    return x < 0.0 ? 0.05 * x * x : (x > 3.0 ? 0.5 : 0.0);
  });
  const Scene scene = Scene::make(testing::shared(std::move(world))).value();
  RayBatch rays;
  rays.count = RayBatch::kMost;
  const auto x_of = [](std::size_t i) { return -4.0 + 7.5 * static_cast<double>(i) / 256.0; };
  for (std::size_t i = 0; i < RayBatch::kMost; ++i) {
    rays.origin[0][i] = x_of(i);
    rays.origin[1][i] = 0.013;
    rays.origin[2][i] = 3.0;
    rays.direction[0][i] = rays.direction[1][i] = 0.0;
    rays.direction[2][i] = -1.0;
    rays.spread_rad[i] = 0.003F;
  }
  SurfaceBatch points;
  scene.cast(rays, points);
  for (std::size_t i = 0; i < RayBatch::kMost; ++i) {
    const double x = x_of(i);
    const auto tilt = static_cast<double>(points.normal_x[i] / points.normal_z[i]);
    if (x < -0.2) {
      EXPECT_NEAR(tilt, -0.1 * x, 2e-3) << x;  // central differences of a parabola are exact
    } else if (x > 0.2 && x < 2.8) {
      EXPECT_NEAR(tilt, 0.0, 1e-5) << x;
    } else if (x > 3.06) {
      // The wall lies between the centres 2.95 and 3.05; the smooth slope reaches one further.
      EXPECT_NEAR(tilt, 0.0, x < 3.15 ? 0.7 : 1e-5) << x;
    }
  }
}

}  // namespace
}  // namespace tread
