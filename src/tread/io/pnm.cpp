#include "tread/io/pnm.hpp"

#include <fmt/format.h>

#include <optional>

#include "tread/io/text.hpp"

namespace tread {
namespace {

tl::unexpected<Error> damaged(const std::string& where, const std::string& what) {
  return fail(ErrorCode::kUnreadable, "the file is damaged: " + what, where,
              "Copy or record it again");
}

// The next number behind blanks and comments; `at` is then behind it.
std::optional<int> next_number(std::string_view bytes, std::size_t& at) {
  const auto blank = [](char c) { return c == ' ' || (c >= '\t' && c <= '\r'); };
  while (at < bytes.size() && (blank(bytes[at]) || bytes[at] == '#')) {
    if (bytes[at] == '#') {
      while (at < bytes.size() && bytes[at] != '\n') ++at;
    } else {
      ++at;
    }
  }
  const std::size_t first = at;
  while (at < bytes.size() && bytes[at] >= '0' && bytes[at] <= '9') ++at;
  return parse_number<int>(bytes.substr(first, at - first));
}

}  // namespace

bool is_pnm(std::string_view bytes) {
  constexpr std::string_view kKinds = "2356";
  return bytes.size() > 2 && bytes[0] == 'P' && kKinds.find(bytes[1]) != std::string_view::npos;
}

Result<PnmHeader> parse_pnm_header(std::string_view bytes, const std::string& where) {
  std::size_t at = 2;
  const auto width = next_number(bytes, at), height = next_number(bytes, at);
  const auto largest = next_number(bytes, at);
  if (!width || !height || !largest || at >= bytes.size()) {
    return damaged(where, "its header cannot be read");
  }
  if (*largest != 255 && *largest != 65535) {
    return fail(ErrorCode::kUnsupported,
                fmt::format("a PGM or PPM with a largest value of {} is not read", *largest), where,
                "Convert it to one of 255 or 65535, or to PNG");
  }
  PnmHeader header;
  header.width = *width;
  header.height = *height;
  header.bits = *largest == 255 ? 8 : 16;
  header.colour = bytes[1] == '3' || bytes[1] == '6';
  header.text = bytes[1] == '2' || bytes[1] == '3';
  header.body = at + 1;
  const std::size_t rest = bytes.size() - header.body;
  // Text: a digit and a blank a value, but the last.
  header.most_values = header.text ? (rest + 1) / 2 : rest / (header.bits == 8 ? 1 : 2);
  return header;
}

Result<std::vector<std::uint16_t>> decode_pnm(std::string_view bytes, const PnmHeader& header,
                                              const std::string& where) {
  const std::size_t count = static_cast<std::size_t>(header.width) *
                            static_cast<std::size_t>(header.height) * (header.colour ? 3 : 1);
  std::vector<std::uint16_t> values(count);
  std::size_t at = header.body;
  const auto byte = [&] { return static_cast<unsigned char>(bytes[at++]); };
  const int largest = header.bits == 8 ? 255 : 65535;
  for (std::uint16_t& value : values) {
    if (header.text) {
      const auto number = next_number(bytes, at);
      if (!number || *number > largest) return damaged(where, "a pixel cannot be read");
      value = static_cast<std::uint16_t>(*number);
    } else if (header.bits == 8) {
      value = byte();
    } else {
      const unsigned high = byte();
      value = static_cast<std::uint16_t>(high << 8U | byte());
    }
  }
  return values;
}

}  // namespace tread
