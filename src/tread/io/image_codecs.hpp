// PNG and JPEG to pixels with libpng and libjpeg themselves: through OpenCV their warnings and
// errors would go to the standard error of the program, and damaged data would pass as a picture.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "tread/core/result.hpp"
#include "tread/io/image_header.hpp"

namespace tread {

// Rows of interleaved pixels to be filled: one channel, or blue, green, red if the header says
// colour, of header.bits, native byte order.
struct PixelRows {
  unsigned char* data = nullptr;
  std::size_t stride_bytes = 0;
};

// `bytes` is the whole file, which parse_image_header has accepted with this header. Alpha and all
// that does not change the stored pixels (gamma, profiles) is left out. Data that cannot be decoded
// to the last pixel is an error with the decoder's words; bytes between segments, which some
// cameras write, are not.
[[nodiscard]] Status decode_png(std::string_view bytes, const ImageHeader& header,
                                const std::string& where, PixelRows rows);
[[nodiscard]] Status decode_jpeg(std::string_view bytes, const ImageHeader& header,
                                 const std::string& where, PixelRows rows);

}  // namespace tread
