// Speckle filter: small patches that stand apart from their surroundings are mismatches. Connected
// components of the disparity image (4 neighbours, joined if they differ by at most max_difference)
// that have at most max_size pixels become "no match".
#pragma once

#include <vector>

#include "tread/core/options.hpp"
#include "tread/core/timer.hpp"
#include "tread/stereo/disparity.hpp"

namespace tread {

struct SpeckleOptions {
  bool enabled = true;
  int max_size_px = 400;           // patches up to this many pixels are removed
  double max_difference_px = 0.5;  // between neighbours of one patch
};
[[nodiscard]] OptionSet describe(SpeckleOptions& options);

// By runs: each row is cut into runs of joined pixels, and runs that touch in neighbouring rows are
// united (union-find). One pass down, one to erase.
class SpeckleFilter {
 public:
  void apply(Image<Disparity>& disparity, const SpeckleOptions& options,
             const Context& context = {});

 private:
  struct Run {
    int first = 0;   // column
    int last = 0;    // one behind
    int parent = 0;  // index of a run of the same patch, itself at the root
    int size = 0;    // pixels of the patch, at the root
  };
  std::vector<Run> runs_;
  std::vector<int> row_begin_;  // index of the first run of each row, and one more
};

}  // namespace tread
