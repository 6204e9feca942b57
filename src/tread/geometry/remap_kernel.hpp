// One row of a remapped grey image, vectorised; equals the plain form in rectification.cpp.
#pragma once

#include "tread/geometry/rectification.hpp"

namespace tread {

// The value between four pixels at (u, v), in 1/32 px, of the top left one: bilinear, rounded.
[[nodiscard]] inline std::uint8_t between_four(int a, int b, int c, int d, int u, int v) {
  constexpr int kUnit = 1 << RemapTable::kFractionBits;
  const int upper = a * (kUnit - u) + b * u;
  const int lower = c * (kUnit - u) + d * u;
  const int sum = upper * (kUnit - v) + lower * v + kUnit * kUnit / 2;
  return static_cast<std::uint8_t>(sum >> (2 * RemapTable::kFractionBits));
}

// `width` pixels, each from the place its entry names.
void remap_row(ImageView<const std::uint8_t> input, const RemapTable::Entry* entries, int width,
               std::uint8_t* out);

}  // namespace tread
