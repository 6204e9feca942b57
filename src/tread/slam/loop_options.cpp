#include "tread/slam/loop_options.hpp"

namespace tread {

OptionSet describe(LoopOptions& options) {
  OptionSet set;
  set.add("enabled", options.enabled, "recognise places and correct the path by them");
  set.add("not_within", options.not_within, "keyframes: places seen so lately are not looked for",
          1, 10'000);
  set.add("candidates", options.candidates, "places that a keyframe is compared with, at most", 1,
          100);
  set.add("least_overlap", options.least_overlap, "of two views of a place, part of the image",
          0.01, 1.0);
  set.add("least_agree", options.least_agree, "of that at the same depth in both", 0.0, 1.0);
  set.add("most_through", options.most_through, "of that which the other view looked through", 0.0,
          1.0);
  set.add("largest_rms", options.largest_rms, "of depths between two views, in sigma", 0.1, 1e3);
  set.add("drift", options.drift, "that odometry may have, part of way and turn", 1e-5, 1.0);
  set.add("most_stretch", options.most_stretch,
          "no loop is believed for which the path would have drifted by so much more", 0.1, 1e3);
  set.add("least_correction_voxels", options.least_correction_voxels,
          "smaller ones are left as they are, voxels", 0.0, 1e3);
  set.add("most_keyframes", options.most_keyframes, "older ones are thinned out then", 10,
          static_cast<int>(PlaceMemory::kMost));
  set.add("memory_mb", options.memory_mb, "of keyframes' images, MiB; then a temporary file", 1,
          65'536);
  set.add("file_mb", options.file_mb, "and of that file", 0, 1'048'576);
  set.add_group("places", describe(options.places));
  set.add_group("graph", describe(options.graph));
  return set;
}

}  // namespace tread
