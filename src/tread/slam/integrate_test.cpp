#include "tread/slam/integrate.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "instruction_sets.hpp"
#include "rendered_scene.hpp"
#include "tread/slam/integrate_kernel.hpp"

namespace tread {
namespace {

Isometry3d random_pose(std::mt19937& random) {
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  Isometry3d T = Isometry3d::Identity();
  T.linear() = so3_exp({0.4 * u(random), 0.4 * u(random), u(random)});
  T.translation() = Eigen::Vector3d(0.2 * u(random), 0.2 * u(random), 0.1 * u(random));
  return T;
}

// The vectorised block against the definition for one voxel, at random poses, on random depth with
// holes; rounding may differ where a voxel falls between two pixels, which is rare.
TEST(IntegrateKernel, EqualsTheDefinitionOnEveryInstructionSet) {
  std::mt19937 random(11);
  Image<float> depth(61, 47);
  for (int y = 0; y < depth.height; ++y) {
    for (int x = 0; x < depth.width; ++x) {
      depth(x, y) = random() % 7 == 0 ? std::numeric_limits<float>::quiet_NaN()
                                      : 0.9F + 0.0002F * static_cast<float>(random() % 1000);
    }
  }
  for (int round = 0; round < 12; ++round) {
    const Isometry3d T = random_pose(random);
    IntegrateFrame frame;
    frame.depth = depth;
    frame.camera = {60.0F, 58.0F, 30.0F, 23.0F};
    frame.voxel_m = 0.02F;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        frame.R[3 * i + j] = static_cast<float>(T.linear()(i, j)) * frame.voxel_m;
      }
      frame.t[i] = static_cast<float>(T.translation()[i]);
    }
    frame.constant_m = 0.001F;
    frame.quadratic_per_m = round % 2 == 0 ? 0.0F : 0.03F;
    frame.truncation_m = 0.08F;
    frame.reference_m = 0.5F;
    frame.full_weight = 7.0F;
    frame.most_weight = 100.0F;
    frame.along_ray = round % 3 == 0;
    const int bx = static_cast<int>(random() % 40) - 20, by = static_cast<int>(random() % 40) - 20,
              bz = 32 + static_cast<int>(random() % 20);
    alignas(64) std::int16_t distance[kBlockVoxels];
    alignas(64) std::uint8_t weight[kBlockVoxels];
    for (int i = 0; i < kBlockVoxels; ++i) {
      distance[i] = static_cast<std::int16_t>(static_cast<int>(random() % 8000) - 4000);
      weight[i] = static_cast<std::uint8_t>(random() % 100);
    }
    std::int16_t expected[kBlockVoxels];
    std::uint8_t expected_weight[kBlockVoxels];
    std::copy_n(distance, kBlockVoxels, expected);
    std::copy_n(weight, kBlockVoxels, expected_weight);
    int touched = 0;
    for (int i = 0; i < kBlockVoxels; ++i) {
      const auto p_c = [&](int k) {
        return frame.R[3 * k] * static_cast<float>(bx + i % 8) +
               frame.R[3 * k + 1] * static_cast<float>(by + i / 8 % 8) +
               frame.R[3 * k + 2] * static_cast<float>(bz + i / 64) + frame.t[k];
      };
      const float p[3] = {p_c(0), p_c(1), p_c(2)};
      integrate_voxel(frame, p, expected[i], expected_weight[i]);
      touched += expected_weight[i] != weight[i] ? 1 : 0;
    }
    testing::on_every_target([&] {
      alignas(64) std::int16_t found[kBlockVoxels];
      alignas(64) std::uint8_t found_weight[kBlockVoxels];
      std::copy_n(distance, kBlockVoxels, found);
      std::copy_n(weight, kBlockVoxels, found_weight);
      integrate_block(frame, bx, by, bz, found, found_weight, nullptr);
      int differ = 0;
      for (int i = 0; i < kBlockVoxels; ++i) {
        const bool same =
            std::abs(found[i] - expected[i]) <= 1 && found_weight[i] == expected_weight[i];
        differ += same ? 0 : 1;
      }
      EXPECT_LE(differ, 2) << "round " << round << ", " << touched << " voxels seen";
    });
  }
}

// Fused from where it was seen, a plane is where it is, to a tenth of a millimetre.
TEST(Integrator, ASeenPlaneLiesWhereItIs) {
  bench::Sensor sensor;
  const bench::Scene ground = bench::flat_ground(true);
  VoxelVolume volume({.voxel_m = 0.02, .memory_mb = 64});
  Integrator integrator;
  for (int i = 0; i < 5; ++i) {
    const bench::RenderedFrame frame =
        bench::render(ground, sensor, bench::walking_camera(0.05 * i), 1);
    volume.centre_on(frame.T_world_camera.translation());
    const int blocks = integrator.integrate(
        {frame.depth, {}, frame.grey, sensor.camera, frame.T_world_camera}, {}, {}, volume);
    EXPECT_GT(blocks, 100);
  }
  const VolumeView& view = volume.view();
  double sum = 0.0;
  int count = 0, painted = 0;
  for (int index = 0; index < volume.size(); ++index) {
    for (int v = 0; v < kBlockVoxels; ++v) {
      const std::size_t at =
          static_cast<std::size_t>(index) * kBlockVoxels + static_cast<std::size_t>(v);
      if (view.weight[at] == 0) continue;
      const double z = 0.02 * (volume.place(index).z() * 8 + v / 64);
      if (std::abs(z) > 0.021) continue;
      // Distances along the optical axis are not those along z; where it is zero they agree.
      const double d = view.distance[at] * 0.02 / kDistanceUnits;
      EXPECT_TRUE(std::abs(z) < 0.01 || (d > 0.0) == (z > 0.0)) << z << " " << d;
      if (z == 0.0) {
        sum += std::abs(d);
        ++count;
      }
      painted += view.colour[at].g > 0 ? 1 : 0;
    }
  }
  ASSERT_GT(count, 1000);
  EXPECT_LT(sum / count, 0.0015) << "a pixel's depth is nearest, not interpolated";
  EXPECT_GT(painted, 1000);
}

// What stood there and is gone is seen through: the space in front of the new surface empties.
TEST(Integrator, WhatHasMovedAwayIsCarvedOut) {
  const Pinhole camera{60.0F, 60.0F, 31.5F, 23.5F};
  VoxelVolume volume({.voxel_m = 0.02, .memory_mb = 16});
  Integrator integrator;
  IntegrateOptions options;
  options.carve_every = 2;
  const Image<float> near(64, 48, 1.0F), far(64, 48, 1.5F);
  for (int i = 0; i < 10; ++i) integrator.integrate({near, {}, {}, camera}, {}, options, volume);
  const auto distance_at = [&](int z) {
    const int index = volume.find({0, 0, z / 8});
    EXPECT_GE(index, 0);
    return volume.view().distance[VolumeView::voxel_of(index, 0, 0, z % 8)];
  };
  EXPECT_LT(distance_at(51), 0) << "behind the surface at 50 voxels";
  for (int i = 0; i < 60; ++i) integrator.integrate({far, {}, {}, camera}, {}, options, volume);
  EXPECT_GT(distance_at(51), 0);
}

TEST(Integrator, TwoThreadsWriteTheSame) {
  bench::Sensor sensor;
  const bench::RenderedFrame frame =
      bench::render(bench::room_corner(), sensor, bench::camera_at({0, 0, 1}, 30, 15, 0), 1);
  const auto fuse = [&](int threads) {
    VoxelVolume volume({.voxel_m = 0.02, .memory_mb = 64});
    Integrator integrator;
    volume.centre_on(frame.T_world_camera.translation());
    for (int i = 0; i < 3; ++i) {
      integrator.integrate({frame.depth, {}, frame.grey, sensor.camera, frame.T_world_camera}, {},
                           {}, volume, {threads, nullptr});
    }
    std::vector<BlockVoxels> all;
    for (const BlockPlace& place : volume.all_blocks()) {
      BlockVoxels voxels;
      EXPECT_TRUE(volume.read(place, voxels));
      all.push_back(voxels);
    }
    return all;
  };
  EXPECT_EQ(fuse(1), fuse(2));
}

}  // namespace
}  // namespace tread
