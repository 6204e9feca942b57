// What simulated robots have in common: a body that moves freely through a world, in steps.
#pragma once

#include <memory>
#include <string>

#include "tread/geometry/pose.hpp"
#include "tread/sim/body_motion.hpp"
#include "tread/sim/physics_model.hpp"

namespace tread {

class Body {
 public:
  virtual ~Body() = default;
  Body(const Body&) = delete;
  Body& operator=(const Body&) = delete;

  // Time goes on by step_s(). An error if the motion has no finite answer or the robot has fallen
  // off the edge of the ground: it is lost then.
  [[nodiscard]] Status step();
  [[nodiscard]] double step_s() const { return physics_.step_s(); }
  [[nodiscard]] double time_s() const { return physics_.time_s(); }
  // Pose and velocities now; accelerations are the means of the step behind, so that they sum up to
  // how the velocities have changed.
  [[nodiscard]] const BodyMotion& motion() const { return now_; }
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
  void look(double passed_s);

  PhysicsModel physics_;
  BodyMotion now_;
  Eigen::Vector3d push_n_ = Eigen::Vector3d::Zero();
  double push_left_s_ = 0.0;
  double floor_m_ = 0.0;
};

// How high the middle of a ball is that lies on the world above a place; NaN outside.
[[nodiscard]] double ball_height(const World& world, const Eigen::Vector2d& place, double radius_m);

}  // namespace tread
