// A room, or a street, of textured planes and pictures of it from any pose: no tracing, so that
// tests can afford hundreds of pairs. World: z up, metres.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "tread/core/image.hpp"
#include "tread/geometry/samples.hpp"
#include "tread/geometry/stereo_rig.hpp"

namespace tread {

class PlaneWorld {
 public:
  // 6 x 5 m, 2.6 m high.
  [[nodiscard]] static PlaneWorld room() {
    return {{{{0, 0, 1}, 0.0},
             {{-1, 0, 0}, -4.0},
             {{1, 0, 0}, -2.0},
             {{0, -1, 0}, -3.0},
             {{0, 1, 0}, -2.0},
             {{0, 0, -1}, -2.6}},
            0.2};
  }
  // Along x, between two rows of houses.
  [[nodiscard]] static PlaneWorld street() {
    return {{{{0, 0, 1}, 0.0}, {{-1, 0, 0}, -300.0}, {{0, -1, 0}, -6.0}, {{0, 1, 0}, -7.0}}, 1.0};
  }

  // What a camera at T_world_camera sees along these rays, one a pixel in rows; noise of `sigma`
  // grey values. A ray is of any length.
  [[nodiscard]] Image<std::uint8_t> picture(const std::vector<Eigen::Vector3d>& rays,
                                            ImageSize size, const Isometry3d& T_world_camera,
                                            double sigma, std::uint32_t seed) const {
    Image<std::uint8_t> image(size.width, size.height);
    const Eigen::Matrix3d& R = T_world_camera.linear();
    const Eigen::Vector3d p = T_world_camera.translation();
    std::size_t i = 0;
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x, ++i) {
        const Eigen::Vector3d ray = R * rays[i];
        double nearest = std::numeric_limits<double>::infinity();
        std::uint32_t which = 0;
        for (std::uint32_t k = 0; k < planes_.size(); ++k) {
          const double along = planes_[k].normal.dot(ray);
          const double t = (planes_[k].offset - planes_[k].normal.dot(p)) / along;
          if (t > 0.0 && t < nearest) {
            nearest = t;
            which = k;
          }
        }
        const double noise = sigma * 1.7 * (2.0 * unit(seed, x, y) - 1.0);
        image(x, y) = static_cast<std::uint8_t>(
            std::clamp(texture(p + nearest * ray, which) + noise, 0.0, 255.0));
      }
    }
    return image;
  }
  // The same of a pinhole camera.
  [[nodiscard]] Image<std::uint8_t> picture(const RectifiedRig& rig,
                                            const Isometry3d& T_world_camera, double sigma,
                                            std::uint32_t seed) const {
    std::vector<Eigen::Vector3d> rays;
    for (int y = 0; y < rig.size.height; ++y) {
      for (int x = 0; x < rig.size.width; ++x) {
        rays.emplace_back((x - rig.cx_px) / rig.fx_px, (y - rig.cy_px) / rig.fy_px, 1.0);
      }
    }
    return picture(rays, rig.size, T_world_camera, sigma, seed);
  }

  // Both images of a rectified pair whose left camera is at T_world_left.
  struct Pair {
    Image<std::uint8_t> left, right;
  };
  [[nodiscard]] Pair pair(const RectifiedRig& rig, const Isometry3d& T_world_left, double sigma,
                          std::uint32_t seed) const {
    Isometry3d T_world_right = T_world_left;
    T_world_right.translation() = T_world_left * Eigen::Vector3d(rig.baseline_m, 0.0, 0.0);
    return {picture(rig, T_world_left, sigma, 2 * seed),
            picture(rig, T_world_right, sigma, 2 * seed + 1)};
  }

 private:
  struct Plane {
    Eigen::Vector3d normal;
    double offset;
  };
  PlaneWorld(std::vector<Plane> planes, double grain_m)
      : planes_(std::move(planes)), grain_m_(grain_m) {}

  // In [0, 1), a function of its arguments.
  [[nodiscard]] static double unit(std::uint32_t seed, int x, int y) {
    std::uint32_t h = seed * 0x9E3779B1U + static_cast<std::uint32_t>(x) * 0x85EBCA77U +
                      static_cast<std::uint32_t>(y) * 0xC2B2AE3DU;
    h = (h ^ (h >> 15)) * 0x2C1B3C6DU;
    h = (h ^ (h >> 12)) * 0x297A2D39U;
    return static_cast<double>(h ^ (h >> 15)) / 4294967296.0;
  }
  [[nodiscard]] static double smooth_noise(double u, double v, std::uint32_t seed) {
    const double fu = std::floor(u), fv = std::floor(v);
    const int iu = static_cast<int>(fu), iv = static_cast<int>(fv);
    const auto ease = [](double t) { return t * t * (3.0 - 2.0 * t); };
    const double a = ease(u - fu), b = ease(v - fv);
    const double upper = (1 - a) * unit(seed, iu, iv) + a * unit(seed, iu + 1, iv);
    const double lower = (1 - a) * unit(seed, iu, iv + 1) + a * unit(seed, iu + 1, iv + 1);
    return (1 - b) * upper + b * lower;
  }
  // Patches of the grain and of a third of it.
  [[nodiscard]] double texture(const Eigen::Vector3d& p, std::uint32_t plane) const {
    const Eigen::Vector3d& n = planes_[plane].normal;
    const double u = (std::abs(n.x()) > 0.5 ? p.y() : p.x()) / grain_m_,
                 v = (std::abs(n.z()) > 0.5 ? p.y() : p.z()) / grain_m_;
    return 30.0 + 110.0 * smooth_noise(u, v, 7 + plane) +
           90.0 * smooth_noise(3.3 * u, 3.3 * v, 77 + plane);
  }

  std::vector<Plane> planes_;
  double grain_m_;
};

// A pair of 480 x 360 pixels with 10 cm between the cameras.
[[nodiscard]] inline RectifiedRig plane_world_rig() {
  RectifiedRig rig;
  rig.size = {480, 360};
  rig.fx_px = rig.fy_px = 330.0;
  rig.cx_px = 239.5;
  rig.cy_px = 179.5;
  rig.baseline_m = 0.10;
  return rig;
}

// A camera carried through the room, smooth in time, at rest before zero: looks along x, about 1.2
// m high.
[[nodiscard]] inline Isometry3d plane_world_pose(double time_s) {
  const double t = std::max(time_s, 0.0);
  Isometry3d T = Isometry3d::Identity();
  const double begin = std::min(t, 1.0) * std::min(t, 1.0) * (3.0 - 2.0 * std::min(t, 1.0));
  T.translation() =
      Eigen::Vector3d(0.5 * begin * std::sin(0.6 * t), 0.4 * begin * std::sin(0.8 * t),
                      1.2 + 0.15 * begin * std::sin(1.1 * t));
  T.linear() = rotation_from_yaw_pitch_roll(0.35 * begin * std::sin(0.7 * t),
                                            0.12 * begin * std::sin(0.9 * t) + 0.1,
                                            0.1 * begin * std::sin(1.3 * t)) *
               R_body_optical();
  return T;
}

// What an IMU on that camera measures from `from_s` to `to_s`, at 200 Hz: after from_s, up to to_s.
[[nodiscard]] inline std::vector<ImuSample> plane_world_imu(
    double from_s, double to_s, const Eigen::Vector3d& gyro_bias, const Eigen::Vector3d& accel_bias,
    const Isometry3d& T_camera_imu = Isometry3d::Identity()) {
  std::vector<ImuSample> samples;
  constexpr double kStep = 1e-4;
  const int first = static_cast<int>(std::floor(from_s * 200.0 + 1e-6)) + 1,
            last = static_cast<int>(std::floor(to_s * 200.0 + 1e-6));
  for (int i = first; i <= last; ++i) {
    const double t = i / 200.0;
    const Isometry3d a = plane_world_pose(t - kStep) * T_camera_imu,
                     b = plane_world_pose(t) * T_camera_imu,
                     c = plane_world_pose(t + kStep) * T_camera_imu;
    ImuSample sample;
    sample.stamp_ns = static_cast<std::int64_t>(std::llround(t * 1e9));
    sample.gyro_rad_per_s =
        so3_log(a.linear().transpose() * c.linear()) / (2.0 * kStep) + gyro_bias;
    const Eigen::Vector3d acceleration =
        (c.translation() - 2.0 * b.translation() + a.translation()) / (kStep * kStep);
    sample.accel_m_per_s2 =
        b.linear().transpose() * (acceleration + Eigen::Vector3d(0, 0, 9.81)) + accel_bias;
    samples.push_back(sample);
  }
  return samples;
}

}  // namespace tread
