// A drive over ground with known heights, seen by a stereo rig: images for the tests of pipelines,
// made by following each ray to the ground. No noise; texture fixed to the ground.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>

#include "tread/geometry/samples.hpp"
#include "tread/geometry/stereo_rig.hpp"

namespace tread::testing {

using HeightFunction = std::function<double(double x, double y)>;  // world, metres

// 0 to 1, from a hash of the whole numbers below (x, y, z): the same on every machine.
inline double lattice_noise(std::int64_t x, std::int64_t y, std::int64_t z) {
  auto h = static_cast<std::uint64_t>(x) * 0x9E3779B97F4A7C15ULL ^
           static_cast<std::uint64_t>(y) * 0xC2B2AE3D27D4EB4FULL ^
           static_cast<std::uint64_t>(z) * 0x165667B19E3779F9ULL;
  h ^= h >> 29;
  h *= 0xBF58476D1CE4E5B9ULL;
  h ^= h >> 32;
  return static_cast<double>(h & 0xFFFFFFU) / static_cast<double>(0x1000000U);
}

// Smooth noise of one grain size.
inline double smooth_noise(const Eigen::Vector3d& p, double grain_m) {
  const Eigen::Vector3d q = p / grain_m;
  const Eigen::Vector3d base = q.array().floor();
  const Eigen::Vector3d f = q - base;
  double sum = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const int i = corner & 1, j = corner >> 1 & 1, k = corner >> 2;
    const double weight =
        (i != 0 ? f.x() : 1 - f.x()) * (j != 0 ? f.y() : 1 - f.y()) * (k != 0 ? f.z() : 1 - f.z());
    sum += weight * lattice_noise(static_cast<std::int64_t>(base.x()) + i,
                                  static_cast<std::int64_t>(base.y()) + j,
                                  static_cast<std::int64_t>(base.z()) + k);
  }
  return sum;
}

// Grey value of the ground at a place: two grain sizes, so that near and far have texture.
inline std::uint8_t ground_texture(const Eigen::Vector3d& p) {
  const double value = 0.5 * smooth_noise(p, 0.02) + 0.5 * smooth_noise(p, 0.08);
  return static_cast<std::uint8_t>(std::lround(255.0 * value));
}

// The image of a pinhole camera with pose T_world_camera; the sky is 128.
inline Image<std::uint8_t> render(const PinholeCamera& camera, ImageSize size,
                                  const Isometry3d& T_world_camera, const HeightFunction& height,
                                  double far_m) {
  Image<std::uint8_t> image(size.width, size.height, 128);
  const Eigen::Vector3d eye = T_world_camera.translation();
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      const Eigen::Vector3d ray =
          T_world_camera.linear() *
          Eigen::Vector3d((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1.0);
      const auto above = [&](double z) {
        const Eigen::Vector3d p = eye + z * ray;
        return p.z() - height(p.x(), p.y());
      };
      double before = 0.2;
      for (double z = before; z < far_m; z += 0.04) {
        if (above(z) > 0.0) {
          before = z;
          continue;
        }
        double low = before, high = z;  // the ground lies between
        for (int i = 0; i < 12; ++i) {
          const double middle = 0.5 * (low + high);
          (above(middle) > 0.0 ? low : high) = middle;
        }
        image(u, v) = ground_texture(eye + high * ray);
        break;
      }
    }
  }
  return image;
}

// Flat ground with a block 0.5 m high across the way, from (3.0, -1.2) to (3.6, 0.6), and a kerb of
// 10 cm on the left, y > 1.6.
inline double block_and_kerb(double x, double y) {
  if (x > 3.0 && x < 3.6 && y > -1.2 && y < 0.6) return 0.5;
  return y > 1.6 ? 0.1 : 0.0;
}

// A rover's rectified cameras: 320x240, f 250 px, 0.2 m baseline, 0.8 m high, 25 degrees down.
inline StereoRig small_rig() {
  StereoRig rig;
  rig.name = "small";
  rig.size = {320, 240};
  rig.left = rig.right = PinholeCamera{250.0, 250.0, 159.5, 119.5, 0.0};
  rig.T_left_right.translation().x() = 0.2;
  rig.rectified = true;
  rig.mount = level_mount(0.8, 0.44, false);
  return rig;
}

inline StereoFrame render_frame(const StereoRig& rig, const Isometry3d& T_world_left,
                                const HeightFunction& height, double far_m) {
  StereoFrame frame;
  frame.T_world_left = T_world_left;
  frame.left = render(pinhole_of(rig.left), rig.size, T_world_left, height, far_m);
  frame.right =
      render(pinhole_of(rig.right), rig.size, T_world_left * rig.T_left_right, height, far_m);
  return frame;
}

}  // namespace tread::testing
