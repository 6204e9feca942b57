#include "tread/stereo/hole_filter.hpp"

#include <algorithm>
#include <array>
#include <bit>
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

// The bits of 64 columns and of the columns beside them.
struct ThreeColumns {
  std::uint64_t left, here, right;
};
ThreeColumns columns_of(const std::uint64_t* bits, std::size_t word, std::size_t words) {
  const std::uint64_t here = bits[word];
  const std::uint64_t before = word > 0 ? bits[word - 1] : 0;
  const std::uint64_t behind = word + 1 < words ? bits[word + 1] : 0;
  return {here << 1 | before >> 63, here, here >> 1 | behind << 63};
}

// Two bits and a carry for each of 64 columns at once.
struct Sum {
  std::uint64_t low, high;
};
Sum add(std::uint64_t a, std::uint64_t b, std::uint64_t c) {
  const std::uint64_t differ = a ^ b;
  return {differ ^ c, (a & b) | (differ & c)};
}

// The holes of 64 columns of the middle one of three rows with at least min_known known neighbours.
std::uint64_t fillable(const std::uint64_t* above, const std::uint64_t* here,
                       const std::uint64_t* below, std::size_t word, std::size_t words,
                       int min_known) {
  const ThreeColumns a = columns_of(above, word, words), h = columns_of(here, word, words),
                     b = columns_of(below, word, words);
  if (~h.here == 0) return 0;
  const Sum upper = add(a.left, a.here, a.right), lower = add(b.left, b.here, b.right);
  const Sum beside = add(h.left, h.right, 0);
  const Sum ones = add(upper.low, lower.low, beside.low);
  const Sum twos = add(upper.high, lower.high, beside.high);
  const Sum twos_more = add(twos.low, ones.high, 0);
  const Sum fours = add(twos.high, twos_more.high, 0);
  // The count's bits from the highest: as soon as one is above that of min_known, it is more.
  const std::uint64_t count[4] = {ones.low, twos_more.low, fours.low, fours.high};
  std::uint64_t more = 0, equal = ~std::uint64_t{0};
  for (int bit = 3; bit >= 0; --bit) {
    if ((min_known >> bit & 1) != 0) {
      equal &= count[bit];
    } else {
      more |= equal & count[bit];
      equal &= ~count[bit];
    }
  }
  return (more | equal) & ~h.here;
}

// Holes of one row, gathered until there are enough to fill them at once.
class HoleBatch {
 public:
  HoleBatch(std::array<const Disparity*, 3> rows, int width, const MedianRule& rule, Disparity* out)
      : rows_(rows), width_(width), rule_(rule), out_(out) {}

  void add(int x) {
    const auto left = [x](const Disparity* row) { return x > 0 ? row[x - 1] : kNoMatch; };
    const auto right = [&](const Disparity* row) { return x + 1 < width_ ? row[x + 1] : kNoMatch; };
    const Disparity values[8] = {left(rows_[0]),  rows_[0][x],    right(rows_[0]), left(rows_[1]),
                                 right(rows_[1]), left(rows_[2]), rows_[2][x],     right(rows_[2])};
    for (int i = 0; i < 8; ++i) around_.values[i][count_] = values[i];
    x_[static_cast<std::size_t>(count_)] = x;
    if (++count_ == Neighbourhoods::kMost) fill();
  }
  void fill() {
    if (count_ == 0) return;
    std::array<Disparity, Neighbourhoods::kMost> filled;
    fill_holes(around_, rule_, filled.data());
    for (int i = 0; i < count_; ++i) {
      out_[x_[static_cast<std::size_t>(i)]] = filled[static_cast<std::size_t>(i)];
    }
    count_ = 0;
  }

 private:
  std::array<const Disparity*, 3> rows_;
  int width_;
  const MedianRule& rule_;
  Disparity* out_;
  int count_ = 0;
  Neighbourhoods around_{};
  std::array<int, Neighbourhoods::kMost> x_{};
};

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

// Every pixel from the pass before. Few holes can be filled: bits of the rows tell which, and those
// are filled 64 at a time.
void HoleFilter::fill_buffered(Image<Disparity>& disparity, const HoleFilterOptions& options,
                               bool from_previous, const Context& context) {
  std::swap(disparity, buffer_);
  disparity.resize(buffer_.width, buffer_.height);
  const MedianRule rule = rule_of(options);
  const int width = disparity.width, height = disparity.height;
  const std::size_t words = (static_cast<std::size_t>(width) + 63) / 64;
  unknown_.assign(static_cast<std::size_t>(width), kNoMatch);
  known_.resize(static_cast<std::size_t>(worker_count(context)));
  parallel_chunks(context, 0, height, 64, [&](int first, int last, int worker) {
    // Bits of three rows, turn by turn.
    std::vector<std::uint64_t>& memory = known_[static_cast<std::size_t>(worker)];
    memory.resize(3 * words);
    const auto bits = [&](int y) {
      return memory.data() + static_cast<std::size_t>((y + 3) % 3) * words;
    };
    const auto row = [&](int y) { return y >= 0 && y < height ? buffer_.row(y) : unknown_.data(); };
    known_row(row(first - 1), width, bits(first - 1));
    known_row(row(first), width, bits(first));
    for (int y = first; y < last; ++y) {
      known_row(row(y + 1), width, bits(y + 1));
      Disparity* out = disparity.row(y);
      std::copy(row(y), row(y) + width, out);
      if (from_previous) {
        const Disparity* before = previous_.row(y);
        for (int x = 0; x < width; ++x) out[x] = out[x] == kNoMatch ? before[x] : out[x];
      }
      if (!options.spatial) continue;
      HoleBatch batch{{row(y - 1), row(y), row(y + 1)}, width, rule, out};
      for (std::size_t w = 0; w < words; ++w) {
        std::uint64_t holes = fillable(bits(y - 1), bits(y), bits(y + 1), w, words, rule.min_known);
        for (; holes != 0; holes &= holes - 1) {
          const int x = static_cast<int>(w * 64) + std::countr_zero(holes);
          if (x < width && out[x] == kNoMatch) batch.add(x);
        }
      }
      batch.fill();
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
