// A path of poses over time.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "tread/geometry/pose.hpp"

namespace tread {

// Poses in strictly increasing order of time, T_world_camera unless said otherwise.
using Trajectory = std::vector<StampedPose>;

// The pose at a time: translation linear, rotation along the shortest arc between the neighbours.
// Empty outside the trajectory's span, and inside gaps longer than max_gap_ns.
[[nodiscard]] std::optional<Isometry3d> pose_at(const Trajectory& trajectory, std::int64_t stamp_ns,
                                                std::int64_t max_gap_ns = 1'000'000'000);

}  // namespace tread
