// Calibration files of a stereo rig: our YAML, and as they are: OpenCV stereo calibration, KITTI
// calib.txt, EuRoC sensor.yaml pairs, Kalibr camchain, ROS camera_info YAML pairs.
//
// Our format. Lengths are metres, focal lengths and principal points pixels ((0, 0) is the centre
// of the top left pixel), frames and models those of geometry/stereo_rig.hpp and camera.hpp. A name
// that is not listed here is refused.
//
//   tread_rig: 1                   # version of the format
//   name: my-rig                   # optional; else the file's
//   size: [640, 480]               # width, height of the images
//   rectified: false               # optional: true if the images come rectified
//   left:                          # one of three models
//     model: brown
//     fx: 458.7
//     fy: 457.3
//     cx: 367.2
//     cy: 248.4
//     skew: 0.0                    # optional; not with kannala_brandt
//     lens_centre: [0.0, 0.0]      # optional: lx, ly
//     K: [-0.28, 0.07]             # optional: up to 5 radial terms
//     P: [1.8e-05, 1.9e-04]        # optional: up to 5 tangential terms, in Brown's order
//     D: []                        # optional: up to 3 terms of the denominator
//     # in place of lens_centre, K, P, D: opencv_distortion: [k1, k2, p1, p2, k3, k4, k5, k6]
//   right:
//     model: kannala_brandt        # OpenCV's fisheye, Kalibr's equidistant
//     fx: 190.9
//     ...
//     k: [0.0035, 0.0007, -0.0021, 0.0002]
//   # model: pinhole               # fx fy cx cy, optional skew
//   T_left_right:                  # right optical axes into left
//     translation_m: [0.12, 0, 0]
//     rotation:                    # optional; or rpy_rad or rpy_deg: [roll, pitch, yaw]
//       - [1, 0, 0]
//       - [0, 1, 0]
//       - [0, 0, 1]
//   # in place of T_left_right, of rectified rigs: baseline_m: 0.12
//   mount:                         # optional: where the left camera sits on the robot
//     height_m: 1.0                # above the ground, looking forward
//     pitch_deg: 55                # down; or pitch_rad
//     assumed: true                # optional: nobody measured it
//     # in place of height_m and pitch: T_body_left: {translation_m: ..., rotation: ...}
//   imu:                           # optional: an inertial measurement unit fixed to the cameras
//     T_imu_left: {translation_m: [-0.02, -0.06, 0.01], rpy_deg: [0, 0, 90]}
//     gyro_noise: 3.4e-4           # optional: rad/s/sqrt(Hz); defaults of a usual MEMS IMU
//     accel_noise: 4.0e-3          # optional: m/s^2/sqrt(Hz)
//     gyro_walk: 3.9e-5            # optional: rad/s^2/sqrt(Hz)
//     accel_walk: 6.0e-3           # optional: m/s^3/sqrt(Hz)
//     rate_hz: 200                 # optional
#pragma once

#include <filesystem>
#include <string>

#include "tread/core/result.hpp"
#include "tread/geometry/stereo_rig.hpp"

namespace tread {

// Finds out what the file (or folder) is from its content. `path` is one of
//   our rig YAML (key "tread_rig: 1")
//   OpenCV YAML or XML with M1 D1 M2 D2 R T (or K1, cameraMatrix1 and distCoeffs1 ...); T in metres
//   KITTI calib.txt (P0 P1, or P2 P3; with or without the names, or raw style P_rect_00)
//   Kalibr camchain YAML (cam0, cam1 with T_cn_cnm1), models pinhole-radtan and pinhole-equi; an
//     IMU with the default noise if cam0 has T_cam_imu (timeshift_cam_imu is not used)
//   a folder with cam0/sensor.yaml and cam1/sensor.yaml (EuRoC/ASL; also its mav0 parent), and an
//     IMU if imu0/sensor.yaml is beside them
//   a folder with left.yaml and right.yaml (ROS camera_info)
//   a folder with intrinsics.yml and extrinsics.yml (OpenCV's calibration sample)
//   "left.yaml,right.yaml", any of these pairs
//   the name of a known rig ("bumblebee2-640")
// `size` is used for formats that do not store an image size (KITTI, many of OpenCV); {0, 0} if not
// known: those then fail. Only our format has a mount. The rig passes check_rig, and rectified_rig
// if it says that its images come rectified. Errors name file, line, field and remedy.
[[nodiscard]] Result<StereoRig> read_rig(const std::string& path, ImageSize size = {});

// Our own format; what read_rig reads back is equal, but that a rig without a name gets the
// file's. Refuses what read_rig would refuse.
[[nodiscard]] Status write_rig(const std::filesystem::path& path, const StereoRig& rig);

}  // namespace tread
