#include "tread/sim/leg_sensor.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tread/sim/quantise.hpp"

namespace tread {
namespace {

double clipped(double value, double range) {
  return std::clamp(value, -range, range);
}

}  // namespace

OptionSet describe(LegSensorOptions& options) {
  OptionSet set;
  set.add_group("channel", describe(options.channel));
  set.add("steps_per_turn", options.steps_per_turn, "of the encoder, a turn of the joint", 1,
          100'000'000);
  set.add("position_offset_rad", options.position_offset_rad,
          "zero of a joint, stays, one standard deviation, rad", 0.0, 1.0);
  set.add("velocity_cutoff_hz", options.velocity_cutoff_hz,
          "of the low-pass of velocities; 0: differences as they are, Hz", 0.0, 1e5);
  set.add("torque_noise_nm", options.torque_noise_nm, "white, one standard deviation, Nm", 0.0,
          1e4);
  set.add("torque_offset_nm", options.torque_offset_nm, "stays, one standard deviation, Nm", 0.0,
          1e4);
  set.add("foot_force_noise_n", options.foot_force_noise_n, "white, one standard deviation, N", 0.0,
          1e5);
  set.add("foot_force_offset_n", options.foot_force_offset_n, "stays, one standard deviation, N",
          0.0, 1e5);
  set.add("velocity_range_rad_per_s", options.velocity_range_rad_per_s, "both ways, rad/s", 1e-3,
          1e4);
  set.add("torque_range_nm", options.torque_range_nm, "both ways, Nm", 1e-3, 1e6);
  set.add("foot_force_range_n", options.foot_force_range_n, "both ways, N", 1e-3, 1e7);
  return set;
}

LegSensor::LegSensor(const LegSensorOptions& options, std::uint64_t seed)
    : options_(options),
      noise_(Random(seed).stream("legs").stream("noise")),
      step_rad_(2.0 * std::numbers::pi / options.steps_per_turn) {
  Random once = Random(seed).stream("legs").stream("offset");
  for (double& offset : offset_.position_rad) offset = options.position_offset_rad * once.normal();
  for (double& offset : offset_.torque_nm) offset = options.torque_offset_nm * once.normal();
  for (Eigen::Vector3d& offset : offset_.foot_force_n) {
    for (double& axis : offset) axis = options.foot_force_offset_n * once.normal();
  }
}

void LegSensor::measure_joint(std::size_t joint, double passed_s, const LegSample& truth,
                              LegSample& sample) {
  double& position = sample.position_rad[joint];
  position = to_step(truth.position_rad[joint] + offset_.position_rad[joint], step_rad_);
  double& velocity = sample.velocity_rad_per_s[joint];
  velocity = last_.velocity_rad_per_s[joint];
  if (last_ns_ && passed_s > 0.0) {
    const double difference = (position - last_.position_rad[joint]) / passed_s;
    const double angle = 2.0 * std::numbers::pi * options_.velocity_cutoff_hz * passed_s;
    const double share = options_.velocity_cutoff_hz > 0.0 ? 1.0 - std::exp(-angle) : 1.0;
    velocity =
        clipped(velocity + share * (difference - velocity), options_.velocity_range_rad_per_s);
  }
  sample.torque_nm[joint] = clipped(truth.torque_nm[joint] + offset_.torque_nm[joint] +
                                        options_.torque_noise_nm * noise_.normal(),
                                    options_.torque_range_nm);
}

LegSample LegSensor::measure(std::int64_t time_ns, const LegSample& truth) {
  const double passed_s = 1e-9 * static_cast<double>(time_ns - last_ns_.value_or(time_ns));
  LegSample sample;
  for (std::size_t joint = 0; joint < kLegJoints; ++joint) {
    measure_joint(joint, passed_s, truth, sample);
  }
  for (std::size_t leg = 0; leg < kLegs; ++leg) {
    for (int axis = 0; axis < 3; ++axis) {
      sample.foot_force_n[leg](axis) =
          clipped(truth.foot_force_n[leg](axis) + offset_.foot_force_n[leg](axis) +
                      options_.foot_force_noise_n * noise_.normal(),
                  options_.foot_force_range_n);
    }
  }
  last_ns_ = time_ns;
  last_ = sample;
  return sample;
}

LegSample LegSensor::full_scale() const {
  LegSample full;
  full.velocity_rad_per_s.fill(options_.velocity_range_rad_per_s);
  full.torque_nm.fill(options_.torque_range_nm);
  for (Eigen::Vector3d& force : full.foot_force_n) force.setConstant(options_.foot_force_range_n);
  return full;
}

}  // namespace tread
