// Rows of pixels as the kernels read them: those of the reference image four times each, so that
// one load fills a vector, those of the other image reversed, so that ascending disparities are
// ascending addresses. Included once for each instruction set.
#if defined(TREAD_STEREO_ROWS_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef TREAD_STEREO_ROWS_INL_HPP
#undef TREAD_STEREO_ROWS_INL_HPP
#else
#define TREAD_STEREO_ROWS_INL_HPP
#endif

#include <algorithm>

#include "tread/stereo/lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace tread::HWY_NAMESPACE {
namespace {
#if HWY_TARGET != HWY_SCALAR && HWY_TARGET != HWY_EMU128

// A row with `beside` more pixels on both sides, the nearest ones; mirrored: from right to left.
inline void spread_row(const std::uint8_t* from, int width, int beside, bool mirrored,
                       std::uint32_t* out) {
  constexpr std::uint32_t kFourTimes = 0x01010101U;
  const int last = width - 1;
  std::uint32_t* inside = out + beside;
  std::fill(out, inside, from[mirrored ? last : 0] * kFourTimes);
  std::fill(inside + width, inside + width + beside, from[mirrored ? 0 : last] * kFourTimes);
  int x = 0;
  if (!mirrored) {
    const hn::Rebind<std::uint8_t, U32> pixels;
    const int lanes = static_cast<int>(Lanes(U32()));
    for (; x + lanes <= width; x += lanes) {
      const auto four = Mul(PromoteTo(U32(), LoadU(pixels, from + x)), Set(U32(), kFourTimes));
      StoreU(four, U32(), inside + x);
    }
  }
  for (; x < width; ++x) inside[x] = from[mirrored ? last - x : x] * kFourTimes;
}

// A row reversed: entry k of `length` is column width - 1 + beside - min_disparity - k, beyond the
// ends the nearest pixel, so that the disparities of column x begin at entry width - 1 + beside -
// x. Mirrored: of the row read from right to left.
inline void reverse_row(const std::uint8_t* from, int width, int beside, int min_disparity,
                        int length, bool mirrored, std::uint8_t* out) {
  const int last = width - 1;
  const int shift = beside - min_disparity;
  const int begin = std::clamp(shift, 0, length), end = std::clamp(shift + width, begin, length);
  const int skipped = begin - shift;
  std::fill(out, out + begin, from[mirrored ? 0 : last]);
  if (mirrored) {
    std::copy(from + skipped, from + skipped + (end - begin), out + begin);
  } else {
    std::reverse_copy(from + width - skipped - (end - begin), from + width - skipped, out + begin);
  }
  std::fill(out + end, out + length, from[mirrored ? last : 0]);
}

#endif
}  // namespace
}  // namespace tread::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
