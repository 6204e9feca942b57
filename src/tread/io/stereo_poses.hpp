// Internal to io: where the left camera was at each frame of a folder, as far as a file there
// knows.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tread/core/result.hpp"
#include "tread/geometry/stereo_rig.hpp"
#include "tread/io/stereo_folder.hpp"

namespace tread::internal {

struct FramePoseRequest {
  const std::filesystem::path& path;  // the folder
  const std::string& file;            // of the poses; empty: what the folder brings
  const StereoFolder& folder;
  const StereoRig& rig;
  const Isometry3d& T_0_left;  // where the left camera sits in the one that KITTI's poses are of
};

// T_world_left, one a frame; none at all if there are no poses.
using FramePoses = std::vector<std::optional<Isometry3d>>;

// The rules are those of open_stereo_source(). Lines that cannot be read, and what keeps the truth
// of EuRoC from being used, are added to the problems.
[[nodiscard]] Result<FramePoses> read_frame_poses(const FramePoseRequest& of,
                                                  std::vector<Error>& problems);

}  // namespace tread::internal
