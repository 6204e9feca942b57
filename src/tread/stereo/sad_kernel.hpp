// The vectorised part of block matching: rows of an edge image pair to disparities, as
// match_rows_plain (sad_plain.hpp) defines them, bit for bit, on SSE4, AVX2, AVX-512 and NEON from
// one source. docs/stereo.md draws it. In short, for one row, columns from left to right:
//
//   disparities lie side by side in the bytes of a vector: 64 of them are one AVX-512 register
//   column[c] += |in| - |out|           the row that enters the window, the row that leaves it
//   cost      += column[c] - column[c - width]       16 bits, never in memory as a volume
//   minimum, its place, how many others are as cheap as uniqueness forbids: from one register
//
// The other image's row is reversed, so that ascending disparities are ascending addresses.
#pragma once

#include "tread/core/image.hpp"
#include "tread/stereo/sad_matcher.hpp"

namespace tread {

// One reference image and the one that is searched. Mirrored: both are read from right to left, so
// that the match of x lies at x - d here too when the right image is the reference.
struct SadImages {
  ImageView<const std::uint8_t> reference;
  ImageView<const std::uint8_t> other;
  bool mirrored = false;
  int largest_difference = 255;  // of any two pixels
};

// The largest sum that the kernel's 16 bits hold; match_rows_plain takes larger windows.
inline constexpr int kLargestKernelSum = 32766;

// How much dearer than the least cost c another may be and still be ambiguous: c * factor >> 16.
[[nodiscard]] constexpr std::uint16_t uniqueness_factor(int percent) {
  return static_cast<std::uint16_t>(percent * 65535 / 100);
}

// Rows first to last - 1 of the output, which has the size of the images. `memory` is the
// caller's to keep: one for each thread.
void match_rows(const SadImages& images, const SadOptions& options, int first, int last,
                Image<std::uint8_t>& memory, const MatchOutput& out);

}  // namespace tread
