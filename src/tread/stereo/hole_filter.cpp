#include "tread/stereo/hole_filter.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "tread/core/parallel.hpp"
#include "tread/stereo/filter_kernel.hpp"

namespace tread {
namespace {

// The median of the 3x3 neighbourhood of (x, y), whose centre has no match, or kNoMatch. Outside
// the image nothing is known.
Disparity neighbourhood_median(const Image<Disparity>& image, int x, int y,
                               const HoleFilterOptions& options) {
  std::array<Disparity, 8> known{};
  std::size_t count = 0;
  for (int v = std::max(0, y - 1); v <= std::min(image.height - 1, y + 1); ++v) {
    const Disparity* row = image.row(v);
    for (int u = std::max(0, x - 1); u <= std::min(image.width - 1, x + 1); ++u) {
      if (row[u] != kNoMatch) known[count++] = row[u];
    }
  }
  const bool all = options.median == HoleFilterOptions::Median::kAll;
  if (count < (all ? 5U : static_cast<std::size_t>(options.min_known))) return kNoMatch;
  // Of nine values the fifth; the unknown ones are the largest, so they only fill the end.
  const std::size_t middle = all ? 4 : count / 2;
  std::nth_element(known.begin(), known.begin() + static_cast<std::ptrdiff_t>(middle),
                   known.begin() + static_cast<std::ptrdiff_t>(count));
  return known[middle];
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
  set.add_choice("update", options.update,
                 "filled pixels count as known in the next pass or at once",
                 {{"buffered", O::Update::kBuffered}, {"in_place", O::Update::kInPlace}});
  set.add("passes", options.passes, "spatial passes", 1, 16);
  return set;
}

// The default reading, vectorised: every pixel from the pass before, median of all nine.
void HoleFilter::fill_buffered(Image<Disparity>& disparity, bool from_previous, bool spatial,
                               const Context& context) {
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
               from_previous ? previous_.row(y) : nullptr, spatial, disparity.row(y));
    }
  });
}

// Every other reading, pixel by pixel.
void HoleFilter::fill_plain(Image<Disparity>& disparity, const HoleFilterOptions& options,
                            bool from_previous) {
  const bool in_place = options.update == HoleFilterOptions::Update::kInPlace;
  if (!in_place) buffer_ = disparity;
  const Image<Disparity>& from = in_place ? disparity : buffer_;
  for (int y = 0; y < disparity.height; ++y) {
    Disparity* row = disparity.row(y);
    for (int x = 0; x < disparity.width; ++x) {
      if (row[x] != kNoMatch) continue;
      if (from_previous) row[x] = previous_(x, y);
      if (options.spatial && row[x] == kNoMatch) {
        row[x] = neighbourhood_median(from, x, y, options);
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
    if (options.update == O::Update::kBuffered && options.median == O::Median::kAll) {
      fill_buffered(disparity, from_previous, options.spatial, context);
    } else {
      fill_plain(disparity, options, from_previous);
    }
  }
  if (keep_raw) std::swap(previous_, raw_);
  if (options.temporal && !keep_raw) previous_ = disparity;
}

}  // namespace tread
