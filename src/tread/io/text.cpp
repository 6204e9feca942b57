#include "tread/io/text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

namespace tread {
namespace {

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

// A decimal number taken apart: sign, digits, and the power of ten of the last digit.
struct Decimal {
  bool negative = false;
  std::string digits;
  std::int64_t exponent = 0;
};

std::optional<Decimal> parse_decimal(std::string_view text) {
  Decimal decimal;
  if (!text.empty() && (text.front() == '+' || text.front() == '-')) {
    decimal.negative = text.front() == '-';
    text.remove_prefix(1);
  }
  bool after_point = false;
  std::size_t i = 0;
  for (; i < text.size(); ++i) {
    if (is_digit(text[i])) {
      decimal.digits += text[i];
      if (after_point) --decimal.exponent;
    } else if (text[i] == '.' && !after_point) {
      after_point = true;
    } else {
      break;
    }
  }
  if (decimal.digits.empty()) return std::nullopt;
  if (i == text.size()) return decimal;
  if (text[i] != 'e' && text[i] != 'E') return std::nullopt;
  const auto power = parse_number<int>(text.substr(i + 1));
  if (!power) return std::nullopt;
  decimal.exponent += *power;
  return decimal;
}

}  // namespace

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r\n\v\f";
  const std::size_t first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

std::vector<TextLine> lines_with_content(std::string_view text) {
  std::vector<TextLine> lines;
  int number = 0;
  while (!text.empty()) {
    ++number;
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = trimmed(text.substr(0, end));
    if (!line.empty() && line.front() != '#') lines.push_back({number, line});
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

std::vector<std::string_view> split_fields(std::string_view line) {
  std::vector<std::string_view> fields;
  constexpr std::string_view kBlank = " \t\r";
  for (std::size_t at = line.find_first_not_of(kBlank); at != std::string_view::npos;
       at = line.find_first_not_of(kBlank, at)) {
    const std::size_t end = std::min(line.find_first_of(kBlank, at), line.size());
    fields.push_back(line.substr(at, end - at));
    at = end;
  }
  return fields;
}

std::optional<std::int64_t> parse_seconds_as_ns(std::string_view text) {
  auto decimal = parse_decimal(text);
  if (!decimal) return std::nullopt;
  // Position of the nanosecond digit: so many digits of the number are whole nanoseconds.
  const std::int64_t whole_digits =
      static_cast<std::int64_t>(decimal->digits.size()) + decimal->exponent + 9;
  constexpr std::int64_t kLimit = std::numeric_limits<std::int64_t>::max();
  std::int64_t value = 0;
  for (std::int64_t i = 0; i < whole_digits; ++i) {
    const bool written = i < static_cast<std::int64_t>(decimal->digits.size());
    if (!written && value == 0) break;  // "0e99999"
    const int digit = written ? decimal->digits[static_cast<std::size_t>(i)] - '0' : 0;
    if (value > (kLimit - digit) / 10) return std::nullopt;
    value = value * 10 + digit;
  }
  const bool has_rest =
      whole_digits >= 0 && whole_digits < static_cast<std::int64_t>(decimal->digits.size());
  if (has_rest && decimal->digits[static_cast<std::size_t>(whole_digits)] >= '5') {
    if (value == kLimit) return std::nullopt;
    ++value;
  }
  return decimal->negative ? -value : value;
}

std::string print_ns_as_seconds(std::int64_t stamp_ns) {
  // Unsigned, so that the most negative number has a magnitude.
  const std::uint64_t magnitude = stamp_ns < 0 ? 0U - static_cast<std::uint64_t>(stamp_ns)
                                               : static_cast<std::uint64_t>(stamp_ns);
  constexpr std::uint64_t kSecond = 1'000'000'000U;
  return fmt::format("{}{}.{:09d}", stamp_ns < 0 ? "-" : "", magnitude / kSecond,
                     magnitude % kSecond);
}

std::string line_place(const std::string& file, int line) {
  return fmt::format("{}:{}", file, line);
}

std::string yaml_text(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      quoted += '\\';
      quoted += c;
    } else if (byte < 0x20 || byte == 0x7f) {
      quoted += fmt::format("\\x{:02x}", byte);
    } else {
      quoted += c;
    }
  }
  return quoted + "\"";
}

std::string in_quotes(std::string_view text) {
  constexpr std::size_t kLongest = 40;
  std::string shown;
  for (const char c : text.substr(0, kLongest)) {
    const auto byte = static_cast<unsigned char>(c);
    shown += (byte < 0x20 || byte >= 0x7f) ? '?' : c;
  }
  return fmt::format("'{}{}'", shown, text.size() > kLongest ? "..." : "");
}

}  // namespace tread
