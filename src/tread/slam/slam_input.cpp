#include "tread/slam/slam_input.hpp"

#include <fmt/format.h>

namespace tread {

Status check_start(const PinholeCamera& camera, const SlamOptions& options,
                   const Isometry3d& T_world_first) {
  if (Status good = check_camera(camera, "camera"); !good) return good;
  if (Status good = check_options(options); !good) return good;
  if (is_rigid(T_world_first)) return {};
  return fail(ErrorCode::kBadValue, "the pose of the first frame is not a rigid motion",
              "T_world_first", "Give an orthonormal right-handed rotation and finite metres");
}

Status check_frame(const SlamFrame& in, const SlamInput& before) {
  if (in.depth.empty()) {
    return fail(ErrorCode::kBadArgument, "the depth image is empty", "depth",
                "Give one with pixels");
  }
  if (in.motion) {
    if (Status sound = check_motion(*in.motion); !sound) return sound;
  }
  const auto differs = [&](const auto& image) {
    return !image.empty() && !same_size(image, in.depth);
  };
  if (differs(in.grey) || differs(in.rgb)) {
    return fail(ErrorCode::kBadArgument,
                fmt::format("the image is not of the size of the depth image, {} x {}",
                            in.depth.width, in.depth.height),
                "grey", "Register the images to the depth, or leave them out");
  }
  if (!before.started) return {};
  if (in.depth.width != before.width || in.depth.height != before.height) {
    return fail(ErrorCode::kBadArgument,
                fmt::format("the depth image is {} x {}, those before were {} x {}", in.depth.width,
                            in.depth.height, before.width, before.height),
                "depth", "One camera has one size: start anew for another one");
  }
  if (in.stamp_ns <= before.stamp_ns) {
    return fail(ErrorCode::kBadValue,
                fmt::format("the time {} ns is not after the last one, {} ns", in.stamp_ns,
                            before.stamp_ns),
                "stamp_ns", "Give frames in order of time, each once");
  }
  return {};
}

}  // namespace tread
