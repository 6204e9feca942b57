#include "tread/slam/depth_level.hpp"

#include <gtest/gtest.h>

#include <random>

#include "instruction_sets.hpp"
#include "rendered_scene.hpp"

namespace tread {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

Image<float> random_depth(int width, int height, unsigned seed) {
  std::mt19937 random(seed);
  Image<float> depth(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto pick = random() % 10;
      depth(x, y) = pick == 0 ? kNan
                              : 1.0F + 0.3F * static_cast<float>(pick == 1) +
                                    1e-3F * static_cast<float>(random() % 8);
    }
  }
  return depth;
}

TEST(HalveDepth, MeanOfTheFourThatAreNotBehind) {
  const DepthNoise noise{0.001, 0.0};  // three sigma: 3 mm
  Image<float> depth(6, 2);
  const float rows[2][6] = {{1.000F, 1.002F, 1.0F, 2.0F, kNan, kNan},
                            {1.001F, 1.001F, 1.0F, kNan, kNan, 3.0F}};
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < 6; ++x) depth(x, y) = rows[y][x];
  }
  Image<float> half;
  testing::on_every_target([&] {
    halve_depth(depth, noise, half);
    ASSERT_EQ(half.width, 3);
    ASSERT_EQ(half.height, 1);
    EXPECT_NEAR(half(0, 0), 1.001F, 1e-6F);
    EXPECT_NEAR(half(1, 0), 1.0F, 1e-6F) << "the far one does not count";
    EXPECT_NEAR(half(2, 0), 3.0F, 1e-6F);
  });
}

TEST(SmoothDepth, EqualsItsDefinition) {
  const DepthNoise noise{0.002, 0.001};
  constexpr float kFocal = 100.0F;
  for (const int spacing : {1, 2}) {
    const Image<float> depth = random_depth(37, 23, 3);
    Image<float> expected(37, 23);
    for (int y = 0; y < 23; ++y) {
      for (int x = 0; x < 37; ++x) {
        const float z = depth(x, y);
        const double gate =
            3.0 * noise.sigma_m(z) + 1.5 * 2.0 * spacing * z / static_cast<double>(kFocal);
        double sum = 0.0;
        int count = 0;
        for (int j = -2; j <= 2; ++j) {
          for (int i = -2; i <= 2; ++i) {
            const int u = x + i * spacing, v = y + j * spacing;
            if (u < 0 || v < 0 || u >= 37 || v >= 23) continue;
            if (!(std::abs(depth(u, v) - z) <= gate)) continue;
            sum += depth(u, v);
            ++count;
          }
        }
        expected(x, y) = count > 0 ? static_cast<float>(sum / count) : kNan;
      }
    }
    testing::on_every_target([&] {
      Image<float> smooth;
      smooth_depth(depth, noise, kFocal, spacing, smooth, {2, nullptr});
      for (int y = 0; y < 23; ++y) {
        for (int x = 0; x < 37; ++x) {
          if (std::isnan(expected(x, y))) {
            ASSERT_TRUE(std::isnan(smooth(x, y)));
          } else {
            ASSERT_NEAR(smooth(x, y), expected(x, y), 2e-6F);
          }
        }
      }
    });
  }
}

// Planes of every tilt: the normal is that of the plane and points to the camera.
TEST(NormalFinder, NormalsOfPlanesOnEveryInstructionSet) {
  const Pinhole camera{120.0F, 110.0F, 32.0F, 20.0F};
  for (const Eigen::Vector3f& n : {Eigen::Vector3f(0, 0, -1), Eigen::Vector3f(0.3F, -0.2F, -1),
                                   Eigen::Vector3f(0, -1, -0.8F)}) {
    const Eigen::Vector3f normal = n.normalized();
    DepthLevel level;
    level.resize(camera, 65, 41);
    for (int y = 0; y < 41; ++y) {
      for (int x = 0; x < 65; ++x) {
        const Eigen::Vector3f ray((static_cast<float>(x) - camera.cx) / camera.fx,
                                  (static_cast<float>(y) - camera.cy) / camera.fy, 1.0F);
        const float z = -1.5F / normal.dot(ray);
        level.depth(x, y) = z > 0.0F && z < 20.0F ? z : kNan;
      }
    }
    testing::on_every_target([&] {
      NormalFinder().find({1e-4, 0.0}, level);
      int known = 0;
      for (int y = 0; y < 41; ++y) {
        for (int x = 0; x < 65; ++x) {
          const Eigen::Vector3f found(level.normal[0](x, y), level.normal[1](x, y),
                                      level.normal[2](x, y));
          const bool border = x == 0 || y == 0 || x == 64 || y == 40;
          EXPECT_TRUE(!border || std::isnan(found.x()));
          if (std::isnan(found.x())) continue;
          ++known;
          ASSERT_NEAR((found - normal).norm(), 0.0F, 2e-4F);
        }
      }
      EXPECT_GT(known, 400);
    });
  }
}

// A step of depth has no surface across it.
TEST(NormalFinder, NoneAcrossAnEdge) {
  DepthLevel level;
  level.resize({100.0F, 100.0F, 16.0F, 8.0F}, 32, 16);
  for (int y = 0; y < 16; ++y) {
    for (int x = 0; x < 32; ++x) level.depth(x, y) = x < 16 ? 1.0F : 2.0F;
  }
  NormalFinder().find({1e-4, 0.0}, level);
  EXPECT_TRUE(std::isnan(level.normal[2](15, 8)));
  EXPECT_TRUE(std::isnan(level.normal[2](16, 8)));
  EXPECT_NEAR(level.normal[2](14, 8), -1.0F, 1e-5F);
}

// What the smoothing is for: at the noise of either kind of sensor, most normals are good to some
// ten degrees.
TEST(NormalFinder, NoiseLeavesNormalsOfUse) {
  bench::Sensor sensor;
  for (const bool stereo : {false, true}) {
    DepthNoise noise;
    if (stereo) {
      sensor.stereo_sigma_px = 0.25;
      noise = stereo_noise(290.0, 0.12, 0.25);
      sensor.noise = {0.0, 0.0};
    } else {
      sensor.noise = noise;
    }
    const bench::RenderedFrame frame =
        bench::render(bench::flat_ground(true), sensor, bench::walking_camera(0.0), 1);
    DepthLevel level;
    level.resize(sensor.camera, sensor.width, sensor.height);
    smooth_depth(frame.depth, noise, sensor.camera.fx, 1, level.depth);
    NormalFinder().find(noise, level);
    const Eigen::Vector3f up =
        (frame.T_world_camera.linear().transpose() * Eigen::Vector3d::UnitZ()).cast<float>();
    int good = 0, known = 0;
    for (int y = 0; y < level.height(); ++y) {
      for (int x = 0; x < level.width(); ++x) {
        const Eigen::Vector3f n(level.normal[0](x, y), level.normal[1](x, y),
                                level.normal[2](x, y));
        if (std::isnan(n.x())) continue;
        ++known;
        good += n.dot(up) > std::cos(12.0F * 0.01745F) ? 1 : 0;
      }
    }
    EXPECT_GT(known, 60'000);
    EXPECT_GT(good, known * 8 / 10) << (stereo ? "stereo" : "structured light");
  }
}

}  // namespace
}  // namespace tread
