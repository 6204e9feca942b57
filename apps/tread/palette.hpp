// Colour scales for pictures of measured values. Each is a short list of control colours in
// lightness, chroma and hue, interpolated in the perceptual space OKLab (Ottosson 2020), so that
// equal steps of the value look equal.
#pragma once

#include <string>

#include "tread/core/image.hpp"

namespace tread {

enum class Palette {
  kHeight,     // violet, blue, green, yellow; lightness rises evenly
  kCost,       // black, violet, orange, yellow; lightness rises evenly
  kDisparity,  // blue, cyan, green, yellow, red: many steps to tell apart, lightness peaks inside
  kGrey,       // almost black to white
};

// The colour of a share of the scale; below 0 and above 1 the ends. `share` must not be NaN.
[[nodiscard]] Rgb palette_colour(Palette palette, double share);

// "#1f77b4"
[[nodiscard]] std::string hex_colour(Rgb colour);

}  // namespace tread
