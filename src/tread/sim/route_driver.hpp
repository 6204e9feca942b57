// Drives a rover along a course's route by its true pose: for data sets, where the way is a given
// and not what is being tested. Pure pursuit (Coulter 1992): an arc to the point of the route that
// is a fixed distance ahead.
#pragma once

#include <vector>

#include "tread/core/options.hpp"
#include "tread/geometry/pose.hpp"
#include "tread/robot/robot.hpp"
#include "tread/sim/world.hpp"

namespace tread {

struct RouteDriverOptions {
  double speed_m_per_s = 0.5;
  double look_ahead_m = 0.8;
  double largest_yaw_rate_rad_per_s = 0.8;
  double arrived_m = 0.25;  // from the end: it stops
  double rest_s = 1.0;      // stands still before it starts
  double stuck_s = 6.0;     // in which it must come a quarter of a metre further, else it gives up
  [[nodiscard]] bool operator==(const RouteDriverOptions&) const = default;
};
[[nodiscard]] OptionSet describe(RouteDriverOptions& options);

class RouteDriver {
 public:
  RouteDriver(const World& world, const RouteDriverOptions& options);

  // To be asked in order of time, ten times a second or more.
  [[nodiscard]] DriveCommand drive(double time_s, const Isometry3d& T_world_body);
  [[nodiscard]] bool arrived() const { return arrived_; }
  [[nodiscard]] bool stuck() const { return stuck_; }
  [[nodiscard]] bool done() const { return arrived_ || stuck_; }
  // Of the route that is behind it.
  [[nodiscard]] double gone_m() const { return gone_m_; }
  [[nodiscard]] double length_m() const { return length_m_; }

 private:
  [[nodiscard]] Eigen::Vector2d at(double way_m) const;
  void move_on(const Eigen::Vector2d& place);
  [[nodiscard]] double target_m() const;

  RouteDriverOptions options_;
  std::vector<Eigen::Vector2d> route_;
  std::vector<double> way_m_;  // from the start to each place
  double length_m_ = 0.0;
  double gone_m_ = 0.0;
  double progress_m_ = 0.0;  // when it last came further
  double progress_s_ = 0.0;
  bool arrived_ = false, stuck_ = false;
};

}  // namespace tread
