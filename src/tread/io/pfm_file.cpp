// Portable float map: three texts ("Pf", size, scale), one blank, then rows of float32 from the
// bottom row to the top one. A negative scale says little endian.
#include <fmt/format.h>

#include <bit>
#include <cstring>

#include "tread/io/atomic_file.hpp"
#include "tread/io/image_file.hpp"
#include "tread/io/text.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLargestFile = std::size_t{1} << 31;

tl::unexpected<Error> bad_pfm(const fs::path& path, const std::string& what) {
  return fail(ErrorCode::kBadFormat, what, path.string(), "Check that this is a PFM file");
}

// The text up to the next blank; `at` is then at that blank.
std::string_view next_text(std::string_view bytes, std::size_t& at) {
  constexpr std::string_view kBlank = " \t\r\n";
  constexpr std::size_t kLongest = 64;
  const std::size_t first = std::min(bytes.find_first_not_of(kBlank, at), bytes.size());
  const std::size_t end = bytes.substr(first, kLongest).find_first_of(kBlank);
  at = end == std::string_view::npos ? bytes.size() : first + end;
  return bytes.substr(first, at - first);
}

struct PfmHeader {
  std::size_t width = 0;
  std::size_t height = 0;
  bool little_endian = true;
  std::size_t bytes = 0;
};

Result<PfmHeader> parse_header(std::string_view bytes, const fs::path& path) {
  std::size_t at = 0;
  const std::string_view magic = next_text(bytes, at);
  if (magic == "PF") {
    return fail(ErrorCode::kUnsupported, "a colour PFM is not read", path.string(),
                "Give one of a single channel ('Pf')");
  }
  if (magic != "Pf" || !bytes.starts_with("Pf"))
    return bad_pfm(path, "it does not begin with 'Pf'");
  const auto width = parse_number<int>(next_text(bytes, at));
  const auto height = parse_number<int>(next_text(bytes, at));
  const auto scale = parse_number<double>(next_text(bytes, at));
  if (!width || !height || *width <= 0 || *height <= 0) {
    return bad_pfm(path, "its size cannot be read");
  }
  if (!scale || !(*scale < 0.0 || *scale > 0.0)) return bad_pfm(path, "its scale cannot be read");
  // One blank ends the header; behind a carriage return a line feed belongs to it only if the
  // number of bytes says so, for it may as well be the first byte of a pixel.
  const std::size_t body = static_cast<std::size_t>(*width) * static_cast<std::size_t>(*height) * 4;
  const std::size_t rest = bytes.size() - std::min(at + 1, bytes.size());
  const bool two = rest == body + 1 && bytes[at] == '\r' && bytes[at + 1] == '\n';
  if (rest < body) {
    return fail(ErrorCode::kUnreadable, fmt::format("{} bytes of pixels instead of {}", rest, body),
                path.string(), "The file is cut off: copy or write it again");
  }
  if (rest > body && !two) {
    return bad_pfm(path, fmt::format("{} bytes of pixels instead of {}", rest, body));
  }
  return PfmHeader{static_cast<std::size_t>(*width), static_cast<std::size_t>(*height),
                   *scale < 0.0, at + (two ? 2 : 1)};
}

float swapped(float value) {
  auto bits = std::bit_cast<std::uint32_t>(value);
  bits = bits >> 24 | (bits >> 8 & 0xff00U) | (bits << 8 & 0xff0000U) | bits << 24;
  return std::bit_cast<float>(bits);
}

}  // namespace

Result<Image<float>> read_pfm(const fs::path& path) {
  const auto bytes = read_file(path, kLargestFile);
  if (!bytes) return forward(bytes);
  const auto header = parse_header(*bytes, path);
  if (!header) return forward(header);
  Image<float> image(static_cast<int>(header->width), static_cast<int>(header->height));
  const char* from = bytes->data() + header->bytes;
  const bool swap = header->little_endian != (std::endian::native == std::endian::little);
  for (int y = image.height - 1; y >= 0; --y, from += header->width * sizeof(float)) {
    std::memcpy(image.row(y), from, header->width * sizeof(float));
    if (swap) std::transform(image.row(y), image.row(y) + image.width, image.row(y), swapped);
  }
  return image;
}

Status write_pfm(const fs::path& path, ImageView<const float> image) {
  if (image.empty()) {
    return fail(ErrorCode::kBadArgument, "an image without pixels cannot be written", path.string(),
                "Give an image");
  }
  std::string bytes = fmt::format("Pf\n{} {}\n-1\n", image.width, image.height);
  const auto row_bytes = static_cast<std::size_t>(image.width) * sizeof(float);
  bytes.reserve(bytes.size() + row_bytes * static_cast<std::size_t>(image.height));
  std::vector<float> row(static_cast<std::size_t>(image.width));
  for (int y = image.height - 1; y >= 0; --y) {
    std::copy(image.row(y), image.row(y) + image.width, row.begin());
    if (std::endian::native != std::endian::little) {
      std::transform(row.begin(), row.end(), row.begin(), swapped);
    }
    bytes.append(reinterpret_cast<const char*>(row.data()), row_bytes);
  }
  return write_file(path, bytes);
}

}  // namespace tread
