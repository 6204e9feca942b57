// Disparity images: fixed point, one reserved value for "no match".
#pragma once

#include <cmath>
#include <cstdint>

#include "tread/core/image.hpp"

namespace tread {

// 1/64 px steps: finer than any matcher resolves, and up to 1023 px, the largest disparity that
// paper Q's library knew, in 16 bits.
using Disparity = std::uint16_t;
inline constexpr int kDisparityScale = 64;
inline constexpr Disparity kNoMatch = 0xFFFF;
inline constexpr int kMaxDisparity = 1022;  // px, of any search range

// What is left at a match: its cost over the slope of the cost beside it, max(l, r) - c, in 1/16.
// The noise of a cost grows with the cost, and moves its minimum the more the flatter that lies:
// see uncertainty.hpp. kLargestResidual: as large or larger, or no minimum; kNoResidual: no match,
// or filled from others.
inline constexpr int kResidualScale = 16;
inline constexpr std::uint8_t kLargestResidual = 254;
inline constexpr std::uint8_t kNoResidual = 255;

// Where matching writes to: images of one size; `residual` may be empty, it is then not made.
struct MatchOutput {
  ImageView<Disparity> disparity;
  ImageView<std::uint8_t> residual = {};
};

[[nodiscard]] constexpr float disparity_px(Disparity d) {
  return static_cast<float>(d) / static_cast<float>(kDisparityScale);
}

// The share of pixels that have a disparity, 0 to 1.
[[nodiscard]] inline double disparity_density(ImageView<const Disparity> disparity) {
  std::int64_t matched = 0;
  for (int y = 0; y < disparity.height; ++y) {
    const Disparity* row = disparity.row(y);
    for (int x = 0; x < disparity.width; ++x) matched += row[x] != kNoMatch ? 1 : 0;
  }
  const double all = static_cast<double>(disparity.width) * disparity.height;
  return all > 0.0 ? static_cast<double>(matched) / all : 0.0;
}

}  // namespace tread
