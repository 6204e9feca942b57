// The vectorised rows of the image filters around the matcher; each equals its plain form in
// edge_image.cpp and hole_filter.cpp bit for bit.
#pragma once

#include <cstdint>

#include "tread/stereo/disparity.hpp"

namespace tread {

// One row of the horizontal Sobel response, 128 + clamp(response, -limit, min(limit, 127)). The
// rows have `width` pixels; beyond the ends lie the nearest ones.
void gradient_row(const std::uint8_t* above, const std::uint8_t* here, const std::uint8_t* below,
                  int width, int limit, std::uint8_t* out);

// The neighbourhoods of up to 64 holes, a lane each: their eight neighbours.
struct Neighbourhoods {
  static constexpr int kMost = 64;
  alignas(64) Disparity values[8][kMost];
};
// How a hole is filled with the median of its neighbourhood; kNoMatch where the rule is not met.
struct MedianRule {
  bool of_all;          // the fifth of all nine, "no match" the largest; else of the known ones
  int min_known;        // 1 to 8; of_all: 5
  unsigned max_spread;  // between the smallest and the largest known value; kNoMatch: any
};
void fill_holes(const Neighbourhoods& around, const MedianRule& rule, Disparity* filled);

// Bit x % 64 of word x / 64, for (width + 63) / 64 words: whether pixel x is known.
void known_row(const Disparity* row, int width, std::uint64_t* known);

// One row of `now` against the frame before as matched, `seen`, and as filtered, `result`, which is
// replaced by that of this frame: `now` where `seen` is within max_change (or, without confirm,
// where it is not known or farther off), else kNoMatch; moved by memory / 16, rounded, towards the
// old `result` where that is within max_change.
struct TemporalRule {
  std::uint16_t max_change;  // at most 512
  std::uint16_t memory;      // 0 to 15
  bool confirm;
};
void steady_row(const Disparity* now, const Disparity* seen, Disparity* result, int width,
                const TemporalRule& rule);

// Bits of a row, bit x % 64 of word x / 64, for (width + 63) / 64 words each: whether pixel x is
// known; is known, as its left neighbour is, and differs from it by at most `limit`; the same for
// the pixel above (`above` null: none).
void link_row(const Disparity* above, const Disparity* here, int width, int limit,
              std::uint64_t* known, std::uint64_t* joined_left, std::uint64_t* joined_above);

}  // namespace tread
