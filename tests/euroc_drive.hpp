// A flight through the room of planes as EuRoC/ASL lays data out: distorted pairs that are not
// rectified, an IMU some centimetres from the cameras, and the truth of the body.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>

#include "plane_world.hpp"
#include "tread/geometry/camera.hpp"
#include "tread/io/image_file.hpp"

namespace tread::testing {

class EurocDrive {
 public:
  EurocDrive() {
    T_body_left_.linear() << 0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0;
    T_body_left_.translation() = Eigen::Vector3d(-0.02, -0.065, 0.01);
    T_left_right_.linear() = so3_exp(Eigen::Vector3d(0.004, -0.01, 0.006));
    T_left_right_.translation() = Eigen::Vector3d(0.11, 0.001, -0.0005);
    BrownCamera lens;
    lens.pinhole = {300.0, 299.0, 241.3, 178.2, 0.0};
    lens.K[0] = -0.28;
    lens.K[1] = 0.07;
    for (int y = 0; y < kSize.height; ++y) {
      for (int x = 0; x < kSize.width; ++x) {
        const Unprojection ray = lens.unproject({x, y});
        rays_.push_back(ray.valid ? ray.bearing : Eigen::Vector3d::UnitZ());
      }
    }
  }

  // `seconds` of pairs at 20 Hz into folder/mav0; half a second of the IMU before them.
  void write(const std::filesystem::path& folder, double seconds) const {
    namespace fs = std::filesystem;
    const fs::path mav = folder / "mav0";
    for (const char* name : {"cam0/data", "cam1/data", "imu0", "state_groundtruth_estimate0"}) {
      fs::create_directories(mav / name);
    }
    put(mav / "cam0/sensor.yaml", camera_yaml(T_body_left_));
    put(mav / "cam1/sensor.yaml", camera_yaml(T_body_left_ * T_left_right_));
    put(mav / "imu0/sensor.yaml",
        "sensor_type: imu\nT_BS:\n  cols: 4\n  rows: 4\n  data: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, "
        "0, 0, 0, 0, 1]\nrate_hz: 200\ngyroscope_noise_density: 1.7e-04\ngyroscope_random_walk: "
        "1.9e-05\naccelerometer_noise_density: 2.0e-03\naccelerometer_random_walk: 3.0e-03\n");
    put(mav / "imu0/data.csv", imu_csv(seconds));
    const PlaneWorld world = PlaneWorld::room();
    std::string truth = "#timestamp, p_x, p_y, p_z, q_w, q_x, q_y, q_z\n";
    for (int i = 0; i < static_cast<int>(seconds * 20.0); ++i) {
      const double t = i / 20.0;
      const Isometry3d T = plane_world_pose(t);
      const std::string name = fmt::format("{}.png", stamp(t));
      const auto seed = static_cast<std::uint32_t>(2 * i);
      write_image(mav / "cam0/data" / name, world.picture(rays_, kSize, T, 1.5, seed));
      write_image(mav / "cam1/data" / name,
                  world.picture(rays_, kSize, T * T_left_right_, 1.5, seed + 1));
      const Isometry3d body = T * T_body_left_.inverse();
      const Eigen::Quaterniond q(body.linear());
      const Eigen::Vector3d p = body.translation();
      truth += fmt::format("{},{},{},{},{},{},{},{}\n", stamp(t), p.x(), p.y(), p.z(), q.w(), q.x(),
                           q.y(), q.z());
    }
    put(mav / "state_groundtruth_estimate0/data.csv", truth);
  }

  [[nodiscard]] static std::int64_t stamp(double t) {
    return 1'403'636'579'000'000'000 + static_cast<std::int64_t>(std::llround(t * 1e9));
  }
  [[nodiscard]] Isometry3d body_at(double t) const {
    return plane_world_pose(t) * T_body_left_.inverse();
  }

 private:
  static constexpr ImageSize kSize{480, 360};

  static void put(const std::filesystem::path& path, const std::string& text) {
    std::ofstream(path, std::ios::binary) << text;
  }
  static void write_image(const std::filesystem::path& path, const Image<std::uint8_t>& image) {
    (void)write_png(path, image.view());  // a missing image fails the test that reads it
  }
  [[nodiscard]] static std::string camera_yaml(const Isometry3d& T_body_camera) {
    std::string text = "sensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n  data: [";
    for (int i = 0; i < 16; ++i) {
      text += fmt::format("{}{}", i > 0 ? ", " : "", T_body_camera.matrix()(i / 4, i % 4));
    }
    return text + fmt::format(
                      "]\nrate_hz: 20\nresolution: [{}, {}]\ncamera_model: pinhole\nintrinsics: "
                      "[300, 299, 241.3, 178.2]\ndistortion_model: radial-tangential\n"
                      "distortion_coefficients: [-0.28, 0.07, 0, 0]\n",
                      kSize.width, kSize.height);
  }
  [[nodiscard]] std::string imu_csv(double seconds) const {
    std::string text = "#timestamp [ns],w_x,w_y,w_z,a_x,a_y,a_z\n";
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    const double gyro = 1.7e-4 * std::sqrt(200.0), accel = 2e-3 * std::sqrt(200.0);
    for (ImuSample s : plane_world_imu(-0.5, seconds, {-0.002, 0.02, 0.07}, {-0.02, 0.12, 0.06},
                                       T_body_left_.inverse())) {
      for (int i = 0; i < 3; ++i) {
        s.gyro_rad_per_s(i) += gyro * normal(random);
        s.accel_m_per_s2(i) += accel * normal(random);
      }
      const Eigen::Vector3d &w = s.gyro_rad_per_s, &a = s.accel_m_per_s2;
      text += fmt::format("{},{},{},{},{},{},{}\n", stamp(1e-9 * static_cast<double>(s.stamp_ns)),
                          w.x(), w.y(), w.z(), a.x(), a.y(), a.z());
    }
    return text;
  }

  Isometry3d T_body_left_ = Isometry3d::Identity();
  Isometry3d T_left_right_ = Isometry3d::Identity();
  std::vector<Eigen::Vector3d> rays_;
};

}  // namespace tread::testing
