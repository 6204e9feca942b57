#include "tread/sim/gnss_sensor.hpp"

#include <algorithm>
#include <cmath>

namespace tread {
namespace {

using Eigen::Vector3d;

// Below it there is no fix whatever the options say, and errors would have no bound.
constexpr double kLeastSky = 0.01;

}  // namespace

OptionSet describe(GnssSensorOptions& options) {
  OptionSet set;
  set.add_group("channel", describe(options.channel));
  set.add("white_m", options.white_m, "white noise level, each axis, one standard deviation, m",
          0.0, 1e3);
  set.add("drift_m", options.drift_m, "slow error level, each axis, one standard deviation, m", 0.0,
          1e3);
  set.add("drift_time_s", options.drift_time_s, "in which the slow error forgets, s", 1e-2, 1e6);
  set.add("up_factor", options.up_factor, "of all errors upwards to those level", 0.0, 100.0);
  set.add("drop_outs_per_h", options.drop_outs_per_h, "how often there is no fix", 0.0, 1e4);
  set.add("drop_out_s", options.drop_out_s, "mean duration, s", 1e-2, 1e6);
  set.add("jumps_per_h", options.jumps_per_h, "how often multipath comes", 0.0, 1e4);
  set.add("jump_m", options.jump_m, "of multipath level, each axis, one standard deviation, m", 0.0,
          1e4);
  set.add("jump_s", options.jump_s, "mean duration of multipath, s", 1e-2, 1e6);
  set.add("least_sky", options.least_sky, "share of the sky that must be open for a fix", 0.0, 1.0);
  set.add("report", options.report, "what it says of its errors to what they are", 1e-3, 1e3);
  return set;
}

GnssSensor::GnssSensor(const GnssSensorOptions& options, const Vector3d& p_body_antenna_m,
                       std::uint64_t seed)
    : options_(options),
      p_body_antenna_m_(p_body_antenna_m),
      white_random_(Random(seed).stream("gnss").stream("white")),
      drift_random_(Random(seed).stream("gnss").stream("drift")),
      jump_random_(Random(seed).stream("gnss").stream("jump")),
      drop_outs_(options.drop_outs_per_h, options.drop_out_s,
                 Random(seed).stream("gnss").stream("drop-outs")),
      jumps_(options.jumps_per_h, options.jump_s, Random(seed).stream("gnss").stream("jumps")),
      drift_m_(options.drift_m * spread(drift_random_)) {}

// Errors of one standard deviation level.
Vector3d GnssSensor::spread(Random& random) const {
  Vector3d errors;
  for (double& error : errors) error = random.normal();
  errors.z() *= options_.up_factor;
  return errors;
}

std::optional<GnssFix> GnssSensor::measure(std::int64_t time_ns, const Isometry3d& T_world_body,
                                           double sky) {
  const double passed_s = 1e-9 * static_cast<double>(time_ns - last_ns_.value_or(time_ns));
  last_ns_ = time_ns;
  const double open = sky >= kLeastSky ? std::min(sky, 1.0) : kLeastSky;  // also if not a number
  const double kept = std::exp(-passed_s / options_.drift_time_s);
  drift_m_ =
      kept * drift_m_ + options_.drift_m * std::sqrt(1.0 - kept * kept) * spread(drift_random_);
  const double white_m = options_.white_m / open;
  const Vector3d white = white_m * spread(white_random_);
  const bool silent = drop_outs_.advance(passed_s);
  const bool multipath = jumps_.advance(passed_s, 1.0 / open);
  if (jumps_.count() != jump_) {
    jump_ = jumps_.count();
    jump_m_ = options_.jump_m * spread(jump_random_);
  }
  if (silent || !(sky >= std::max(options_.least_sky, kLeastSky))) return std::nullopt;
  GnssFix fix;
  fix.position_m = T_world_body * p_body_antenna_m_ + white + drift_m_;
  if (multipath) fix.position_m += jump_m_;
  fix.sigma_level_m = options_.report * std::hypot(white_m, options_.drift_m);
  fix.sigma_up_m = options_.up_factor * fix.sigma_level_m;
  return fix;
}

}  // namespace tread
