// A small recording, for the tests of its writer.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "tread/io/data_set_writer.hpp"
#include "tread/io/source.hpp"

namespace tread::testing::recording {

inline constexpr std::int64_t kFirst_ns = 1'700'000'000'123'456'789;
inline constexpr std::int64_t kFrame_ns = 100'000'000;
inline constexpr ImageSize kSize{6, 4};

inline Isometry3d pose(double x, double yaw) {
  Isometry3d T = Isometry3d::Identity();
  T.linear() = rotation_from_yaw_pitch_roll(yaw, 0.1, -0.2);
  T.translation() = Eigen::Vector3d(x, 1.0 / 3.0, 0.7);
  return T;
}

inline BrownCamera brown() {
  BrownCamera camera;
  camera.pinhole = {10.1, 10.2, 2.9, 1.8, 0.0};
  camera.K = {-0.28, 0.07, 1e-3, 0.0, 0.0};
  camera.P = {1.8e-5, 1.9e-4, 0.0, 0.0, 0.0};
  return camera;
}

inline StereoRig rig(double y) {
  StereoRig made;
  made.name = "front";
  made.size = kSize;
  made.left = brown();
  made.right = KannalaBrandtCamera{9.5, 9.6, 3.0, 2.0, {0.003, -0.001, 0.002, 1e-4}};
  made.T_left_right = pose(0.12, 0.001);
  CameraMount mount = level_mount(0.9, 0.3, false);
  mount.T_body_left.translation().y() = y;
  made.mount = mount;
  return made;
}

inline RecordingSetup setup() {
  RecordingSetup made;
  made.description = "a \"garden\", seed 7";
  made.heads = {rig(0.2), rig(-0.2)};
  made.heads[0].imu.emplace().T_imu_left = pose(-0.3, 1.2);
  made.heads[0].imu->gyro_walk = 1.0 / 3e4;
  made.camera_rate_hz = 10.0;
  made.p_body_antenna_m = Eigen::Vector3d(0.1, 0.0, 1.1);
  return made;
}

inline StereoFrame frame(int number, bool colour = false) {
  StereoFrame made;
  made.stamp_ns = kFirst_ns + number * kFrame_ns;
  made.name = std::to_string(number);
  made.left = Image<std::uint8_t>(kSize.width, kSize.height);
  made.right = Image<std::uint8_t>(kSize.width, kSize.height);
  if (colour) made.left_colour = Image<Rgb>(kSize.width, kSize.height);
  for (int y = 0; y < kSize.height; ++y) {
    for (int x = 0; x < kSize.width; ++x) {
      made.left(x, y) = static_cast<std::uint8_t>(40 * x + 7 * y + number);
      made.right(x, y) = static_cast<std::uint8_t>(255 - 13 * x - y * number);
      if (colour) made.left_colour(x, y) = {made.left(x, y), made.right(x, y), 77};
    }
  }
  return made;
}

inline DataSetWriter open(const std::filesystem::path& folder,
                          const RecordingSetup& recording = setup()) {
  auto writer = DataSetWriter::create(folder, recording);
  EXPECT_TRUE(writer) << writer.error().message();
  return std::move(*writer);
}

inline std::vector<StereoFrame> frames_of(const std::filesystem::path& folder) {
  auto source = open_stereo_source(folder);
  EXPECT_TRUE(source) << source.error().message();
  std::vector<StereoFrame> frames;
  while (source) {
    auto next = (*source)->next();
    EXPECT_TRUE(next) << next.error().message();
    if (!next || !*next) break;
    frames.push_back(std::move(**next));
  }
  return frames;
}

inline BodyTruth truth(int number) {
  BodyTruth made;
  made.stamp_ns = kFirst_ns + number * kFrame_ns / 2;
  made.T_world_body = pose(0.05 * number, 2.9 + 0.05 * number);
  made.velocity_m_per_s = Eigen::Vector3d(0.5, 1.0 / 7.0, -0.01 * number);
  made.gyro_bias_rad_per_s = Eigen::Vector3d(1e-3, 2e-3, 3e-3);
  made.accel_bias_m_per_s2 = Eigen::Vector3d(0.1, 0.2, 0.3);
  return made;
}

inline ImuSample imu(int number) {
  return {
      kFirst_ns + number * 5'000'000LL, {0.1 / (1 + number), -2e-17, 1.0 / 3.0}, {9.81, 0.0, -1e5}};
}

inline void expect_equal(const Isometry3d& a, const Isometry3d& b, double tolerance) {
  EXPECT_LT((a.matrix() - b.matrix()).cwiseAbs().maxCoeff(), tolerance);
}

}  // namespace tread::testing::recording

#define EXPECT_DONE(call)                          \
  do {                                             \
    const Status done_ = call;                     \
    EXPECT_TRUE(done_) << done_.error().message(); \
  } while (false)
