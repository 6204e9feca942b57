// Semi-global matching with four or eight paths: the paths down, kept for all of the image, then
// those up with the choice of the winner.
#include <algorithm>
#include <cstddef>

#include "tread/stereo/sad_kernel.hpp"
#include "tread/stereo/sgm_kernel.hpp"

// This file is compiled once for every instruction set; what is outside `#if HWY_ONCE` lies in a
// name space of that set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tread/stereo/sgm_full_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "tread/stereo/sgm-inl.hpp"
#include "tread/stereo/winners-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace tread::HWY_NAMESPACE {
namespace {

#if HWY_TARGET == HWY_SCALAR || HWY_TARGET == HWY_EMU128  // SgmMatcher uses the plain form there
std::size_t front_bytes(int, int) {
  return 0;
}
void begin_front(int, const SgmOptions&, std::uint8_t*) {}
void front_row(const SgmOptions&, int, const SgmFront&, int, int) {}
void full_winners(const SgmOptions&, const SgmSums&, int, int, std::uint8_t*, std::uint64_t*) {}
#else

// A front holds a row of one or three paths, each with its least taken off: for each, a column
// before the first, those of the image and one behind the last; each between vectors of 255.
inline std::ptrdiff_t path_bytes(int width, int padded) {
  return above_stride(padded) * (width + 2);
}

std::size_t front_bytes(int width, int num_disparities) {
  return static_cast<std::size_t>(3 * path_bytes(width, padded_range(num_disparities)) + kLanes);
}

void begin_front(int width, const SgmOptions& options, std::uint8_t* front) {
  const int padded = padded_range(options.num_disparities);
  std::fill(front, front + front_bytes(width, options.num_disparities), std::uint8_t{255});
  for (int i = 0; i < 3 * (width + 2); ++i) {
    std::uint8_t* path = front + kLanes + i * above_stride(padded);
    std::fill(path, path + padded, std::uint8_t{0});
  }
}

// One pixel of a path: its costs are added to `sum` and, the least taken off, left in `to`.
HWY_INLINE void follow(const std::uint8_t* from, int vectors, const std::uint8_t* cost, Bytes p1,
                       Bytes p2, std::uint8_t* to, Bytes* sum) {
  Bytes least = Set(U8(), 255);
  for (int i = 0; i < vectors; ++i) {
    const std::uint8_t* path = from + i * kLanes;
    const Bytes beside = Min(LoadU(U8(), path - 1), LoadU(U8(), path + 1));
    const Bytes cheapest = Min(Min(Load(U8(), path), p2), SaturatedAdd(beside, p1));
    const Bytes now = SaturatedAdd(Load(U8(), cost + i * kLanes), cheapest);
    Store(now, U8(), to + i * kLanes);
    sum[i] = SaturatedAdd(sum[i], now);
    least = Min(least, now);
  }
  least = spread_byte(least_byte_of(U8(), least));
  for (int i = 0; i < vectors; ++i) {
    Store(Sub(Load(U8(), to + i * kLanes), least), U8(), to + i * kLanes);
  }
}

template <int kVectors>
HWY_NOINLINE void front_row_of(const SgmOptions& options, int width, const SgmFront& front,
                               int begin, int end) {
  const int vectors = kVectors > 0 ? kVectors : padded_range(options.num_disparities) / kLanes;
  const int padded = vectors * kLanes;
  const std::ptrdiff_t stride = above_stride(padded);
  const Bytes p1 = Set(U8(), static_cast<std::uint8_t>(options.p1));
  const Bytes p2 = Set(U8(), static_cast<std::uint8_t>(options.p2));
  for (int x = begin; x < end; ++x) {
    Bytes sum[kVectors > 0 ? kVectors : kMaxVectors];
    for (int i = 0; i < vectors; ++i) sum[i] = Zero(U8());
    const std::uint8_t* cost = front.cost + static_cast<std::ptrdiff_t>(x) * padded;
    for (int path = 0; path < front.paths; ++path) {
      const std::ptrdiff_t at = kLanes + path * path_bytes(width, padded) + (x + 1) * stride;
      constexpr int kFrom[] = {0, -1, 1};  // the column that a path comes from
      follow(front.before + at + kFrom[path] * stride, vectors, cost, p1, p2, front.here + at, sum);
    }
    for (int i = 0; i < vectors; ++i) {
      Store(sum[i], U8(), front.sum + static_cast<std::ptrdiff_t>(x) * padded + i * kLanes);
    }
  }
}

void front_row(const SgmOptions& options, int width, const SgmFront& front, int begin, int end) {
  switch (padded_range(options.num_disparities) / kLanes) {
    case 1:
      return front_row_of<1>(options, width, front, begin, end);
    case 2:
      return front_row_of<2>(options, width, front, begin, end);
    case 4:
      return front_row_of<4>(options, width, front, begin, end);
    default:
      return front_row_of<0>(options, width, front, begin, end);
  }
}

void full_winners(const SgmOptions& options, const SgmSums& sums, int begin, int end,
                  std::uint8_t* memory, std::uint64_t* results) {
  const int range = options.num_disparities, padded = padded_range(range);
  Arena arena{memory};
  auto* total = arena.take<std::int16_t>(static_cast<std::size_t>(padded));
  auto* lane = arena.take<std::int16_t>(static_cast<std::size_t>(padded));
  for (int d = 0; d < padded; ++d) lane[widened_place(d)] = static_cast<std::int16_t>(d);
  auto* pixels = reinterpret_cast<PixelResult*>(results);
  const std::uint32_t factor = uniqueness_factor(options.uniqueness_percent);
  constexpr int kWords = kLanes / 2;
  for (int x = begin; x < end; ++x) {
    const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(x) * padded;
    // At least one, so that the sums of the first columns have a least, which nobody asks for.
    const int fit = std::clamp(x - options.min_disparity_px + 1, 1, range);
    const Words limit_lane = Set(I16(), static_cast<std::int16_t>(fit));
    const Words none = Set(I16(), kSgmNoWideCost);
    Words least_lanes = none;
    const auto add_up = [&](auto widen, int d) HWY_ATTR {
      const Words sum = Add(Add(widen(Load(U8(), sums.down + at + d / kLanes * kLanes)),
                                widen(Load(U8(), sums.up + at + d / kLanes * kLanes))),
                            widen(Load(U8(), sums.sides + at + d / kLanes * kLanes)));
      const Words masked = IfThenElse(Lt(Load(I16(), lane + d), limit_lane), sum, none);
      Store(masked, I16(), total + d);
      least_lanes = Min(least_lanes, masked);
    };
    for (int d = 0; d < padded; d += kLanes) {
      add_up([](Bytes v) HWY_ATTR { return widen_lower(v); }, d);
      add_up([](Bytes v) HWY_ATTR { return widen_upper(v); }, d + kWords);
    }
    const auto least = static_cast<std::uint32_t>(GetLane(least_of(I16(), least_lanes)));
    const std::uint32_t limit =
        std::min<std::uint32_t>(least + (least * factor >> 16), kSgmNoWideCost - 1);
    const Words all = Set(I16(), static_cast<std::int16_t>(least));
    const Words top = Set(I16(), static_cast<std::int16_t>(limit));
    Words first = Set(I16(), kSgmNoWideCost);
    std::size_t close = 0;
    for (int d = 0; d < padded; d += kWords) {
      const Words sum = Load(I16(), total + d);
      first = Min(first, IfThenElse(Eq(sum, all), Load(I16(), lane + d), first));
      close += CountTrue(I16(), Eq(Min(sum, top), sum));
    }
    const int index = GetLane(least_of(I16(), first));
    const auto neighbour = [&](int d) {
      return d < 0 || d >= fit ? std::uint32_t{kSgmNoWideCost}
                               : static_cast<std::uint32_t>(total[widened_place(d)]);
    };
    const std::uint32_t before = neighbour(index - 1), behind = neighbour(index + 1);
    const std::size_t own = 1U + (before <= limit ? 1U : 0U) + (behind <= limit ? 1U : 0U);
    pixels[x] = {least << 16 | static_cast<std::uint32_t>(index),
                 before | behind << 16 | (close != own ? kAmbiguous : 0U)};
  }
}
#endif

}  // namespace
}  // namespace tread::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tread {
HWY_EXPORT(front_bytes);
HWY_EXPORT(begin_front);
HWY_EXPORT(front_row);
HWY_EXPORT(full_winners);

std::size_t sgm_front_bytes(int width, int num_disparities) {
  return HWY_DYNAMIC_DISPATCH(front_bytes)(width, num_disparities);
}
void sgm_begin_front(int width, const SgmOptions& options, std::uint8_t* front) {
  HWY_DYNAMIC_DISPATCH(begin_front)(width, options, front);
}
void sgm_front_row(const SgmOptions& options, int width, const SgmFront& front, int begin,
                   int end) {
  HWY_DYNAMIC_DISPATCH(front_row)(options, width, front, begin, end);
}
void sgm_full_winners(const SgmOptions& options, const SgmSums& sums, int begin, int end,
                      std::uint8_t* memory, std::uint64_t* pixels) {
  HWY_DYNAMIC_DISPATCH(full_winners)(options, sums, begin, end, memory, pixels);
}
}  // namespace tread
#endif
