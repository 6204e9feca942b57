// The second half of the semi-global kernel: paths along rows and columns, and the winners.
#include <algorithm>
#include <cstddef>
#include <type_traits>

#include "tread/stereo/sad_kernel.hpp"
#include "tread/stereo/sgm_kernel.hpp"

// This file is compiled once for every instruction set; what is outside `#if HWY_ONCE` lies in a
// name space of that set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tread/stereo/sgm_path_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "tread/stereo/sgm-inl.hpp"
#include "tread/stereo/winners-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace tread::HWY_NAMESPACE {
namespace {

#if HWY_TARGET == HWY_SCALAR || HWY_TARGET == HWY_EMU128  // SgmMatcher uses the plain form there
int padded_range(int) {
  return 0;
}
std::size_t above_bytes(int, int) {
  return 0;
}
std::size_t worker_bytes(int, int) {
  return 0;
}
void begin_above(int, const SgmOptions&, std::uint8_t*) {}
void side_rows(const SgmOptions&, int, const SgmBlock&, int, int) {}
void above_columns(const SgmOptions&, const SgmBlock&, int, int, std::uint8_t*) {}
void finish_rows(const SgmOptions&, int, const SgmBlock&, int, int, std::uint8_t*,
                 const MatchOutput&) {}
#else

void begin_above(int width, const SgmOptions& options, std::uint8_t* above) {
  const int padded = padded_range(options.num_disparities);
  std::fill(above, above + above_bytes(width, options.num_disparities), std::uint8_t{255});
  for (int x = 0; x < width; ++x) {
    std::uint8_t* path = above + kLanes + x * above_stride(padded);
    std::fill(path, path + padded, std::uint8_t{0});
  }
}

// A pixel's path from `path`, that of the pixel before with its least taken off, to its own costs
// on it; `path` becomes that with its least taken off. Costs go to `out`, or are added there.
template <int kVectors, bool kAdd>
HWY_INLINE void step(Bytes* path, int vectors, const std::uint8_t* cost, Bytes p1, Bytes p2,
                     std::uint8_t* out) {
  const Bytes top = Set(U8(), 255);
  Bytes now[kVectors > 0 ? kVectors : kMaxVectors];
  for (int i = 0; i < vectors; ++i) {
    const Bytes lower = from_lower(path[i], i > 0 ? path[i - 1] : top);
    const Bytes upper = from_upper(path[i], i + 1 < vectors ? path[i + 1] : top);
    const Bytes stay = Min(path[i], p2);
    now[i] =
        SaturatedAdd(Load(U8(), cost + i * kLanes), Min(stay, SaturatedAdd(Min(lower, upper), p1)));
    const Bytes sum = kAdd ? Add(now[i], Load(U8(), out + i * kLanes)) : now[i];
    Store(sum, U8(), out + i * kLanes);
  }
  Bytes least = top;
  for (int i = 0; i < vectors; ++i) least = Min(least, now[i]);
  least = spread_byte(least_byte_of(U8(), least));
  for (int i = 0; i < vectors; ++i) path[i] = Sub(now[i], least);
}

// Both paths of kRows rows, turn by turn: each is one long chain of dependent instructions.
template <int kVectors, int kRows>
HWY_NOINLINE void side_paths(const SgmOptions& options, int width, const SgmBlock& block, int row) {
  const int vectors = kVectors > 0 ? kVectors : padded_range(options.num_disparities) / kLanes;
  const std::ptrdiff_t padded = static_cast<std::ptrdiff_t>(vectors) * kLanes;
  constexpr int kStore = kVectors > 0 ? kVectors : kMaxVectors;
  Bytes right[kRows][kStore], left[kRows][kStore];
  for (int r = 0; r < kRows; ++r) {
    for (int i = 0; i < vectors; ++i) right[r][i] = left[r][i] = Zero(U8());
  }
  const Bytes p1 = Set(U8(), static_cast<std::uint8_t>(options.p1));
  const Bytes p2 = Set(U8(), static_cast<std::uint8_t>(options.p2));
  const std::ptrdiff_t first = (row - block.first) * block.row_stride;
  // Column x of the path from the left, and as far from the other end of that from the right: the
  // one that comes first leaves its costs, the other one adds its own.
  const auto step_both = [&](int x, auto add_right, auto add_left) HWY_ATTR {
    const std::ptrdiff_t ahead = first + x * padded, back = first + (width - 1 - x) * padded;
    for (int r = 0; r < kRows; ++r) {
      const std::ptrdiff_t at = r * block.row_stride;
      step<kVectors, decltype(add_right)::value>(right[r], vectors, block.cost + at + ahead, p1, p2,
                                                 block.sides + at + ahead);
      step<kVectors, decltype(add_left)::value>(left[r], vectors, block.cost + at + back, p1, p2,
                                                block.sides + at + back);
    }
  };
  const int half = width / 2;
  for (int x = 0; x < half; ++x) step_both(x, std::false_type(), std::false_type());
  if (width % 2 != 0) step_both(half, std::false_type(), std::true_type());
  for (int x = width - half; x < width; ++x) step_both(x, std::true_type(), std::true_type());
}

template <int kVectors>
void side_rows_of(const SgmOptions& options, int width, const SgmBlock& block, int begin, int end) {
  int y = begin;
  for (; y + 2 <= end; y += 2) side_paths<kVectors, 2>(options, width, block, y);
  if (y < end) side_paths<kVectors, 1>(options, width, block, y);
}

void side_rows(const SgmOptions& options, int width, const SgmBlock& block, int begin, int end) {
  switch (padded_range(options.num_disparities) / kLanes) {
    case 1:
      return side_rows_of<1>(options, width, block, begin, end);
    case 2:
      return side_rows_of<2>(options, width, block, begin, end);
    case 4:
      return side_rows_of<4>(options, width, block, begin, end);
    default:
      return side_rows_of<0>(options, width, block, begin, end);
  }
}

// Up to where a sum is ambiguous beside the least: below kSgmNoCost, which stands for no disparity.
HWY_INLINE std::uint32_t limit_of(std::uint32_t least, std::uint32_t margin_factor) {
  return std::min<std::uint32_t>(least + (least * margin_factor >> 16), kSgmNoCost - 1);
}

// What one look at the sums of a pixel finds.
struct SumScan {
  std::uint64_t equal;  // kBits: lanes that cost the least; else the first of them
  std::uint64_t close;  // kBits: lanes nearly as cheap; else how many there are
  std::uint32_t least;
};

// The path from above to a pixel, and the sum of all three, left in `sums`.
template <int kVectors, bool kBits>
HWY_INLINE SumScan sum_paths(std::uint8_t* above, int vectors, const std::uint8_t* cost,
                             const std::uint8_t* sides, int fit, std::uint32_t margin_factor,
                             Bytes p1, Bytes p2, std::uint8_t* sums) {
  constexpr int kStore = kVectors > 0 ? kVectors : kMaxVectors;
  Bytes now[kStore], sum[kStore];
  for (int i = 0; i < vectors; ++i) {
    const std::uint8_t* path = above + i * kLanes;
    const Bytes beside = Min(LoadU(U8(), path - 1), LoadU(U8(), path + 1));
    const Bytes stay = Min(Load(U8(), path), p2);
    now[i] = SaturatedAdd(Load(U8(), cost + i * kLanes), Min(stay, SaturatedAdd(beside, p1)));
    sum[i] = SaturatedAdd(now[i], Load(U8(), sides + i * kLanes));
    if (fit < (i + 1) * kLanes) sum[i] = Or(sum[i], outside(i, fit));
    Store(sum[i], U8(), sums + i * kLanes);
  }
  Bytes least = Set(U8(), 255), cheapest = least;
  for (int i = 0; i < vectors; ++i) {
    least = Min(least, now[i]);
    cheapest = Min(cheapest, sum[i]);
  }
  least = spread_byte(least_byte_of(U8(), least));
  for (int i = 0; i < vectors; ++i) Store(Sub(now[i], least), U8(), above + i * kLanes);

  const auto lane = least_byte_of(U8(), cheapest);
  const Bytes all = spread_byte(lane);
  SumScan found{0, 0, static_cast<std::uint32_t>(GetLane(lane))};
  const Bytes limit =
      Set(U8(), static_cast<std::uint8_t>(limit_of(found.least, margin_factor) - found.least));
  for (int i = vectors - 1; i >= 0; --i) {
    const Bytes excess = Sub(sum[i], all);
    const std::uint64_t equal = bits_of(Eq(excess, Zero(U8())));
    const std::uint64_t close = bits_at_most(excess, limit);
    if constexpr (kBits) {
      found.equal |= equal << (i * kLanes);
      found.close |= close << (i * kLanes);
    } else {
      if (equal != 0) found.equal = static_cast<std::uint64_t>(i * kLanes) + lowest_bit(equal);
      found.close += hwy::PopCount(close);
    }
  }
  return found;
}

template <bool kBits>
HWY_INLINE PixelResult settle(const SumScan& found, const std::uint8_t* sums,
                              std::uint32_t margin_factor) {
  const std::uint32_t index =
      kBits ? lowest_bit(found.equal) : static_cast<std::uint32_t>(found.equal);
  const std::uint32_t before = sums[static_cast<std::ptrdiff_t>(index) - 1];
  const std::uint32_t behind = sums[index + 1];
  bool ambiguous = false;
  if constexpr (kBits) {
    const std::uint64_t best = found.equal & (~found.equal + 1);
    ambiguous = (found.close & ~(best | best << 1 | best >> 1)) != 0;
  } else {
    const std::uint32_t limit = limit_of(found.least, margin_factor);
    const std::uint64_t own = 1U + (before <= limit ? 1U : 0U) + (behind <= limit ? 1U : 0U);
    ambiguous = found.close != own;
  }
  return {found.least << 16 | index, before | behind << 16 | (ambiguous ? kAmbiguous : 0U)};
}

template <int kVectors>
HWY_NOINLINE void above_columns_of(const SgmOptions& options, const SgmBlock& block, int begin,
                                   int end, std::uint8_t* memory) {
  const int range = options.num_disparities;
  const int vectors = kVectors > 0 ? kVectors : padded_range(range) / kLanes;
  constexpr bool kBits = kVectors > 0 && kVectors * kLanes <= 64;
  const std::ptrdiff_t padded = static_cast<std::ptrdiff_t>(vectors) * kLanes;
  const std::ptrdiff_t stride = padded + 2 * kLanes;
  std::fill(memory, memory + kSgmPixels * stride, std::uint8_t{kSgmNoCost});
  const std::uint32_t factor = uniqueness_factor(options.uniqueness_percent);
  const Bytes p1 = Set(U8(), static_cast<std::uint8_t>(options.p1));
  const Bytes p2 = Set(U8(), static_cast<std::uint8_t>(options.p2));
  for (int y = block.first; y < block.last; ++y) {
    const std::ptrdiff_t row = (y - block.first) * block.row_stride;
    auto* pixels =
        reinterpret_cast<PixelResult*>(block.pixels + (y - block.first) * block.pixel_stride);
    SumScan scans[kSgmPixels];
    for (int first = begin; first < end; first += kSgmPixels) {
      const int count = std::min(kSgmPixels, end - first);
      std::uint8_t* sums = memory + kLanes;
      for (int i = 0; i < count; ++i, sums += stride) {
        const int x = first + i;
        const std::ptrdiff_t at = row + x * padded;
        // At least one, so that the sums of the first columns have a least, which nobody asks for.
        const int fit = std::clamp(x - options.min_disparity_px + 1, 1, range);
        scans[i] = sum_paths<kVectors, kBits>(block.above + kLanes + x * (padded + kLanes), vectors,
                                              block.cost + at, block.sides + at, fit, factor, p1,
                                              p2, sums);
      }
      sums = memory + kLanes;
      for (int i = 0; i < count; ++i, sums += stride) {
        pixels[first + i] = settle<kBits>(scans[i], sums, factor);
      }
    }
  }
}

void above_columns(const SgmOptions& options, const SgmBlock& block, int begin, int end,
                   std::uint8_t* memory) {
  switch (padded_range(options.num_disparities) / kLanes) {
    case 1:
      return above_columns_of<1>(options, block, begin, end, memory);
    case 2:
      return above_columns_of<2>(options, block, begin, end, memory);
    case 4:
      return above_columns_of<4>(options, block, begin, end, memory);
    default:
      return above_columns_of<0>(options, block, begin, end, memory);
  }
}

void finish_rows(const SgmOptions& options, int width, const SgmBlock& block, int begin, int end,
                 std::uint8_t* memory, const MatchOutput& output) {
  auto* owners = reinterpret_cast<std::uint32_t*>(memory);
  RefineJob job;
  job.begin = std::min(options.min_disparity_px, width);
  job.width = width;
  job.no_cost = kSgmNoCost;
  job.min_disparity_px = options.min_disparity_px;
  job.sub_pixel = options.sub_pixel;
  job.strict_sub_pixel = options.strict_sub_pixel;
  job.check_unique = options.uniqueness_percent > 0;
  job.left_right_tolerance_px = options.left_right_tolerance_px;
  for (int y = begin; y < end; ++y) {
    const auto* pixels =
        reinterpret_cast<const PixelResult*>(block.pixels + (y - block.first) * block.pixel_stride);
    std::fill(owners, owners + width, ~std::uint32_t{0});
    for (int x = job.begin; x < width; ++x) {
      claim(owners + x - job.min_disparity_px, pixels[x].winner);
    }
    Disparity* out = output.disparity.row(y);
    std::fill(out, out + job.begin, kNoMatch);
    std::uint8_t* residual = output.residual.empty() ? nullptr : output.residual.row(y);
    if (residual != nullptr) std::fill(residual, residual + job.begin, kNoResidual);
    refine(pixels, owners, job, out, residual);
  }
}
#endif

}  // namespace
}  // namespace tread::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tread {
HWY_EXPORT(padded_range);
HWY_EXPORT(above_bytes);
HWY_EXPORT(worker_bytes);
HWY_EXPORT(begin_above);
HWY_EXPORT(side_rows);
HWY_EXPORT(above_columns);
HWY_EXPORT(finish_rows);

int sgm_padded_range(int num_disparities) {
  return HWY_DYNAMIC_DISPATCH(padded_range)(num_disparities);
}
std::size_t sgm_above_bytes(int width, int num_disparities) {
  return HWY_DYNAMIC_DISPATCH(above_bytes)(width, num_disparities);
}
std::size_t sgm_worker_bytes(int width, int num_disparities) {
  return HWY_DYNAMIC_DISPATCH(worker_bytes)(width, num_disparities);
}
void sgm_begin(int width, const SgmOptions& options, std::uint8_t* above) {
  HWY_DYNAMIC_DISPATCH(begin_above)(width, options, above);
}
void sgm_side_rows(const SgmOptions& options, int width, const SgmBlock& block, int begin,
                   int end) {
  HWY_DYNAMIC_DISPATCH(side_rows)(options, width, block, begin, end);
}
void sgm_above_columns(const SgmOptions& options, const SgmBlock& block, int begin, int end,
                       std::uint8_t* memory) {
  HWY_DYNAMIC_DISPATCH(above_columns)(options, block, begin, end, memory);
}
void sgm_finish_rows(const SgmOptions& options, int width, const SgmBlock& block, int begin,
                     int end, std::uint8_t* memory, const MatchOutput& output) {
  HWY_DYNAMIC_DISPATCH(finish_rows)(options, width, block, begin, end, memory, output);
}
}  // namespace tread
#endif
