// Trajectories: TUM format ("time tx ty tz qx qy qz qw", seconds, one pose a line, # comments) and
// KITTI poses (3x4 row-major matrices, one a line, no time).
#pragma once

#include <filesystem>
#include <vector>

#include "tread/core/result.hpp"
#include "tread/geometry/trajectory.hpp"

namespace tread {

// Times must increase strictly; a line that cannot be read is named by its number.
[[nodiscard]] Result<Trajectory> read_tum_trajectory(const std::filesystem::path& path);
// Nanoseconds are written exactly.
[[nodiscard]] Status write_tum_trajectory(const std::filesystem::path& path,
                                          const Trajectory& trajectory);
[[nodiscard]] Result<std::vector<Isometry3d>> read_kitti_poses(const std::filesystem::path& path);

}  // namespace tread
