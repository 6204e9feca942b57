// A simulated bumper switch: it tells of a change when that has lasted for a while, as contacts
// bounce.
#pragma once

#include <cstdint>
#include <optional>

#include "tread/geometry/samples.hpp"
#include "tread/sim/sensor_channel.hpp"

namespace tread {

struct BumpSensorOptions {
  SensorChannelOptions channel = {.rate_hz = 200.0, .latency_s = 0.005};  // how often it looks
  double debounce_s = 0.03;  // how long a change must have lasted
  [[nodiscard]] bool operator==(const BumpSensorOptions&) const = default;
};
[[nodiscard]] OptionSet describe(BumpSensorOptions& options);

class BumpSensor {
 public:
  explicit BumpSensor(const BumpSensorOptions& options) : options_(options) {}

  // Whether the bumper touches something, each time the sensor looks, in order of time. The event
  // if there is one to tell; it begins as let go. The stamp is left to the channel.
  [[nodiscard]] std::optional<BumpEvent> look(std::int64_t time_ns, bool touches);

 private:
  BumpSensorOptions options_;
  bool pressed_ = false;
  std::optional<std::int64_t> changed_ns_;  // since when it has been otherwise
};

}  // namespace tread
