#include "tread/stereo/sad_kernel.hpp"

#include <algorithm>
#include <cstddef>
#include <cstring>

#include "tread/stereo/sad_plain.hpp"

// This file is compiled once for every instruction set; what is outside `#if HWY_ONCE` lies in a
// name space of that set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tread/stereo/sad_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "tread/stereo/lanes-inl.hpp"
#include "tread/stereo/rows-inl.hpp"
#include "tread/stereo/winners-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace tread::HWY_NAMESPACE {
namespace {

#if HWY_TARGET == HWY_SCALAR || \
    HWY_TARGET == HWY_EMU128  // nothing to vectorise with: a machine older than SSE4
void match_rows_here(const SadImages& images, const SadOptions& options, int first, int last,
                     Image<std::uint8_t>& /*memory*/, const MatchOutput& out) {
  match_rows_plain(images, options, first, last, out);
}
#else
constexpr int kBlock = 16;                // pixels scanned before the results are looked at
constexpr int kCostGuard = 32;            // behind each pixel's costs: a vector's alignment
constexpr std::int16_t kNoCost = 0x7FFF;  // above every sum

// Matches the rows of a band. Column: what holds a column's sum over the rows of the window, 8 bits
// if that is enough, else 16.
template <class Column>
class Band {
  static constexpr bool kNarrow = sizeof(Column) == 1;

 public:
  Band(const SadImages& images, const SadOptions& options, Image<std::uint8_t>& memory)
      : images_(images),
        options_(options),
        width_(images.reference.width),
        radius_x_(options.window_width_px / 2),
        radius_y_(options.window_height_px / 2),
        columns_(width_ + 2 * radius_x_),
        range_(options.num_disparities),
        vectors_((range_ + kLanes - 1) / kLanes),
        padded_(vectors_ * kLanes) {
    lay_out(nullptr);
    const std::size_t needed = used_;
    if (memory.width < static_cast<int>(needed)) memory.resize(static_cast<int>(needed), 1);
    lay_out(memory.row(0));
    std::memset(memory.row(0), 0, needed);
    for (int d = 0; d < range_; ++d) place_[d + 1] = static_cast<std::int16_t>(widened_place(d));
    place_[0] = place_[range_ + 1] = static_cast<std::int16_t>(padded_);
    for (int i = 1; i <= kBlock; ++i) {
      std::int16_t* end = costs_ + static_cast<std::ptrdiff_t>(i) * (padded_ + kCostGuard);
      std::fill(end - kCostGuard, end, kNoCost);
    }
    margin_factor_ = uniqueness_factor(options.uniqueness_percent);
    wide_margin_ =
        margin_factor_ == 0 ? ~0U : (255U * 65536U + margin_factor_ - 1U) / margin_factor_;
    for (int d = 0; d < padded_; ++d) lane_[widened_place(d)] = static_cast<std::int16_t>(d);
  }

  void match(int first, int last, const MatchOutput& out) {
    for (int y = first - radius_y_; y < first + radius_y_; ++y) {
      load_row(y, left_in_, right_in_);
      sum_columns();
    }
    // Nothing leaves the window of the first row: left_out_ and right_out_ are still all zero.
    for (int y = first; y < last; ++y) {
      load_row(y + radius_y_, left_in_, right_in_);
      if (y > first) load_row(y - radius_y_ - 1, left_out_, right_out_);
      match_columns();
      finish_row(out.disparity.row(y), out.residual.empty() ? nullptr : out.residual.row(y));
    }
  }

 private:
  template <class T>
  T* take(std::uint8_t* base, std::size_t count) {
    T* here = reinterpret_cast<T*>(base == nullptr ? nullptr : base + used_);
    used_ += (count * sizeof(T) + 63) / 64 * 64;
    return here;
  }

  void lay_out(std::uint8_t* base) {
    const auto columns = static_cast<std::size_t>(columns_);
    const auto padded = static_cast<std::size_t>(padded_);
    const auto window = static_cast<std::size_t>(options_.window_width_px);
    const auto width = static_cast<std::size_t>(width_);
    used_ = 0;
    left_in_ = take<std::uint32_t>(base, columns);
    left_out_ = take<std::uint32_t>(base, columns);
    right_in_ = take<std::uint8_t>(base, columns + padded);
    right_out_ = take<std::uint8_t>(base, columns + padded);
    costs_ = take<std::int16_t>(base, kBlock * (padded + kCostGuard));
    lane_ = take<std::int16_t>(base, padded);
    place_ = take<std::int16_t>(base, static_cast<std::size_t>(range_) + 2);
    pixels_ = take<PixelResult>(base, width + kLanes);
    owner_ = take<std::uint32_t>(base, width + static_cast<std::size_t>(range_));
    ring_ = take<std::int16_t>(base, kNarrow ? window * padded : 0);
    sums_ = take<Column>(base, (columns + (kNarrow ? 0 : window)) * padded);
  }

  // A row of both images; beyond the border lie the nearest ones.
  void load_row(int y, std::uint32_t* left, std::uint8_t* right) const {
    const int row = std::clamp(y, 0, images_.reference.height - 1);
    spread_row(images_.reference.row(row), width_, radius_x_, images_.mirrored, left);
    reverse_row(images_.other.row(row), width_, radius_x_, options_.min_disparity_px,
                columns_ + padded_, images_.mirrored, right);
  }

  static HWY_INLINE Bytes difference(Bytes left, const std::uint8_t* right) {
    const Bytes other = LoadU(U8(), right);
    if constexpr (kNarrow) {  // differences fit seven bits there
      return BitCast(U8(), Abs(BitCast(I8(), Sub(left, other))));
    } else {
      return Sub(Max(left, other), Min(left, other));
    }
  }

  static HWY_INLINE Bytes spread(std::uint32_t four) { return BitCast(U8(), Set(U32(), four)); }

  [[nodiscard]] Column* column(int c) const {
    return sums_ +
           static_cast<std::ptrdiff_t>(c + (kNarrow ? 0 : options_.window_width_px)) * padded_;
  }

  // Adds the entering row to the sums of the columns, before the first row of a band.
  void sum_columns() {
    for (int c = 0; c < columns_; ++c) {
      const Bytes left = spread(left_in_[c]);
      const std::uint8_t* right = right_in_ + (columns_ - 1 - c);
      Column* sum = column(c);
      for (int d = 0; d < padded_; d += kLanes) {
        const Bytes added = difference(left, right + d);
        if constexpr (kNarrow) {
          Store(Add(Load(U8(), sum + d), added), U8(), sum + d);
        } else {
          std::int16_t* upper = sum + d + kLanes / 2;
          Store(Add(Load(I16(), sum + d), widen_lower(added)), I16(), sum + d);
          Store(Add(Load(I16(), upper), widen_upper(added)), I16(), upper);
        }
      }
    }
  }

  // Where the next column of the row at hand lies: all that the inner loop reads and writes.
  struct Cursor {
    const std::uint32_t* left;  // of the row that enters the window
    std::ptrdiff_t left_out;    // elements from there to the row that leaves
    const std::uint8_t* right;
    std::ptrdiff_t right_out;
    Column* sum;
    std::int16_t* ring;  // narrow: the column that leaves, widened
    std::int16_t* ring_begin;
    std::int16_t* ring_end;
    std::ptrdiff_t window;  // elements from a column to the one that leaves with it
  };

  // Moves the window one column to the right.
  static HWY_INLINE void slide(Cursor& at, int vectors, Words* cost) {
    const Bytes in = spread(*at.left), out = spread(at.left[at.left_out]);
    for (int i = 0; i < vectors; ++i) {
      const int d = i * kLanes, upper_d = d + kLanes / 2;
      const Bytes added = difference(in, at.right + d);
      const Bytes taken = difference(out, at.right + at.right_out + d);
      if constexpr (kNarrow) {
        const Bytes now = Sub(Add(Load(U8(), at.sum + d), added), taken);
        Store(now, U8(), at.sum + d);
        const Words lower = widen_lower(now), upper = widen_upper(now);
        cost[2 * i] = Add(cost[2 * i], Sub(lower, Load(I16(), at.ring + d)));
        cost[2 * i + 1] = Add(cost[2 * i + 1], Sub(upper, Load(I16(), at.ring + upper_d)));
        Store(lower, I16(), at.ring + d);
        Store(upper, I16(), at.ring + upper_d);
      } else {
        const Column* old = at.sum - at.window;
        const Words lower =
            Sub(Add(Load(I16(), at.sum + d), widen_lower(added)), widen_lower(taken));
        const Words upper =
            Sub(Add(Load(I16(), at.sum + upper_d), widen_upper(added)), widen_upper(taken));
        Store(lower, I16(), at.sum + d);
        Store(upper, I16(), at.sum + upper_d);
        cost[2 * i] = Add(cost[2 * i], Sub(lower, Load(I16(), old + d)));
        cost[2 * i + 1] = Add(cost[2 * i + 1], Sub(upper, Load(I16(), old + upper_d)));
      }
    }
    ++at.left;
    --at.right;
    at.sum += vectors * kLanes;
    if constexpr (kNarrow) {
      at.ring += vectors * kLanes;
      if (at.ring == at.ring_end) at.ring = at.ring_begin;
    }
  }

  // What one look at the costs finds, of each pixel of a block.
  struct Scans {
    HWY_ALIGN std::uint64_t equal[kBlock];  // kBits: lanes that cost the least; else the first one
    HWY_ALIGN std::uint64_t close[kBlock];  // kBits: lanes nearly as cheap; else how many there are
    HWY_ALIGN std::uint64_t least[kBlock];
  };

  // Scans the costs of pixel i of the block, of which the first `fit` disparities count (kMasked:
  // not all), and leaves them in `costs`. kBits: all lanes fit one word of bits.
  template <bool kMasked, bool kBits>
  HWY_INLINE void scan(int fit, int vectors, const Words* window, std::int16_t* costs, int i_pixel,
                       Scans& found) const {
    Words cost[2 * kMaxVectors];
    Words least_lanes = window[0];
    for (int i = 0; i < 2 * vectors; ++i) {
      cost[i] = window[i];
      if constexpr (kMasked) {
        const Words lane = Load(I16(), lane_ + i * kLanes / 2);
        cost[i] = IfThenElse(Lt(lane, Set(I16(), static_cast<std::int16_t>(fit))), cost[i],
                             Set(I16(), kNoCost));
      }
      Store(cost[i], I16(), costs + i * kLanes / 2);
      least_lanes = i == 0 ? cost[i] : Min(least_lanes, cost[i]);
    }
    const auto least_lane = least_of(I16(), least_lanes);
    const Words least = spread_word(least_lane);
    const auto margin = MulHigh(BitCast(U16(), least), Set(U16(), margin_factor_));
    const Bytes limit = narrow(BitCast(I16(), margin), BitCast(I16(), margin));
    std::uint64_t equal = 0, close = 0;
    for (int i = vectors - 1; i >= 0; --i) {
      const Bytes excess = narrow(Sub(cost[2 * i], least), Sub(cost[2 * i + 1], least));
      const std::uint64_t equal_here = bits_of(Eq(excess, Zero(U8())));
      const std::uint64_t close_here = bits_at_most(excess, limit);
      if constexpr (kBits) {
        equal |= equal_here << (i * kLanes);
        close |= close_here << (i * kLanes);
      } else {
        if (equal_here != 0) {
          equal = static_cast<std::uint64_t>(i * kLanes) + lowest_bit(equal_here);
        }
        close += hwy::PopCount(close_here);
      }
    }
    found.equal[i_pixel] = equal;
    found.close[i_pixel] = close;
    found.least[i_pixel] = static_cast<std::uint64_t>(GetLane(least_lane));
  }

  // Winners of a block, as a PixelResult without neighbours, from what the scans found, many at
  // once. Of those with too wide a margin nothing is known yet.
  template <bool kBits>
  static HWY_INLINE void settle(const Scans& found, std::uint64_t* winners) {
    const hn::ScalableTag<std::uint64_t> u64;
    const auto one = Set(u64, 1);
    for (int i = 0; i < kBlock; i += static_cast<int>(Lanes(u64))) {
      auto winner = hn::ShiftLeft<16>(Load(u64, found.least + i));
      const auto equal = Load(u64, found.equal + i);
      if constexpr (kBits) {
        const auto best = And(equal, Sub(Zero(u64), equal));  // the lowest bit
        const auto own = Or(best, Or(hn::ShiftLeft<1>(best), hn::ShiftRight<1>(best)));
        const auto others = AndNot(own, Load(u64, found.close + i));
        winner = Or(winner, PopulationCount(Sub(best, one)));
        winner = IfThenElse(Eq(others, Zero(u64)), winner,
                            Or(winner, Set(u64, std::uint64_t{kAmbiguous} << 32)));
      } else {
        winner = Or(winner, equal);
      }
      Store(winner, u64, winners + i);
    }
  }

  [[nodiscard]] std::uint32_t limit_of(std::uint32_t least) const {
    return least + (least * margin_factor_ >> 16);
  }

  // How many of the winner and its neighbours cost at most `limit`.
  static HWY_INLINE std::uint64_t own_count(std::uint32_t limit, std::uint32_t before,
                                            std::uint32_t behind) {
    return 1U + (before <= limit ? 1U : 0U) + (behind <= limit ? 1U : 0U);
  }

  // As the scan, where the margin is more than a byte holds.
  HWY_NOINLINE bool ambiguous_by_words(const std::int16_t* costs, int vectors, std::uint32_t least,
                                       std::uint32_t before, std::uint32_t behind) const {
    const std::uint32_t limit = limit_of(least);
    const Words top =
        Set(I16(), static_cast<std::int16_t>(std::min<std::uint32_t>(limit, kNoCost - 1)));
    std::uint64_t count = 0;
    for (int i = 0; i < 2 * vectors; ++i) {
      const Words cost = Load(I16(), costs + i * kLanes / 2);
      count += CountTrue(I16(), Eq(Min(cost, top), cost));
    }
    return count != own_count(limit, before, behind);
  }

  // Pixels first to last - 1, in short blocks: first the scans, each a long chain of dependent
  // instructions, then what hangs on their results.
  template <bool kMasked, int kVectors>
  HWY_INLINE void match_pixels(Cursor& at, int first, int last, Words* cost) {
    const int vectors = kVectors > 0 ? kVectors : vectors_;
    constexpr bool kBits = kVectors > 0 && kVectors * kLanes <= 64;
    const std::ptrdiff_t stride = vectors * kLanes + kCostGuard;
    std::uint32_t* owner = owner_ - options_.min_disparity_px;
    Scans scans{};
    HWY_ALIGN std::uint64_t winners[kBlock];
    for (int begin = first; begin < last; begin += kBlock) {
      const int count = std::min(kBlock, last - begin);
      std::int16_t* costs = costs_;
      for (int i = 0; i < count; ++i, costs += stride) {
        slide(at, vectors, cost);
        const int fit = kMasked ? std::min(range_, begin + i - options_.min_disparity_px + 1) : 0;
        scan<kMasked, kBits>(fit, vectors, cost, costs, i, scans);
      }
      settle<kBits>(scans, winners);
      costs = costs_;
      for (int i = 0; i < count; ++i, costs += stride) {
        const std::uint32_t index = winners[i] & kIndexMask;
        const auto before = static_cast<std::uint32_t>(costs[place_[index]]);
        const auto behind = static_cast<std::uint32_t>(costs[place_[index + 2]]);
        const auto winner = static_cast<std::uint32_t>(winners[i]);
        auto ambiguous = static_cast<std::uint32_t>(winners[i] >> 32);
        if (const std::uint32_t least = winner >> 16; HWY_UNLIKELY(least >= wide_margin_)) {
          const bool by_words = ambiguous_by_words(costs, vectors, least, before, behind);
          ambiguous = by_words ? kAmbiguous : 0;
        } else if constexpr (!kBits) {
          const std::uint64_t own = own_count(limit_of(least), before, behind);
          ambiguous = scans.close[i] != own ? kAmbiguous : 0;
        }
        pixels_[begin + i] = {winner, before | behind << 16 | ambiguous};
        claim(owner + begin + i, winner);
      }
    }
  }

  template <int kVectors>
  HWY_NOINLINE void match_columns_of() {
    const int vectors = kVectors > 0 ? kVectors : vectors_;
    Words cost[2 * (kVectors > 0 ? kVectors : kMaxVectors)];
    for (int i = 0; i < 2 * vectors; ++i) cost[i] = Zero(I16());
    const std::ptrdiff_t window = static_cast<std::ptrdiff_t>(options_.window_width_px) * padded_;
    if constexpr (kNarrow) std::memset(ring_, 0, static_cast<std::size_t>(window) * 2);
    std::fill(owner_, owner_ + width_, ~std::uint32_t{0});
    Cursor at{left_in_,
              left_out_ - left_in_,
              right_in_ + columns_ - 1,
              right_out_ - right_in_,
              column(0),
              ring_,
              ring_,
              ring_ + window,
              window};
    const int begin = first_pixel();
    // From here on the whole range fits the image and the vectors.
    const int full = padded_ == range_
                         ? std::clamp(options_.min_disparity_px + range_ - 1, begin, width_)
                         : width_;
    for (int c = std::min(options_.window_width_px - 1 + begin, columns_); c > 0; --c) {
      slide(at, vectors, cost);
    }
    match_pixels<true, kVectors>(at, begin, full, cost);
    match_pixels<false, kVectors>(at, full, width_, cost);
  }

  void match_columns() {
    switch (vectors_) {
      case 1:
        return match_columns_of<1>();
      case 2:
        return match_columns_of<2>();
      case 4:
        return match_columns_of<4>();
      default:
        return match_columns_of<0>();
    }
  }

  // The first pixel that has disparities to try.
  [[nodiscard]] int first_pixel() const {
    const int all = options_.min_disparity_px + range_ - 1;
    return std::min(width_, options_.reduced_range_at_border ? options_.min_disparity_px : all);
  }

  void finish_row(Disparity* out, std::uint8_t* residual) const {
    const int begin = first_pixel();
    std::fill(out, out + begin, kNoMatch);
    if (residual != nullptr) std::fill(residual, residual + begin, kNoResidual);
    RefineJob job;
    job.begin = begin;
    job.width = width_;
    job.no_cost = kNoCost;
    job.min_disparity_px = options_.min_disparity_px;
    job.sub_pixel = options_.sub_pixel;
    job.sub_pixel_steps = options_.sub_pixel_steps;
    job.strict_sub_pixel = options_.strict_sub_pixel;
    job.check_unique = options_.uniqueness_percent > 0;
    job.left_right_tolerance_px = options_.left_right_tolerance_px;
    refine(pixels_, owner_, job, out, residual);
    if (!images_.mirrored) return;
    std::reverse(out, out + width_);
    if (residual != nullptr) std::reverse(residual, residual + width_);
  }

  const SadImages& images_;
  const SadOptions& options_;
  int width_;
  int radius_x_;
  int radius_y_;
  int columns_;  // of the image and a radius on both sides
  int range_;
  int vectors_;  // of bytes that hold the range
  int padded_;   // their lanes
  std::size_t used_ = 0;
  std::uint32_t* left_in_ = nullptr;  // the row that enters the window, each pixel four times
  std::uint32_t* left_out_ = nullptr;
  std::uint8_t* right_in_ = nullptr;  // reversed
  std::uint8_t* right_out_ = nullptr;
  Column* sums_ = nullptr;         // [column][disparity]
  std::int16_t* ring_ = nullptr;   // [column mod window width][disparity], widened
  std::int16_t* costs_ = nullptr;  // of the block's pixels, by cost_place, kNoCost behind them
  std::uint16_t margin_factor_ = 0;
  std::uint32_t wide_margin_ = 0;   // the least cost whose margin does not fit a byte
  std::int16_t* lane_ = nullptr;    // disparity index by place
  std::int16_t* place_ = nullptr;   // place by disparity index + 1
  PixelResult* pixels_ = nullptr;   // of the row
  std::uint32_t* owner_ = nullptr;  // by column of the other image: cost and index
};

void match_rows_here(const SadImages& images, const SadOptions& options, int first, int last,
                     Image<std::uint8_t>& memory, const MatchOutput& out) {
  const int column_sum = options.window_height_px * images.largest_difference;
  if (images.largest_difference <= 127 && column_sum <= 255) {
    Band<std::uint8_t>(images, options, memory).match(first, last, out);
  } else {
    Band<std::int16_t>(images, options, memory).match(first, last, out);
  }
}
#endif

}  // namespace
}  // namespace tread::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tread {
HWY_EXPORT(match_rows_here);

void match_rows(const SadImages& images, const SadOptions& options, int first, int last,
                Image<std::uint8_t>& memory, const MatchOutput& out) {
  HWY_DYNAMIC_DISPATCH(match_rows_here)(images, options, first, last, memory, out);
}
}  // namespace tread
#endif
