// What simulated robots have in common: a body that moves freely through a world, in steps.
#pragma once

#include <memory>
#include <string>

#include "tread/geometry/pose.hpp"
#include "tread/geometry/samples.hpp"
#include "tread/sim/physics_model.hpp"

namespace tread {

// The true motion of the body's origin, world axes.
struct BodyMotion {
  double time_s = 0.0;
  Isometry3d T_world_body = Isometry3d::Identity();
  Eigen::Vector3d velocity_m_per_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d turn_rad_per_s = Eigen::Vector3d::Zero();
};

class Body {
 public:
  virtual ~Body() = default;
  Body(const Body&) = delete;
  Body& operator=(const Body&) = delete;

  // Time goes on by step_s(). An error if the motion has no finite answer or the robot has fallen
  // off the edge of the ground: it is lost then.
  [[nodiscard]] Status step();
  [[nodiscard]] double step_s() const { return physics_.step_s(); }
  [[nodiscard]] const BodyMotion& motion() const { return now_; }
  // What an ideal unit fixed to the body feels: its turn now, and the mean specific force of the
  // step behind, so that what it says sums up to how its velocity has changed.
  [[nodiscard]] ImuSample imu_at(const Isometry3d& T_body_imu) const;
  [[nodiscard]] std::vector<Touch> touches() const { return physics_.touches(); }
  [[nodiscard]] const PhysicsModel& physics() const { return physics_; }

  // A force on the centre of mass of the trunk from now on, world axes.
  void push(const Eigen::Vector3d& force_n, double duration_s);

 protected:
  explicit Body(PhysicsModel physics);
  [[nodiscard]] PhysicsModel& engine() { return physics_; }
  // Puts forces on the joints for the step that has begun.
  virtual void drive() = 0;

  // Puts the body at rest to a pose, lifts it out of the ground if need be, and lets it settle,
  // which ends at time 0. An error names what of the robot is inside what by more than a few
  // millimetres, or says that it does not stay where it was put.
  [[nodiscard]] Status stand_at(const Isometry3d& T_world_body, double settle_s,
                                const std::string& robot);

 private:
  [[nodiscard]] Status lift_out(Isometry3d T_world_body, const std::string& where);
  void look();

  PhysicsModel physics_;
  BodyMotion now_, before_;
  Eigen::Vector3d push_n_ = Eigen::Vector3d::Zero();
  double push_left_s_ = 0.0;
  double floor_m_ = 0.0;
};

// How high the middle of a ball is that lies on the world above a place; NaN outside.
[[nodiscard]] double ball_height(const World& world, const Eigen::Vector2d& place, double radius_m);

}  // namespace tread
