#include "tread/sim/sample_values.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace tread {
namespace {

void clip(double& value, double full_scale, double share) {
  const double limit = share * std::abs(full_scale);
  if (limit > 0.0) value = std::clamp(value, -limit, limit);
}

void clip(Eigen::Vector3d& values, const Eigen::Vector3d& full_scale, double share) {
  for (int axis = 0; axis < 3; ++axis) clip(values(axis), full_scale(axis), share);
}

template <std::size_t N>
void clip(std::array<double, N>& values, const std::array<double, N>& full_scale, double share) {
  for (std::size_t i = 0; i < N; ++i) clip(values[i], full_scale[i], share);
}

}  // namespace

void copy_values(const StereoFrame& from, StereoFrame& into) {
  into.left = from.left;
  into.right = from.right;
  into.left_colour = from.left_colour;
}

void clip_values(ImuSample& sample, const ImuSample& full_scale, double share) {
  clip(sample.gyro_rad_per_s, full_scale.gyro_rad_per_s, share);
  clip(sample.accel_m_per_s2, full_scale.accel_m_per_s2, share);
}

void clip_values(WheelSample& sample, const WheelSample& full_scale, double share) {
  clip(sample.left_current_a, full_scale.left_current_a, share);
  clip(sample.right_current_a, full_scale.right_current_a, share);
}

void clip_values(LegSample& sample, const LegSample& full_scale, double share) {
  clip(sample.velocity_rad_per_s, full_scale.velocity_rad_per_s, share);
  clip(sample.torque_nm, full_scale.torque_nm, share);
  for (std::size_t leg = 0; leg < kLegs; ++leg) {
    clip(sample.foot_force_n[leg], full_scale.foot_force_n[leg], share);
  }
}

void clip_values(StereoFrame& frame, const StereoFrame&, double share) {
  const auto limit = static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(share, 0.0, 1.0)));
  const auto darker = [=](std::uint8_t value) { return std::min(value, limit); };
  for (Image<std::uint8_t>* image : {&frame.left, &frame.right}) {
    for (int y = 0; y < image->height; ++y) {
      std::transform(image->row(y), image->row(y) + image->width, image->row(y), darker);
    }
  }
  Image<Rgb>& colour = frame.left_colour;
  for (int y = 0; y < colour.height; ++y) {
    std::transform(colour.row(y), colour.row(y) + colour.width, colour.row(y), [=](Rgb pixel) {
      return Rgb{darker(pixel.r), darker(pixel.g), darker(pixel.b)};
    });
  }
}

}  // namespace tread
