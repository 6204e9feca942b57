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
    : options_(options), route_{world.start.position_m}, way_m_{0.0} {
  std::vector<Eigen::Vector2d> places = world.route_m;
  if (places.empty()) places.push_back(world.goal_m);
  for (const Eigen::Vector2d& place : places) {
    const double step = (place - route_.back()).norm();
    if (step <= 0.0) continue;
    length_m_ += step;
    route_.push_back(place);
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

// The nearest point of the route, among those not far ahead: a route may cross itself.
void RouteDriver::move_on(const Eigen::Vector2d& place) {
  constexpr double kStep_m = 0.02;
  double best = (at(gone_m_) - place).norm();
  const double last = std::min(length_m_, gone_m_ + 2.0 * options_.look_ahead_m);
  for (double way = gone_m_ + kStep_m; way <= last; way += kStep_m) {
    const double distance = (at(way) - place).norm();
    if (distance < best) {
      best = distance;
      gone_m_ = way;
    }
  }
}

DriveCommand RouteDriver::drive(double time_s, const Isometry3d& T_world_body) {
  constexpr double kFurther_m = 0.25;
  const Eigen::Vector2d place = T_world_body.translation().head<2>();
  move_on(place);
  arrived_ = arrived_ || (route_.back() - place).norm() < options_.arrived_m ||
             gone_m_ > length_m_ - 0.5 * options_.arrived_m;
  if (time_s < options_.rest_s || arrived_ || stuck_) {
    progress_s_ = time_s;
    return {};
  }
  if (gone_m_ > progress_m_ + kFurther_m) {
    progress_m_ = gone_m_;
    progress_s_ = time_s;
  }
  stuck_ = time_s - progress_s_ > options_.stuck_s;
  const Eigen::Vector2d target = at(gone_m_ + options_.look_ahead_m);
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
