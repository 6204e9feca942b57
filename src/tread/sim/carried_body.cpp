#include "tread/sim/carried_body.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tread/sim/true_maps.hpp"

namespace tread {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kKnot_s = 0.04;  // of the splines
constexpr double kStep_m = 0.02;  // of the way, on which it is laid out

// Places every kStep_m along straight lines between the places of a route.
std::vector<Vector2d> lay_out(const World& world) {
  const std::vector<Vector2d> route = way_of(world);
  std::vector<Vector2d> way{route.front()};
  for (std::size_t i = 1; i < route.size(); ++i) {
    const Vector2d from = way.back(), to = route[i];
    const double length = (to - from).norm();
    for (double s = kStep_m; s <= length; s += kStep_m)
      way.push_back(from + s / length * (to - from));
  }
  return way;
}

// Means over a window of the way, twice, the ends staying where they are.
template <class T>
std::vector<T> smoothed(std::vector<T> values, double window_m) {
  const auto half = static_cast<std::ptrdiff_t>(0.5 * window_m / kStep_m);
  const auto count = static_cast<std::ptrdiff_t>(values.size());
  for (int pass = 0; pass < 2; ++pass) {
    std::vector<T> means = values;
    for (std::ptrdiff_t i = 0; i < count; ++i) {
      const std::ptrdiff_t reach = std::min({half, i, count - 1 - i});
      T sum = values[static_cast<std::size_t>(i)];
      for (std::ptrdiff_t d = 1; d <= reach; ++d) {
        sum += values[static_cast<std::size_t>(i - d)] + values[static_cast<std::size_t>(i + d)];
      }
      means[static_cast<std::size_t>(i)] = sum / static_cast<double>(2 * reach + 1);
    }
    values = std::move(means);
  }
  return values;
}

// Height and slopes along x and y of the plane that fits the ground around a place best.
Vector3d plane_under(const Grid<float>& height, const Vector2d& place, double radius) {
  const GridGeometry& g = height.geometry;
  const Cell middle = g.cell_at(place);
  const int reach = static_cast<int>(std::ceil(radius / g.resolution_m));
  Eigen::Matrix3d A = 1e-9 * Eigen::Matrix3d::Identity();
  Vector3d b = Vector3d::Zero();
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; ++dx) {
      const Cell c{middle.x + dx, middle.y + dy};
      if (!g.contains(c) || !std::isfinite(height[c])) continue;
      const Vector2d d = g.centre(c) - place;
      if (d.norm() > radius) continue;
      const Vector3d row(1.0, d.x(), d.y());
      A += row * row.transpose();
      b += static_cast<double>(height[c]) * row;
    }
  }
  return A.ldlt().solve(b);
}

// The way gone after a time: speeds up, goes on, and slows down to rest at `length`.
struct Pace {
  double length, speed, acceleration, rest;
  Pace(double way, const CarryOptions& options)
      : length(way),
        speed(std::min(options.speed_m_per_s, std::sqrt(way * options.acceleration_m_per_s2))),
        acceleration(options.acceleration_m_per_s2),
        rest(options.rest_s) {}
  [[nodiscard]] double ramp_s() const { return speed / acceleration; }
  [[nodiscard]] double duration_s() const { return rest + length / speed + ramp_s(); }
  [[nodiscard]] double at(double time_s) const {
    const double t = std::clamp(time_s - rest, 0.0, duration_s() - rest), ramp = ramp_s(),
                 end = duration_s() - rest;
    if (t < ramp) return 0.5 * acceleration * t * t;
    if (t > end - ramp) return length - 0.5 * acceleration * (end - t) * (end - t);
    return speed * (t - 0.5 * ramp);
  }
};

double between(const std::vector<double>& values, double way_m) {
  const double at = std::clamp(way_m / kStep_m, 0.0, static_cast<double>(values.size() - 1));
  const auto i = std::min(static_cast<std::size_t>(at), values.size() - 2);
  const double share = at - static_cast<double>(i);
  return (1.0 - share) * values[i] + share * values[i + 1];
}

}  // namespace

OptionSet describe(CarryOptions& options) {
  OptionSet set;
  set.add("speed_m_per_s", options.speed_m_per_s, "speed along the route", 0.01, 20.0);
  set.add("acceleration_m_per_s2", options.acceleration_m_per_s2, "at the start and the end", 0.01,
          20.0);
  set.add("rest_s", options.rest_s, "stands still before it starts", 0.0, 1000.0);
  set.add("corner_m", options.corner_m, "how far before a corner of the route it starts to turn",
          0.04, 100.0);
  set.add("footprint_m", options.footprint_m, "radius of the ground that height and tilt follow",
          0.05, 10.0);
  set.add("smooth_m", options.smooth_m, "way over which height and tilt follow the ground", 0.04,
          100.0);
  set.add("gait_hz", options.gait_hz, "trot cycles a second, of two steps each; 0: wheels", 0.0,
          5.0);
  set.add("heave_m", options.heave_m, "up and down of the gait", 0.0, 0.2);
  set.add("tilt_rad", options.tilt_rad, "roll and pitch of the gait", 0.0, 0.3);
  return set;
}

Result<CarriedBody> CarriedBody::make(const World& world, const CarryOptions& options) {
  if (Status s = check_options(options); !s) return forward(s);
  std::vector<Vector2d> way = smoothed(lay_out(world), options.corner_m);
  if (way.size() < 4) {
    return fail(ErrorCode::kBadValue, "the route has no length", world.name,
                "Give the course a route_m or a goal_m away from its start");
  }
  const Grid<float> height = true_height(world, map_geometry(world, 0.05));
  std::vector<Vector3d> planes;
  std::vector<double> yaw, up, pitch, roll, length{0.0};
  for (const Vector2d& p : way) planes.push_back(plane_under(height, p, options.footprint_m));
  planes = smoothed(std::move(planes), options.smooth_m);
  for (std::size_t i = 0; i < way.size(); ++i) {
    const Vector2d ahead = way[std::min(i + 1, way.size() - 1)] - way[i > 0 ? i - 1 : 0];
    double angle = std::atan2(ahead.y(), ahead.x());
    if (!yaw.empty())
      angle = yaw.back() + std::remainder(angle - yaw.back(), 2.0 * std::numbers::pi);
    yaw.push_back(angle);
    if (i > 0) length.push_back(length.back() + (way[i] - way[i - 1]).norm());
  }
  yaw = smoothed(std::move(yaw), options.corner_m);
  for (std::size_t i = 0; i < way.size(); ++i) {
    const double c = std::cos(yaw[i]), s = std::sin(yaw[i]);
    const double forward_slope = c * planes[i].y() + s * planes[i].z(),
                 left_slope = -s * planes[i].y() + c * planes[i].z();
    up.push_back(planes[i].x());
    pitch.push_back(-std::atan(forward_slope));
    roll.push_back(std::atan(left_slope * std::cos(pitch.back())));
  }
  std::vector<double> x, y;
  for (const Vector2d& p : way) {
    x.push_back(p.x());
    y.push_back(p.y());
  }
  // Corners are cut, so that steps of the way are a little shorter than laid out.
  const auto index_of = [&](double gone) {
    const auto next = std::upper_bound(length.begin(), length.end(), gone);
    const auto i =
        std::min(static_cast<std::size_t>(std::max<std::ptrdiff_t>(next - length.begin() - 1, 0)),
                 length.size() - 2);
    const double step = length[i + 1] - length[i];
    return kStep_m * (static_cast<double>(i) + (step > 0.0 ? (gone - length[i]) / step : 0.0));
  };
  CarriedBody body;
  const Pace pace(length.back(), options);
  body.duration_s_ = pace.duration_s();
  const auto knots = static_cast<int>(std::ceil(body.duration_s_ / kKnot_s)) + 4;
  for (int k = 0; k < knots; ++k) {
    const double t = (k - 1) * kKnot_s;
    const double at = index_of(pace.at(t));
    Point point;
    point << between(x, at), between(y, at), between(up, at), between(yaw, at), between(pitch, at),
        between(roll, at);
    if (options.gait_hz > 0.0) {
      // Only while it walks, growing and fading with its speed.
      const double moving = (pace.at(t + 0.3) - pace.at(t - 0.3)) / (0.6 * pace.speed);
      const double phase = 2.0 * std::numbers::pi * options.gait_hz * t;
      point(2) += moving * options.heave_m * std::sin(2.0 * phase);
      point(4) += moving * options.tilt_rad * std::sin(2.0 * phase + 0.7);
      point(5) += moving * options.tilt_rad * std::sin(phase);
    }
    body.points_.push_back(point);
  }
  return body;
}

Isometry3d CarriedBody::pose(double time_s) const {
  const auto last = static_cast<double>(points_.size() - 4);
  const double at = std::clamp(time_s / kKnot_s, 0.0, last);
  const auto i = std::min(static_cast<std::size_t>(at), points_.size() - 4);
  const double t = at - static_cast<double>(i), s = 1.0 - t;
  const Point p =
      (s * s * s * points_[i] + (3.0 * t * t * t - 6.0 * t * t + 4.0) * points_[i + 1] +
       (3.0 * s * s * s - 6.0 * s * s + 4.0) * points_[i + 2] + t * t * t * points_[i + 3]) /
      6.0;
  Isometry3d T = Isometry3d::Identity();
  T.linear() = rotation_from_yaw_pitch_roll(p(3), p(4), p(5));
  T.translation() = p.head<3>();
  return T;
}

BodyMotion CarriedBody::motion(double time_s) const {
  // Central differences of splines, which are cubic: exact but for rounding and at knots.
  constexpr double kStep_s = 1e-4;
  const Isometry3d before = pose(time_s - kStep_s), now = pose(time_s),
                   after = pose(time_s + kStep_s);
  BodyMotion motion;
  motion.T_world_body = now;
  motion.velocity_m_per_s = (after.translation() - before.translation()) / (2.0 * kStep_s);
  motion.acceleration_m_per_s2 =
      (after.translation() - 2.0 * now.translation() + before.translation()) / (kStep_s * kStep_s);
  const Vector3d forward = so3_log(now.linear().transpose() * after.linear()),
                 backward = so3_log(now.linear().transpose() * before.linear());
  motion.rate_rad_per_s = (forward - backward) / (2.0 * kStep_s);
  motion.rate_change_rad_per_s2 = (forward + backward) / (kStep_s * kStep_s);
  return motion;
}

}  // namespace tread
