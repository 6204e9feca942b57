// Simulated encoders and motor current sensors of the two driven sides.
#pragma once

#include <cstdint>

#include "tread/geometry/samples.hpp"
#include "tread/sim/quantise.hpp"
#include "tread/sim/random.hpp"
#include "tread/sim/sensor_channel.hpp"

namespace tread {

struct WheelSensorOptions {
  SensorChannelOptions channel = {.rate_hz = 50.0, .latency_s = 0.005};
  int steps_per_turn = 2048;      // of the wheel
  double current_noise_a = 0.2;   // white, of a sample, one standard deviation
  double current_offset_a = 0.1;  // stays, one standard deviation
  double current_step_a = 0.05;   // 0: not rounded
  double current_range_a = 60.0;  // both ways
  [[nodiscard]] bool operator==(const WheelSensorOptions&) const = default;
};
[[nodiscard]] OptionSet describe(WheelSensorOptions& options);

class WheelSensor {
 public:
  WheelSensor(const WheelSensorOptions& options, std::uint64_t seed);

  // Of the true angles since the start and the true currents. The stamp is left to the channel.
  [[nodiscard]] WheelSample measure(const WheelSample& truth);
  // The ends of the ranges.
  [[nodiscard]] WheelSample full_scale() const;

 private:
  [[nodiscard]] double current(double truth_a, double offset_a);

  WheelSensorOptions options_;
  Random noise_;
  Encoder left_;
  Encoder right_;
  double left_offset_a_;
  double right_offset_a_;
};

}  // namespace tread
