// Sources: PNG specification (W3C 2003) 5 and 11.2.2; ITU-T T.81 (JPEG) annex B. Bounds on how far
// a file can expand: deflate codes at most 258 bytes in 2 bits (1032:1); a JPEG spends at least 2
// bits on an 8x8 block (256 pixels a byte), or in progressive mode 1 bit in its first scan, and is
// granted twice that.
#include "tread/io/image_header.hpp"

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <optional>

#include "tread/io/pnm.hpp"
#include "tread/io/text.hpp"

namespace tread {
namespace {

constexpr std::uint64_t kDeflateRatio = 1032;
constexpr std::uint64_t kJpegPixelsPerByte = 1024;
constexpr std::uint64_t kMostPixels = std::uint64_t{1} << 27;  // 11600 x 11600
constexpr int kLongestSide = 65535;

std::uint32_t byte_at(std::string_view bytes, std::size_t at) {
  return static_cast<unsigned char>(bytes[at]);
}
std::uint32_t big_endian_16(std::string_view bytes, std::size_t at) {
  return byte_at(bytes, at) << 8 | byte_at(bytes, at + 1);
}
std::uint32_t big_endian_32(std::string_view bytes, std::size_t at) {
  return big_endian_16(bytes, at) << 16 | big_endian_16(bytes, at + 2);
}

tl::unexpected<Error> truncated(const std::string& where, const std::string& what) {
  return fail(ErrorCode::kUnreadable, "the file is cut off: " + what, where,
              "Copy or record it again");
}
tl::unexpected<Error> damaged(const std::string& where, const std::string& what) {
  return fail(ErrorCode::kUnreadable, "the file is damaged: " + what, where,
              "Copy or record it again");
}
tl::unexpected<Error> unsupported(const std::string& where, const std::string& what) {
  return fail(ErrorCode::kUnsupported, what + " is not read", where,
              "Convert it to PNG, JPEG or PGM with 8 or 16 bits");
}

Status check_size(const ImageHeader& header, std::uint64_t most_pixels, const std::string& where) {
  if (header.width <= 0 || header.height <= 0) {
    return damaged(where, fmt::format("its size is {}x{}", header.width, header.height));
  }
  const auto pixels =
      static_cast<std::uint64_t>(header.width) * static_cast<std::uint64_t>(header.height);
  const bool too_large = header.width > kLongestSide || header.height > kLongestSide;
  if (too_large || pixels > kMostPixels) {
    return fail(ErrorCode::kUnsupported,
                fmt::format("{}x{} pixels are too many", header.width, header.height), where,
                fmt::format("Images have at most {} pixels, {} a side", kMostPixels, kLongestSide));
  }
  if (pixels > most_pixels) {
    return damaged(where, fmt::format("its header promises {}x{} pixels, more than its bytes can "
                                      "hold",
                                      header.width, header.height));
  }
  return {};
}

constexpr std::array<std::uint32_t, 256> make_crc_table() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t n = 0; n < 256; ++n) {
    std::uint32_t c = n;
    for (int bit = 0; bit < 8; ++bit) c = (c & 1U) != 0 ? 0xedb88320U ^ (c >> 1) : c >> 1;
    table[n] = c;
  }
  return table;
}

// The checksum of PNG chunks (annex D). Checked here because libpng prints to stderr.
std::uint32_t crc32_of(std::string_view bytes) {
  static constexpr std::array<std::uint32_t, 256> kTable = make_crc_table();
  std::uint32_t crc = 0xffffffffU;
  for (const char c : bytes) {
    crc = kTable[(crc ^ static_cast<unsigned char>(c)) & 0xffU] ^ (crc >> 8);
  }
  return ~crc;
}

constexpr std::string_view kPngSignature("\x89PNG\r\n\x1a\n", 8);

Result<ImageHeader> parse_ihdr(std::string_view data, const std::string& where) {
  if (data.size() != 13) return damaged(where, "its header has the wrong length");
  ImageHeader header;
  const std::uint32_t width = big_endian_32(data, 0), height = big_endian_32(data, 4);
  if (width > INT32_MAX || height > INT32_MAX) return damaged(where, "its size is negative");
  header.width = static_cast<int>(width);
  header.height = static_cast<int>(height);
  const std::uint32_t type = byte_at(data, 9);  // 1: palette, 2: colour, 4: alpha
  header.bits = static_cast<int>(byte_at(data, 8));
  header.colour = (type & 2U) != 0;
  header.alpha = (type & 4U) != 0;
  const bool valid_type = type == 0 || type == 2 || type == 3 || type == 4 || type == 6;
  const bool few_bits = header.bits == 1 || header.bits == 2 || header.bits == 4;
  const bool valid_bits = header.bits == 8 || (header.bits == 16 && type != 3) ||
                          (few_bits && (type == 0 || type == 3));
  if (!valid_type || !valid_bits) return damaged(where, "its kind of pixels does not exist");
  return header;
}

Result<ImageHeader> parse_png(std::string_view bytes, const std::string& where) {
  ImageHeader header;
  std::uint64_t compressed = 0;
  std::size_t at = kPngSignature.size();
  for (bool first = true;; first = false) {
    if (bytes.size() - at < 12) return truncated(where, "it has no end (IEND)");
    const std::uint32_t length = big_endian_32(bytes, at);
    if (length > bytes.size() - at - 12) return truncated(where, "a chunk is not complete");
    const std::string_view type = bytes.substr(at + 4, 4);
    const std::string_view data = bytes.substr(at + 8, length);
    if (crc32_of(bytes.substr(at + 4, 4 + length)) != big_endian_32(bytes, at + 8 + length)) {
      return damaged(where, "wrong checksum of chunk " + in_quotes(type));
    }
    if (first) {
      if (type != "IHDR") return damaged(where, "it does not begin with its header (IHDR)");
      const auto parsed = parse_ihdr(data, where);
      if (!parsed) return parsed;
      header = *parsed;
    }
    if (type == "IDAT") compressed += length;
    if (type == "IEND") break;
    at += 12 + length;
  }
  // A lower bound of the bytes of a pixel, in eighths.
  const auto bits = static_cast<std::uint64_t>(header.bits);
  const Status size = check_size(header, compressed * kDeflateRatio * 8 / bits, where);
  if (!size) return forward(size);
  if (header.bits < 8) header.bits = 8;  // the decoder expands them
  return header;
}

bool is_frame_marker(std::uint32_t marker) {
  return marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
}

Result<ImageHeader> parse_frame(std::uint32_t marker, std::string_view data,
                                const std::string& where) {
  if (marker > 0xc2) return unsupported(where, "this kind of JPEG (lossless or arithmetic)");
  if (data.size() < 6) return damaged(where, "its header is too short");
  const std::uint32_t components = byte_at(data, 5);
  if (byte_at(data, 0) != 8) return unsupported(where, "a JPEG of more than 8 bits");
  if (components != 1 && components != 3) {
    return unsupported(where, fmt::format("a JPEG of {} components", components));
  }
  ImageHeader header;
  header.format = ImageFormat::kJpeg;
  header.height = static_cast<int>(big_endian_16(data, 1));
  header.width = static_cast<int>(big_endian_16(data, 3));
  header.colour = components == 3;
  return header;
}

// The place behind the next marker of a JPEG, which may be padded with ff. In coded data (of a
// scan) other bytes stand before it, and there ff 00 and the restart markers are no markers.
std::optional<std::size_t> behind_marker(std::string_view bytes, std::size_t at, bool in_scan) {
  for (;;) {
    const std::size_t found = bytes.find('\xff', at);
    if (found == std::string_view::npos || (!in_scan && found != at)) return std::nullopt;
    const std::size_t code = bytes.find_first_not_of('\xff', found);
    if (code == std::string_view::npos) return std::nullopt;
    at = code + 1;
    const std::uint32_t marker = byte_at(bytes, code);
    const bool data = marker == 0x00 || (marker >= 0xd0 && marker <= 0xd7);
    if (!data) return at;
    if (!in_scan) return std::nullopt;
  }
}

// Walks the segments to the end marker.
Result<ImageHeader> parse_jpeg(std::string_view bytes, const std::string& where) {
  std::optional<ImageHeader> header;
  bool has_scan = false, in_scan = false;
  std::size_t at = 2;
  for (;;) {
    const auto behind = behind_marker(bytes, at, in_scan);
    if (!behind) {
      const bool ends = bytes.find_first_not_of('\xff', at) == std::string_view::npos;
      if (in_scan || ends) return truncated(where, "it has no end marker");
      return damaged(where, "a segment does not begin with its marker");
    }
    at = *behind;
    const std::uint32_t marker = byte_at(bytes, at - 1);
    if (marker == 0xd9) break;
    if (bytes.size() - at < 2) return truncated(where, "a segment is not complete");
    const std::size_t length = big_endian_16(bytes, at);
    if (length < 2) return damaged(where, "a segment has no length");
    if (length > bytes.size() - at) return truncated(where, "a segment is not complete");
    if (is_frame_marker(marker)) {
      const auto frame = parse_frame(marker, bytes.substr(at + 2, length - 2), where);
      if (!frame) return frame;
      if (header) return damaged(where, "it has two headers");
      header = *frame;
    }
    in_scan = marker == 0xda;
    has_scan = has_scan || in_scan;
    at += length;
  }
  if (!header || !has_scan) return damaged(where, "it has no picture");
  const Status size = check_size(*header, bytes.size() * kJpegPixelsPerByte, where);
  if (!size) return forward(size);
  return *header;
}

Result<ImageHeader> parse_pnm(std::string_view bytes, const std::string& where) {
  const auto pnm = parse_pnm_header(bytes, where);
  if (!pnm) return forward(pnm);
  const ImageHeader header{ImageFormat::kPnm, pnm->width,  pnm->height,
                           pnm->bits,         pnm->colour, false};
  const Status size = check_size(header, pnm->most_values / (pnm->colour ? 3 : 1), where);
  if (!size) return forward(size);
  return header;
}

}  // namespace

Result<ImageHeader> parse_image_header(std::string_view bytes, const std::string& where) {
  if (bytes.starts_with(kPngSignature)) return parse_png(bytes, where);
  if (bytes.starts_with("\xff\xd8\xff")) return parse_jpeg(bytes, where);
  if (is_pnm(bytes)) return parse_pnm(bytes, where);
  if (bytes.empty()) return truncated(where, "it is empty");
  if (kPngSignature.starts_with(bytes) || std::string_view("\xff\xd8").starts_with(bytes)) {
    return truncated(where, "it has no header");
  }
  return unsupported(where, "this kind of file");
}

}  // namespace tread
