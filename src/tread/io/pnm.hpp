// Netpbm grey and colour maps (pgm(5), ppm(5)): P2 and P3 as text, P5 and P6 as bytes, largest
// value 255 or 65535. Decoded here and not by OpenCV, which prints what it does not like.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "tread/core/result.hpp"

namespace tread {

struct PnmHeader {
  int width = 0;
  int height = 0;
  int bits = 8;  // or 16
  bool colour = false;
  bool text = false;
  std::size_t body = 0;         // where the pixels begin
  std::size_t most_values = 0;  // that the bytes from there on can hold
};

// True if the file begins as one of the four kinds.
[[nodiscard]] bool is_pnm(std::string_view bytes);
[[nodiscard]] Result<PnmHeader> parse_pnm_header(std::string_view bytes, const std::string& where);
// All values in the order of the file: rows from the top, red, green and blue of a pixel together.
// The header must be one whose size the file can hold.
[[nodiscard]] Result<std::vector<std::uint16_t>> decode_pnm(std::string_view bytes,
                                                            const PnmHeader& header,
                                                            const std::string& where);

}  // namespace tread
