// Whether two depth images show the same surface, and how they lie to each other: what a place that
// looks the same must pass.
#pragma once

#include <array>
#include <optional>

#include "tread/slam/align.hpp"
#include "tread/slam/loop_options.hpp"

namespace tread {

// Of the known pixels of one image, as another one sees them.
struct Overlap {
  int known = 0;    // of the image
  int seen = 0;     // those that fall on known pixels of the other
  int agree = 0;    // of these, that lie on what is seen there
  int through = 0;  // that lie before it: the other has looked through them
};
// `gate` in standard deviations of both depths together.
[[nodiscard]] Overlap overlap_of(const DepthLevel& image, const DepthLevel& other,
                                 const Isometry3d& T_other_image, const DepthNoise& noise,
                                 double gate);

// The pose of a frame beside the depth image of a place, from where its corners put it: aligned,
// and compared both ways. Empty unless all that `limits` asks for holds.
struct ViewPose {
  Isometry3d T_place_frame = Isometry3d::Identity();
  Matrix6d covariance = Matrix6d::Identity();  // of a twist in axes of the frame
};
[[nodiscard]] std::optional<ViewPose> compare_views(
    const AlignFrame& frame, const std::array<DepthLevel, 3>& place, const PlaceMatch& match,
    const DepthNoise& noise, const AlignOptions& options, const LoopOptions& limits,
    const Context& context = {});

}  // namespace tread
