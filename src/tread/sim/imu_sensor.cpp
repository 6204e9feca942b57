#include "tread/sim/imu_sensor.hpp"

#include <algorithm>
#include <cmath>

#include "tread/sim/quantise.hpp"

namespace tread {
namespace {

using Eigen::Vector3d;

constexpr double kGravity_m_per_s2 = 9.81;

// One after the other: the order in which a constructor's arguments are evaluated is free.
Vector3d normal_vector(Random& random) {
  Vector3d values;
  for (double& value : values) value = random.normal();
  return values;
}

}  // namespace

OptionSet describe(ImuSensorOptions& options) {
  OptionSet set;
  set.add_group("channel", describe(options.channel));
  set.add("gyro_noise", options.gyro_noise, "white noise, rad/s/sqrt(Hz)", 0.0, 1.0);
  set.add("accel_noise", options.accel_noise, "white noise, m/s^2/sqrt(Hz)", 0.0, 100.0);
  set.add("gyro_walk", options.gyro_walk, "random walk of the bias, rad/s^2/sqrt(Hz)", 0.0, 1.0);
  set.add("accel_walk", options.accel_walk, "random walk of the bias, m/s^3/sqrt(Hz)", 0.0, 100.0);
  set.add("gyro_bias_rad_per_s", options.gyro_bias_rad_per_s,
          "at the start, one standard deviation, rad/s", 0.0, 10.0);
  set.add("accel_bias_m_per_s2", options.accel_bias_m_per_s2,
          "at the start, one standard deviation, m/s^2", 0.0, 100.0);
  set.add("gyro_scale", options.gyro_scale, "error, one standard deviation", 0.0, 0.5);
  set.add("accel_scale", options.accel_scale, "error, one standard deviation", 0.0, 0.5);
  set.add("gyro_range_rad_per_s", options.gyro_range_rad_per_s, "both ways, rad/s", 1e-3, 1e3);
  set.add("accel_range_m_per_s2", options.accel_range_m_per_s2, "both ways, m/s^2", 1e-3, 1e5);
  set.add("gyro_step_rad_per_s", options.gyro_step_rad_per_s, "0: not rounded, rad/s", 0.0, 1.0);
  set.add("accel_step_m_per_s2", options.accel_step_m_per_s2, "0: not rounded, m/s^2", 0.0, 100.0);
  return set;
}

Imu imu_of(const ImuSensorOptions& options, const Isometry3d& T_imu_left) {
  return {T_imu_left,        options.gyro_noise, options.accel_noise,
          options.gyro_walk, options.accel_walk, options.channel.rate_hz};
}

ImuSample felt_motion(const BodyMotion& motion, const Isometry3d& T_body_imu) {
  const Vector3d& w = motion.rate_rad_per_s;
  const Vector3d r = T_body_imu.translation();
  const Vector3d force =
      motion.T_world_body.linear().transpose() *
          (motion.acceleration_m_per_s2 + kGravity_m_per_s2 * Vector3d::UnitZ()) +
      motion.rate_change_rad_per_s2.cross(r) + w.cross(w.cross(r));
  const Eigen::Matrix3d R_imu_body = T_body_imu.linear().transpose();
  return {0, R_imu_body * w, R_imu_body * force};
}

ImuSensor::ImuSensor(const ImuSensorOptions& options, const Isometry3d& T_body_imu,
                     std::uint64_t seed)
    : options_(options),
      T_body_imu_(T_body_imu),
      gyro_(start(Random(seed).stream("imu").stream("gyro"), options.gyro_bias_rad_per_s,
                  options.gyro_scale)),
      accel_(start(Random(seed).stream("imu").stream("accel"), options.accel_bias_m_per_s2,
                   options.accel_scale)) {}

ImuSensor::Axes ImuSensor::start(const Random& random, double bias, double scale) {
  Random once = random.stream("once");
  Axes axes{random.stream("noise"), random.stream("walk"), Vector3d::Zero(), Vector3d::Zero()};
  axes.bias = bias * normal_vector(once);
  axes.scale = scale * normal_vector(once);
  return axes;
}

ImuSample ImuSensor::measure(std::int64_t time_ns, const BodyMotion& motion) {
  const double passed_s = 1e-9 * static_cast<double>(time_ns - last_ns_.value_or(time_ns));
  last_ns_ = time_ns;
  ImuSample sample = felt_motion(motion, T_body_imu_);
  sample.gyro_rad_per_s = spoil(sample.gyro_rad_per_s, passed_s,
                                {options_.gyro_noise, options_.gyro_walk,
                                 options_.gyro_range_rad_per_s, options_.gyro_step_rad_per_s},
                                gyro_);
  sample.accel_m_per_s2 = spoil(sample.accel_m_per_s2, passed_s,
                                {options_.accel_noise, options_.accel_walk,
                                 options_.accel_range_m_per_s2, options_.accel_step_m_per_s2},
                                accel_);
  return sample;
}

ImuSample ImuSensor::full_scale() const {
  return {0, Vector3d::Constant(options_.gyro_range_rad_per_s),
          Vector3d::Constant(options_.accel_range_m_per_s2)};
}

Vector3d ImuSensor::spoil(const Vector3d& truth, double passed_s, const Figures& figures,
                          Axes& axes) const {
  axes.bias += figures.walk * std::sqrt(passed_s) * normal_vector(axes.walk);
  const Vector3d noise =
      figures.noise * std::sqrt(options_.channel.rate_hz) * normal_vector(axes.noise);
  const Vector3d value = truth + axes.scale.cwiseProduct(truth) + axes.bias + noise;
  return value.unaryExpr([&](double v) {
    return to_step(std::clamp(v, -figures.range, figures.range), figures.step);
  });
}

}  // namespace tread
