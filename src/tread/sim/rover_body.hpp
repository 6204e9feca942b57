// The wheeled robot in a world. Its wheels hold and slip as tyre.hpp says by the surface under each
// of them, and the ground resists their rolling by a torque; so encoders overestimate the way where
// the ground is loose or rises, wheels spin where it gives no more, and a robot that stands on a
// slope stays there until friction gives way.
#pragma once

#include <memory>
#include <vector>

#include "tread/robot/robot.hpp"
#include "tread/robot/rover_model.hpp"
#include "tread/sim/body.hpp"
#include "tread/sim/rover_mjcf.hpp"
#include "tread/sim/tyre.hpp"

namespace tread {

class RoverBody final : public Body {
 public:
  // Stands there on whatever is under its wheels. The world must outlive it. An error says what is
  // in the way, or that it does not stay there.
  [[nodiscard]] static Result<std::unique_ptr<RoverBody>> place(const World& world,
                                                                const RoverModelOptions& options,
                                                                const RobotPlace& place,
                                                                const PhysicsOptions& physics = {});

  // From the next step on; what lies beyond the top speeds is cut. An error if a value is not
  // finite.
  [[nodiscard]] Status command(const DriveCommand& command);
  [[nodiscard]] const DriveCommand& command() const { return command_; }
  // Of the driven wheels as ideal encoders and current sensors would give them: not in steps, and
  // where a side has two wheels, the mean of their angles and the sum of their currents.
  [[nodiscard]] WheelSample wheels() const;
  // Part of the way of the treads of a side that is lost to slip; 0 while they hardly turn.
  [[nodiscard]] double slip(bool left) const;
  [[nodiscard]] double bumper_force_n() const;
  [[nodiscard]] bool bumper_pressed() const;
  [[nodiscard]] const RoverModelOptions& options() const { return options_; }

 private:
  // Where a wheel touches one thing; bristles stay while it does.
  struct Hold {
    int other = 0;
    Footing footing;
    Eigen::Vector3d place_m = Eigen::Vector3d::Zero();
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    double load_n = 0.0;
    Eigen::Vector3d bristle_m = Eigen::Vector3d::Zero();
  };
  struct Wheel {
    RoverWheel what;
    int part = 0, body = 0, position = 0, speed = 0;  // in MuJoCo's model and state
    TyreOptions tyre;
    std::vector<Hold> holds;
    double wound_rad = 0.0;  // by rolling resistance, which holds a wheel at rest, too
    double start_rad = 0.0;  // where its encoder began to count
    double told_rad = 0.0;   // where it should be by now
    double told_rad_per_s = 0.0;
    double torque_nm = 0.0;  // of its motor
    double slip = 0.0;
  };

  RoverBody(PhysicsModel physics, const RoverModelOptions& options);
  void drive() override;
  void find_holds();
  void turn(Wheel& wheel, double told_rad_per_s);
  void resist(Wheel& wheel);
  void hold(Wheel& wheel);

  RoverModelOptions options_;
  DriveCommand command_;
  std::vector<Wheel> wheels_;
};

}  // namespace tread
