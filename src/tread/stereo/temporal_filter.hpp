// Consistency over time, for video: a match counts once two frames in a row agree on it, and its
// disparity is smoothed. Not in the papers, whose temporal filter only fills holes
// (hole_filter.hpp). It asks that disparities change by less than max_change_px from frame to
// frame: right for cameras that move slowly against what they see.
#pragma once

#include "tread/core/options.hpp"
#include "tread/core/timer.hpp"
#include "tread/stereo/disparity.hpp"

namespace tread {

struct TemporalOptions {
  bool enabled = false;
  double max_change_px = 1.0;  // between frames, to be the same surface
  bool confirm = true;         // a match that the frame before does not have waits for one frame
  int memory = 8;              // share of the frames before in the result, sixteenths; 0: none
  [[nodiscard]] bool operator==(const TemporalOptions&) const = default;
};
[[nodiscard]] OptionSet describe(TemporalOptions& options);

// One a stream: keeps the frame before.
class TemporalFilter {
 public:
  // In place. The first frame, and the first after a change of size or reset(), stays as it is.
  void apply(Image<Disparity>& disparity, const TemporalOptions& options,
             const Context& context = {});
  void reset() { seen_ = {}; }

 private:
  Image<Disparity> seen_;    // the frame before as matched
  Image<Disparity> result_;  // and as filtered
};

}  // namespace tread
