// Images as cameras deliver them, made 8-bit grey for matching.
//
//   RawImage raw{buffer, 1280, 720, 2 * 1280, PixelFormat::kBayer16, 12};
//   Image<std::uint8_t> grey;
//   if (Status ok = to_grey(raw, grey); !ok) ...
#pragma once

#include <cstddef>
#include <cstdint>

#include "tread/core/image.hpp"
#include "tread/core/result.hpp"
#include "tread/core/timer.hpp"

namespace tread {

enum class PixelFormat {
  kGrey8,
  kGrey16,  // native byte order, `bits` of them used
  kRgb8,
  kBgr8,
  kBayer8,  // raw mosaic of a colour sensor, in any of its four phases
  kBayer16,
};

// Borrowed pixels of any format.
struct RawImage {
  const void* data = nullptr;
  int width = 0;
  int height = 0;
  std::ptrdiff_t row_bytes = 0;  // from one row to the next
  PixelFormat format = PixelFormat::kGrey8;
  int bits = 16;  // of the 16-bit formats: the largest value is 2^bits - 1; 8 to 16
};

// 16-bit values lose their lowest bits - 8; values beyond 2^bits - 1 become 255. Colours become
// BT.601 luma. A Bayer mosaic becomes (R + 2 G + B) / 4 at every pixel: the 3x3 binomial mean,
// which weighs the colours so in every phase; it smooths as much as interpolating them would.
// `grey` is resized. Errors: no pixels, rows that overlap, 16-bit pixels at odd addresses, bits out
// of range.
[[nodiscard]] Status to_grey(const RawImage& raw, Image<std::uint8_t>& grey,
                             const Context& context = {});

}  // namespace tread
