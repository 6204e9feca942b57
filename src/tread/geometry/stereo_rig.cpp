#include "tread/geometry/stereo_rig.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <utility>

#include "tread/core/shrink.hpp"

namespace tread {
namespace {

using Eigen::Vector3d;

// How far a rig that calls itself rectified may be off: less than 1/100 pixel in usual images.
constexpr double kRelativeTolerance = 1e-5;  // focal lengths, and radians
constexpr double kRowTolerancePx = 1e-2;

bool undistorted(const CameraModel& camera) {
  if (std::holds_alternative<PinholeCamera>(camera)) return true;
  const auto* brown = std::get_if<BrownCamera>(&camera);
  return brown != nullptr && brown->parameters().tail<13>().isZero(0.0);
}

tl::unexpected<Error> not_rectified(const std::string& what, const std::string& where) {
  return fail(ErrorCode::kBadValue, "the rig says its images come rectified, but " + what, where,
              "Correct it, or write 'rectified: false' if the images are as the cameras gave them");
}

Status check_size(const ImageSize& size) {
  constexpr int kLargestSide = 16384;
  constexpr std::int64_t kMostPixels = std::int64_t{1} << 26;
  const bool sound = size.width > 0 && size.height > 0 && size.width <= kLargestSide &&
                     size.height <= kLargestSide &&
                     std::int64_t{size.width} * size.height <= kMostPixels;
  if (sound) return {};
  return fail(ErrorCode::kBadValue,
              "image size " + std::to_string(size.width) + " x " + std::to_string(size.height) +
                  " is not one of a camera",
              "size", "Write width and height in pixels, at most 16384 each and 2^26 in all");
}

}  // namespace

double RectifiedRig::depth_m(double disparity_px) const {
  const double shifted = disparity_px + cx_offset_px;
  if (shifted <= 0.0) return std::numeric_limits<double>::infinity();
  return baseline_m * fx_px / shifted;
}

double RectifiedRig::disparity_px(double depth_m) const {
  return baseline_m * fx_px / depth_m - cx_offset_px;
}

double RectifiedRig::depth_resolution_m(double depth_m, double step_px) const {
  return step_px * depth_m * depth_m / (baseline_m * fx_px);
}

Vector3d RectifiedRig::point(double u, double v, double depth_m) const {
  return {(u - cx_px) / fx_px * depth_m, (v - cy_px) / fy_px * depth_m, depth_m};
}

Vector3d RectifiedRig::pixel_and_disparity(const Vector3d& p) const {
  return {fx_px * p.x() / p.z() + cx_px, fy_px * p.y() / p.z() + cy_px, disparity_px(p.z())};
}

Status check_imu(const Imu& imu) {
  if (!is_rigid(imu.T_imu_left)) {
    return fail(ErrorCode::kBadValue, "the place of the IMU is not a rigid motion",
                "imu.T_imu_left", "Write an orthonormal right-handed rotation and finite metres");
  }
  const std::pair<const char*, double> above_zero[] = {{"imu.gyro_noise", imu.gyro_noise},
                                                       {"imu.accel_noise", imu.accel_noise},
                                                       {"imu.gyro_walk", imu.gyro_walk},
                                                       {"imu.accel_walk", imu.accel_walk},
                                                       {"imu.rate_hz", imu.rate_hz}};
  for (const auto& [name, value] : above_zero) {
    if (value > 0.0 && std::isfinite(value)) continue;
    return fail(ErrorCode::kBadValue, fmt::format("{} is not a number above 0", value), name,
                "Take it from the calibration or the data sheet of the IMU");
  }
  return {};
}

Status check_rig(const StereoRig& rig) {
  if (Status sound = check_size(rig.size); !sound) return sound;
  if (Status sound = check_camera(rig.left, "left"); !sound) return sound;
  if (Status sound = check_camera(rig.right, "right"); !sound) return sound;
  if (!is_rigid(rig.T_left_right)) {
    return fail(ErrorCode::kBadValue, "the pose of the right camera is not a rigid motion",
                "T_left_right", "Write an orthonormal right-handed rotation and finite metres");
  }
  if (!(rig.T_left_right.translation().norm() > 0.0)) {
    return fail(ErrorCode::kBadValue, "the baseline is 0", "T_left_right",
                "Write the distance of the two cameras in metres");
  }
  if (rig.mount && !is_rigid(rig.mount->T_body_left)) {
    return fail(ErrorCode::kBadValue, "the mount of the camera is not a rigid motion", "mount",
                "Write an orthonormal right-handed rotation and finite metres");
  }
  return rig.imu ? check_imu(*rig.imu) : Status{};
}

Result<RectifiedRig> rectified_rig(const StereoRig& rig) {
  if (Status sound = check_rig(rig); !sound) return forward(sound);
  if (!rig.rectified) {
    return fail(ErrorCode::kBadArgument, "the images of this rig do not come rectified",
                "rectified", "Rectify them first (make_rectification)");
  }
  if (!undistorted(rig.left)) return not_rectified("its left camera distorts", "left");
  if (!undistorted(rig.right)) return not_rectified("its right camera distorts", "right");
  const PinholeCamera left = pinhole_of(rig.left), right = pinhole_of(rig.right);
  if (left.skew != 0.0 || right.skew != 0.0) return not_rectified("its pixels are skewed", "skew");
  if (std::abs(left.fx - right.fx) > kRelativeTolerance * left.fx ||
      std::abs(left.fy - right.fy) > kRelativeTolerance * left.fy) {
    return not_rectified("the focal lengths of its cameras differ", "right.fx");
  }
  if (std::abs(left.cy - right.cy) > kRowTolerancePx) {
    return not_rectified("the rows of its principal points differ", "right.cy");
  }
  if (so3_log(rig.T_left_right.linear()).norm() > kRelativeTolerance) {
    return not_rectified("its cameras are turned against each other", "T_left_right");
  }
  const Vector3d baseline = rig.T_left_right.translation();
  if (baseline.x() <= 0.0 ||
      std::hypot(baseline.y(), baseline.z()) > kRelativeTolerance * baseline.x()) {
    return not_rectified("its right camera is not beside the left one along x", "T_left_right");
  }
  return RectifiedRig{rig.size,           left.fx,     left.fy, left.cx, left.cy,
                      right.cx - left.cx, baseline.x()};
}

StereoRig shrunk(const StereoRig& rig, int factor) {
  if (factor <= 1) return rig;
  StereoRig small = rig;
  small.size = {shrunk_size(rig.size.width, factor), shrunk_size(rig.size.height, factor)};
  small.left = scaled(rig.left, 1.0 / factor);
  small.right = scaled(rig.right, 1.0 / factor);
  return small;
}

CameraMount level_mount(double height_m, double pitch_rad, bool assumed) {
  CameraMount mount;
  mount.T_body_left.linear() = rotation_from_yaw_pitch_roll(0.0, pitch_rad, 0.0) * R_body_optical();
  mount.T_body_left.translation() = Vector3d(0.0, 0.0, height_m);
  mount.assumed = assumed;
  return mount;
}

StereoRig bumblebee2(int width) {
  constexpr double kFocalLengthMm = 2.5, kSensorWidthMm = 4.8, kBaselineM = 0.12;
  StereoRig rig;
  rig.name = "bumblebee2-" + std::to_string(width);
  rig.size = {width, width * 3 / 4};
  const double f = kFocalLengthMm / kSensorWidthMm * width;
  const PinholeCamera camera{f, f, 0.5 * (rig.size.width - 1), 0.5 * (rig.size.height - 1), 0.0};
  rig.left = camera;
  rig.right = camera;
  rig.T_left_right.translation().x() = kBaselineM;
  rig.rectified = true;
  return rig;
}

std::optional<StereoRig> named_rig(const std::string& name) {
  for (int width : {1024, 640}) {
    StereoRig rig = bumblebee2(width);
    if (rig.name == name) return rig;
  }
  return std::nullopt;
}

}  // namespace tread
