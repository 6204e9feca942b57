// Pairs without poses, and with them: visual odometry says where each was taken, so that what maps
// posed frames maps these too.
#pragma once

#include <memory>

#include "tread/core/timer.hpp"
#include "tread/io/source.hpp"
#include "tread/slam/visual_odometry.hpp"

namespace tread {

// The frames of `pairs` in which T_world_left is what visual odometry finds, with the IMU if there
// is one; poses that the frames bring are not looked at. The world is level (by the IMU at rest,
// else as the rig's mount says), with its origin on the ground below the first camera's body. A
// frame whose pose is only guessed has none. Fails if the rig cannot be rectified.
[[nodiscard]] Result<std::unique_ptr<StereoSource>> with_odometry(
    std::unique_ptr<StereoSource> pairs, const OdometryOptions& options = {},
    const Context& context = {});

// Whether with_odometry() made it.
[[nodiscard]] bool is_placed_by_odometry(const StereoSource& source);

}  // namespace tread
