#include "rendered_scene.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

namespace tread::bench {
namespace {

std::uint32_t hash(std::int32_t x, std::int32_t y, std::int32_t z, std::uint32_t seed) {
  std::uint32_t h = seed;
  for (const std::int32_t v : {x, y, z}) {
    h ^= static_cast<std::uint32_t>(v) + 0x9E3779B9U + (h << 6) + (h >> 2);
    h *= 0x85EBCA6BU;
    h ^= h >> 13;
  }
  h *= 0xC2B2AE35U;
  return h ^ (h >> 16);
}

double lattice(std::int32_t x, std::int32_t y, std::int32_t z, std::uint32_t seed) {
  return hash(x, y, z, seed) / 2147483647.5 - 1.0;
}

double smooth_noise(const Eigen::Vector3d& p, std::uint32_t seed) {
  const Eigen::Vector3d base = p.array().floor();
  const Eigen::Vector3d f = p - base;
  const Eigen::Vector3d s = f.array() * f.array() * (3.0 - 2.0 * f.array());
  const auto x = static_cast<std::int32_t>(base.x()), y = static_cast<std::int32_t>(base.y()),
             z = static_cast<std::int32_t>(base.z());
  double value = 0.0;
  for (int i = 0; i < 8; ++i) {
    const int dx = i & 1, dy = i >> 1 & 1, dz = i >> 2;
    const double weight = (dx != 0 ? s.x() : 1.0 - s.x()) * (dy != 0 ? s.y() : 1.0 - s.y()) *
                          (dz != 0 ? s.z() : 1.0 - s.z());
    value += weight * lattice(x + dx, y + dy, z + dz, seed);
  }
  return value;
}

double gravel(const Eigen::Vector3d& p) {
  return 128.0 + 110.0 * noise_at(p, 0.8, 7, 7);
}
double plain(const Eigen::Vector3d& /*p*/) {
  return 128.0;
}

double box_distance(const Eigen::Vector3d& p, const Eigen::Vector3d& half) {
  const Eigen::Vector3d q = p.cwiseAbs() - half;
  return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
}

}  // namespace

double noise_at(const Eigen::Vector3d& p, double scale_m, int octaves, std::uint32_t seed) {
  double sum = 0.0, share = 0.5;
  Eigen::Vector3d q = p / scale_m;
  for (int i = 0; i < octaves; ++i, share /= 1.6, q *= 2.03) {
    sum += share * smooth_noise(q + Eigen::Vector3d::Constant(17.3 * i),
                                seed + 31U * static_cast<std::uint32_t>(i));
  }
  return std::clamp(sum, -1.0, 1.0);
}

Scene flat_ground(bool textured) {
  return {textured ? "flat textured ground" : "flat plain ground",
          [](const Eigen::Vector3d& p) { return p.z(); }, textured ? gravel : plain};
}

Scene rough_ground(double height_m, bool textured) {
  return {"rough ground",
          [height_m](const Eigen::Vector3d& p) {
            const double h = height_m * noise_at({p.x(), p.y(), 0.5}, 0.3, 2, 99);
            return 0.8 * (p.z() - h);  // slopes stay below 3 : 4
          },
          textured ? gravel : plain};
}

Scene stairs(double tread_m, double rise_m) {
  return {"stairs",
          [tread_m, rise_m](const Eigen::Vector3d& p) {
            double nearest = p.z();
            const int at = static_cast<int>(std::floor(p.x() / tread_m));
            for (int i = std::max(1, at - 2); i <= std::max(1, at + 3); ++i) {
              // Step i begins at i * tread and is a block without end behind.
              const Eigen::Vector3d half(50.0, 50.0, 0.5 * rise_m * i);
              nearest = std::min(
                  nearest,
                  box_distance(p - Eigen::Vector3d(i * tread_m + 50.0, 0.0, half.z()), half));
            }
            return nearest;
          },
          gravel};
}

Scene room_corner() {
  return {"room corner",
          [](const Eigen::Vector3d& p) {
            double nearest = std::min({p.z(), 2.5 - p.x(), 2.0 - p.y()});
            nearest = std::min(nearest, box_distance(p - Eigen::Vector3d(1.9, 0.2, 0.3),
                                                     Eigen::Vector3d(0.25, 0.35, 0.3)));
            return std::min(nearest, (p - Eigen::Vector3d(1.6, 1.1, 0.35)).norm() - 0.35);
          },
          gravel};
}

Scene ball(double radius_m) {
  return {"ball", [radius_m](const Eigen::Vector3d& p) { return p.norm() - radius_m; }, gravel};
}

RenderedFrame render(const Scene& scene, const Sensor& sensor, const Isometry3d& T_world_camera,
                     std::uint32_t seed) {
  RenderedFrame frame;
  frame.T_world_camera = T_world_camera;
  frame.depth = Image<float>(sensor.width, sensor.height, std::numeric_limits<float>::quiet_NaN());
  frame.grey = Image<std::uint8_t>(sensor.width, sensor.height);
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  // Noise of disparities that neighbours share.
  Image<float> shared(sensor.width, sensor.height);
  if (sensor.stereo_sigma_px > 0.0) {
    Image<float> white(sensor.width + 4, sensor.height + 4);
    for (int y = 0; y < white.height; ++y) {
      for (int x = 0; x < white.width; ++x) white(x, y) = static_cast<float>(normal(random));
    }
    for (int y = 0; y < sensor.height; ++y) {
      for (int x = 0; x < sensor.width; ++x) {
        float sum = 0.0F;
        for (int j = 0; j < 5; ++j) {
          for (int i = 0; i < 5; ++i) sum += white(x + i, y + j);
        }
        shared(x, y) = static_cast<float>(sensor.stereo_sigma_px) * sum / 5.0F;
      }
    }
  }
  const Eigen::Matrix3d R = T_world_camera.linear();
  const Eigen::Vector3d t = T_world_camera.translation();
  const double fx = sensor.camera.fx, fy = sensor.camera.fy, cx = sensor.camera.cx,
               cy = sensor.camera.cy;
  for (int y = 0; y < sensor.height; ++y) {
    for (int x = 0; x < sensor.width; ++x) {
      const Eigen::Vector3d bearing((x - cx) / fx, (y - cy) / fy, 1.0);
      const double length = bearing.norm();
      const Eigen::Vector3d ray = R * (bearing / length);
      double way = 0.0;
      bool hit = false;
      for (int step = 0; step < 400 && way < sensor.farthest_m * length; ++step) {
        const double d = scene.distance(t + way * ray);
        if (d < 1e-6) {
          hit = true;
          break;
        }
        way += d;
      }
      if (!hit) continue;
      double z = way / length;
      const double shade = scene.brightness(t + way * ray) + sensor.grey_sigma * normal(random);
      frame.grey(x, y) = static_cast<std::uint8_t>(std::clamp(std::lround(shade), 0L, 255L));
      if (sensor.stereo_sigma_px > 0.0) {
        const double disparity = sensor.focal_baseline / z + shared(x, y);
        z = sensor.focal_baseline / disparity;
      }
      z += sensor.noise.sigma_m(z) * normal(random);
      frame.depth(x, y) = static_cast<float>(z);
    }
  }
  return frame;
}

Isometry3d camera_at(const Eigen::Vector3d& position, double yaw_deg, double pitch_down_deg,
                     double roll_deg) {
  constexpr double kRad = std::numbers::pi / 180.0;
  Isometry3d T = Isometry3d::Identity();
  T.linear() =
      rotation_from_yaw_pitch_roll(yaw_deg * kRad, pitch_down_deg * kRad, roll_deg * kRad) *
      R_body_optical();
  T.translation() = position;
  return T;
}

Isometry3d walking_camera(double time_s) {
  const double phase = 2.0 * std::numbers::pi * 1.4 * time_s;
  return camera_at({0.5 * time_s, 0.02 * std::sin(phase / 2.0), 0.9 + 0.01 * std::sin(phase)},
                   1.5 * std::sin(phase / 2.0), 40.0 + 1.0 * std::sin(phase + 0.7),
                   1.5 * std::cos(phase / 2.0));
}

}  // namespace tread::bench
