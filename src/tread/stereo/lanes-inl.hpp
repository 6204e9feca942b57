// Vector types and the few operations that Highway 1.0 lacks, for the kernels of this module.
// Included once for each instruction set.
#if defined(TREAD_STEREO_LANES_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef TREAD_STEREO_LANES_INL_HPP
#undef TREAD_STEREO_LANES_INL_HPP
#else
#define TREAD_STEREO_LANES_INL_HPP
#endif

#include <hwy/highway.h>

#include <cstdint>

HWY_BEFORE_NAMESPACE();
namespace tread::HWY_NAMESPACE {
namespace {
#if HWY_TARGET != HWY_SCALAR && HWY_TARGET != HWY_EMU128

namespace hn = hwy::HWY_NAMESPACE;

using U8 = hn::ScalableTag<std::uint8_t>;
using I8 = hn::RebindToSigned<U8>;
using I16 = hn::ScalableTag<std::int16_t>;
using U16 = hn::ScalableTag<std::uint16_t>;
using U32 = hn::ScalableTag<std::uint32_t>;
using I32 = hn::ScalableTag<std::int32_t>;
using F32 = hn::ScalableTag<float>;
using Bytes = hn::Vec<U8>;
using Words = hn::Vec<I16>;

constexpr int kLanes = static_cast<int>(hn::MaxLanes(U8()));  // disparities of a vector of bytes
constexpr int kMaxVectors = 1024 / kLanes;                    // kMaxDisparity of them

// Where byte i of a row lies among words, once widened: each block of sixteen bytes becomes a block
// of the lower vector and one of the upper.
constexpr int widened_place(int i) {
  return i / kLanes * kLanes + (i / 8 % 2) * (kLanes / 2) + i % kLanes / 16 * 8 + i % 8;
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
#elif HWY_TARGET == HWY_SSE4 || HWY_TARGET == HWY_SSSE3
  return Bytes{_mm_packus_epi16(lower.raw, upper.raw)};
#else
  const hn::Half<U8> half;
  return Combine(U8(), DemoteTo(half, upper), DemoteTo(half, lower));
#endif
}

// The least of all lanes, none negative, in lane 0.
template <class D, class V>
HWY_INLINE auto least_of(D d, V v) {
  if constexpr (hn::MaxLanes(D()) > 8) {
    const hn::Half<D> half;
    return least_of(half, Min(LowerHalf(half, v), UpperHalf(half, v)));
  } else {
#if HWY_ARCH_X86 && HWY_TARGET <= HWY_SSE4
    return V{_mm_minpos_epu16(v.raw)};
#else
    return MinOfLanes(d, v);
#endif
  }
}

// Lane 0 of a vector of eight in every lane.
template <class V>
HWY_INLINE Words spread_word(V v) {
#if HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX3_DL
  return Words{_mm512_broadcastw_epi16(v.raw)};
#elif HWY_TARGET == HWY_AVX2
  return Words{_mm256_broadcastw_epi16(v.raw)};
#else
  return hn::Broadcast<0>(v);
#endif
}

// The least byte of all lanes, in lane 0 of a vector of sixteen.
template <class D, class V>
HWY_INLINE auto least_byte_of(D d, V v) {
  if constexpr (hn::MaxLanes(D()) > 16) {
    const hn::Half<D> half;
    return least_byte_of(half, Min(LowerHalf(half, v), UpperHalf(half, v)));
  } else {
#if HWY_ARCH_X86 && HWY_TARGET <= HWY_SSE4
    const hn::Repartition<std::uint16_t, D> pairs;
    const V least = Min(v, BitCast(d, hn::ShiftRight<8>(BitCast(pairs, v))));
    return V{_mm_minpos_epu16(least.raw)};
#else
    return MinOfLanes(d, v);
#endif
  }
}

// The lowest byte of each four, four times.
HWY_INLINE Bytes repeat_lowest(Bytes v) {
  alignas(16) static constexpr std::uint8_t kLowest[16] = {0, 0, 0, 0, 4,  4,  4,  4,
                                                           8, 8, 8, 8, 12, 12, 12, 12};
  return TableLookupBytes(v, hn::LoadDup128(U8(), kLowest));
}

// The least bytes of four vectors at once, for less than four times the price: in every block of 16
// bytes, bytes 4 k to 4 k + 3 are the least byte of the k-th.
HWY_INLINE Bytes least_bytes_of(Bytes v0, Bytes v1, Bytes v2, Bytes v3) {
  const hn::Repartition<std::uint64_t, U8> u64;
  const auto merge = [](auto by, Bytes a, Bytes b) HWY_ATTR {
    const auto x = BitCast(by, a), y = BitCast(by, b);
    return Min(BitCast(U8(), InterleaveLower(by, x, y)), BitCast(U8(), InterleaveUpper(by, x, y)));
  };
  Bytes least = merge(u64, merge(U32(), v0, v1), merge(U32(), v2, v3));
  if constexpr (kLanes > 32) least = Min(least, hn::ReverseBlocks(U8(), least));
  if constexpr (kLanes > 16) least = Min(least, hn::SwapAdjacentBlocks(least));
  least = Min(least, BitCast(U8(), hn::ShiftRight<16>(BitCast(U32(), least))));
  return repeat_lowest(Min(least, BitCast(U8(), hn::ShiftRight<8>(BitCast(U32(), least)))));
}

// Lane 0 of a vector of sixteen in every lane.
template <class V>
HWY_INLINE Bytes spread_byte(V v) {
#if HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX3_DL
  return Bytes{_mm512_broadcastb_epi8(v.raw)};
#elif HWY_TARGET == HWY_AVX2
  return Bytes{_mm256_broadcastb_epi8(v.raw)};
#else
  return TableLookupBytes(v, Zero(U8()));
#endif
}

// Lane i takes lane i - 1; the first takes the last one of `before`.
HWY_INLINE Bytes from_lower(Bytes v, Bytes before) {
#if HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX3_DL
  return Bytes{_mm512_alignr_epi8(v.raw, _mm512_alignr_epi64(v.raw, before.raw, 6), 15)};
#elif HWY_TARGET == HWY_AVX2
  return Bytes{_mm256_alignr_epi8(v.raw, _mm256_permute2x128_si256(before.raw, v.raw, 0x21), 15)};
#else
  return hn::CombineShiftRightBytes<15>(U8(), v, before);
#endif
}

// Lane i takes lane i + 1; the last takes the first one of `behind`.
HWY_INLINE Bytes from_upper(Bytes v, Bytes behind) {
#if HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX3_DL
  return Bytes{_mm512_alignr_epi8(_mm512_alignr_epi64(behind.raw, v.raw, 2), v.raw, 1)};
#elif HWY_TARGET == HWY_AVX2
  return Bytes{_mm256_alignr_epi8(_mm256_permute2x128_si256(v.raw, behind.raw, 0x21), v.raw, 1)};
#else
  return hn::CombineShiftRightBytes<1>(U8(), behind, v);
#endif
}

// The same where there is one vector only: 255 comes in.
HWY_INLINE Bytes from_lower(Bytes v) {
#if HWY_TARGET == HWY_AVX3_DL
  const __m512i from = Iota(U8(), 255).raw;
  return Bytes{_mm512_mask_permutexvar_epi8(Set(U8(), 255).raw, ~1ULL, from, v.raw)};
#else
  return from_lower(v, Set(U8(), 255));
#endif
}

HWY_INLINE Bytes from_upper(Bytes v) {
#if HWY_TARGET == HWY_AVX3_DL
  const __m512i from = Iota(U8(), 1).raw;
  return Bytes{_mm512_mask_permutexvar_epi8(Set(U8(), 255).raw, ~0ULL >> 1, from, v.raw)};
#else
  return from_upper(v, Set(U8(), 255));
#endif
}

// Of bits of which at least one is set.
HWY_INLINE std::uint32_t lowest_bit(std::uint64_t bits) {
  return static_cast<std::uint32_t>(hwy::Num0BitsBelowLS1Bit_Nonzero64(bits));
}

HWY_INLINE std::uint64_t bits_of(hn::Mask<U8> mask) {
  std::uint64_t bits = 0;
  StoreMaskBits(U8(), mask, reinterpret_cast<std::uint8_t*>(&bits));
  return bits;
}

// The lanes of a that are at most b.
HWY_INLINE std::uint64_t bits_at_most(Bytes a, Bytes b) {
#if HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX3_DL
  return ~bits_of(Gt(a, b));  // all 64 bits are lanes
#else
  return bits_of(Eq(Min(a, b), a));
#endif
}

#endif
}  // namespace
}  // namespace tread::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
