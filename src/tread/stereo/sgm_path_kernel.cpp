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
void above_columns(const SgmOptions&, int, const SgmBlock&, int, int, std::uint8_t*) {}
void finish_rows(const SgmOptions&, int, const SgmBlock&, int, int, int, std::uint8_t*,
                 const MatchOutput&) {}
#else

void begin_above(int width, const SgmOptions& options, std::uint8_t* above) {
  const int padded = padded_range(options.num_disparities);
  std::fill(above, above + above_bytes(width, options.num_disparities), std::uint8_t{255});
  auto* least = reinterpret_cast<AboveLeast*>(above);
  for (int x = 0; x < width; ++x) {
    least[x] = {0, static_cast<std::uint32_t>(options.p2) * 0x01010101U};
    std::uint8_t* path = above + above_begin(width) + x * above_stride(padded);
    std::fill(path, path + padded, std::uint8_t{0});
  }
}

// A pixel's path from `path`, that of the pixel before with its least taken off, to its own costs
// on it, of which the least is yet to be taken off: the least of each lane is returned. Costs go to
// `out`, or are added there.
template <int kVectors, bool kAdd>
HWY_INLINE Bytes step(Bytes* path, int vectors, const std::uint8_t* cost, Bytes p1, Bytes p2,
                      std::uint8_t* out) {
  const Bytes top = Set(U8(), 255);
  Bytes least = top, before = top;
  for (int i = 0; i < vectors; ++i) {
    const Bytes lower = kVectors == 1 ? from_lower(path[i]) : from_lower(path[i], before);
    const Bytes upper = kVectors == 1 ? from_upper(path[i])
                                      : from_upper(path[i], i + 1 < vectors ? path[i + 1] : top);
    const Bytes stay = Min(path[i], p2);
    const Bytes now =
        SaturatedAdd(Load(U8(), cost + i * kLanes), Min(stay, SaturatedAdd(Min(lower, upper), p1)));
    const Bytes sum = kAdd ? Add(now, Load(U8(), out + i * kLanes)) : now;
    Store(sum, U8(), out + i * kLanes);
    least = i == 0 ? now : Min(least, now);
    before = path[i];
    path[i] = now;
  }
  return least;
}

// Takes off each of four paths its least, given that of each lane.
template <int kVectors>
HWY_INLINE void settle_paths(Bytes (*paths)[kVectors], int vectors, const Bytes* lanes) {
  const auto least = BitCast(U32(), least_bytes_of(lanes[0], lanes[1], lanes[2], lanes[3]));
  const auto take_off = [vectors](Bytes* path, Bytes off) HWY_ATTR {
    for (int i = 0; i < vectors; ++i) path[i] = Sub(path[i], off);
  };
  take_off(paths[0], BitCast(U8(), hn::Broadcast<0>(least)));
  take_off(paths[1], BitCast(U8(), hn::Broadcast<1>(least)));
  take_off(paths[2], BitCast(U8(), hn::Broadcast<2>(least)));
  take_off(paths[3], BitCast(U8(), hn::Broadcast<3>(least)));
}

// Both paths of kRows rows, turn by turn: each is one long chain of dependent instructions.
template <int kVectors, int kRows>
HWY_NOINLINE void side_paths(const SgmOptions& options, int width, const SgmBlock& block, int row) {
  static_assert(kRows % 2 == 0);
  constexpr int kPaths = 2 * kRows;
  const int vectors = kVectors > 0 ? kVectors : padded_range(options.num_disparities) / kLanes;
  const std::ptrdiff_t padded = static_cast<std::ptrdiff_t>(vectors) * kLanes;
  constexpr int kStore = kVectors > 0 ? kVectors : kMaxVectors;
  Bytes paths[kPaths][kStore];
  for (auto& path : paths) {
    for (int i = 0; i < vectors; ++i) path[i] = Zero(U8());
  }
  const Bytes p1 = Set(U8(), static_cast<std::uint8_t>(options.p1));
  const Bytes p2 = Set(U8(), static_cast<std::uint8_t>(options.p2));
  const std::ptrdiff_t first = (row - block.first) * block.row_stride;
  // Column x of the path from the left, and as far from the other end of that from the right: the
  // one that comes first leaves its costs, the other one adds its own.
  const auto step_both = [&](int x, auto add_right, auto add_left) HWY_ATTR {
    const std::ptrdiff_t ahead = first + x * padded, back = first + (width - 1 - x) * padded;
    Bytes lanes[kPaths];
    for (int r = 0; r < kRows; ++r) {
      const std::ptrdiff_t at = r * block.row_stride;
      lanes[2 * r] = step<kVectors, decltype(add_right)::value>(
          paths[2 * r], vectors, block.cost + at + ahead, p1, p2, block.sides + at + ahead);
      lanes[2 * r + 1] = step<kVectors, decltype(add_left)::value>(
          paths[2 * r + 1], vectors, block.cost + at + back, p1, p2, block.sides + at + back);
    }
    for (int k = 0; k < kPaths; k += 4) settle_paths<kStore>(paths + k, vectors, lanes + k);
  };
  const int half = width / 2;
  for (int x = 0; x < half; ++x) step_both(x, std::false_type(), std::false_type());
  if (width % 2 != 0) step_both(half, std::false_type(), std::true_type());
  for (int x = width - half; x < width; ++x) step_both(x, std::true_type(), std::true_type());
}

template <int kVectors>
void side_rows_of(const SgmOptions& options, int width, const SgmBlock& block, int begin, int end) {
  constexpr int kRows = kVectors == 1 ? 4 : 2;  // the registers hold so many
  // Behind the last row of the image lie others of the block (kSgmRowsAtOnce), which nobody reads.
  for (int y = begin; y < end; y += kRows) side_paths<kVectors, kRows>(options, width, block, y);
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

// Up to where sums are ambiguous beside the least, given four times: below kSgmNoCost, which stands
// for no disparity.
HWY_INLINE Bytes limits_of(Bytes leasts, hn::Vec<U32> margin_factor) {
  const auto least = And(BitCast(U32(), leasts), Set(U32(), 0xFF));
  const auto limit = Add(least, hn::ShiftRight<16>(Mul(least, margin_factor)));
  return repeat_lowest(BitCast(U8(), Min(limit, Set(U32(), kSgmNoCost - 1))));
}

// The path from above to a pixel, its least not taken off, and the sum of all three, left in
// `sums`. The least of each lane are returned.
struct LaneLeasts {
  // Written out: g++ 12 makes an implicit one without the instruction set, which NEON refuses.
  HWY_INLINE LaneLeasts() {}
  HWY_INLINE LaneLeasts(Bytes of_path, Bytes of_sum) : path(of_path), sum(of_sum) {}
  Bytes path;
  Bytes sum;
};
template <int kVectors>
HWY_INLINE LaneLeasts sum_paths(std::uint8_t* above, int vectors, const AboveLeast& before,
                                const std::uint8_t* cost, const std::uint8_t* sides, int fit,
                                Bytes p1, std::uint8_t* sums) {
  constexpr int kStore = kVectors > 0 ? kVectors : kMaxVectors;
  const Bytes least = BitCast(U8(), Set(U32(), before.least));
  const Bytes larger_step = BitCast(U8(), Set(U32(), before.larger_step));
  Bytes now[kStore];
  LaneLeasts leasts{least, least};
  for (int i = 0; i < vectors; ++i) {
    const std::uint8_t* path = above + i * kLanes;
    const Bytes beside = Min(LoadU(U8(), path - 1), LoadU(U8(), path + 1));
    const Bytes cheapest = Min(Min(Load(U8(), path), larger_step), SaturatedAdd(beside, p1));
    now[i] = SaturatedAdd(Load(U8(), cost + i * kLanes), Sub(cheapest, least));
    Bytes sum = SaturatedAdd(now[i], Load(U8(), sides + i * kLanes));
    if (fit < (i + 1) * kLanes) sum = Or(sum, outside(i, fit));
    Store(sum, U8(), sums + i * kLanes);
    leasts = i == 0 ? LaneLeasts{now[0], sum}
                    : LaneLeasts{Min(leasts.path, now[i]), Min(leasts.sum, sum)};
  }
  for (int i = 0; i < vectors; ++i) Store(now[i], U8(), above + i * kLanes);
  return leasts;
}

// What one look at the sums of a pixel finds.
struct SumScan {
  std::uint64_t equal;  // kBits: lanes that cost the least; else the first of them
  std::uint64_t close;  // kBits: lanes nearly as cheap; else how many there are
  std::uint32_t least;
};

// least, up_to: the least sum and the largest that is close to it, each four times.
template <bool kBits>
HWY_INLINE SumScan scan(const std::uint8_t* sums, int vectors, const std::uint32_t& least,
                        const std::uint32_t& up_to) {
  SumScan found{0, 0, least & 0xFFU};
  const Bytes all = BitCast(U8(), Set(U32(), least));
  const Bytes limit = BitCast(U8(), Set(U32(), up_to));
  for (int i = vectors - 1; i >= 0; --i) {
    const Bytes sum = Load(U8(), sums + i * kLanes);
    const std::uint64_t equal = bits_of(Eq(sum, all));
    const std::uint64_t close = bits_at_most(sum, limit);
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
HWY_INLINE PixelResult settle(const SumScan& found, const std::uint8_t* sums, std::uint32_t limit) {
  const std::uint32_t index =
      kBits ? lowest_bit(found.equal) : static_cast<std::uint32_t>(found.equal);
  const std::uint32_t before = sums[static_cast<std::ptrdiff_t>(index) - 1];
  const std::uint32_t behind = sums[index + 1];
  bool ambiguous = false;
  if constexpr (kBits) {
    const std::uint64_t best = found.equal & (~found.equal + 1);
    ambiguous = (found.close & ~(best | best << 1 | best >> 1)) != 0;
  } else {
    const std::uint64_t own = 1U + (before <= limit ? 1U : 0U) + (behind <= limit ? 1U : 0U);
    ambiguous = found.close != own;
  }
  return {found.least << 16 | index, before | behind << 16 | (ambiguous ? kAmbiguous : 0U)};
}

template <int kVectors>
HWY_NOINLINE void above_columns_of(const SgmOptions& options, int width, const SgmBlock& block,
                                   int begin, int end, std::uint8_t* memory) {
  constexpr int kGroup = 4;
  constexpr std::size_t kWords = hn::MaxLanes(U32());
  const int range = options.num_disparities;
  const int vectors = kVectors > 0 ? kVectors : padded_range(range) / kLanes;
  constexpr bool kBits = kVectors > 0 && kVectors * kLanes <= 64;
  const std::ptrdiff_t padded = static_cast<std::ptrdiff_t>(vectors) * kLanes;
  const std::ptrdiff_t stride = padded + 2 * kLanes;
  std::fill(memory, memory + kSgmPixels * stride, std::uint8_t{kSgmNoCost});
  std::uint8_t* const sums = memory + kLanes;
  HWY_ALIGN std::uint32_t least[kWords], larger_step[kWords];
  HWY_ALIGN std::uint32_t least_sum[kSgmPixels + kWords], up_to[kSgmPixels + kWords];
  const auto margin_factor = Set(U32(), uniqueness_factor(options.uniqueness_percent));
  const Bytes p1 = Set(U8(), static_cast<std::uint8_t>(options.p1));
  const Bytes p2 = Set(U8(), static_cast<std::uint8_t>(options.p2));
  auto* const above_least = reinterpret_cast<AboveLeast*>(block.above);
  std::uint8_t* const above = block.above + above_begin(width);
  for (int y = block.first; y < block.last; ++y) {
    const std::ptrdiff_t row = (y - block.first) * block.row_stride;
    auto* pixels =
        reinterpret_cast<PixelResult*>(block.pixels + (y - block.first) * block.pixel_stride);
    for (int first = begin; first < end; first += kSgmPixels) {
      const int count = std::min(kSgmPixels, end - first);
      for (int group = 0; group < count; group += kGroup) {
        LaneLeasts lanes[kGroup];
        const auto sum_pixel = [&](int i) HWY_ATTR {
          const int x = first + i;
          const std::ptrdiff_t at = row + x * padded;
          // At least one, so that the sums of the first columns have a least, which nobody asks
          // for.
          const int fit = std::clamp(x - options.min_disparity_px + 1, 1, range);
          return sum_paths<kVectors>(above + x * above_stride(static_cast<int>(padded)), vectors,
                                     above_least[x], block.cost + at, block.sides + at, fit, p1,
                                     sums + i * stride);
        };
        lanes[0] = sum_pixel(group);
        for (int i = 1; i < kGroup; ++i) {
          lanes[i] = group + i < count ? sum_pixel(group + i) : lanes[0];
        }
        const Bytes path =
            least_bytes_of(lanes[0].path, lanes[1].path, lanes[2].path, lanes[3].path);
        const Bytes sum = least_bytes_of(lanes[0].sum, lanes[1].sum, lanes[2].sum, lanes[3].sum);
        StoreU(BitCast(U32(), sum), U32(), least_sum + group);
        StoreU(BitCast(U32(), limits_of(sum, margin_factor)), U32(), up_to + group);
        Store(BitCast(U32(), path), U32(), least);
        Store(BitCast(U32(), SaturatedAdd(path, p2)), U32(), larger_step);
        for (int i = 0; i < kGroup && group + i < count; ++i) {
          above_least[first + group + i] = {least[i], larger_step[i]};
        }
      }
      SumScan scans[kSgmPixels];
      for (int i = 0; i < count; ++i) {
        scans[i] = scan<kBits>(sums + i * stride, vectors, least_sum[i], up_to[i]);
      }
      for (int i = 0; i < count; ++i) {
        pixels[first + i] = settle<kBits>(scans[i], sums + i * stride, up_to[i] & 0xFFU);
      }
    }
  }
}

void above_columns(const SgmOptions& options, int width, const SgmBlock& block, int begin, int end,
                   std::uint8_t* memory) {
  switch (padded_range(options.num_disparities) / kLanes) {
    case 1:
      return above_columns_of<1>(options, width, block, begin, end, memory);
    case 2:
      return above_columns_of<2>(options, width, block, begin, end, memory);
    case 4:
      return above_columns_of<4>(options, width, block, begin, end, memory);
    default:
      return above_columns_of<0>(options, width, block, begin, end, memory);
  }
}

void finish_rows(const SgmOptions& options, int width, const SgmBlock& block, int no_cost,
                 int begin, int end, std::uint8_t* memory, const MatchOutput& output) {
  auto* owners = reinterpret_cast<std::uint32_t*>(memory);
  RefineJob job;
  job.begin = std::min(options.min_disparity_px, width);
  job.width = width;
  job.no_cost = no_cost;
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
void sgm_above_columns(const SgmOptions& options, int width, const SgmBlock& block, int begin,
                       int end, std::uint8_t* memory) {
  HWY_DYNAMIC_DISPATCH(above_columns)(options, width, block, begin, end, memory);
}
void sgm_finish_rows(const SgmOptions& options, int width, const SgmBlock& block, int no_cost,
                     int begin, int end, std::uint8_t* memory, const MatchOutput& output) {
  HWY_DYNAMIC_DISPATCH(finish_rows)(options, width, block, no_cost, begin, end, memory, output);
}
}  // namespace tread
#endif
