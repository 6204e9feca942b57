// Cost: 640x480 in 0.02 ms (16-bit grey) to 0.1 ms (colour, Bayer) with AVX2 on one thread.
#include "tread/core/raw_image.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <type_traits>

#include "tread/core/parallel.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tread/core/raw_image.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tread::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using U16 = hn::ScalableTag<std::uint16_t>;
using U32 = hn::ScalableTag<std::uint32_t>;
using HalfU8 = hn::Rebind<std::uint8_t, U16>;
using QuarterU8 = hn::Rebind<std::uint8_t, U32>;

void shift_row(const std::uint16_t* from, int width, int shift, std::uint8_t* out) {
  const U16 d;
  const HalfU8 bytes;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto most = hn::Set(d, 255);
  int x = 0;
  for (; x + lanes <= width; x += lanes) {
    const auto value = hn::Min(hn::ShiftRightSame(hn::LoadU(d, from + x), shift), most);
    hn::StoreU(hn::DemoteTo(bytes, hn::BitCast(hn::RebindToSigned<U16>(), value)), bytes, out + x);
  }
  for (; x < width; ++x) out[x] = static_cast<std::uint8_t>(std::min(from[x] >> shift, 255));
}

// 65536 times the weights of BT.601.
constexpr std::uint32_t kRed = 19595, kGreen = 38470, kBlue = 7471, kHalf = 32768;

void luma_row(const std::uint8_t* from, int width, bool blue_first, std::uint8_t* out) {
  const U32 d;
  const QuarterU8 bytes;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const std::uint32_t first = blue_first ? kBlue : kRed, third = blue_first ? kRed : kBlue;
  int x = 0;
  for (; x + lanes <= width; x += lanes) {
    hn::Vec<QuarterU8> a, g, c;
    hn::LoadInterleaved3(bytes, from + std::ptrdiff_t{3} * x, a, g, c);
    auto sum = hn::Add(hn::Mul(hn::PromoteTo(d, a), hn::Set(d, first)), hn::Set(d, kHalf));
    sum = hn::Add(sum, hn::Mul(hn::PromoteTo(d, g), hn::Set(d, kGreen)));
    sum = hn::Add(sum, hn::Mul(hn::PromoteTo(d, c), hn::Set(d, third)));
    const auto value = hn::BitCast(hn::RebindToSigned<U32>(), hn::ShiftRight<16>(sum));
    hn::StoreU(hn::DemoteTo(bytes, value), bytes, out + x);
  }
  for (; x < width; ++x) {
    const std::uint8_t* p = from + std::ptrdiff_t{3} * x;
    out[x] = static_cast<std::uint8_t>((first * p[0] + kGreen * p[1] + third * p[2] + kHalf) >> 16);
  }
}

// The rows of 8-bit values around one, and one value more on both sides of each.
void binomial_row(const std::uint8_t* above, const std::uint8_t* here, const std::uint8_t* below,
                  int width, std::uint8_t* out) {
  const U16 d;
  const HalfU8 bytes;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto column = [&](int x) HWY_ATTR {
    const auto a = hn::PromoteTo(d, hn::LoadU(bytes, above + x));
    const auto h = hn::PromoteTo(d, hn::LoadU(bytes, here + x));
    const auto b = hn::PromoteTo(d, hn::LoadU(bytes, below + x));
    return hn::Add(hn::Add(a, b), hn::Add(h, h));
  };
  int x = 0;
  for (; x + lanes <= width; x += lanes) {
    const auto middle = column(x);
    const auto sum = hn::Add(hn::Add(column(x - 1), column(x + 1)), hn::Add(middle, middle));
    const auto value = hn::ShiftRight<4>(hn::Add(sum, hn::Set(d, 8)));
    hn::StoreU(hn::DemoteTo(bytes, hn::BitCast(hn::RebindToSigned<U16>(), value)), bytes, out + x);
  }
  for (; x < width; ++x) {
    const auto at = [&](int u) { return above[u] + 2 * here[u] + below[u]; };
    out[x] = static_cast<std::uint8_t>((at(x - 1) + 2 * at(x) + at(x + 1) + 8) >> 4);
  }
}

}  // namespace
}  // namespace tread::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tread {
namespace {
HWY_EXPORT(shift_row);
HWY_EXPORT(luma_row);
HWY_EXPORT(binomial_row);

bool is_deep(PixelFormat format) {
  return format == PixelFormat::kGrey16 || format == PixelFormat::kBayer16;
}

std::ptrdiff_t pixel_bytes(PixelFormat format) {
  if (format == PixelFormat::kRgb8 || format == PixelFormat::kBgr8) return 3;
  return is_deep(format) ? 2 : 1;
}

Status check(const RawImage& raw) {
  const auto refuse = [](const std::string& what, const char* remedy) {
    return fail(ErrorCode::kBadArgument, what, "raw image", remedy);
  };
  if (raw.data == nullptr || raw.width <= 0 || raw.height <= 0) {
    return refuse("it has no pixels", "Give an image");
  }
  if (raw.row_bytes < raw.width * pixel_bytes(raw.format)) {
    return refuse("its rows overlap", "Give the bytes from one row to the next, not pixels");
  }
  if (!is_deep(raw.format)) return {};
  if (raw.bits < 8 || raw.bits > 16) {
    return refuse(fmt::format("{} bits are out of range", raw.bits), "Give 8 to 16");
  }
  if (reinterpret_cast<std::uintptr_t>(raw.data) % 2 != 0 || raw.row_bytes % 2 != 0) {
    return refuse("16-bit pixels at an odd address", "Align the rows to two bytes");
  }
  return {};
}

const std::uint8_t* row_of(const RawImage& raw, int y) {
  return static_cast<const std::uint8_t*>(raw.data) + y * raw.row_bytes;
}

// One row made 8 bits a value.
void shallow_row(const RawImage& raw, int y, std::uint8_t* out) {
  const std::uint8_t* from = row_of(raw, y);
  if (is_deep(raw.format)) {
    HWY_DYNAMIC_DISPATCH(shift_row)
    (reinterpret_cast<const std::uint16_t*>(from), raw.width, raw.bits - 8, out);
  } else {
    std::copy(from, from + raw.width, out);
  }
}

// Rows first to last - 1 of a mosaic. Beyond a border lies what is as far inside of it: it has the
// same colour.
void smooth_mosaic(const RawImage& raw, int first, int last, Image<std::uint8_t>& grey) {
  Image<std::uint8_t> ring(raw.width + 2, 3);
  const auto mirrored = [](int i, int size) {
    if (size == 1) return 0;
    return i < 0 ? -i : i >= size ? 2 * size - 2 - i : i;
  };
  const auto row = [&](int y) { return ring.row((y + 3) % 3) + 1; };
  const auto load = [&](int y) {
    std::uint8_t* to = row(y);
    shallow_row(raw, mirrored(y, raw.height), to);
    to[-1] = to[mirrored(-1, raw.width)];
    to[raw.width] = to[mirrored(raw.width, raw.width)];
  };
  load(first - 1);
  load(first);
  for (int y = first; y < last; ++y) {
    load(y + 1);
    HWY_DYNAMIC_DISPATCH(binomial_row)
    (row(y - 1), row(y), row(y + 1), raw.width, grey.row(y));
  }
}

}  // namespace

Status to_grey(const RawImage& raw, Image<std::uint8_t>& grey, const Context& context) {
  if (Status ok = check(raw); !ok) return ok;
  const ScopedTimer timer(context, "stereo/unpack");
  grey.resize(raw.width, raw.height);
  const bool mosaic = raw.format == PixelFormat::kBayer8 || raw.format == PixelFormat::kBayer16;
  const bool coloured = pixel_bytes(raw.format) == 3;
  parallel_chunks(context, 0, raw.height, 64, [&](int first, int last) {
    if (mosaic) return smooth_mosaic(raw, first, last, grey);
    for (int y = first; y < last; ++y) {
      if (coloured) {
        HWY_DYNAMIC_DISPATCH(luma_row)
        (row_of(raw, y), raw.width, raw.format == PixelFormat::kBgr8, grey.row(y));
      } else {
        shallow_row(raw, y, grey.row(y));
      }
    }
  });
  return {};
}

}  // namespace tread
#endif
