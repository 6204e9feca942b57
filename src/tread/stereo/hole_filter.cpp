#include "tread/stereo/hole_filter.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "tread/core/parallel.hpp"
#include "tread/stereo/filter_kernel.hpp"

namespace tread {
namespace {

MedianRule rule_of(const HoleFilterOptions& options) {
  const bool all = options.median == HoleFilterOptions::Median::kAll;
  const bool any = options.max_spread_px == 0.0;
  return {
      all, all ? 5 : options.min_known,
      any ? kNoMatch : static_cast<unsigned>(std::lround(options.max_spread_px * kDisparityScale))};
}

// The median of the 3x3 neighbourhood of (x, y), whose centre has no match, or kNoMatch. Outside
// the image nothing is known.
Disparity neighbourhood_median(const Image<Disparity>& image, int x, int y,
                               const MedianRule& rule) {
  std::array<Disparity, 8> known{};  // sorted
  std::size_t count = 0;
  for (int v = std::max(0, y - 1); v <= std::min(image.height - 1, y + 1); ++v) {
    const Disparity* row = image.row(v);
    for (int u = std::max(0, x - 1); u <= std::min(image.width - 1, x + 1); ++u) {
      if (row[u] == kNoMatch) continue;
      std::size_t i = count++;
      for (; i > 0 && known[i - 1] > row[u]; --i) known[i] = known[i - 1];
      known[i] = row[u];
    }
  }
  if (count < static_cast<std::size_t>(rule.min_known)) return kNoMatch;
  if (static_cast<unsigned>(known[count - 1] - known[0]) > rule.max_spread) return kNoMatch;
  // Of nine values the fifth; the unknown ones are the largest, so they only fill the end.
  return known[rule.of_all ? 4 : count / 2];
}

}  // namespace

OptionSet describe(HoleFilterOptions& options) {
  using O = HoleFilterOptions;
  OptionSet set;
  set.add("temporal", options.temporal, "fill holes from the previous frame");
  set.add("spatial", options.spatial, "fill holes with the median of the 3x3 neighbourhood");
  set.add_choice("previous", options.previous, "the previous frame as matched or as filtered",
                 {{"raw", O::Previous::kRaw}, {"filtered", O::Previous::kFiltered}});
  set.add_choice("median", options.median, "median of all nine values or of the known ones",
                 {{"all", O::Median::kAll}, {"known", O::Median::kKnown}});
  set.add("min_known", options.min_known, "known neighbours needed, with median: known", 1, 8);
  set.add("max_spread_px", options.max_spread_px,
          "largest difference between known neighbours, px; beyond it lies a depth edge; 0: not "
          "checked",
          0.0, 64.0);
  set.add_choice("update", options.update,
                 "filled pixels count as known in the next pass or at once",
                 {{"buffered", O::Update::kBuffered}, {"in_place", O::Update::kInPlace}});
  set.add("passes", options.passes, "spatial passes", 1, 16);
  return set;
}

// Vectorised: every pixel from the pass before.
void HoleFilter::fill_buffered(Image<Disparity>& disparity, const HoleFilterOptions& options,
                               bool from_previous, const Context& context) {
  const MedianRule rule = rule_of(options);
  std::swap(disparity, buffer_);
  disparity.resize(buffer_.width, buffer_.height);
  const int width = disparity.width, height = disparity.height;
  rows_.resize(static_cast<std::size_t>(worker_count(context)));
  parallel_chunks(context, 0, height, 64, [&](int first, int last, int worker) {
    // A ring of three rows of the pass before, with one unknown pixel on both sides.
    Image<Disparity>& ring = rows_[static_cast<std::size_t>(worker)];
    ring.resize(width + 2, 3);
    const auto row = [&](int y) { return ring.row((y + 3) % 3); };
    const auto load = [&](int y) {
      Disparity* to = row(y);
      if (y < 0 || y >= height) {
        std::fill(to, to + width + 2, kNoMatch);
        return;
      }
      to[0] = to[width + 1] = kNoMatch;
      std::copy(buffer_.row(y), buffer_.row(y) + width, to + 1);
    };
    load(first - 1);
    load(first);
    for (int y = first; y < last; ++y) {
      load(y + 1);
      fill_row(row(y - 1) + 1, row(y) + 1, row(y + 1) + 1, width,
               from_previous ? previous_.row(y) : nullptr, options.spatial, rule, disparity.row(y));
    }
  });
}

// Pixel by pixel, each from what the pass has made so far.
void HoleFilter::fill_in_place(Image<Disparity>& disparity, const HoleFilterOptions& options,
                               bool from_previous) {
  const MedianRule rule = rule_of(options);
  for (int y = 0; y < disparity.height; ++y) {
    Disparity* row = disparity.row(y);
    for (int x = 0; x < disparity.width; ++x) {
      if (row[x] != kNoMatch) continue;
      if (from_previous) row[x] = previous_(x, y);
      if (options.spatial && row[x] == kNoMatch) {
        row[x] = neighbourhood_median(disparity, x, y, rule);
      }
    }
  }
}

void HoleFilter::apply(Image<Disparity>& disparity, const HoleFilterOptions& options,
                       const Context& context) {
  if (disparity.empty() || (!options.temporal && !options.spatial)) return;
  const ScopedTimer timer(context, "stereo/holes");
  using O = HoleFilterOptions;
  const bool keep_raw = options.temporal && options.previous == O::Previous::kRaw;
  if (keep_raw) raw_ = disparity;
  const int passes = options.spatial ? options.passes : 1;
  for (int pass = 0; pass < passes; ++pass) {
    const bool from_previous = pass == 0 && options.temporal && same_size(previous_, disparity);
    if (options.update == O::Update::kBuffered) {
      fill_buffered(disparity, options, from_previous, context);
    } else {
      fill_in_place(disparity, options, from_previous);
    }
  }
  if (keep_raw) std::swap(previous_, raw_);
  if (options.temporal && !keep_raw) previous_ = disparity;
}

}  // namespace tread
