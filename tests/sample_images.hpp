// Image files for the tests of readers, made without the codecs that are tested: PNG of every kind
// with stored (uncompressed) data, and two JPEG files of a few hundred bytes.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

namespace tread::testing {

inline std::string big_endian(std::uint32_t value) {
  return {static_cast<char>(value >> 24), static_cast<char>(value >> 16),
          static_cast<char>(value >> 8), static_cast<char>(value)};
}

inline std::string png_chunk(const std::string& type, const std::string& data) {
  std::uint32_t crc = 0xffffffffU;
  for (const char c : type + data) {
    crc ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1U) != 0 ? crc >> 1 ^ 0xedb88320U : crc >> 1;
  }
  return big_endian(static_cast<std::uint32_t>(data.size())) + type + data + big_endian(~crc);
}

// A zlib stream of one stored block (RFC 1950, 1951); at most 65535 bytes.
inline std::string stored_zlib(const std::string& data) {
  const auto length = static_cast<std::uint16_t>(data.size());
  const auto low = [](int v) { return static_cast<char>(v & 0xff); };
  const std::string head = {
      0x78, 0x01, 0x01, low(length), low(length >> 8), low(~length), low(~length >> 8)};
  std::uint32_t a = 1, b = 0;
  for (const char c : data) {
    a = (a + static_cast<unsigned char>(c)) % 65521U;
    b = (b + a) % 65521U;
  }
  return head + data + big_endian(b << 16 | a);
}

inline std::string png_header(int width, int height, int bits, int type) {
  return png_chunk("IHDR",
                   big_endian(static_cast<std::uint32_t>(width)) +
                       big_endian(static_cast<std::uint32_t>(height)) +
                       std::string{static_cast<char>(bits), static_cast<char>(type), 0, 0, 0});
}

inline const std::string kPngStart("\x89PNG\r\n\x1a\n", 8);

// `rows` holds the packed bytes of the pixels, row by row; `palette` only for type 3. Types: 0
// grey, 2 colour, 3 palette, 4 grey and alpha, 6 colour and alpha.
inline std::string make_png(int width, int height, int bits, int type, const std::string& rows,
                            const std::string& palette = "") {
  const std::size_t row_bytes = rows.size() / static_cast<std::size_t>(height);
  std::string filtered;
  for (std::size_t y = 0; y < static_cast<std::size_t>(height); ++y) {
    filtered += '\0' + rows.substr(y * row_bytes, row_bytes);
  }
  return kPngStart + png_header(width, height, bits, type) +
         (palette.empty() ? "" : png_chunk("PLTE", palette)) +
         png_chunk("IDAT", stored_zlib(filtered)) + png_chunk("IEND", "");
}

// 24 x 16 grey, baseline: pixel (x, y) is about 8 x + 2 y.
inline constexpr std::array<unsigned char, 197> kGreyJpeg = {
    255, 216, 255, 224, 0,   16,  74,  70,  73,  70,  0,   1,   1,   0,   0,   1,   0,   1,  0,  0,
    255, 219, 0,   67,  0,   3,   2,   2,   3,   2,   2,   3,   3,   3,   3,   4,   3,   3,  4,  5,
    8,   5,   5,   4,   4,   5,   10,  7,   7,   6,   8,   12,  10,  12,  12,  11,  10,  11, 11, 13,
    14,  18,  16,  13,  14,  17,  14,  11,  11,  16,  22,  16,  17,  19,  20,  21,  21,  21, 12, 15,
    23,  24,  22,  20,  24,  18,  20,  21,  20,  255, 192, 0,   11,  8,   0,   16,  0,   24, 1,  1,
    17,  0,   255, 196, 0,   21,  0,   1,   1,   0,   0,   0,   0,   0,   0,   0,   0,   0,  0,  0,
    0,   0,   0,   8,   9,   255, 196, 0,   25,  16,  0,   1,   5,   0,   0,   0,   0,   0,  0,  0,
    0,   0,   0,   0,   0,   0,   0,   5,   7,   33,  51,  81,  255, 218, 0,   8,   1,   1,  0,  0,
    63,  0,   3,   182, 201, 181, 70,  10,  182, 217, 54,  168, 193, 84,  219, 38,  213, 24, 77, 86,
    217, 54,  168, 193, 84,  219, 38,  213, 24,  42,  219, 100, 218, 163, 15,  255, 217};

// 16 x 16 colour, progressive: all about (200, 60, 20).
inline constexpr std::array<unsigned char, 523> kColourJpeg = {
    255, 216, 255, 224, 0,   16,  74,  70,  73,  70,  0,   1,   1,   0,   0,   1,   0,   1,   0,
    0,   255, 219, 0,   67,  0,   3,   2,   2,   3,   2,   2,   3,   3,   3,   3,   4,   3,   3,
    4,   5,   8,   5,   5,   4,   4,   5,   10,  7,   7,   6,   8,   12,  10,  12,  12,  11,  10,
    11,  11,  13,  14,  18,  16,  13,  14,  17,  14,  11,  11,  16,  22,  16,  17,  19,  20,  21,
    21,  21,  12,  15,  23,  24,  22,  20,  24,  18,  20,  21,  20,  255, 219, 0,   67,  1,   3,
    4,   4,   5,   4,   5,   9,   5,   5,   9,   20,  13,  11,  13,  20,  20,  20,  20,  20,  20,
    20,  20,  20,  20,  20,  20,  20,  20,  20,  20,  20,  20,  20,  20,  20,  20,  20,  20,  20,
    20,  20,  20,  20,  20,  20,  20,  20,  20,  20,  20,  20,  20,  20,  20,  20,  20,  20,  20,
    20,  20,  20,  20,  20,  20,  255, 194, 0,   17,  8,   0,   16,  0,   16,  3,   1,   34,  0,
    2,   17,  1,   3,   17,  1,   255, 196, 0,   21,  0,   1,   1,   0,   0,   0,   0,   0,   0,
    0,   0,   0,   0,   0,   0,   0,   0,   0,   6,   255, 196, 0,   21,  1,   1,   1,   0,   0,
    0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   6,   7,   255, 218, 0,   12,  3,
    1,   0,   2,   16,  3,   16,  0,   0,   1,   149, 1,   44,  63,  255, 196, 0,   20,  16,  1,
    0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   32,  255, 218, 0,
    8,   1,   1,   0,   1,   5,   2,   31,  255, 196, 0,   20,  17,  1,   0,   0,   0,   0,   0,
    0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   255, 218, 0,   8,   1,   3,   1,   1,
    63,  1,   127, 255, 196, 0,   20,  17,  1,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,
    0,   0,   0,   0,   0,   0,   255, 218, 0,   8,   1,   2,   1,   1,   63,  1,   127, 255, 196,
    0,   20,  16,  1,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,
    32,  255, 218, 0,   8,   1,   1,   0,   6,   63,  2,   31,  255, 196, 0,   20,  16,  1,   0,
    0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   32,  255, 218, 0,   8,
    1,   1,   0,   1,   63,  33,  31,  255, 218, 0,   12,  3,   1,   0,   2,   0,   3,   0,   0,
    0,   16,  255, 0,   255, 196, 0,   20,  17,  1,   0,   0,   0,   0,   0,   0,   0,   0,   0,
    0,   0,   0,   0,   0,   0,   0,   255, 218, 0,   8,   1,   3,   1,   1,   63,  16,  127, 255,
    196, 0,   20,  17,  1,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,
    0,   0,   255, 218, 0,   8,   1,   2,   1,   1,   63,  16,  127, 255, 196, 0,   20,  16,  1,
    0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   0,   32,  255, 218, 0,
    8,   1,   1,   0,   1,   63,  16,  31,  255, 217};

template <class Bytes>
std::string as_string(const Bytes& bytes) {
  return {bytes.begin(), bytes.end()};
}

}  // namespace tread::testing
