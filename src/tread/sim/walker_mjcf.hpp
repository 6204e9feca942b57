// The walking robot as MuJoCo reads it. Joint k of all twelve is the k-th after the free one.
#pragma once

#include "tread/robot/walker_model.hpp"
#include "tread/sim/world_mjcf.hpp"

namespace tread {

[[nodiscard]] RobotMjcf walker_mjcf(const WalkerModelOptions& options);
// "left front foot"
[[nodiscard]] std::string foot_part(int leg);

}  // namespace tread
