// One small file of every format that read_rig knows, for its tests.
#pragma once

#include <string>

namespace tread::testing {

inline const std::string kOwnRig = R"(# a comment
tread_rig: 1
name: bench
size: [752, 480]
left:
  model: brown
  fx: 458.7
  fy: 457.3
  cx: 367.2
  cy: 248.4
  skew: 0.5
  lens_centre: [0.01, -0.02]
  K: [-0.28, 0.07]
  P: [1.8e-05, 1.9e-04, 0.1]
  D: [0.01]
right:
  model: kannala_brandt
  fx: 190.9
  fy: 190.8
  cx: 354.9
  cy: 256.8
  k: [0.0035, 0.0007, -0.0021, 0.0002]
T_left_right:
  translation_m: [0.12, 0.001, -0.002]
  rpy_deg: [1.0, -2.0, 3.0]
mount:
  height_m: 1.0
  pitch_deg: 55
  assumed: true
)";

// May follow each of our own.
inline const std::string kOwnImu = R"(imu:
  T_imu_left:
    translation_m: [-0.02, -0.06, 0.01]
    rpy_deg: [0, 0, 90]
  gyro_noise: 1.7e-4
  accel_noise: 2.0e-3
  gyro_walk: 2.0e-5
  accel_walk: 3.0e-3
  rate_hz: 400
)";

inline const std::string kOwnRectifiedRig = R"(tread_rig: 1
size: [640, 480]
rectified: true
left: {model: pinhole, fx: 333.5, fy: 333.5, cx: 319.5, cy: 239.5}
right: {model: pinhole, fx: 333.5, fy: 333.5, cx: 350.5, cy: 239.5}
baseline_m: 0.12
)";

// As cv::FileStorage writes it: tags, "1." for whole numbers, lines broken inside lists.
inline const std::string kOpenCvYaml = R"(%YAML:1.0
---
image_width: 640
image_height: 480
M1: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 5.3e+02, 0., 3.2e+02, 0., 5.31e+02, 2.4e+02, 0., 0., 1. ]
D1: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data: [ -2.8e-01, 9.0e-02, 1.2e-03, -1.0e-04,
       2.0e-02 ]
M2: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 5.4e+02, 0., 3.3e+02, 0., 5.41e+02, 2.5e+02, 0., 0., 1. ]
D2: !!opencv-matrix
   rows: 1
   cols: 8
   dt: d
   data: [ 0.1, 0.2, 0.003, 0.004, 0.05, 0.06, 0.07, 0.08 ]
R: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 0.9998, -0.019998666693333, 0., 0.019998666693333, 0.9998, 0.,
       0., 0., 1. ]
T: !!opencv-matrix
   rows: 3
   cols: 1
   dt: d
   data: [ -0.11, 0.002, 0.001 ]
)";

inline const std::string kOpenCvXml = R"(<?xml version="1.0"?>
<opencv_storage>
<!-- made by hand -->
<imageSize>
  640 480</imageSize>
<cameraMatrix1 type_id="opencv-matrix">
  <rows>3</rows>
  <cols>3</cols>
  <dt>d</dt>
  <data>
    530. 0. 320. 0. 531. 240. 0. 0. 1.</data></cameraMatrix1>
<distCoeffs1 type_id="opencv-matrix"><rows>1</rows><cols>4</cols><dt>d</dt>
  <data>-0.28 0.09 0.0012 -0.0001</data></distCoeffs1>
<cameraMatrix2 type_id="opencv-matrix"><rows>3</rows><cols>3</cols><dt>d</dt>
  <data>540. 0. 330. 0. 541. 250. 0. 0. 1.</data></cameraMatrix2>
<distCoeffs2 type_id="opencv-matrix"><rows>1</rows><cols>4</cols><dt>d</dt>
  <data>0. 0. 0. 0.</data></distCoeffs2>
<R type_id="opencv-matrix"><rows>3</rows><cols>3</cols><dt>d</dt>
  <data>1. 0. 0. 0. 1. 0. 0. 0. 1.</data></R>
<T type_id="opencv-matrix"><rows>3</rows><cols>1</cols><dt>d</dt>
  <data>-0.11 0. 0.</data></T>
</opencv_storage>
)";

inline const std::string kKalibr = R"(cam0:
  cam_overlaps: [1]
  camera_model: pinhole
  distortion_coeffs: [-0.28, 0.07, 0.0002, 1.8e-05]
  distortion_model: radtan
  intrinsics: [458.65, 457.29, 367.21, 248.37]
  resolution: [752, 480]
  rostopic: /cam0/image_raw
cam1:
  T_cn_cnm1:
  - [0.9999, 0.014141782065920828, 0.0, -0.11]
  - [-0.014141782065920828, 0.9999, 0.0, 0.0004]
  - [0.0, 0.0, 1.0, -0.0008]
  - [0.0, 0.0, 0.0, 1.0]
  cam_overlaps: [0]
  camera_model: pinhole
  distortion_coeffs: [0.0035, 0.0007, -0.0021, 0.0002]
  distortion_model: equidistant
  intrinsics: [457.58, 456.13, 379.99, 255.23]
  resolution: [752, 480]
  rostopic: /cam1/image_raw
)";

// What Kalibr adds to cam0 when it has calibrated the IMU too: a quarter turn about z.
inline const std::string kKalibrImu = R"(  T_cam_imu:
  - [0.0, 1.0, 0.0, 0.1]
  - [-1.0, 0.0, 0.0, 0.2]
  - [0.0, 0.0, 1.0, 0.3]
  - [0.0, 0.0, 0.0, 1.0]
  timeshift_cam_imu: 0.001
)";

// The calibration of the EuRoC data set.
inline const std::string kEurocLeft = R"(# General sensor definitions.
sensor_type: camera
comment: VI-Sensor cam0 (MT9M034)
T_BS:
  cols: 4
  rows: 4
  data: [0.0148655429818, -0.999880929698, 0.00414029679422, -0.0216401454975,
         0.999557249008, 0.0149672133247, 0.025715529948, -0.064676986768,
        -0.0257744366974, 0.00375618835797, 0.999660727178, 0.00981073058949,
         0.0, 0.0, 0.0, 1.0]
rate_hz: 20
resolution: [752, 480]
camera_model: pinhole
intrinsics: [458.654, 457.296, 367.215, 248.375] #fu, fv, cu, cv
distortion_model: radial-tangential
distortion_coefficients: [-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05]
)";

inline const std::string kEurocRight = R"(sensor_type: camera
comment: VI-Sensor cam1 (MT9M034)
T_BS:
  cols: 4
  rows: 4
  data: [0.0125552670891, -0.999755099723, 0.0182237714554, -0.0198435579556,
         0.999598781151, 0.0130119051815, 0.0251588363115, 0.0453689425024,
        -0.0253898008918, 0.0179005838253, 0.999517347078, 0.00786212447038,
         0.0, 0.0, 0.0, 1.0]
rate_hz: 20
resolution: [752, 480]
camera_model: pinhole
intrinsics: [457.587, 456.134, 379.999, 255.238]
distortion_model: radial-tangential
distortion_coefficients: [-0.28368365, 0.07451284, -0.00010473, -3.55590700e-05]
)";

inline const std::string kEurocImu = R"(#Default imu sensor yaml file
sensor_type: imu
comment: VI-Sensor IMU (ADIS16448)
T_BS:
  cols: 4
  rows: 4
  data: [1.0, 0.0, 0.0, 0.0,
         0.0, 1.0, 0.0, 0.0,
         0.0, 0.0, 1.0, 0.0,
         0.0, 0.0, 0.0, 1.0]
rate_hz: 200
gyroscope_noise_density: 1.6968e-04     # [ rad / s / sqrt(Hz) ]
gyroscope_random_walk: 1.9393e-05       # [ rad / s^2 / sqrt(Hz) ]
accelerometer_noise_density: 2.0000e-3  # [ m / s^2 / sqrt(Hz) ]
accelerometer_random_walk: 3.0000e-3    # [ m / s^3 / sqrt(Hz) ]
)";

// Turned by 0.02 rad about z (left) and y (right).
inline const std::string kRosLeft = R"(image_width: 640
image_height: 480
camera_name: narrow_stereo/left
camera_matrix:
  rows: 3
  cols: 3
  data: [430.1, 0, 311.2, 0, 430.5, 238.1, 0, 0, 1]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-0.36, 0.11, -0.001, 0.0005, 0.02]
rectification_matrix:
  rows: 3
  cols: 3
  data: [0.999800006666578, -0.019998666693333, 0, 0.019998666693333, 0.999800006666578, 0, 0, 0, 1]
projection_matrix:
  rows: 3
  cols: 4
  data: [380, 0, 320, 0, 0, 380, 240, 0, 0, 0, 1, 0]
)";

inline const std::string kRosRight = R"(image_width: 640
image_height: 480
camera_name: narrow_stereo/right
camera_matrix:
  rows: 3
  cols: 3
  data: [431.1, 0, 315.2, 0, 431.5, 236.1, 0, 0, 1]
distortion_model: rational_polynomial
distortion_coefficients:
  rows: 1
  cols: 8
  data: [0.1, 0.2, 0.003, 0.004, 0.05, 0.06, 0.07, 0.08]
rectification_matrix:
  rows: 3
  cols: 3
  data: [0.999800006666578, 0, 0.019998666693333, 0, 1, 0, -0.019998666693333, 0, 0.999800006666578]
projection_matrix:
  rows: 3
  cols: 4
  data: [380, 0, 320, -34.2, 0, 380, 240, 0, 0, 0, 1, 0]
)";

// The message as ROS 2 prints it, of a pair that comes rectified.
inline const std::string kRosMessageLeft = R"(header:
  stamp: {sec: 1, nanosec: 2}
  frame_id: left
height: 480
width: 640
distortion_model: plumb_bob
d: [0.0, 0.0, 0.0, 0.0, 0.0]
k: [380.0, 0.0, 320.0, 0.0, 380.0, 240.0, 0.0, 0.0, 1.0]
r: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
p: [380.0, 0.0, 320.0, 0.0, 0.0, 380.0, 240.0, 0.0, 0.0, 0.0, 1.0, 0.0]
binning_x: 0
)";

inline const std::string kRosMessageRight = R"(height: 480
width: 640
distortion_model: plumb_bob
d: [0.0, 0.0, 0.0, 0.0, 0.0]
k: [380.0, 0.0, 320.0, 0.0, 380.0, 240.0, 0.0, 0.0, 1.0]
r: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
p: [380.0, 0.0, 320.0, -38.0, 0.0, 380.0, 240.0, 0.0, 0.0, 0.0, 1.0, 0.0]
)";

inline const std::string kKittiOdometry =
    "P0: 700.5 0 601.5 0 0 700.5 183.5 0 0 0 1 0\n"
    "P1: 700.5 0 601.5 -350.25 0 700.5 183.5 0 0 0 1 0\n"
    "P2: 700.5 0 601.5 45.5 0 700.5 183.5 0.2 0 0 1 0.003\n"
    "P3: 700.5 0 601.5 -334.77 0 700.5 183.5 2.2 0 0 1 0.003\n"
    "Tr: 1 0 0 0 0 1 0 0 0 0 1 0\n";

inline const std::string kKittiBare =
    "7.005e+02 0 601.5 0 0 700.5 183.5 0 0 0 1 0\n"
    "700.5 0 601.5 -350.25 0 700.5 183.5 0 0 0 1 0";  // no line end, as such copies are

inline const std::string kKittiRaw =
    "calib_time: 09-Jan-2012 13:57:47\n"
    "S_00: 1.392000e+03 5.120000e+02\n"
    "K_00: 984.2 0 690 0 980.8 233.2 0 0 1\n"
    "S_rect_00: 1.242000e+03 3.750000e+02\n"
    "P_rect_00: 700.5 0 601.5 0 0 700.5 183.5 0 0 0 1 0\n"
    "P_rect_01: 700.5 0 601.5 -350.25 0 700.5 183.5 0 0 0 1 0\n";

}  // namespace tread::testing
