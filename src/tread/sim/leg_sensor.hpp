// Simulated sensors of four legs: joint encoders, whose differences over time, low-passed, are the
// velocities; torques; forces of the ground on the feet.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "tread/geometry/samples.hpp"
#include "tread/sim/random.hpp"
#include "tread/sim/sensor_channel.hpp"

namespace tread {

struct LegSensorOptions {
  SensorChannelOptions channel = {.rate_hz = 500.0, .latency_s = 0.001};
  int steps_per_turn = 80'000;             // of a joint
  double position_offset_rad = 1e-3;       // zero of a joint, stays, one standard deviation
  double velocity_cutoff_hz = 60.0;        // of the low-pass; 0: differences as they are
  double torque_noise_nm = 0.3;            // white, of a sample, one standard deviation
  double torque_offset_nm = 0.5;           // stays, one standard deviation
  double foot_force_noise_n = 4.0;         // each axis, white, one standard deviation
  double foot_force_offset_n = 3.0;        // each axis, stays, one standard deviation
  double velocity_range_rad_per_s = 20.0;  // both ways
  double torque_range_nm = 250.0;          // both ways
  double foot_force_range_n = 3000.0;      // each axis, both ways
  [[nodiscard]] bool operator==(const LegSensorOptions&) const = default;
};
[[nodiscard]] OptionSet describe(LegSensorOptions& options);

class LegSensor {
 public:
  LegSensor(const LegSensorOptions& options, std::uint64_t seed);

  // Of the true positions, torques and forces; the true velocities are not looked at. To be asked
  // in order of time; the first velocities are 0. The stamp is left to the channel.
  [[nodiscard]] LegSample measure(std::int64_t time_ns, const LegSample& truth);
  // The ends of the ranges.
  [[nodiscard]] LegSample full_scale() const;

 private:
  void measure_joint(std::size_t joint, double passed_s, const LegSample& truth, LegSample& sample);

  LegSensorOptions options_;
  Random noise_;
  double step_rad_;
  LegSample offset_;  // of positions, torques and forces
  LegSample last_;
  std::optional<std::int64_t> last_ns_;
};

}  // namespace tread
