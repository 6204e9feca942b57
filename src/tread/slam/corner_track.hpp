// Internal to slam: a point of the world as visual odometry follows it.
#pragma once

#include <cstdint>
#include <optional>

#include "tread/core/image.hpp"
#include "tread/slam/corner_patch.hpp"
#include "tread/slam/refine_window.hpp"

namespace tread {

struct StereoView {
  ImageView<const std::uint8_t> left;
  ImageView<const std::uint8_t> right;
};

struct CornerTrack {
  StereoSight sight;  // in the frame at hand
  WindowPoint point;
  Eigen::Vector2d at_key = Eigen::Vector2d::Zero();  // where the last keyframe saw it
  CornerPatch patch;                                 // as it was first seen
  CornerPatch::Warp warp;                            // and how the last keyframe saw it
};

// A corner that both images show, or empty if the patch around it says that they do not.
[[nodiscard]] std::optional<CornerTrack> make_corner_track(const StereoView& view,
                                                           const StereoSight& sight);

// Takes the drift out of a track: its sight is where its patch is, in both images. What has changed
// too much to be compared goes on from how it looks now.
void settle(const StereoView& view, CornerTrack& track);

}  // namespace tread
