// Smaller images: blocks of factor x factor pixels become their mean.
#pragma once

#include <algorithm>
#include <cstdint>

#include "tread/core/image.hpp"

namespace tread {

// The size of an image after shrinking: incomplete blocks at the right and lower border are left
// out, but at least one pixel is kept.
[[nodiscard]] constexpr int shrunk_size(int size, int factor) {
  return std::max(1, size / factor);
}

// `small` is resized. A block that reaches over the border takes the pixels that are there.
inline void shrink(ImageView<const std::uint8_t> image, int factor, Image<std::uint8_t>& small) {
  small.resize(shrunk_size(image.width, factor), shrunk_size(image.height, factor));
  for (int y = 0; y < small.height; ++y) {
    const int v_end = std::min(image.height, factor * (y + 1));
    for (int x = 0; x < small.width; ++x) {
      const int u_end = std::min(image.width, factor * (x + 1));
      int sum = 0, pixels = 0;
      for (int v = factor * y; v < v_end; ++v) {
        for (int u = factor * x; u < u_end; ++u) {
          sum += image(u, v);
          ++pixels;
        }
      }
      small(x, y) = static_cast<std::uint8_t>((sum + pixels / 2) / pixels);
    }
  }
}

inline void shrink(ImageView<const Rgb> image, int factor, Image<Rgb>& small) {
  small.resize(shrunk_size(image.width, factor), shrunk_size(image.height, factor));
  for (int y = 0; y < small.height; ++y) {
    const int v_end = std::min(image.height, factor * (y + 1));
    for (int x = 0; x < small.width; ++x) {
      const int u_end = std::min(image.width, factor * (x + 1));
      int r = 0, g = 0, b = 0, pixels = 0;
      for (int v = factor * y; v < v_end; ++v) {
        for (int u = factor * x; u < u_end; ++u) {
          r += image(u, v).r;
          g += image(u, v).g;
          b += image(u, v).b;
          ++pixels;
        }
      }
      const auto mean = [pixels](int sum) {
        return static_cast<std::uint8_t>((sum + pixels / 2) / pixels);
      };
      small(x, y) = {mean(r), mean(g), mean(b)};
    }
  }
}

}  // namespace tread
