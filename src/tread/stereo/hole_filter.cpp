#include "tread/stereo/hole_filter.hpp"

#include <algorithm>
#include <array>

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

void HoleFilter::apply(Image<Disparity>& disparity, const HoleFilterOptions& options,
                       const Context& context) {
  const ScopedTimer timer(context, "stereo/holes");
  using O = HoleFilterOptions;
  const bool in_place = options.update == O::Update::kInPlace;
  const bool from_previous = options.temporal && same_size(previous_, disparity);
  const int passes = options.spatial ? options.passes : 1;
  Image<Disparity> raw;
  if (options.temporal && options.previous == O::Previous::kRaw) raw = disparity;

  for (int pass = 0; pass < passes; ++pass) {
    if (!in_place) buffer_ = disparity;
    const Image<Disparity>& from = in_place ? disparity : buffer_;
    for (int y = 0; y < disparity.height; ++y) {
      Disparity* row = disparity.row(y);
      for (int x = 0; x < disparity.width; ++x) {
        if (row[x] != kNoMatch) continue;
        if (from_previous && pass == 0) row[x] = previous_(x, y);
        if (options.spatial && row[x] == kNoMatch) {
          row[x] = neighbourhood_median(from, x, y, options);
        }
      }
    }
  }
  if (options.temporal)
    previous_ = options.previous == O::Previous::kRaw ? std::move(raw) : disparity;
}

}  // namespace tread
