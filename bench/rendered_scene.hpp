// Scenes that are made, not measured: surfaces by their distance function, a texture by position,
// and images of them from any pose with any noise. The truth is known, so errors are errors.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "tread/core/image.hpp"
#include "tread/geometry/pose.hpp"
#include "tread/geometry/trajectory.hpp"
#include "tread/slam/depth_level.hpp"

namespace tread::bench {

// World: z up, metres. distance() must not exceed the true distance to the surface.
struct Scene {
  std::string name;
  std::function<double(const Eigen::Vector3d&)> distance;
  std::function<double(const Eigen::Vector3d&)> brightness;  // 0 to 255
};

// Noise in [-1, 1] with features of size `scale_m` and of some octaves below; a function of place.
[[nodiscard]] double noise_at(const Eigen::Vector3d& p, double scale_m, int octaves,
                              std::uint32_t seed);

[[nodiscard]] Scene flat_ground(bool textured);
// Hills of up to height_m / 2 above and below, some 0.3 m wide.
[[nodiscard]] Scene rough_ground(double height_m, bool textured);
[[nodiscard]] Scene stairs(double tread_m, double rise_m);
// The inside corner of a room with a box and a ball in it.
[[nodiscard]] Scene room_corner();
[[nodiscard]] Scene ball(double radius_m);

struct Sensor {
  int width = 320, height = 240;
  Pinhole camera{290.0F, 290.0F, 159.5F, 119.5F};
  DepthNoise noise{0.0, 0.0};    // of a depth, apart for each pixel
  double stereo_sigma_px = 0.0;  // and of a disparity, alike for neighbours (5 x 5), as stereo's
  double focal_baseline = 290.0 * 0.12;
  double grey_sigma = 0.0;
  double farthest_m = 6.0;
};

struct RenderedFrame {
  std::int64_t stamp_ns = 0;
  Image<float> depth;  // metres, NaN where there is nothing
  Image<std::uint8_t> grey;
  Isometry3d T_world_camera = Isometry3d::Identity();
};

[[nodiscard]] RenderedFrame render(const Scene& scene, const Sensor& sensor,
                                   const Isometry3d& T_world_camera, std::uint32_t seed);

// A camera in optical axes at a position, looking along yaw, down by pitch, rolled.
[[nodiscard]] Isometry3d camera_at(const Eigen::Vector3d& position, double yaw_deg,
                                   double pitch_down_deg, double roll_deg);
// How a walking robot carries its camera: 0.9 m above the ground, 40 degrees down, forward at
// 0.5 m/s, with sway.
[[nodiscard]] Isometry3d walking_camera(double time_s);

}  // namespace tread::bench
