#include "tread/stereo/filter_kernel.hpp"

#include <algorithm>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tread/stereo/filter_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tread::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using U16 = hn::ScalableTag<std::uint16_t>;
using I16 = hn::ScalableTag<std::int16_t>;
using HalfU8 = hn::Rebind<std::uint8_t, U16>;

std::uint8_t edge_of(int response, int limit) {
  return static_cast<std::uint8_t>(128 + std::clamp(response, -limit, std::min(limit, 127)));
}

// above + 2 here + below of columns first to last - 1.
void smooth_columns(const std::uint8_t* above, const std::uint8_t* here, const std::uint8_t* below,
                    int first, int last, std::uint16_t* sums) {
  const U16 u16;
  const HalfU8 u8;
  const int lanes = static_cast<int>(hn::Lanes(u16));
  int x = first;
  for (; x + lanes <= last; x += lanes) {
    const auto a = hn::PromoteTo(u16, hn::LoadU(u8, above + x));
    const auto h = hn::PromoteTo(u16, hn::LoadU(u8, here + x));
    const auto b = hn::PromoteTo(u16, hn::LoadU(u8, below + x));
    hn::StoreU(hn::Add(hn::Add(a, b), hn::Add(h, h)), u16, sums + (x - first));
  }
  for (; x < last; ++x) {
    sums[x - first] = static_cast<std::uint16_t>(above[x] + 2 * here[x] + below[x]);
  }
}

void gradient_row_here(const std::uint8_t* above, const std::uint8_t* here,
                       const std::uint8_t* below, int width, int limit, std::uint8_t* out) {
  const I16 i16;
  const HalfU8 u8;
  const int lanes = static_cast<int>(hn::Lanes(i16));
  const auto lowest = hn::Set(i16, static_cast<std::int16_t>(-limit));
  const auto highest = hn::Set(i16, static_cast<std::int16_t>(std::min(limit, 127)));
  const auto middle = hn::Set(i16, 128);
  constexpr int kTile = 1024;  // columns at a time, so that their sums need no heap
  HWY_ALIGN std::uint16_t sums[kTile + 2];
  for (int tile = 0; tile < width; tile += kTile) {
    // sums[1 + i] belongs to column tile + i; one more on both sides.
    const int end = std::min(tile + kTile, width);
    const int first = std::max(tile - 1, 0), last = std::min(end + 1, width);
    smooth_columns(above, here, below, first, last, sums + 1 + (first - tile));
    if (tile == 0) sums[0] = sums[1];
    if (end == width) sums[1 + (end - tile)] = sums[end - tile];
    int x = tile;
    for (; x + lanes <= end; x += lanes) {
      const auto left = hn::BitCast(i16, hn::LoadU(U16(), sums + (x - tile)));
      const auto right = hn::BitCast(i16, hn::LoadU(U16(), sums + (x - tile) + 2));
      const auto response = hn::Min(hn::Max(hn::Sub(right, left), lowest), highest);
      hn::StoreU(hn::DemoteTo(u8, hn::Add(response, middle)), u8, out + x);
    }
    for (; x < end; ++x) out[x] = edge_of(sums[x - tile + 2] - sums[x - tile], limit);
  }
}

template <class V>
HWY_INLINE void sort_two(V& a, V& b) {
  const V less = hn::Min(a, b);
  b = hn::Max(a, b);
  a = less;
}

// The eight neighbours are sorted by Batcher's network; the unknown ones, being the largest, come
// last.
void fill_holes_here(const Neighbourhoods& around, const MedianRule& rule, Disparity* filled) {
  const U16 d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto hole = hn::Set(d, kNoMatch);
  const auto most = hn::Set(d, static_cast<Disparity>(rule.max_spread));
  for (int x = 0; x < Neighbourhoods::kMost; x += lanes) {
    hn::Vec<U16> v[8];
    for (int i = 0; i < 8; ++i) v[i] = hn::Load(d, around.values[i] + x);
    constexpr int kNetwork[19][2] = {{0, 1}, {2, 3}, {4, 5}, {6, 7}, {0, 2}, {1, 3}, {4, 6},
                                     {5, 7}, {1, 2}, {5, 6}, {0, 4}, {1, 5}, {2, 6}, {3, 7},
                                     {2, 4}, {3, 5}, {1, 2}, {3, 4}, {5, 6}};
    for (const auto& [a, b] : kNetwork) sort_two(v[a], v[b]);
    auto median = v[4];  // of nine the fifth
    if (!rule.of_all) {  // of n known ones number n / 2
      median = v[0];
      for (int n = 2; n <= 8; n += 2) {
        median = hn::IfThenElse(hn::Eq(v[n - 1], hole), median, v[n / 2]);
      }
    }
    auto last = v[0];
    for (int n = 1; n < 8; ++n) last = hn::IfThenElse(hn::Eq(v[n], hole), last, v[n]);
    const auto spread = hn::Sub(last, v[0]);
    median = hn::IfThenElse(hn::Eq(v[rule.min_known - 1], hole), hole, median);
    median = hn::IfThenElse(hn::Eq(hn::Min(spread, most), spread), median, hole);
    hn::StoreU(median, d, filled + x);
  }
}

template <class D>
HWY_INLINE void steady_at(D d, const Disparity* now, const Disparity* seen, Disparity* result,
                          const TemporalRule& rule) {
  const hn::RebindToSigned<D> i16;
  const auto hole = hn::Set(d, kNoMatch);
  const auto most = hn::Set(d, rule.max_change);
  const auto here = hn::LoadU(d, now), before = hn::LoadU(d, seen), old = hn::LoadU(d, result);
  // A hole is at least a pixel above every disparity, but max_change may be more than that.
  const auto near = [&](auto other) HWY_ATTR {
    const auto apart = hn::Sub(hn::Max(here, other), hn::Min(here, other));
    return hn::And(hn::Ne(other, hole), hn::Eq(hn::Min(apart, most), apart));
  };
  const auto step = hn::BitCast(i16, hn::Sub(old, here));
  const auto memory = hn::Set(i16, static_cast<std::int16_t>(rule.memory));
  const auto moved =
      hn::ShiftRight<4>(hn::Add(hn::Mul(step, memory), hn::Set(i16, std::int16_t{8})));
  auto out = hn::Add(here, hn::IfThenElseZero(near(old), hn::BitCast(d, moved)));
  if (rule.confirm) out = hn::IfThenElse(near(before), out, hole);
  hn::StoreU(hn::IfThenElse(hn::Eq(here, hole), hole, out), d, result);
}

void steady_row_here(const Disparity* now, const Disparity* seen, Disparity* result, int width,
                     const TemporalRule& rule) {
  const U16 u16;
  const int lanes = static_cast<int>(hn::Lanes(u16));
  int x = 0;
  for (; x + lanes <= width; x += lanes) steady_at(u16, now + x, seen + x, result + x, rule);
  for (; x < width; ++x) {
    steady_at(hn::CappedTag<std::uint16_t, 1>(), now + x, seen + x, result + x, rule);
  }
}

// One bit a lane, beginning at bit 0.
template <class D, class M>
HWY_INLINE std::uint64_t bits_of(D d, M mask) {
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(d, mask, bytes);
  std::uint64_t bits = 0;
  std::memcpy(&bits, bytes, sizeof(bits));
  return bits;
}

void known_row_here(const Disparity* row, int width, std::uint64_t* known) {
  const U16 d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto hole = hn::Set(d, kNoMatch);
  HWY_ALIGN Disparity last[64];
  for (int first = 0; first < width; first += 64) {
    const Disparity* from = row + first;
    if (width - first < 64) {
      std::fill(std::copy(from, row + width, last), last + 64, kNoMatch);
      from = last;
    }
    std::uint64_t bits = 0;
    for (int x = 0; x < 64; x += lanes) {
      bits |= bits_of(d, hn::Ne(hn::LoadU(d, from + x), hole)) << x;
    }
    known[first / 64] = bits;
  }
}

void link_row_here(const Disparity* above, const Disparity* here, int width, int limit,
                   std::uint64_t* known, std::uint64_t* joined_left, std::uint64_t* joined_above) {
  const U16 u16;
  const int lanes = static_cast<int>(hn::Lanes(u16));
  const auto hole = hn::Set(u16, kNoMatch);
  const auto most = hn::Set(u16, static_cast<std::uint16_t>(limit));
  const auto near = [&](auto a, auto b) HWY_ATTR {
    const auto difference = hn::Sub(hn::Max(a, b), hn::Min(a, b));
    return hn::AndNot(
        hn::Or(hn::VecFromMask(u16, hn::Eq(a, hole)), hn::VecFromMask(u16, hn::Eq(b, hole))),
        hn::VecFromMask(u16, hn::Eq(hn::Min(difference, most), difference)));
  };
  // The ends of the row, with holes around them.
  HWY_ALIGN Disparity here_padded[1 + 64], above_padded[64];
  for (int first = 0; first < width; first += 64) {
    const int count = std::min(64, width - first);
    const Disparity* from = here + first;
    const Disparity* up = above == nullptr ? nullptr : above + first;
    if (first == 0 || count < 64) {
      here_padded[0] = first > 0 ? here[first - 1] : kNoMatch;
      std::fill(std::copy(from, from + count, here_padded + 1), here_padded + 65, kNoMatch);
      from = here_padded + 1;
    }
    if (up != nullptr && count < 64) {
      std::fill(std::copy(up, up + count, above_padded), above_padded + 64, kNoMatch);
      up = above_padded;
    }
    std::uint64_t k = 0, l = 0, a = 0;
    for (int x = 0; x < 64; x += lanes) {
      const auto now = hn::LoadU(u16, from + x);
      k |= bits_of(u16, hn::Ne(now, hole)) << x;
      l |= bits_of(u16, hn::MaskFromVec(near(hn::LoadU(u16, from + x - 1), now))) << x;
      if (up != nullptr) {
        a |= bits_of(u16, hn::MaskFromVec(near(hn::LoadU(u16, up + x), now))) << x;
      }
    }
    known[first / 64] = k;
    joined_left[first / 64] = l;
    joined_above[first / 64] = a;
  }
}

}  // namespace
}  // namespace tread::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tread {
HWY_EXPORT(gradient_row_here);
HWY_EXPORT(fill_holes_here);
HWY_EXPORT(known_row_here);
HWY_EXPORT(link_row_here);
HWY_EXPORT(steady_row_here);

void gradient_row(const std::uint8_t* above, const std::uint8_t* here, const std::uint8_t* below,
                  int width, int limit, std::uint8_t* out) {
  HWY_DYNAMIC_DISPATCH(gradient_row_here)(above, here, below, width, limit, out);
}

void fill_holes(const Neighbourhoods& around, const MedianRule& rule, Disparity* filled) {
  HWY_DYNAMIC_DISPATCH(fill_holes_here)(around, rule, filled);
}

void known_row(const Disparity* row, int width, std::uint64_t* known) {
  HWY_DYNAMIC_DISPATCH(known_row_here)(row, width, known);
}

void steady_row(const Disparity* now, const Disparity* seen, Disparity* result, int width,
                const TemporalRule& rule) {
  HWY_DYNAMIC_DISPATCH(steady_row_here)(now, seen, result, width, rule);
}

void link_row(const Disparity* above, const Disparity* here, int width, int limit,
              std::uint64_t* known, std::uint64_t* joined_left, std::uint64_t* joined_above) {
  HWY_DYNAMIC_DISPATCH(link_row_here)(above, here, width, limit, known, joined_left, joined_above);
}
}  // namespace tread
#endif
