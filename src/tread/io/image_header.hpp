// What an image file says about itself, read before any decoder sees the file: so a file that is
// cut off, or whose header promises more pixels than its bytes can hold, is refused by name and
// costs no memory.
#pragma once

#include <string>
#include <string_view>

#include "tread/core/result.hpp"

namespace tread {

enum class ImageFormat { kPng, kJpeg, kPnm };

struct ImageHeader {
  ImageFormat format = ImageFormat::kPng;
  int width = 0;
  int height = 0;
  int bits = 8;         // of a channel; a palette counts as 8
  bool colour = false;  // red, green, blue or a palette; else grey
  bool alpha = false;
};

// `bytes` is the whole file; `where` is its name in messages. Beside the header it is checked that
// the file is complete: PNG to its IEND, with the checksum of every chunk; JPEG to its end marker;
// PNM to its last pixel.
[[nodiscard]] Result<ImageHeader> parse_image_header(std::string_view bytes,
                                                     const std::string& where);

}  // namespace tread
