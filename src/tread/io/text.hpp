// What the readers of text files share: lines with their numbers, fields, numbers and times that
// do not depend on the locale, and texts of messages.
#pragma once

#include <charconv>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tread {

struct TextLine {
  int number = 0;  // from 1
  std::string_view text;
};

// The lines that hold something: blank lines and those that start with '#' are left out, carriage
// returns and blanks at both ends removed. Borrows `text`.
[[nodiscard]] std::vector<TextLine> lines_with_content(std::string_view text);

// Fields between blanks and tabs. Borrows `line`.
[[nodiscard]] std::vector<std::string_view> split_fields(std::string_view line);

[[nodiscard]] std::string_view trimmed(std::string_view text);

// The whole text as a number; empty if it is not one or does not fit T.
template <class T>
[[nodiscard]] std::optional<T> parse_number(std::string_view text) {
  if (!text.empty() && text.front() == '+') {
    text.remove_prefix(1);
    if (!text.empty() && text.front() == '-') return std::nullopt;
  }
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// Seconds as decimal text ("1305031102.175304", "1.7e9") in nanoseconds, exact: no floating-point
// number is between. Digits beyond the ninth round to nearest, halves away from zero. Empty if the
// text is not a number or is beyond +-292 years.
[[nodiscard]] std::optional<std::int64_t> parse_seconds_as_ns(std::string_view text);
// The inverse: "1305031102.175304000".
[[nodiscard]] std::string print_ns_as_seconds(std::int64_t stamp_ns);

// "poses.txt:12", how messages name a line.
[[nodiscard]] std::string line_place(const std::string& file, int line);

// As text of YAML in double quotes, where every control byte can be written.
[[nodiscard]] std::string yaml_text(std::string_view text);

// Text from a file as it may stand in a message: at most 40 bytes, control bytes as '?'.
[[nodiscard]] std::string in_quotes(std::string_view text);

}  // namespace tread
