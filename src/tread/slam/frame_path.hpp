// The path of a camera, each frame held relative to a keyframe, so that it goes along when that is
// corrected.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "tread/geometry/trajectory.hpp"

namespace tread {

class FramePath {
 public:
  // Of frames; then every second one of the older half is dropped. 80 bytes each.
  static constexpr std::size_t kMost = 400'000;
  static constexpr std::int64_t kWorld = -1;  // an anchor that never moves

  // Times must increase.
  void add(std::int64_t stamp_ns, std::int64_t anchor, const Isometry3d& T_anchor_camera);
  // Frames held by `from` are held by `to`.
  void move_anchor(std::int64_t from, std::int64_t to, const Isometry3d& T_to_from);
  [[nodiscard]] Trajectory poses(
      const std::function<Isometry3d(std::int64_t anchor)>& T_world_anchor) const;
  [[nodiscard]] std::size_t size() const { return frames_.size(); }

 private:
  struct Frame {
    std::int64_t stamp_ns = 0;
    std::int64_t anchor = kWorld;
    std::array<double, 3> t{};
    std::array<double, 4> q{};
  };
  std::vector<Frame> frames_;
};

}  // namespace tread
