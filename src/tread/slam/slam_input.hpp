// Internal to slam: whether DepthSlam can work with what it is given.
#pragma once

#include "tread/slam/depth_slam.hpp"

namespace tread {

[[nodiscard]] Status check_start(const PinholeCamera& camera, const SlamOptions& options,
                                 const Isometry3d& T_world_first);

// What is known of the frames before.
struct SlamInput {
  bool started = false;
  int width = 0, height = 0;
  std::int64_t stamp_ns = 0;
};
[[nodiscard]] Status check_frame(const SlamFrame& in, const SlamInput& before);

}  // namespace tread
