// Small pictures of where the camera has been, to find its way back after it was lost (Klein and
// Murray 2008: small blurry images).
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "tread/slam/align.hpp"

namespace tread {

class KeyframeBank {
 public:
  // A place that looked like the frame at hand.
  struct Candidate {
    Isometry3d T_world_camera = Isometry3d::Identity();  // of the frame, by how it is turned
    double likeness = 0.0;                               // -1 to 1
    PhotoKeyframe key;                                   // of the place, at the coarsest level only
    std::int64_t anchor = -1;                            // that the place hangs on
  };

  // Keeps a view if none like it was kept from nearby. `depth` is that of the surface. At kMost
  // views every second one of the older half is dropped first, so that a long way stays known from
  // its start, the more coarsely the longer ago it was. `anchor` is what move() knows it by.
  void add(const AlignFrame& frame, const DepthLevel& depth, const Isometry3d& T_world_camera,
           std::int64_t anchor = -1);
  // Up to `most` places, the likeliest first; none for a frame without an image.
  [[nodiscard]] std::vector<Candidate> find(const AlignFrame& frame, std::size_t most) const;
  [[nodiscard]] std::size_t size() const { return views_.size(); }

  // Views go along with what they hang on: their poses are multiplied by this from the left.
  void move(const std::function<Isometry3d(std::int64_t anchor)>& correction);

  static constexpr std::size_t kMost = 1000;

 private:
  struct View {
    Image<float> grey;   // of the coarsest level
    Image<float> depth;  // the same
    Pinhole camera;
    Isometry3d T_world_camera = Isometry3d::Identity();
    std::vector<float> thumbnail;
    std::int64_t anchor = -1;
  };
  void thin_out();
  std::vector<View> views_;  // in the order in which they were added
};

}  // namespace tread
