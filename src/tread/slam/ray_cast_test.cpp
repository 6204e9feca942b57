#include "tread/slam/ray_cast.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "instruction_sets.hpp"
#include "rendered_scene.hpp"
#include "tread/slam/integrate.hpp"
#include "tread/slam/ray_cast_kernel.hpp"

namespace tread {
namespace {

// Voxels that hold the true distance to the scene, wherever it is near.
void fill_exactly(const bench::Scene& scene, const Eigen::Vector3d& low,
                  const Eigen::Vector3d& high, VoxelVolume& volume) {
  const double voxel_m = volume.options().voxel_m;
  const BlockPlace first = volume.block_of(low), last = volume.block_of(high);
  for (int z = first.z(); z <= last.z(); ++z) {
    for (int y = first.y(); y <= last.y(); ++y) {
      for (int x = first.x(); x <= last.x(); ++x) {
        const Eigen::Vector3d middle =
            voxel_m * (Eigen::Vector3d(x, y, z) + Eigen::Vector3d::Constant(0.5)) * kBlockSide;
        if (std::abs(scene.distance(middle)) > 12.0 * voxel_m) continue;
        const int index = volume.touch({x, y, z});
        ASSERT_GE(index, 0);
        for (int v = 0; v < kBlockVoxels; ++v) {
          const Eigen::Vector3d p =
              voxel_m * Eigen::Vector3d(x * 8 + v % 8, y * 8 + v / 8 % 8, z * 8 + v / 64);
          const double d = scene.distance(p) / voxel_m * kDistanceUnits;
          const std::size_t at = VolumeView::voxel_of(index, 0, 0, 0) + static_cast<std::size_t>(v);
          volume.view().distance[at] =
              static_cast<std::int16_t>(std::lround(std::clamp(d, -30000.0, 30000.0)));
          volume.view().weight[at] = 1;
        }
      }
    }
  }
}

TEST(RayCast, FindsABallThatIsExactInTheVolume) {
  const bench::Scene ball = bench::ball(0.5);
  VoxelVolume volume({.voxel_m = 0.02, .memory_mb = 64});
  fill_exactly(ball, Eigen::Vector3d::Constant(-0.6), Eigen::Vector3d::Constant(0.6), volume);
  bench::Sensor sensor;
  const Isometry3d T = bench::camera_at({-1.5, 0.1, 0.05}, 3.0, 2.0, 20.0);
  const bench::RenderedFrame truth = bench::render(ball, sensor, T, 1);
  for (const double off_m : {0.0, 0.03, -0.03}) {  // seeds that are off
    Image<float> seeds = truth.depth;
    for (int y = 0; y < seeds.height; ++y) {
      for (int x = 0; x < seeds.width; ++x) seeds(x, y) += static_cast<float>(off_m);
    }
    DepthLevel seen;
    seen.resize(sensor.camera, sensor.width, sensor.height);
    ray_cast(volume, T, seeds, 0.12, seen, {2, nullptr});
    int known = 0, found = 0;
    double worst = 0.0, sum = 0.0;
    for (int y = 0; y < seen.height(); ++y) {
      for (int x = 0; x < seen.width(); ++x) {
        if (!(truth.depth(x, y) > 0.0F)) {
          EXPECT_TRUE(std::isnan(seen.depth(x, y)));
          continue;
        }
        ++known;
        const double e = std::abs(seen.depth(x, y) - truth.depth(x, y));
        if (std::isnan(e)) continue;
        ++found;
        sum += e;
        // Rays that graze the ball see it flat.
        if (truth.depth(x, y) < 1.2F) worst = std::max(worst, e);
      }
    }
    EXPECT_GT(found, known * 97 / 100) << off_m;
    EXPECT_LT(sum / found, 0.0004) << off_m;
    EXPECT_LT(worst, 0.002) << off_m;
  }
}

// The vectorised row against the definition for one ray: noisy voxels, holes, seeds that are off.
TEST(RayCastKernel, EqualsTheDefinitionOnEveryInstructionSet) {
  bench::Sensor sensor;
  sensor.noise = DepthNoise{};
  const bench::RenderedFrame frame =
      bench::render(bench::room_corner(), sensor, bench::camera_at({0, 0, 1}, 30, 15, 0), 1);
  VoxelVolume volume({.voxel_m = 0.02, .memory_mb = 64});
  Integrator().integrate({frame.depth, {}, {}, sensor.camera, frame.T_world_camera}, sensor.noise,
                         {}, volume);
  const VolumeView& view = volume.view();
  const Eigen::Vector3d window(view.origin[0], view.origin[1], view.origin[2]);
  const Eigen::Vector3f origin =
      (frame.T_world_camera.translation() / 0.02 - window * kBlockSide).cast<float>();
  const Eigen::Matrix3f R = (frame.T_world_camera.linear() / 0.02).cast<float>();
  const Pinhole& c = sensor.camera;
  for (int y = 3; y < 240; y += 29) {
    const Eigen::Vector3f first =
        R * Eigen::Vector3f(-c.cx / c.fx, (static_cast<float>(y) - c.cy) / c.fy, 1.0F);
    const Eigen::Vector3f step = R * Eigen::Vector3f(1.0F / c.fx, 0.0F, 0.0F);
    const RayRow rays{{origin.x(), origin.y(), origin.z()},
                      {first.x(), first.y(), first.z()},
                      {step.x(), step.y(), step.z()}};
    std::vector<float> seeds(frame.depth.row(y), frame.depth.row(y) + 311);
    for (std::size_t x = 0; x < seeds.size(); ++x)
      seeds[x] += 0.02F * static_cast<float>(x % 7) - 0.06F;
    testing::on_every_target([&] {
      std::vector<float> found(seeds.size());
      cast_row(view, rays, seeds.data(), static_cast<int>(seeds.size()), 0.12F, found.data());
      int differ = 0, known = 0;
      for (std::size_t x = 0; x < seeds.size(); ++x) {
        const auto u = static_cast<float>(x);
        const Ray ray{
            {origin.x(), origin.y(), origin.z()},
            {first.x() + u * step.x(), first.y() + u * step.y(), first.z() + u * step.z()}};
        const float expected = seeds[x] > 0.0F ? cast_ray(view, ray, seeds[x], 0.12F)
                                               : std::numeric_limits<float>::quiet_NaN();
        known += expected == expected ? 1 : 0;
        const bool same =
            std::isnan(expected) ? std::isnan(found[x]) : std::abs(found[x] - expected) < 2e-5F;
        differ += same ? 0 : 1;
      }
      EXPECT_GT(known, 150) << y;
      EXPECT_LE(differ, 4) << y;
    });
  }
}

TEST(RayCast, SeesNothingWhereNothingIsKnownAndNoSurfaceFromBehind) {
  const bench::Scene ground = bench::flat_ground(true);
  VoxelVolume volume({.voxel_m = 0.02, .memory_mb = 64});
  fill_exactly(ground, {-0.5, -0.5, -0.2}, {0.5, 0.5, 0.2}, volume);
  DepthLevel seen;
  seen.resize({50.0F, 50.0F, 9.5F, 9.5F}, 20, 20);
  const Image<float> seeds(20, 20, 1.0F);
  ray_cast(volume, bench::camera_at({0, 0, 1.0}, 0, 90, 0), seeds, 0.1, seen);
  EXPECT_NEAR(seen.depth(10, 10), 1.0F, 1e-4F);
  ray_cast(volume, bench::camera_at({0, 0, -1.0}, 0, -90, 0), seeds, 0.1, seen);
  EXPECT_TRUE(std::isnan(seen.depth(10, 10))) << "from below the ground";
  ray_cast(volume, bench::camera_at({3, 0, 1.0}, 0, 90, 0), seeds, 0.1, seen);
  EXPECT_TRUE(std::isnan(seen.depth(10, 10)));
  const Image<float> no_seeds(20, 20, std::numeric_limits<float>::quiet_NaN());
  ray_cast(volume, bench::camera_at({0, 0, 1.0}, 0, 90, 0), no_seeds, 0.1, seen);
  EXPECT_TRUE(std::isnan(seen.depth(10, 10)));
}

// Goal: the fused surface of a rendered staircase within 3 mm RMS at 1.5 m.
TEST(RayCast, FusedStairsAreWithinThreeMillimetres) {
  bench::Sensor sensor;
  sensor.noise = DepthNoise{};
  const bench::Scene stairs = bench::stairs(0.3, 0.15);
  VoxelVolume volume({.voxel_m = 0.01, .memory_mb = 128});
  Integrator integrator;
  const auto pose = [](int i) {
    return bench::camera_at({-0.9 + 0.004 * i, 0.02 * std::sin(0.3 * i), 1.0}, 0.0, 35.0, 0.0);
  };
  for (int i = 0; i < 30; ++i) {
    const bench::RenderedFrame frame =
        bench::render(stairs, sensor, pose(i), static_cast<std::uint32_t>(i));
    volume.centre_on(frame.T_world_camera.translation());
    integrator.integrate({frame.depth, {}, frame.grey, sensor.camera, frame.T_world_camera},
                         sensor.noise, {}, volume);
  }
  bench::Sensor exact = sensor;
  exact.noise = {0.0, 0.0};
  const bench::RenderedFrame truth = bench::render(stairs, exact, pose(29), 1);
  DepthLevel seen;
  seen.resize(sensor.camera, sensor.width, sensor.height);
  ray_cast(volume, pose(29), truth.depth, 0.1, seen);
  double sum = 0.0;
  int count = 0, known = 0;
  for (int y = 0; y < seen.height(); ++y) {
    for (int x = 0; x < seen.width(); ++x) {
      if (!(truth.depth(x, y) < 2.0F)) continue;
      ++known;
      // To the surface, not along the ray.
      const Eigen::Vector3d p =
          pose(29) * (Eigen::Vector3d((x - 159.5) / 290.0, (y - 119.5) / 290.0, 1.0) *
                      static_cast<double>(seen.depth(x, y)));
      if (!p.allFinite()) continue;
      const double d = stairs.distance(p);
      sum += d * d;
      ++count;
    }
  }
  ASSERT_GT(known, 20'000);
  EXPECT_GT(count, known * 9 / 10);
  const double rms = std::sqrt(sum / count);
  ::testing::Test::RecordProperty("rms_mm", std::to_string(1000.0 * rms));
  EXPECT_LT(rms, 0.003);
}

}  // namespace
}  // namespace tread
