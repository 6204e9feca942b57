#include "tread/sim/sensor_channel.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tread {
namespace {

double seconds(std::int64_t time_ns) {
  return 1e-9 * static_cast<double>(time_ns);
}

std::int64_t nanoseconds(double time_s) {
  return std::llround(1e9 * time_s);
}

}  // namespace

OptionSet describe(SensorChannelOptions& options) {
  OptionSet set;
  set.add("rate_hz", options.rate_hz, "samples a second", 1e-3, 1e5);
  set.add("phase", options.phase, "part of a period until the first sample", 0.0, 1.0);
  set.add("latency_s", options.latency_s, "from the measurement to the arrival, s", 0.0, 1e3);
  set.add("jitter_s", options.jitter_s, "up to so much more, evenly, s", 0.0, 1e3);
  set.add("loss", options.loss, "share of the samples that never come", 0.0, 1.0);
  set.add("clock_offset_s", options.clock_offset_s, "of the stamps, s", -1e6, 1e6);
  set.add("clock_drift_ppm", options.clock_drift_ppm, "of the stamps, microseconds a second", -1e4,
          1e4);
  return set;
}

ChannelTiming::ChannelTiming(const SensorChannelOptions& options, const SensorChannelSetup& setup)
    : options_(options),
      epoch_ns_(setup.epoch_ns),
      faults_(setup.faults, setup.sensor),
      random_(Random(setup.seed).stream("channel").stream(setup.sensor)),
      last_arrival_ns_(std::numeric_limits<std::int64_t>::min()) {}

std::optional<std::int64_t> ChannelTiming::due(std::int64_t now_ns) {
  // From the number of the sample, not from the time of the last: nothing adds up.
  const double periods = static_cast<double>(next_) + options_.phase;
  const std::int64_t time_ns = std::llround(periods / options_.rate_hz * 1e9);
  if (time_ns > now_ns) return std::nullopt;
  ++next_;
  return time_ns;
}

std::int64_t ChannelTiming::stamp_ns(std::int64_t time_ns) const {
  const double time_s = seconds(time_ns);
  const double off_s = options_.clock_offset_s + 1e-6 * options_.clock_drift_ppm * time_s +
                       faults_.clock_jump_s(time_s);
  return epoch_ns_ + time_ns + nanoseconds(off_s);
}

std::optional<std::int64_t> ChannelTiming::arrival_ns(std::int64_t time_ns) {
  const bool lost = random_.uniform() < options_.loss;
  const double jitter = random_.uniform(), disorder = random_.uniform();
  if (lost) return std::nullopt;
  const std::int64_t in_order_ns = std::max(
      last_arrival_ns_, time_ns + nanoseconds(options_.latency_s + jitter * options_.jitter_s));
  if (const Fault* shuffled = fault(FaultKind::kShuffled, time_ns)) {
    return in_order_ns + nanoseconds(disorder * shuffled->amount);
  }
  last_arrival_ns_ = in_order_ns;
  return in_order_ns;
}

const Fault* ChannelTiming::fault(FaultKind kind, std::int64_t time_ns) const {
  return faults_.find(kind, seconds(time_ns));
}

bool ChannelTiming::repeats() const {
  return faults_.has(FaultKind::kStuck) || faults_.has(FaultKind::kFrozen);
}

}  // namespace tread
