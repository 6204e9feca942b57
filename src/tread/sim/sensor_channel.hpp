// The way of samples from a simulated sensor to the robot's program: when the sensor measures, what
// its clock says of that, what of it is lost, when the rest arrives, and scripted faults. Times are
// whole nanoseconds from the start of the simulation, exact, so that it does not matter in which
// steps a simulator asks:
//   while (const auto time_ns = channel.due(now_ns)) channel.push(*time_ns, measure(*time_ns));
//   for (ImuSample& sample : channel.arrived(now_ns)) ...
// Every sample uses up the same random numbers, whether it is lost or not: a fault changes nothing
// but the samples that it is of.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "tread/core/options.hpp"
#include "tread/sim/fault.hpp"
#include "tread/sim/random.hpp"
#include "tread/sim/sample_values.hpp"

namespace tread {

struct SensorChannelOptions {
  double rate_hz = 100.0;
  double phase = 0.0;            // of a period, until the first sample
  double latency_s = 0.0;        // from the measurement to the arrival
  double jitter_s = 0.0;         // up to so much more, evenly; samples still come in order
  double loss = 0.0;             // share of the samples that never come
  double clock_offset_s = 0.0;   // of the stamps
  double clock_drift_ppm = 0.0;  // of the stamps: microseconds a second
  [[nodiscard]] bool operator==(const SensorChannelOptions&) const = default;
};
[[nodiscard]] OptionSet describe(SensorChannelOptions& options);

// What the channels of a simulation share.
struct SensorChannelSetup {
  std::string sensor;             // "imu", for its faults and its random numbers
  std::uint64_t seed = 0;         // of the simulation
  std::span<const Fault> faults;  // of all sensors
  std::int64_t epoch_ns = 0;      // what a right clock says at the start of the simulation
};

// The part of a channel that does not depend on what is sent.
class ChannelTiming {
 public:
  ChannelTiming(const SensorChannelOptions& options, const SensorChannelSetup& setup);

  // The time of the next sample if it is not after `now_ns`; each is given once.
  [[nodiscard]] std::optional<std::int64_t> due(std::int64_t now_ns);
  // What the sensor's clock says at a time, with jumps.
  [[nodiscard]] std::int64_t stamp_ns(std::int64_t time_ns) const;
  // When the sample of this time arrives; nothing if it is lost. To be asked once a sample.
  [[nodiscard]] std::optional<std::int64_t> arrival_ns(std::int64_t time_ns);
  // The fault of this kind at a time, or null.
  [[nodiscard]] const Fault* fault(FaultKind kind, std::int64_t time_ns) const;
  // Whether the last sample before a fault will be asked for.
  [[nodiscard]] bool repeats() const;

 private:
  SensorChannelOptions options_;
  std::int64_t epoch_ns_;
  FaultSchedule faults_;
  Random random_;
  std::int64_t next_ = 0;         // number of the sample
  std::int64_t last_arrival_ns_;  // of those in order
};

// `Sample` is one of ImuSample, GnssFix, WheelSample, LegSample, HeadState, BumpEvent, StereoFrame.
template <class Sample>
class SensorChannel {
 public:
  // `full_scale` holds the ends of the ranges that saturation refers to (see sample_values.hpp).
  SensorChannel(const SensorChannelOptions& options, const SensorChannelSetup& setup,
                Sample full_scale = {})
      : timing_(options, setup), full_scale_(std::move(full_scale)) {}

  // The time of the next sample if it is not after `now_ns`; each is given once.
  [[nodiscard]] std::optional<std::int64_t> due(std::int64_t now_ns) { return timing_.due(now_ns); }

  // Sends what was measured at a time, in order of time; the channel writes the stamp. A sensor
  // that tells of events need not send anything when it is due.
  void push(std::int64_t time_ns, Sample sample) {
    const auto arrival_ns = timing_.arrival_ns(time_ns);
    if (timing_.fault(FaultKind::kDead, time_ns) != nullptr) return;
    sample.stamp_ns = timing_.stamp_ns(time_ns);
    if (const Fault* fault = timing_.fault(FaultKind::kSaturated, time_ns)) {
      clip_values(sample, full_scale_, fault->amount);
    }
    if (timing_.repeats()) repeat_last(time_ns, sample);
    if (arrival_ns) under_way_.emplace(*arrival_ns, std::move(sample));
  }

  // What has arrived until now and was not given before, in order of arrival.
  [[nodiscard]] std::vector<Sample> arrived(std::int64_t now_ns) {
    std::vector<Sample> samples;
    while (!under_way_.empty() && under_way_.begin()->first <= now_ns) {
      samples.push_back(std::move(under_way_.begin()->second));
      under_way_.erase(under_way_.begin());
    }
    return samples;
  }

 private:
  void repeat_last(std::int64_t time_ns, Sample& sample) {
    const bool frozen = timing_.fault(FaultKind::kFrozen, time_ns) != nullptr;
    const bool stuck = timing_.fault(FaultKind::kStuck, time_ns) != nullptr;
    if ((!frozen && !stuck) || !last_) {
      last_ = sample;
    } else if (frozen) {
      sample = *last_;
    } else {
      copy_values(*last_, sample);
    }
  }

  ChannelTiming timing_;
  Sample full_scale_;
  std::optional<Sample> last_;                     // as it was sent, while a fault may ask for it
  std::multimap<std::int64_t, Sample> under_way_;  // by time of arrival
};

}  // namespace tread
