// A robot that is carried along a route, as a hand or another controller would move it: for data
// sets of cameras and inertial sensors without a controller. Smooth in time up to the acceleration,
// so that what the sensors feel fits the way.
#pragma once

#include <vector>

#include "tread/core/options.hpp"
#include "tread/core/result.hpp"
#include "tread/sim/body_motion.hpp"
#include "tread/sim/world.hpp"

namespace tread {

struct CarryOptions {
  double speed_m_per_s = 0.5;
  double acceleration_m_per_s2 = 0.5;  // at the start and at the end
  double rest_s = 1.0;                 // stands still before it starts
  double corner_m = 0.6;               // how far before a corner of the route it starts to turn
  double footprint_m = 0.35;           // radius of the ground that its height and tilt follow
  double smooth_m = 0.3;               // of the way, over which height and tilt follow the ground
  // A trot, two legs at a time: the trunk heaves and nods with every step, and rolls with every
  // other one.
  double gait_hz = 0.0;  // 0: wheels
  double heave_m = 0.01;
  double tilt_rad = 0.03;
  [[nodiscard]] bool operator==(const CarryOptions&) const = default;
};
[[nodiscard]] OptionSet describe(CarryOptions& options);

class CarriedBody {
 public:
  // Along the world's route from its start; the body's origin is on the ground. An error if the
  // route has no length.
  [[nodiscard]] static Result<CarriedBody> make(const World& world, const CarryOptions& options);

  // When it has come to rest at the end.
  [[nodiscard]] double duration_s() const { return duration_s_; }
  // At rest before the start and after the end.
  [[nodiscard]] BodyMotion motion(double time_s) const;

 private:
  CarriedBody() = default;
  [[nodiscard]] Isometry3d pose(double time_s) const;

  // Control points of uniform cubic splines over time: x, y, z, yaw, pitch, roll.
  using Point = Eigen::Matrix<double, 6, 1>;
  std::vector<Point> points_;
  double duration_s_ = 0.0;
};

}  // namespace tread
