// Time-stamped sensor samples, as every source yields them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tread/core/image.hpp"
#include "tread/geometry/pose.hpp"

namespace tread {

// What an inertial measurement unit felt, in its own axes.
struct ImuSample {
  std::int64_t stamp_ns = 0;
  Eigen::Vector3d gyro_rad_per_s = Eigen::Vector3d::Zero();
  // The specific force: at rest 9.81 upwards, as what holds the unit pushes it up.
  Eigen::Vector3d accel_m_per_s2 = Eigen::Vector3d::Zero();
};

// A pair of images taken at one time, as the cameras gave them (not yet rectified).
struct StereoFrame {
  std::int64_t stamp_ns = 0;
  std::string name;  // how messages call it: "000012"
  Image<std::uint8_t> left;
  Image<std::uint8_t> right;
  Image<Rgb> left_colour;                  // empty if the camera is grey
  std::optional<Isometry3d> T_world_left;  // if the source knows: left optical axes into a world
                                           // with z up (REP 103), metres
  // After the frame before, and up to this one's time (the first frame: those of the second before
  // it, to find the vertical from). Empty without an IMU.
  std::vector<ImuSample> imu;
};

// Depth, and colour if there is a colour camera, of one time and of one size.
struct RgbdFrame {
  std::int64_t stamp_ns = 0;                 // of the depth image
  std::string name;                          // how messages call it: "frame-000012"
  Image<float> depth;                        // metres along the optical axis; NaN where unknown
  Image<std::uint8_t> grey;                  // empty without a colour image
  Image<Rgb> rgb;                            // likewise, and if that image is grey
  std::optional<Isometry3d> T_world_camera;  // if the source knows: optical axes of the depth
                                             // camera into the world of the source, metres
};

}  // namespace tread
