#include "tread/geometry/remap_kernel.hpp"

#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tread/geometry/remap_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tread::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using I32 = hn::ScalableTag<std::int32_t>;
using U32 = hn::RebindToUnsigned<I32>;
using Lane = hn::Vec<I32>;

constexpr int kBits = RemapTable::kFractionBits;
constexpr int kUnit = 1 << kBits;

// Pixel (x, y), which must be inside or kOutside; beyond the last column and row lie the same.
std::uint8_t sample(ImageView<const std::uint8_t> input, RemapTable::Entry entry) {
  const int x = entry.u >> kBits, y = entry.v >> kBits;
  if (x < 0 || y < 0 || x >= input.width || y >= input.height) return 0;
  const int right = x + (x + 1 < input.width ? 1 : 0);
  const std::uint8_t* upper = input.row(y);
  const std::uint8_t* lower = input.row(y + (y + 1 < input.height ? 1 : 0));
  return between_four(upper[x], upper[right], lower[x], lower[right], entry.u & (kUnit - 1),
                      entry.v & (kUnit - 1));
}

// Between two neighbours, the lowest two bytes, by u in 1/32.
HWY_INLINE Lane between(Lane bytes, Lane u) {
  const I32 d;
  const Lane low = hn::Set(d, 255);
  const Lane left = hn::And(bytes, low), right = hn::And(hn::ShiftRight<8>(bytes), low);
  return hn::Add(hn::ShiftLeft<kBits>(left), hn::Mul(hn::Sub(right, left), u));
}

void remap_row_here(ImageView<const std::uint8_t> input, const RemapTable::Entry* entries,
                    int width, std::uint8_t* out) {
  const I32 d;
  const U32 unsigned_d;
  const hn::Rebind<std::uint8_t, I32> bytes_d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const Lane zero = hn::Zero(d);
  // Where four bytes of two rows can be loaded.
  const auto widest = hn::Set(unsigned_d, static_cast<std::uint32_t>(input.width - 3));
  const auto highest = hn::Set(unsigned_d, static_cast<std::uint32_t>(input.height - 1));
  const Lane stride = hn::Set(d, static_cast<std::int32_t>(input.stride));
  const Lane fraction = hn::Set(d, kUnit - 1);
  const auto* upper = reinterpret_cast<const std::int32_t*>(input.data);
  const auto* lower = reinterpret_cast<const std::int32_t*>(input.data + input.stride);
  // Lanes of kOutside load from the first pixel.
  const bool vectors = input.width >= 4 && input.height >= 2 &&
                       input.stride * input.height <= std::numeric_limits<std::int32_t>::max();
  int i = 0;
  for (; vectors && i + lanes <= width; i += lanes) {
    Lane u, v;
    hn::LoadInterleaved2(d, &entries[i].u, u, v);
    const Lane x = hn::ShiftRight<kBits>(u), y = hn::ShiftRight<kBits>(v);
    const auto missing = hn::Lt(u, zero);  // kOutside
    const auto fits = hn::And(hn::Lt(hn::BitCast(unsigned_d, x), widest),
                              hn::Lt(hn::BitCast(unsigned_d, y), highest));
    if (!hn::AllTrue(d, hn::Or(missing, hn::MaskFromVec(
                                            hn::BitCast(d, hn::VecFromMask(unsigned_d, fits)))))) {
      for (int k = i; k < i + lanes; ++k) out[k] = sample(input, entries[k]);
      continue;
    }
    const Lane at = hn::IfThenElse(missing, zero, hn::Add(hn::Mul(y, stride), x));
    const Lane fu = hn::And(u, fraction), fv = hn::And(v, fraction);
    const Lane above = between(hn::GatherOffset(d, upper, at), fu);
    const Lane below = between(hn::GatherOffset(d, lower, at), fu);
    const Lane sum =
        hn::Add(hn::Add(hn::ShiftLeft<kBits>(above), hn::Mul(hn::Sub(below, above), fv)),
                hn::Set(d, kUnit * kUnit / 2));
    const Lane value = hn::IfThenElse(missing, zero, hn::ShiftRight<2 * kBits>(sum));
    hn::StoreU(hn::DemoteTo(bytes_d, value), bytes_d, out + i);
  }
  for (; i < width; ++i) out[i] = sample(input, entries[i]);
}

}  // namespace
}  // namespace tread::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tread {
HWY_EXPORT(remap_row_here);

void remap_row(ImageView<const std::uint8_t> input, const RemapTable::Entry* entries, int width,
               std::uint8_t* out) {
  HWY_DYNAMIC_DISPATCH(remap_row_here)(input, entries, width, out);
}
}  // namespace tread
#endif
