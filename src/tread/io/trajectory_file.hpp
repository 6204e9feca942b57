// Trajectories: TUM format ("time tx ty tz qx qy qz qw", seconds, one pose a line, # comments),
// KITTI poses (3x4 row-major matrices, one a line, no time), and the truth of EuRoC.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tread/core/result.hpp"
#include "tread/geometry/trajectory.hpp"

namespace tread {

// Times must increase strictly; a line that cannot be read is named by its number: it is the error
// of the whole, or, with `bad_lines`, is added there and left out. Nanoseconds are read exactly,
// quaternions normalised.
[[nodiscard]] Result<Trajectory> read_tum_trajectory(const std::filesystem::path& path,
                                                     std::vector<Error>* bad_lines = nullptr);
// Nanoseconds are written exactly.
[[nodiscard]] Status write_tum_trajectory(const std::filesystem::path& path,
                                          const Trajectory& trajectory);
// Rotations that are off by rounding are made orthonormal; others are refused. With `bad_lines` a
// line that cannot be read is added there and has no pose.
[[nodiscard]] Result<std::vector<std::optional<Isometry3d>>> read_kitti_poses(
    const std::filesystem::path& path, std::vector<Error>* bad_lines = nullptr);

// The truth of EuRoC/ASL (state_groundtruth_estimate0/data.csv): "time in ns,px,py,pz,qw,qx,qy,qz"
// and whatever follows a line, which is the body's pose in the world. Lines that are left out are
// told as read_imu does it.
[[nodiscard]] Result<Trajectory> read_euroc_poses(const std::filesystem::path& path,
                                                  std::vector<Error>* problems = nullptr);

// One pose a file, as 7-Scenes has it: a 4x4 matrix of 16 numbers, row by row, between blanks and
// line ends. A rotation that is off by rounding is made orthonormal; one that is none, and numbers
// that are not finite (how those data sets write that a frame has no pose), are errors.
[[nodiscard]] Result<Isometry3d> read_pose_matrix(const std::filesystem::path& path);

// One time in seconds a line, strictly increasing, as KITTI's times.txt; exact nanoseconds.
[[nodiscard]] Result<std::vector<std::int64_t>> read_times(const std::filesystem::path& path);

// Parts of a line, for readers of lists that hold times and poses; `place` names it in messages.
// Seconds as exact nanoseconds.
[[nodiscard]] Result<std::int64_t> parse_stamp(std::string_view text, const std::string& place);
// Seven fields, tx ty tz qx qy qz qw; the quaternion is normalised.
[[nodiscard]] Result<Isometry3d> parse_tum_pose(std::span<const std::string_view> fields,
                                                const std::string& place);

}  // namespace tread
