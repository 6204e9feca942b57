// Speckle filter: small patches that stand apart from their surroundings are mismatches. Connected
// components of the disparity image (4 neighbours, joined if they differ by at most max_difference)
// that have at most max_size pixels become "no match".
#pragma once

#include <cstdint>
#include <vector>

#include "tread/core/options.hpp"
#include "tread/core/timer.hpp"
#include "tread/stereo/disparity.hpp"

namespace tread {

struct SpeckleOptions {
  bool enabled = true;
  int max_size_px = 400;           // patches up to this many pixels are removed
  double max_difference_px = 0.5;  // between neighbours of one patch
  [[nodiscard]] bool operator==(const SpeckleOptions&) const = default;
};
[[nodiscard]] OptionSet describe(SpeckleOptions& options);

// By runs: each row is cut into runs of joined pixels, and runs that touch in neighbouring rows are
// united (union-find). What is joined is found for many pixels at once and kept as bits; after that
// the work is by runs. Bands of rows are worked on apart and then sewn together.
class SpeckleFilter {
 public:
  void apply(Image<Disparity>& disparity, const SpeckleOptions& options,
             const Context& context = {});

 private:
  struct Run {
    int first;  // column
    int last;   // one behind
  };
  struct Band {
    std::vector<Run> runs;
    std::vector<int> parent;     // by run: a run of the same patch, itself or one before it
    std::vector<int> row_begin;  // index of the first run of each row, and one more
    std::vector<std::uint64_t> bits;
    int offset = 0;  // of its runs among all
  };
  void cut(ImageView<const Disparity> disparity, int first, int last, int limit, Band& band);
  void sew(ImageView<const Disparity> disparity, int rows, int limit);

  std::vector<Band> bands_;
  std::vector<int> parent_;  // of all runs
  std::vector<int> size_;    // pixels of the patch, by its first run
};

}  // namespace tread
