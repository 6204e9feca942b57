// The walking robot in a world: twelve joints driven by torques, balls for feet; links collide with
// the world, but not with each other. The body's axes are those of walker_model.hpp.
#pragma once

#include <array>
#include <memory>

#include "tread/robot/robot.hpp"
#include "tread/robot/walker_model.hpp"
#include "tread/sim/body.hpp"

namespace tread {

class WalkerBody final : public Body {
 public:
  // Stands there, level, a foot below each hip's home on whatever is there, held by stand_command.
  // The world must outlive it. An error says which foot finds no hold within reach, or what is in
  // the way.
  [[nodiscard]] static Result<std::unique_ptr<WalkerBody>> place(
      const World& world, const WalkerModelOptions& options, const RobotPlace& place,
      const StandOptions& stand = {}, const PhysicsOptions& physics = {});

  // From the next step on. Torques are cut to what the joints have. An error if a value is not
  // finite, or a stiffness or damping is negative.
  [[nodiscard]] Status command(const JointCommand& command);
  [[nodiscard]] const JointCommand& command() const { return command_; }
  // True values, as ideal sensors would give them. Torques are those of the step behind.
  [[nodiscard]] LegSample legs() const;
  // Middle of the ball of a foot, world axes.
  [[nodiscard]] Eigen::Vector3d foot_m(int leg) const;
  // Of all that touches the robot, world axes.
  [[nodiscard]] Eigen::Vector3d contact_force_n() const;
  [[nodiscard]] const WalkerModelOptions& options() const { return options_; }

 private:
  WalkerBody(PhysicsModel physics, const WalkerModelOptions& options);
  void drive() override;

  WalkerModelOptions options_;
  JointCommand command_;
  std::array<double, kLegJoints> torque_nm_{};
};

}  // namespace tread
