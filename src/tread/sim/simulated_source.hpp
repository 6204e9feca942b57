// A simulated drive as a source of frames, where a program expects a data set: no files between.
#pragma once

#include <memory>

#include "tread/io/source.hpp"
#include "tread/sim/simulated_robot.hpp"

namespace tread {

// The frames of the first head of a robot that is carried along the course's route, with true poses
// and the samples of its IMU. `options.carried` and `frames_know_pose` are taken as true.
[[nodiscard]] Result<std::unique_ptr<StereoSource>> open_simulated_source(
    const Course& course, const RobotSetup& setup, const SimulationOptions& options,
    const Context& context = {});

}  // namespace tread
