#include "tread/sim/bump_sensor.hpp"

#include <cmath>

namespace tread {

OptionSet describe(BumpSensorOptions& options) {
  OptionSet set;
  set.add_group("channel", describe(options.channel));
  set.add("debounce_s", options.debounce_s, "how long a change must have lasted, s", 0.0, 10.0);
  return set;
}

std::optional<BumpEvent> BumpSensor::look(std::int64_t time_ns, bool touches) {
  if (touches == pressed_) {
    changed_ns_.reset();
    return std::nullopt;
  }
  if (!changed_ns_) changed_ns_ = time_ns;
  if (time_ns - *changed_ns_ < std::llround(1e9 * options_.debounce_s)) return std::nullopt;
  changed_ns_.reset();
  pressed_ = touches;
  return BumpEvent{0, pressed_};
}

}  // namespace tread
