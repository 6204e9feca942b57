#include "tread/sim/wheel_sensor.hpp"

#include <algorithm>
#include <numbers>

namespace tread {
namespace {

Encoder encoder(const WheelSensorOptions& options, const Random& random) {
  return {2.0 * std::numbers::pi / options.steps_per_turn, Random(random).uniform()};
}

}  // namespace

OptionSet describe(WheelSensorOptions& options) {
  OptionSet set;
  set.add_group("channel", describe(options.channel));
  set.add("steps_per_turn", options.steps_per_turn, "of the encoder, a turn of the wheel", 1,
          100'000'000);
  set.add("current_noise_a", options.current_noise_a, "white, one standard deviation, A", 0.0, 1e3);
  set.add("current_offset_a", options.current_offset_a, "stays, one standard deviation, A", 0.0,
          1e3);
  set.add("current_step_a", options.current_step_a, "0: not rounded, A", 0.0, 1e3);
  set.add("current_range_a", options.current_range_a, "both ways, A", 1e-3, 1e5);
  return set;
}

WheelSensor::WheelSensor(const WheelSensorOptions& options, std::uint64_t seed)
    : options_(options),
      noise_(Random(seed).stream("wheels").stream("current")),
      left_(encoder(options, Random(seed).stream("wheels").stream("left"))),
      right_(encoder(options, Random(seed).stream("wheels").stream("right"))) {
  Random once = Random(seed).stream("wheels").stream("offset");
  left_offset_a_ = options.current_offset_a * once.normal();
  right_offset_a_ = options.current_offset_a * once.normal();
}

double WheelSensor::current(double truth_a, double offset_a) {
  const double value = truth_a + offset_a + options_.current_noise_a * noise_.normal();
  return to_step(std::clamp(value, -options_.current_range_a, options_.current_range_a),
                 options_.current_step_a);
}

WheelSample WheelSensor::measure(const WheelSample& truth) {
  WheelSample sample;
  sample.left_rad = left_.read(truth.left_rad);
  sample.right_rad = right_.read(truth.right_rad);
  sample.left_current_a = current(truth.left_current_a, left_offset_a_);
  sample.right_current_a = current(truth.right_current_a, right_offset_a_);
  return sample;
}

WheelSample WheelSensor::full_scale() const {
  return {0, 0.0, 0.0, options_.current_range_a, options_.current_range_a};
}

}  // namespace tread
