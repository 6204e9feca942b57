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

HWY_BEFORE_NAMESPACE();
namespace tread::HWY_NAMESPACE {
namespace {

#if HWY_TARGET == HWY_SCALAR  // nothing to vectorise with: a machine older than SSE4
void match_rows_here(const SadImages& images, const SadOptions& options, int first, int last,
                     Image<std::uint8_t>& /*memory*/, Image<Disparity>& disparity) {
  match_rows_plain(images, options, first, last, disparity);
}
#else
namespace hn = hwy::HWY_NAMESPACE;

using U8 = hn::ScalableTag<std::uint8_t>;
using I8 = hn::RebindToSigned<U8>;
using I16 = hn::ScalableTag<std::int16_t>;
using U32 = hn::ScalableTag<std::uint32_t>;
using I32 = hn::ScalableTag<std::int32_t>;
using F32 = hn::ScalableTag<float>;
using Bytes = hn::Vec<U8>;
using Words = hn::Vec<I16>;

constexpr int kLanes = static_cast<int>(hn::MaxLanes(U8()));  // disparities of a vector of bytes
constexpr int kMaxVectors = 1024 / kLanes;                    // kMaxDisparity of them
constexpr std::int16_t kNoCost = 0x7FFF;                      // above every sum

// Where the cost of disparity index d lies: each block of sixteen bytes widens to a block of the
// vector `lower` and one of the vector `upper`.
constexpr int cost_place(int d) {
  return d / kLanes * kLanes + (d / 8 % 2) * (kLanes / 2) + d % kLanes / 16 * 8 + d % 8;
}

HWY_INLINE Words widen_lower(Bytes v) {
  return BitCast(I16(), InterleaveLower(U8(), v, Zero(U8())));
}
HWY_INLINE Words widen_upper(Bytes v) {
  return BitCast(I16(), InterleaveUpper(U8(), v, Zero(U8())));
}

// Undoes the widening; what is above 255 becomes 255.
HWY_INLINE Bytes narrow(Words lower, Words upper) {
#if HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX3_DL
  return Bytes{_mm512_packus_epi16(lower.raw, upper.raw)};
#elif HWY_TARGET == HWY_AVX2
  return Bytes{_mm256_packus_epi16(lower.raw, upper.raw)};
#elif HWY_ARCH_X86
  return Bytes{_mm_packus_epi16(lower.raw, upper.raw)};
#else
  const hn::Half<U8> half;
  return Combine(U8(), DemoteTo(half, upper), DemoteTo(half, lower));
#endif
}

template <class D, class V>
HWY_INLINE int least_of(D d, V v) {
  if constexpr (hn::MaxLanes(D()) > 8) {
    const hn::Half<D> half;
    return least_of(half, Min(LowerHalf(half, v), UpperHalf(half, v)));
  } else {
    const hn::RebindToUnsigned<D> unsigned_tag;  // one instruction where there is one
    return static_cast<int>(GetLane(MinOfLanes(unsigned_tag, BitCast(unsigned_tag, v))));
  }
}

HWY_INLINE std::uint64_t bits_of(hn::Mask<U8> mask) {
  std::uint64_t bits = 0;
  StoreMaskBits(U8(), mask, reinterpret_cast<std::uint8_t*>(&bits));
  return bits;
}

// What the columns of one row leave for its second pass, by x.
struct RowResult {
  std::int16_t* index;   // of the least cost, disparity - min_disparity
  std::int16_t* least;   // that cost
  std::int16_t* before;  // the cost of one disparity less, kNoCost outside the range
  std::int16_t* behind;  // and of one more
  std::int16_t* unique;  // -1: no other disparity is nearly as cheap, 0
};

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
    for (int d = 0; d < range_; ++d) place_[d + 1] = static_cast<std::int16_t>(cost_place(d));
    place_[0] = place_[range_ + 1] = static_cast<std::int16_t>(padded_);
    std::fill(costs_ + padded_, costs_ + padded_ + 8, kNoCost);
    for (int d = 0; d < padded_; ++d) lane_[cost_place(d)] = static_cast<std::int16_t>(d);
  }

  void match(int first, int last, Image<Disparity>& disparity) {
    for (int y = first - radius_y_; y < first + radius_y_; ++y) {
      load_row(y, left_in_, right_in_);
      sum_columns();
    }
    // Nothing leaves the window of the first row: left_out_ and right_out_ are still all zero.
    for (int y = first; y < last; ++y) {
      load_row(y + radius_y_, left_in_, right_in_);
      if (y > first) load_row(y - radius_y_ - 1, left_out_, right_out_);
      match_columns();
      finish_row(disparity.row(y));
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
    costs_ = take<std::int16_t>(base, padded + 8);
    lane_ = take<std::int16_t>(base, padded);
    place_ = take<std::int16_t>(base, static_cast<std::size_t>(range_) + 2);
    for (std::int16_t** row :
         {&row_.index, &row_.least, &row_.before, &row_.behind, &row_.unique}) {
      *row = take<std::int16_t>(base, width + kLanes);
    }
    chosen_ = take<std::uint32_t>(base, width + static_cast<std::size_t>(range_));
    ring_ = take<std::int16_t>(base, kNarrow ? window * padded : 0);
    sums_ = take<Column>(base, (columns + (kNarrow ? 0 : window)) * padded);
  }

  // A row of the reference image, each pixel four times (one load then fills a vector), and of the
  // other one, reversed: entry k is its column width - 1 + radius - min_disparity - k. Beyond the
  // border lie the nearest pixels.
  void load_row(int y, std::uint32_t* left, std::uint8_t* right) const {
    const int row = std::clamp(y, 0, images_.reference.height - 1);
    const std::uint8_t* from = images_.reference.row(row);
    const std::uint8_t* other = images_.other.row(row);
    const int last = width_ - 1;
    const bool mirrored = images_.mirrored;
    constexpr std::uint32_t kFourTimes = 0x01010101U;
    std::uint32_t* inside = left + radius_x_;
    std::fill(left, inside, from[mirrored ? last : 0] * kFourTimes);
    if (mirrored) {
      for (int x = 0; x < width_; ++x) inside[x] = from[last - x] * kFourTimes;
    } else {
      for (int x = 0; x < width_; ++x) inside[x] = from[x] * kFourTimes;
    }
    std::fill(inside + width_, left + columns_, from[mirrored ? 0 : last] * kFourTimes);

    const int length = columns_ + padded_;
    const int shift = radius_x_ - options_.min_disparity_px;  // entry k is column last + shift - k
    const int begin = std::clamp(shift, 0, length), end = std::clamp(shift + width_, begin, length);
    std::fill(right, right + begin, other[mirrored ? 0 : last]);
    const int skipped = begin - shift;
    if (mirrored) {
      std::copy(other + skipped, other + skipped + (end - begin), right + begin);
    } else {
      std::reverse_copy(other + width_ - skipped - (end - begin), other + width_ - skipped,
                        right + begin);
    }
    std::fill(right + end, right + length, other[mirrored ? last : 0]);
  }

  HWY_INLINE Bytes difference(Bytes left, const std::uint8_t* right) const {
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

  // Moves the window one column to the right: column c enters.
  HWY_INLINE void slide(int c, int vectors, std::int16_t* ring, Words* cost) const {
    const Bytes in = spread(left_in_[c]), out = spread(left_out_[c]);
    const std::uint8_t* right_in = right_in_ + (columns_ - 1 - c);
    const std::uint8_t* right_out = right_out_ + (columns_ - 1 - c);
    Column* sum = column(c);
    for (int i = 0; i < vectors; ++i) {
      const int d = i * kLanes, upper_d = d + kLanes / 2;
      const Bytes added = difference(in, right_in + d);
      const Bytes taken = difference(out, right_out + d);
      if constexpr (kNarrow) {
        const Bytes now = Sub(Add(Load(U8(), sum + d), added), taken);
        Store(now, U8(), sum + d);
        const Words lower = widen_lower(now), upper = widen_upper(now);
        cost[2 * i] = Add(cost[2 * i], Sub(lower, Load(I16(), ring + d)));
        cost[2 * i + 1] = Add(cost[2 * i + 1], Sub(upper, Load(I16(), ring + upper_d)));
        Store(lower, I16(), ring + d);
        Store(upper, I16(), ring + upper_d);
      } else {
        const Column* old = column(c - options_.window_width_px);
        const Words lower = Sub(Add(Load(I16(), sum + d), widen_lower(added)), widen_lower(taken));
        const Words upper =
            Sub(Add(Load(I16(), sum + upper_d), widen_upper(added)), widen_upper(taken));
        Store(lower, I16(), sum + d);
        Store(upper, I16(), sum + upper_d);
        cost[2 * i] = Add(cost[2 * i], Sub(lower, Load(I16(), old + d)));
        cost[2 * i + 1] = Add(cost[2 * i + 1], Sub(upper, Load(I16(), old + upper_d)));
      }
    }
  }

  // Finds the winner of pixel x among the first `fit` disparities. Masked: not all lanes count.
  template <bool kMasked>
  HWY_INLINE void decide(int x, int fit, int vectors, const Words* window) const {
    Words cost[2 * kMaxVectors];
    for (int i = 0; i < 2 * vectors; ++i) {
      cost[i] = window[i];
      if constexpr (kMasked) {
        const Words lane = Load(I16(), lane_ + i * kLanes / 2);
        cost[i] = IfThenElse(Lt(lane, Set(I16(), static_cast<std::int16_t>(fit))), cost[i],
                             Set(I16(), kNoCost));
      }
      Store(cost[i], I16(), costs_ + i * kLanes / 2);
    }
    Words least_lanes = cost[0];
    for (int i = 1; i < 2 * vectors; ++i) least_lanes = Min(least_lanes, cost[i]);
    const int least = least_of(I16(), least_lanes);
    const int margin = least * options_.uniqueness_percent / 100;

    const Words least_cost = Set(I16(), static_cast<std::int16_t>(least));
    const Bytes limit = Set(U8(), static_cast<std::uint8_t>(std::min(margin, 255)));
    int index = 0;
    std::size_t close = 0;
    for (int i = vectors - 1; i >= 0; --i) {
      const Bytes excess = narrow(Sub(cost[2 * i], least_cost), Sub(cost[2 * i + 1], least_cost));
      const std::uint64_t equal = bits_of(Eq(excess, Zero(U8())));
      if (equal != 0 || i == vectors - 1) {
        index =
            i * kLanes +
            static_cast<int>(hwy::Num0BitsBelowLS1Bit_Nonzero64(equal | (std::uint64_t{1} << 63)));
      }
      close += hwy::PopCount(bits_of(Eq(Min(excess, limit), excess)));
    }
    const int before = costs_[place_[index]], behind = costs_[place_[index + 2]];
    if (HWY_UNLIKELY(margin >= 255)) close = count_close(least + margin);
    const std::size_t own =
        1U + (before - least <= margin ? 1U : 0U) + (behind - least <= margin ? 1U : 0U);
    row_.index[x] = static_cast<std::int16_t>(index);
    row_.least[x] = static_cast<std::int16_t>(least);
    row_.before[x] = static_cast<std::int16_t>(before);
    row_.behind[x] = static_cast<std::int16_t>(behind);
    row_.unique[x] = close == own ? -1 : 0;
  }

  HWY_NOINLINE std::size_t count_close(int limit) const {
    return static_cast<std::size_t>(std::count_if(
        costs_, costs_ + padded_, [limit](std::int16_t c) { return c <= limit && c != kNoCost; }));
  }

  template <int kVectors>
  HWY_NOINLINE void match_columns_of() const {
    const int vectors = kVectors > 0 ? kVectors : vectors_;
    Words cost[2 * (kVectors > 0 ? kVectors : kMaxVectors)];
    for (int i = 0; i < 2 * vectors; ++i) cost[i] = Zero(I16());
    const int window = options_.window_width_px;
    const int begin = first_pixel();
    // From here on the whole range fits the image.
    const int full = padded_ == range_
                         ? std::clamp(options_.min_disparity_px + range_ - 1, begin, width_)
                         : width_;
    int c = 0;
    std::int16_t* ring = ring_;
    const std::int16_t* ring_end = ring_ + static_cast<std::ptrdiff_t>(window) * padded_;
    const auto turn = [&]() HWY_ATTR {
      slide(c++, vectors, ring, cost);
      ring += padded_;
      if (ring == ring_end) ring = ring_;
    };
    if constexpr (kNarrow) std::memset(ring_, 0, static_cast<std::size_t>(window * padded_) * 2);
    while (c < window - 1 + begin && c < columns_) turn();
    for (int x = begin; x < full; ++x) {
      turn();
      decide<true>(x, std::min(range_, x - options_.min_disparity_px + 1), vectors, cost);
    }
    for (int x = full; x < width_; ++x) {
      turn();
      decide<false>(x, range_, vectors, cost);
    }
  }

  void match_columns() const {
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

  void finish_row(Disparity* out) const {
    const int begin = first_pixel();
    std::fill(out, out + begin, kNoMatch);
    refine(begin, out);
    if (options_.left_right_tolerance_px >= 0) check_back(begin, out);
    if (images_.mirrored) std::reverse(out, out + width_);
  }

  // Below the pixel: n / m of a step, rounded to the nearest, half to even. Both are small enough
  // integers that a float's quotient never rounds to another step than the true one would.
  void refine(int begin, Disparity* out) const {
    const F32 f32;
    const I32 i32;
    const hn::Rebind<std::int16_t, I32> i16;
    const hn::Rebind<std::uint16_t, I32> u16;
    const int lanes = static_cast<int>(Lanes(i32));
    const auto no_cost = Set(i32, kNoCost);
    const auto steps = Set(f32, static_cast<float>(options_.sub_pixel_steps));
    const auto scale = Set(f32, static_cast<float>(kDisparityScale));
    const bool strict = options_.strict_sub_pixel;
    const bool every = options_.uniqueness_percent <= 0;
    HWY_ALIGN Disparity last[static_cast<int>(hn::MaxLanes(I32()))];
    for (int x = begin; x < width_; x += lanes) {
      const auto c = PromoteTo(i32, LoadU(i16, row_.least + x));
      const auto l = PromoteTo(i32, LoadU(i16, row_.before + x));
      const auto r = PromoteTo(i32, LoadU(i16, row_.behind + x));
      const auto index = PromoteTo(i32, LoadU(i16, row_.index + x));
      const auto unique = PromoteTo(i32, LoadU(i16, row_.unique + x));
      const auto inside = And(Ne(l, no_cost), Ne(r, no_cost));
      auto divisor = Zero(i32);
      if (options_.sub_pixel == SubPixel::kSymmetricV) divisor = Sub(Max(l, r), c);
      if (options_.sub_pixel == SubPixel::kParabola) divisor = Sub(Add(l, r), Add(c, c));
      const auto refined = And(inside, Gt(divisor, Zero(i32)));
      const auto m = ConvertTo(f32, IfThenElse(refined, Add(divisor, divisor), Set(i32, 1)));
      const auto n = Mul(ConvertTo(f32, Sub(l, r)), steps);
      const auto whole_steps = Round(IfThenElseZero(RebindMask(f32, refined), Div(n, m)));
      const auto fraction = ConvertTo(i32, Div(Mul(whole_steps, scale), steps));
      const auto whole =
          Mul(Add(index, Set(i32, options_.min_disparity_px)), Set(i32, kDisparityScale));
      auto good = every ? Eq(c, c) : Ne(unique, Zero(i32));
      if (strict) good = And(good, And(inside, And(Gt(l, c), Gt(r, c))));
      const auto found =
          DemoteTo(u16, IfThenElse(good, Add(whole, fraction), Set(i32, int{kNoMatch})));
      if (x + lanes <= width_) {
        StoreU(found, u16, out + x);
      } else {
        Store(found, u16, last);
        std::copy(last, last + (width_ - x), out + x);
      }
    }
  }

  // A pixel of the other image belongs to the cheapest of those that chose it, of equal ones to the
  // one with the smaller disparity; the others have no match.
  void check_back(int begin, Disparity* out) const {
    const int size = width_ - options_.min_disparity_px;
    std::fill(chosen_, chosen_ + std::max(size, 0), ~std::uint32_t{0});
    for (int x = begin; x < width_; ++x) {
      std::uint32_t& chosen = chosen_[x - options_.min_disparity_px - row_.index[x]];
      const std::uint32_t key = static_cast<std::uint32_t>(row_.least[x]) << 16 |
                                static_cast<std::uint32_t>(row_.index[x]);
      chosen = std::min(chosen, key);
    }
    for (int x = begin; x < width_; ++x) {
      const int index = row_.index[x];
      const int back = static_cast<int>(chosen_[x - options_.min_disparity_px - index] & 0xFFFFU);
      if (std::abs(back - index) > options_.left_right_tolerance_px) out[x] = kNoMatch;
    }
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
  std::int16_t* costs_ = nullptr;  // of the pixel at hand, by cost_place
  std::int16_t* lane_ = nullptr;   // disparity index by place
  std::int16_t* place_ = nullptr;  // place by disparity index + 1
  RowResult row_{};
  std::uint32_t* chosen_ = nullptr;  // by column of the other image: cost and index
};

void match_rows_here(const SadImages& images, const SadOptions& options, int first, int last,
                     Image<std::uint8_t>& memory, Image<Disparity>& disparity) {
  const int column_sum = options.window_height_px * images.largest_difference;
  if (images.largest_difference <= 127 && column_sum <= 255) {
    Band<std::uint8_t>(images, options, memory).match(first, last, disparity);
  } else {
    Band<std::int16_t>(images, options, memory).match(first, last, disparity);
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
                Image<std::uint8_t>& memory, Image<Disparity>& disparity) {
  HWY_DYNAMIC_DISPATCH(match_rows_here)(images, options, first, last, memory, disparity);
}
}  // namespace tread
#endif
