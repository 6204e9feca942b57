// A simulated pan-tilt unit that carries a stereo head: paper Q's FLIR PTU-D46-17. Commands are
// taken at ticks of 60 Hz, and have effect a dead time later. Towards its target each axis then
// moves as fast as its speed and acceleration allow and comes to rest there (the time-optimal path
// of a double integrator). A position between ticks is by formula from the tick before, so that it
// does not matter when it is asked for.
//
// Pan turns left, tilt lowers the nose. The paper counts tilt the other way, upwards, and says -47
// to +31 degrees: the nose goes down by 47 and up by 31.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <numbers>

#include "tread/core/options.hpp"
#include "tread/geometry/samples.hpp"
#include "tread/robot/robot.hpp"

namespace tread {

struct PanTiltOptions {
  double pan_limit_rad = 159.0 * std::numbers::pi / 180.0;     // to the left and right
  double nose_up_limit_rad = 31.0 * std::numbers::pi / 180.0;  // tilt is above minus this
  double nose_down_limit_rad = 47.0 * std::numbers::pi / 180.0;
  double speed_rad_per_s = 145.0 * std::numbers::pi / 180.0;  // at most
  double acceleration_rad_per_s2 = 60.0;                      // at most
  double rate_hz = 60.0;                                      // of the control
  double dead_time_s = 0.030;                                 // from a tick to its effect
  double step_rad = 0.0514 * std::numbers::pi / 180.0;        // of the angles it tells; 0: none
  [[nodiscard]] bool operator==(const PanTiltOptions&) const = default;
};
[[nodiscard]] OptionSet describe(PanTiltOptions& options);

class PanTilt {
 public:
  // At rest at these angles, or at the limit if they are beyond.
  explicit PanTilt(const PanTiltOptions& options, const HeadCommand& start = {});

  // Where to look, from the time on that it has advanced to; angles beyond the limits are taken as
  // the limit. Angles that are not finite leave the axis as it was told before.
  void command(const HeadCommand& command);
  // Lets time go by, in order of time.
  void advance(std::int64_t time_ns);

  // At the time that it has advanced to: where it is, and how fast it turns.
  [[nodiscard]] double pan_rad() const { return position(0); }
  [[nodiscard]] double tilt_rad() const { return position(1); }
  [[nodiscard]] double pan_rate_rad_per_s() const;
  [[nodiscard]] double tilt_rate_rad_per_s() const;
  // What the unit tells of that, in its steps. The stamp is left to the channel.
  [[nodiscard]] HeadState measure() const;

 private:
  using Angles = std::array<double, 2>;  // pan, tilt
  struct Motion {
    double position = 0.0, rate = 0.0;
  };
  struct Waiting {
    std::int64_t effect_ns = 0;
    Angles target{};
  };
  [[nodiscard]] Motion motion_at(std::size_t axis, std::int64_t time_ns) const;
  [[nodiscard]] double position(std::size_t axis) const {
    return motion_at(axis, now_ns_).position;
  }
  void aim(const Waiting& waiting);

  PanTiltOptions options_;
  std::array<std::array<double, 2>, 2> limits_{};  // of each axis, low and high
  Angles told_{};                                  // by the last command
  Angles last_taken_{};                            // at a tick
  std::deque<Waiting> waiting_;                    // taken, without effect yet
  std::int64_t next_tick_ = 0;
  std::int64_t now_ns_ = 0;
  // The path in effect: from where, since when, to where.
  std::array<Motion, 2> start_{};
  std::int64_t start_ns_ = 0;
  Angles target_{};
};

}  // namespace tread
