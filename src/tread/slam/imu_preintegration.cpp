#include "tread/slam/imu_preintegration.hpp"

#include <algorithm>

namespace tread {
namespace {

struct Measured {
  Eigen::Vector3d gyro, accel;
};

// What was measured at a time, between two samples or at the nearest.
Measured measured_at(std::span<const ImuSample> samples, std::int64_t stamp_ns) {
  const auto after = std::lower_bound(
      samples.begin(), samples.end(), stamp_ns,
      [](const ImuSample& sample, std::int64_t stamp) { return sample.stamp_ns < stamp; });
  const auto of = [](const ImuSample& s) { return Measured{s.gyro_rad_per_s, s.accel_m_per_s2}; };
  if (after == samples.end()) return of(samples.back());
  if (after == samples.begin() || after->stamp_ns == stamp_ns) return of(*after);
  const ImuSample& a = *(after - 1);
  const ImuSample& b = *after;
  const double share =
      static_cast<double>(stamp_ns - a.stamp_ns) / static_cast<double>(b.stamp_ns - a.stamp_ns);
  return {a.gyro_rad_per_s + share * (b.gyro_rad_per_s - a.gyro_rad_per_s),
          a.accel_m_per_s2 + share * (b.accel_m_per_s2 - a.accel_m_per_s2)};
}

}  // namespace

void ImuPreintegration::integrate(std::span<const ImuSample> samples, std::int64_t from_ns,
                                  std::int64_t to_ns) {
  if (samples.empty() || to_ns <= from_ns) return;
  std::int64_t at_ns = from_ns;
  Measured at = measured_at(samples, from_ns);
  const auto go_to = [&](std::int64_t stamp_ns) {
    const Measured next = measured_at(samples, stamp_ns);
    add({static_cast<double>(stamp_ns - at_ns) * 1e-9, 0.5 * (at.gyro + next.gyro),
         0.5 * (at.accel + next.accel)});
    at_ns = stamp_ns;
    at = next;
  };
  for (const ImuSample& sample : samples) {
    if (sample.stamp_ns > at_ns && sample.stamp_ns < to_ns) go_to(sample.stamp_ns);
  }
  go_to(to_ns);
}

// Midpoint rule. The errors (rotation, v, p) go over into those behind the step by A; those of the
// measurements, bias and noise alike, come in by G.
void ImuPreintegration::add(const Step& step) {
  steps_.push_back(step);
  const double dt = step.seconds;
  const Eigen::Vector3d turn = (step.gyro - bias_.gyro_rad_per_s) * dt;
  const Eigen::Vector3d a = step.accel - bias_.accel_m_per_s2;
  const Eigen::Matrix3d dR = so3_exp(turn), half = so3_exp(0.5 * turn);
  const Eigen::Matrix3d R_half = motion_.R * half;
  const Eigen::Matrix3d push = -R_half * hat(a);

  Matrix9d A = Matrix9d::Identity();
  A.block<3, 3>(0, 0) = dR.transpose();
  A.block<3, 3>(3, 0) = dt * push * half.transpose();
  A.block<3, 3>(6, 0) = 0.5 * dt * A.block<3, 3>(3, 0);
  A.block<3, 3>(6, 3) = dt * Eigen::Matrix3d::Identity();
  BiasJacobian G = BiasJacobian::Zero();
  G.block<3, 3>(0, 0) = -dt * so3_left_jacobian(-turn);
  G.block<3, 3>(3, 0) = -0.5 * dt * dt * push * so3_left_jacobian(-0.5 * turn);
  G.block<3, 3>(6, 0) = 0.5 * dt * G.block<3, 3>(3, 0);
  G.block<3, 3>(3, 3) = -dt * R_half;
  G.block<3, 3>(6, 3) = -0.5 * dt * dt * R_half;

  Vector6d noise;
  noise << Eigen::Vector3d::Constant(imu_.gyro_noise * imu_.gyro_noise / dt),
      Eigen::Vector3d::Constant(imu_.accel_noise * imu_.accel_noise / dt);
  covariance_ = A * covariance_ * A.transpose() + G * noise.asDiagonal() * G.transpose();
  by_bias_ = A * by_bias_ + G;

  const Eigen::Vector3d pushed = R_half * a * dt;
  motion_.p += motion_.v * dt + 0.5 * dt * pushed;
  motion_.v += pushed;
  motion_.R = motion_.R * dR;
  seconds_ += dt;
}

ImuPreintegration::Motion ImuPreintegration::motion_with(const ImuBias& bias) const {
  Vector6d change;
  change << bias.gyro_rad_per_s - bias_.gyro_rad_per_s, bias.accel_m_per_s2 - bias_.accel_m_per_s2;
  const Eigen::Matrix<double, 9, 1> d = by_bias_ * change;
  return {motion_.R * so3_exp(d.head<3>()), motion_.v + d.segment<3>(3), motion_.p + d.tail<3>()};
}

ImuPreintegration ImuPreintegration::again(const ImuBias& bias) const {
  ImuPreintegration other(imu_, bias);
  for (const Step& step : steps_) other.add(step);
  return other;
}

InertialState ImuPreintegration::predict(const InertialState& before,
                                         const Eigen::Vector3d& gravity_world) const {
  const Motion m = motion_with(before.bias);
  const Eigen::Matrix3d& R = before.T_world_imu.linear();
  InertialState after = before;
  after.T_world_imu.linear() = so3_exp(so3_log(R * m.R));
  after.T_world_imu.translation() +=
      before.velocity_m_per_s * seconds_ + 0.5 * seconds_ * seconds_ * gravity_world + R * m.p;
  after.velocity_m_per_s += seconds_ * gravity_world + R * m.v;
  return after;
}

}  // namespace tread
