// A simulated satellite receiver. The error of a fix is the sum of
//   white noise,
//   drift: a first-order Gauss-Markov process (clocks, orbits, the ionosphere),
//     d(t + dt) = exp(-dt / tau) d(t) + sigma sqrt(1 - exp(-2 dt / tau)) n,
//   multipath: a jump that stays for a while, more often where less of the sky is open.
// Errors upwards are larger by a factor. Fixes fail for a while now and then, and where too little
// of the sky is open. What the receiver says of itself knows noise, drift and sky, but no
// multipath.
#pragma once

#include <cstdint>
#include <optional>

#include "tread/geometry/samples.hpp"
#include "tread/sim/random.hpp"
#include "tread/sim/sensor_channel.hpp"
#include "tread/sim/spells.hpp"

namespace tread {

// A receiver with WAAS, as LAGR had: 3 m level, most of it slow.
struct GnssSensorOptions {
  SensorChannelOptions channel = {.rate_hz = 1.0, .latency_s = 0.1};
  double white_m = 0.5;         // level, each axis, one standard deviation, under an open sky
  double drift_m = 2.95;        // level, each axis, one standard deviation
  double drift_time_s = 300.0;  // in which the drift forgets
  double up_factor = 1.5;       // of all errors upwards to those level
  double drop_outs_per_h = 3.0;
  double drop_out_s = 20.0;  // mean duration
  double jumps_per_h = 3.0;  // of multipath, under an open sky
  double jump_m = 6.0;       // level, each axis, one standard deviation
  double jump_s = 30.0;      // mean duration
  double least_sky = 0.2;    // share of the sky that must be open for a fix
  double report = 1.0;       // what it says of its errors to what they are
  [[nodiscard]] bool operator==(const GnssSensorOptions&) const = default;
};
[[nodiscard]] OptionSet describe(GnssSensorOptions& options);

class GnssSensor {
 public:
  // `p_body_antenna_m`: where the antenna is on the body.
  GnssSensor(const GnssSensorOptions& options, const Eigen::Vector3d& p_body_antenna_m,
             std::uint64_t seed);

  // To be asked in order of time. `sky`: the share of the sky that is open above the antenna, 0 to
  // 1; white noise and how often multipath comes go with its inverse. The fix is where the antenna
  // seems to be, in the axes of the world; nothing if there is none. The stamp is left to the
  // channel.
  [[nodiscard]] std::optional<GnssFix> measure(std::int64_t time_ns, const Isometry3d& T_world_body,
                                               double sky = 1.0);

 private:
  [[nodiscard]] Eigen::Vector3d spread(Random& random) const;

  GnssSensorOptions options_;
  Eigen::Vector3d p_body_antenna_m_;
  Random white_random_;
  Random drift_random_;
  Random jump_random_;
  Spells drop_outs_;
  Spells jumps_;
  Eigen::Vector3d drift_m_;
  Eigen::Vector3d jump_m_ = Eigen::Vector3d::Zero();
  std::int64_t jump_ = 0;  // its number
  std::optional<std::int64_t> last_ns_;
};

}  // namespace tread
