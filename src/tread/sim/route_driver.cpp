#include "tread/sim/route_driver.hpp"

#include <algorithm>
#include <cmath>

namespace tread {

OptionSet describe(RouteDriverOptions& options) {
  OptionSet set;
  set.add("speed_m_per_s", options.speed_m_per_s, "speed along the route", 0.01, 10.0);
  set.add("look_ahead_m", options.look_ahead_m, "how far ahead the point is that it steers for",
          0.05, 20.0);
  set.add("largest_yaw_rate_rad_per_s", options.largest_yaw_rate_rad_per_s, "turns no faster", 0.01,
          10.0);
  set.add("arrived_m", options.arrived_m, "so near to the end it stops", 0.01, 10.0);
  set.add("rest_s", options.rest_s, "stands still before it starts", 0.0, 1000.0);
  set.add("stuck_s", options.stuck_s, "gives up if it came no further for so long", 0.1, 1e6);
  return set;
}

RouteDriver::RouteDriver(const World& world, const RouteDriverOptions& options)
    : options_(options), route_(way_of(world)), way_m_{0.0} {
  for (std::size_t i = 1; i < route_.size(); ++i) {
    length_m_ += (route_[i] - route_[i - 1]).norm();
    way_m_.push_back(length_m_);
  }
}

Eigen::Vector2d RouteDriver::at(double way_m) const {
  const auto next = std::upper_bound(way_m_.begin(), way_m_.end(), way_m);
  if (next == way_m_.end()) return route_.back();
  const auto i = static_cast<std::size_t>(next - way_m_.begin());
  const double share = (way_m - way_m_[i - 1]) / (way_m_[i] - way_m_[i - 1]);
  return route_[i - 1] + share * (route_[i] - route_[i - 1]);
}

// The nearest point of the route, among those just ahead: a route may cross itself or turn back.
void RouteDriver::move_on(const Eigen::Vector2d& place) {
  constexpr double kStep_m = 0.02, kAhead_m = 0.3;
  double best = (at(gone_m_) - place).norm();
  const double last = std::min(length_m_, gone_m_ + kAhead_m);
  for (double way = gone_m_ + kStep_m; way <= last; way += kStep_m) {
    const double distance = (at(way) - place).norm();
    if (distance < best) {
      best = distance;
      gone_m_ = way;
    }
  }
}

// How far along the way it steers for: not beyond a place where the route turns back, until it is
// there.
double RouteDriver::target_m() const {
  constexpr double kThere_m = 0.15;
  const double target = gone_m_ + options_.look_ahead_m;
  for (std::size_t i = 1; i + 1 < route_.size() && way_m_[i] < target; ++i) {
    const Eigen::Vector2d in = route_[i] - route_[i - 1], out = route_[i + 1] - route_[i];
    if (in.dot(out) < 0.0 && way_m_[i] > gone_m_ + kThere_m) return way_m_[i];
  }
  return target;
}

DriveCommand RouteDriver::drive(double time_s, const Isometry3d& T_world_body) {
  constexpr double kFurther_m = 0.25;
  const Eigen::Vector2d place = T_world_body.translation().head<2>();
  move_on(place);
  // A route may end where it starts: only what is near the end by the way counts.
  const bool near = (route_.back() - place).norm() < options_.arrived_m;
  const double left_m = length_m_ - gone_m_;
  arrived_ =
      arrived_ || left_m < 0.5 * options_.arrived_m || (near && left_m < options_.look_ahead_m);
  if (time_s < options_.rest_s || arrived_ || stuck_) {
    progress_s_ = time_s;
    return {};
  }
  if (gone_m_ > progress_m_ + kFurther_m) {
    progress_m_ = gone_m_;
    progress_s_ = time_s;
  }
  stuck_ = time_s - progress_s_ > options_.stuck_s;
  const Eigen::Vector2d target = at(target_m());
  const Eigen::Vector3d forward = T_world_body.linear().col(0);
  const Eigen::Vector2d ahead = forward.head<2>().normalized(), to = target - place;
  const double x = ahead.dot(to), y = ahead.x() * to.y() - ahead.y() * to.x();
  DriveCommand command;
  // The arc through the target has the curvature 2 y / d^2. One that lies behind or far to a side
  // is turned to on the spot first.
  const double distance2 = std::max(to.squaredNorm(), 1e-6);
  if (x < std::abs(y)) {
    command.yaw_rate_rad_per_s = std::copysign(options_.largest_yaw_rate_rad_per_s, y);
    return command;
  }
  const double left = std::min(1.0, (route_.back() - place).norm() / options_.look_ahead_m);
  command.speed_m_per_s = options_.speed_m_per_s * std::max(left, 0.3);
  const double curvature = 2.0 * y / distance2;
  const double rate = command.speed_m_per_s * curvature;
  command.yaw_rate_rad_per_s =
      std::clamp(rate, -options_.largest_yaw_rate_rad_per_s, options_.largest_yaw_rate_rad_per_s);
  return command;
}

}  // namespace tread
