#include "tread/stereo/speckle_filter.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace tread {

OptionSet describe(SpeckleOptions& options) {
  OptionSet set;
  set.add("enabled", options.enabled, "remove small patches");
  set.add("max_size_px", options.max_size_px, "patches up to this many pixels are removed", 0,
          1'000'000);
  set.add("max_difference_px", options.max_difference_px,
          "largest difference between neighbours of one patch, px", 0.0, 64.0);
  return set;
}

void SpeckleFilter::apply(Image<Disparity>& disparity, const SpeckleOptions& options,
                          const Context& context) {
  if (!options.enabled || disparity.empty()) return;
  const ScopedTimer timer(context, "stereo/speckle");
  const int limit = static_cast<int>(std::lround(options.max_difference_px * kDisparityScale));
  const auto joined = [limit](Disparity a, Disparity b) {
    return std::abs(static_cast<int>(a) - static_cast<int>(b)) <= limit;
  };
  const auto root_of = [this](int run) {
    while (runs_[static_cast<std::size_t>(run)].parent != run) {
      Run& r = runs_[static_cast<std::size_t>(run)];
      r.parent = runs_[static_cast<std::size_t>(r.parent)].parent;  // halve the way
      run = r.parent;
    }
    return run;
  };
  const auto unite = [&](int a, int b) {
    a = root_of(a);
    b = root_of(b);
    if (a == b) return;
    const int low = std::min(a, b), high = std::max(a, b);
    runs_[static_cast<std::size_t>(high)].parent = low;
    runs_[static_cast<std::size_t>(low)].size += runs_[static_cast<std::size_t>(high)].size;
  };

  runs_.clear();
  row_begin_.assign(1, 0);
  for (int y = 0; y < disparity.height; ++y) {
    const Disparity* row = disparity.row(y);
    for (int x = 0; x < disparity.width;) {
      if (row[x] == kNoMatch) {
        ++x;
        continue;
      }
      const int first = x++;
      while (x < disparity.width && row[x] != kNoMatch && joined(row[x - 1], row[x])) ++x;
      const int index = static_cast<int>(runs_.size());
      runs_.push_back({first, x, index, x - first});
    }
    row_begin_.push_back(static_cast<int>(runs_.size()));
    if (y == 0) continue;
    // Runs of both rows from left to right; every overlap is looked at once.
    const Disparity* above = disparity.row(y - 1);
    int a = row_begin_[static_cast<std::size_t>(y) - 1];
    int b = row_begin_[static_cast<std::size_t>(y)];
    const int a_end = b, b_end = row_begin_[static_cast<std::size_t>(y) + 1];
    while (a < a_end && b < b_end) {
      const Run upper = runs_[static_cast<std::size_t>(a)];
      const Run lower = runs_[static_cast<std::size_t>(b)];
      const int end = std::min(upper.last, lower.last);
      for (int x = std::max(upper.first, lower.first); x < end; ++x) {
        if (!joined(above[x], row[x])) continue;
        unite(a, b);
        break;
      }
      (upper.last < lower.last ? a : b) += 1;
    }
  }

  for (int y = 0; y < disparity.height; ++y) {
    Disparity* row = disparity.row(y);
    for (int i = row_begin_[static_cast<std::size_t>(y)];
         i < row_begin_[static_cast<std::size_t>(y) + 1]; ++i) {
      if (runs_[static_cast<std::size_t>(root_of(i))].size > options.max_size_px) continue;
      const Run& run = runs_[static_cast<std::size_t>(i)];
      std::fill(row + run.first, row + run.last, kNoMatch);
    }
  }
}

}  // namespace tread
