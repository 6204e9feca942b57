#include "tread/io/euroc_sensor.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <optional>
#include <variant>
#include <vector>

namespace tread::internal {
namespace {

std::string print_place(const char* type, const Isometry3d& T_body_sensor) {
  const Eigen::Matrix<double, 4, 4, Eigen::RowMajor> rows = T_body_sensor.matrix();
  return fmt::format("sensor_type: {}\nT_BS:\n  cols: 4\n  rows: 4\n  data: [{}]\n", type,
                     fmt::join(rows.data(), rows.data() + rows.size(), ", "));
}

struct Distorted {
  const char* model = "radial-tangential";
  std::vector<double> coefficients = {0.0, 0.0, 0.0, 0.0};
};

// What keeps a camera from being written; nothing if there is nothing.
std::optional<const char*> too_much(const BrownCamera& camera) {
  const auto any = [](const auto& values, std::size_t from) {
    return std::any_of(values.begin() + static_cast<std::ptrdiff_t>(from), values.end(),
                       [](double v) { return v != 0.0; });
  };
  if (camera.lx != 0.0 || camera.ly != 0.0) return "a lens centre";
  if (any(camera.K, 3)) return "radial terms above K3";
  if (any(camera.P, 2)) return "tangential terms above P2";
  if (any(camera.D, 0)) return "a rational denominator";
  return std::nullopt;
}

Distorted distortion_of(const BrownCamera& camera) {
  // OpenCV's order; its p1 is Brown's P2.
  Distorted text;
  text.coefficients = {camera.K[0], camera.K[1], camera.P[1], camera.P[0]};
  if (camera.K[2] != 0.0) text.coefficients.push_back(camera.K[2]);
  return text;
}

}  // namespace

Result<std::string> print_euroc_camera(const CameraModel& camera, ImageSize size,
                                       const Isometry3d& T_body_camera, double rate_hz,
                                       const std::string& where) {
  const PinholeCamera pinhole = pinhole_of(camera);
  std::optional<const char*> what;
  Distorted text;
  if (const auto* brown = std::get_if<BrownCamera>(&camera)) {
    what = too_much(*brown);
    text = distortion_of(*brown);
  } else if (const auto* wide = std::get_if<KannalaBrandtCamera>(&camera)) {
    text.model = "equidistant";
    text.coefficients.assign(wide->k.begin(), wide->k.end());
  }
  if (pinhole.skew != 0.0) what = "skew";
  if (what) {
    return fail(ErrorCode::kUnsupported,
                fmt::format("EuRoC's sensor.yaml has no form for a camera with {}", *what), where,
                "Use a pinhole, Brown's K1 K2 K3 P1 P2, or Kannala-Brandt");
  }
  return print_place("camera", T_body_camera) +
         fmt::format(
             "rate_hz: {}\nresolution: [{}, {}]\ncamera_model: pinhole\n"
             "intrinsics: [{}, {}, {}, {}]\ndistortion_model: {}\ndistortion_coefficients: [{}]\n",
             rate_hz, size.width, size.height, pinhole.fx, pinhole.fy, pinhole.cx, pinhole.cy,
             text.model, fmt::join(text.coefficients, ", "));
}

std::string print_euroc_imu(const Imu& imu, const Isometry3d& T_body_imu) {
  return print_place("imu", T_body_imu) +
         fmt::format(
             "rate_hz: {}\ngyroscope_noise_density: {}\ngyroscope_random_walk: {}\n"
             "accelerometer_noise_density: {}\naccelerometer_random_walk: {}\n",
             imu.rate_hz, imu.gyro_noise, imu.gyro_walk, imu.accel_noise, imu.accel_walk);
}

std::string print_euroc_gnss(const Eigen::Vector3d& p_body_antenna_m, double rate_hz) {
  Isometry3d T_body_antenna = Isometry3d::Identity();
  T_body_antenna.translation() = p_body_antenna_m;
  return print_place("gnss", T_body_antenna) + fmt::format("rate_hz: {}\n", rate_hz);
}

}  // namespace tread::internal
