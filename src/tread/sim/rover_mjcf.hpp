// The wheeled robot as MuJoCo reads it. Every wheel is a geom and a joint of one name.
#pragma once

#include <string>
#include <vector>

#include "tread/robot/rover_model.hpp"
#include "tread/sim/world_mjcf.hpp"

namespace tread {

struct RoverWheel {
  std::string name;
  bool left = false;
  bool driven = false;
  Eigen::Vector3d hub_m = Eigen::Vector3d::Zero();  // body axes; of a caster above its swivel axis
  double radius_m = 0.0;
};
// Front wheels, then those behind; of each the left one first.
[[nodiscard]] std::vector<RoverWheel> rover_wheels(const RoverModelOptions& options);

inline constexpr const char* kBumperPart = "bumper";
[[nodiscard]] RobotMjcf rover_mjcf(const RoverModelOptions& options);

}  // namespace tread
