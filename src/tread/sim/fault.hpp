// Faults of sensors, scripted by time: what a course or a test breaks on purpose. Plain data;
// SensorChannel carries them out.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tread/core/result.hpp"

namespace tread {

enum class FaultKind : std::uint8_t {
  kDead,       // nothing comes
  kStuck,      // the values of the last sample before it again and again; stamps go on
  kFrozen,     // the last sample before it again and again, with its stamp
  kSaturated,  // values are clipped to the share `amount` of their range
  kShuffled,   // each sample comes up to `amount` seconds later than it would, so out of order
  kClockJump,  // stamps are off by `amount` seconds
};

struct Fault {
  std::string sensor;  // one of sensor_names()
  FaultKind kind = FaultKind::kDead;
  double from_s = 0.0;  // of the time of the simulation, when the sample is taken
  double until_s = std::numeric_limits<double>::infinity();
  double amount = 0.0;  // see FaultKind; the others have none
};

// "clock_jump"; and back.
[[nodiscard]] std::string name_of(FaultKind kind);
[[nodiscard]] std::optional<FaultKind> fault_kind_named(std::string_view name);
[[nodiscard]] std::vector<std::string> fault_kind_names();

// imu, gnss, wheels, legs, bump, head, and camera0, camera1, ...: one a stereo head.
[[nodiscard]] std::vector<std::string> sensor_names(int heads);

// Sensors that there are, times and amounts that make sense. Errors name the field:
// "faults[2].sensor".
[[nodiscard]] Status check_faults(std::span<const Fault> faults, int heads);

// The faults of one sensor.
class FaultSchedule {
 public:
  FaultSchedule() = default;
  FaultSchedule(std::span<const Fault> faults, std::string_view sensor);

  // The fault of this kind at a time, of several the last in the list; null if there is none.
  [[nodiscard]] const Fault* find(FaultKind kind, double time_s) const;
  // Whether there ever is one.
  [[nodiscard]] bool has(FaultKind kind) const;
  // All jumps of the clock that are in effect.
  [[nodiscard]] double clock_jump_s(double time_s) const;

 private:
  std::vector<Fault> faults_;
};

}  // namespace tread
