// What the two halves of the semi-global kernel share: how its memory is laid out. Included once
// for each instruction set.
#if defined(TREAD_STEREO_SGM_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef TREAD_STEREO_SGM_INL_HPP
#undef TREAD_STEREO_SGM_INL_HPP
#else
#define TREAD_STEREO_SGM_INL_HPP
#endif

#include <algorithm>
#include <cstddef>

#include "tread/stereo/lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace tread::HWY_NAMESPACE {
namespace {
#if HWY_TARGET != HWY_SCALAR && HWY_TARGET != HWY_EMU128

constexpr int kSgmPixels = 16;   // looked at before their results are
constexpr int kEdgeColumns = 2;  // beside a pixel that count for its edge cost

inline int padded_range(int num_disparities) {
  return (num_disparities + kLanes - 1) / kLanes * kLanes;
}

// Of the path from above, for each pixel: its least, and that plus p2, each four times; then the
// paths, each between vectors of 255, so that neighbours can be loaded.
struct AboveLeast {
  std::uint32_t least;
  std::uint32_t larger_step;
};
inline std::ptrdiff_t above_begin(int width) {
  return (static_cast<std::ptrdiff_t>(sizeof(AboveLeast)) * width + 63) / 64 * 64 + kLanes;
}
inline std::ptrdiff_t above_stride(int padded) {
  return padded + kLanes;
}

inline std::size_t above_bytes(int width, int num_disparities) {
  return static_cast<std::size_t>(above_begin(width) +
                                  above_stride(padded_range(num_disparities)) * width);
}

// Of a row's differences.
inline std::size_t difference_bytes(int width, int num_disparities) {
  return static_cast<std::size_t>(width + 2 * kEdgeColumns) *
         static_cast<std::size_t>(padded_range(num_disparities));
}

inline std::size_t worker_bytes(int width, int num_disparities) {
  const auto row = static_cast<std::size_t>(width + 2 * kEdgeColumns + 64);
  const auto padded = static_cast<std::size_t>(padded_range(num_disparities));
  const std::size_t costs = 6 * (4 * row + row + padded + 64) + 8 * padded +
                            2 * (difference_bytes(width, num_disparities) + 64);
  const std::size_t winners = kSgmPixels * (padded + 2 * 64);
  return std::max({costs, winners, 4 * row, 5 * row}) + 1024;
}

// Hands out parts of a worker's memory.
struct Arena {
  std::uint8_t* at;
  template <class T>
  T* take(std::size_t count) {
    T* here = reinterpret_cast<T*>(at);
    at += (count * sizeof(T) + 63) / 64 * 64;
    return here;
  }
};

// 255 in the lanes of vector i that are not among the first `range`.
HWY_INLINE Bytes outside(int i, int range) {
  const int inside = std::clamp(range - i * kLanes, 0, kLanes);
  return hn::IfThenElseZero(hn::Not(hn::FirstN(U8(), static_cast<std::size_t>(inside))),
                            Set(U8(), 255));
}

#endif
}  // namespace
}  // namespace tread::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
