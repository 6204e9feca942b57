#include "tread/sim/pan_tilt.hpp"

#include <algorithm>
#include <cmath>

#include "tread/sim/quantise.hpp"

namespace tread {
namespace {

// The time-optimal path from a position and rate to rest at a target, with bounded speed and
// acceleration: faster with +a, evenly, slower with -a, all times `sign`.
struct Path {
  double sign = 1.0;
  double start_rate = 0.0, top_rate = 0.0;  // along `sign`
  double speeding_s = 0.0, even_s = 0.0, slowing_s = 0.0;
};

Path fastest_path(double way, double rate, double speed, double acceleration) {
  // Where it would come to rest if it slowed down now, and whether the target is behind that.
  const double stop = 0.5 * rate * std::abs(rate) / acceleration;
  Path path;
  path.sign = way >= stop ? 1.0 : -1.0;
  way *= path.sign;
  path.start_rate = rate * path.sign;
  const double top2 = acceleration * way + 0.5 * path.start_rate * path.start_rate;
  path.top_rate = std::min(std::sqrt(std::max(top2, 0.0)), speed);
  path.speeding_s = std::max(0.0, (path.top_rate - path.start_rate) / acceleration);
  path.slowing_s = path.top_rate / acceleration;
  const double speeding_way = 0.5 * (path.start_rate + path.top_rate) * path.speeding_s;
  const double rest = way - speeding_way - 0.5 * path.top_rate * path.slowing_s;
  path.even_s = path.top_rate > 0.0 ? std::max(0.0, rest / path.top_rate) : 0.0;
  return path;
}

}  // namespace

OptionSet describe(PanTiltOptions& options) {
  OptionSet set;
  set.add("pan_limit_rad", options.pan_limit_rad, "to the left and right, rad", 0.0, 100.0);
  set.add("nose_up_limit_rad", options.nose_up_limit_rad, "how far tilt goes up, rad", 0.0, 1.6);
  set.add("nose_down_limit_rad", options.nose_down_limit_rad, "how far tilt goes down, rad", 0.0,
          1.6);
  set.add("speed_rad_per_s", options.speed_rad_per_s, "at most, rad/s", 1e-3, 1e3);
  set.add("acceleration_rad_per_s2", options.acceleration_rad_per_s2, "at most, rad/s^2", 1e-3,
          1e6);
  set.add("rate_hz", options.rate_hz, "of the control, Hz", 0.1, 1e4);
  set.add("dead_time_s", options.dead_time_s, "from a tick of the control to its effect, s", 0.0,
          10.0);
  set.add("step_rad", options.step_rad, "of the angles it tells; 0: not rounded, rad", 0.0, 1.0);
  return set;
}

PanTilt::PanTilt(const PanTiltOptions& options, const HeadCommand& start)
    : options_(options),
      limits_{{{-options.pan_limit_rad, options.pan_limit_rad},
               {-options.nose_up_limit_rad, options.nose_down_limit_rad}}} {
  command(start);
  last_taken_ = target_ = told_;
  for (std::size_t axis = 0; axis < 2; ++axis) start_[axis].position = told_[axis];
}

void PanTilt::command(const HeadCommand& command) {
  const Angles asked = {command.pan_rad, command.tilt_rad};
  for (std::size_t axis = 0; axis < 2; ++axis) {
    if (!std::isfinite(asked[axis])) continue;
    told_[axis] = std::clamp(asked[axis], limits_[axis][0], limits_[axis][1]);
  }
}

void PanTilt::advance(std::int64_t time_ns) {
  const std::int64_t dead_ns = std::llround(1e9 * options_.dead_time_s);
  for (;;) {
    const std::int64_t tick_ns =
        std::llround(1e9 * static_cast<double>(next_tick_) / options_.rate_hz);
    if (tick_ns > time_ns) break;
    ++next_tick_;
    if (told_ == last_taken_) continue;  // a path need not be planned again to be kept to
    last_taken_ = told_;
    waiting_.push_back({tick_ns + dead_ns, told_});
  }
  while (!waiting_.empty() && waiting_.front().effect_ns <= time_ns) {
    aim(waiting_.front());
    waiting_.pop_front();
  }
  now_ns_ = std::max(now_ns_, time_ns);
}

void PanTilt::aim(const Waiting& waiting) {
  const std::array<Motion, 2> now = {motion_at(0, waiting.effect_ns),
                                     motion_at(1, waiting.effect_ns)};
  start_ = now;
  start_ns_ = waiting.effect_ns;
  target_ = waiting.target;
}

PanTilt::Motion PanTilt::motion_at(std::size_t axis, std::int64_t time_ns) const {
  const Motion& start = start_[axis];
  const double a = options_.acceleration_rad_per_s2;
  const Path path =
      fastest_path(target_[axis] - start.position, start.rate, options_.speed_rad_per_s, a);
  double left_s = 1e-9 * static_cast<double>(time_ns - start_ns_);
  double way = 0.0, rate = path.start_rate;
  const auto go = [&](double piece_s, double change) {
    const double t = std::clamp(left_s, 0.0, piece_s);
    way += (rate + 0.5 * change * t) * t;
    rate += change * t;
    left_s -= piece_s;
  };
  go(path.speeding_s, a);
  go(path.even_s, 0.0);
  go(path.slowing_s, -a);
  if (left_s >= 0.0) return {target_[axis], 0.0};  // there, without the rounding on the way
  return {std::clamp(start.position + path.sign * way, limits_[axis][0], limits_[axis][1]),
          path.sign * rate};
}

double PanTilt::pan_rate_rad_per_s() const {
  return motion_at(0, now_ns_).rate;
}

double PanTilt::tilt_rate_rad_per_s() const {
  return motion_at(1, now_ns_).rate;
}

HeadState PanTilt::measure() const {
  return {0, to_step(pan_rad(), options_.step_rad), to_step(tilt_rad(), options_.step_rad)};
}

}  // namespace tread
