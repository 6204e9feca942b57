// How DepthSlam recognises places and corrects its path by them.
#pragma once

#include "tread/core/options.hpp"
#include "tread/slam/place_memory.hpp"
#include "tread/slam/pose_graph.hpp"

namespace tread {

struct LoopOptions {
  bool enabled = true;
  int not_within = 12;  // keyframes: places seen so lately are not looked for
  int candidates = 3;   // places that a keyframe is compared with, at most
  // Both depth images must show the same: of the pixels of either that fall into the other.
  double least_overlap = 0.15;  // part of the image
  double least_agree = 0.6;     // at the same depth
  double most_through = 0.1;    // in front of what the other saw there, through it
  double largest_rms = 2.2;     // of depths, in their standard deviations: both are measured
  // What the path may drift by: part of the way, and of the turn. Frames by themselves say less.
  double drift = 0.005;
  double most_stretch = 5.0;  // a loop is not believed if the path would have drifted so much more
  double least_correction_voxels = 2.0;  // smaller ones are left as they are
  int most_keyframes = 1000;             // then older ones are thinned out
  int memory_mb = 64;                    // of keyframes, then a temporary file
  int file_mb = 512;
  PlaceOptions places;
  PoseGraphOptions graph;
  [[nodiscard]] bool operator==(const LoopOptions&) const = default;
};
[[nodiscard]] OptionSet describe(LoopOptions& options);

}  // namespace tread
