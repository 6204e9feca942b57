// Times in order are found as the longest increasing subsequence (Fredman 1975), O(n log n): one
// stamp with a wrong digit, hours ahead, costs its own line and not all behind it.
#include "tread/io/stamped_csv.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>

#include "tread/io/atomic_file.hpp"
#include "tread/io/text.hpp"
#include "tread/io/text_tree.hpp"

namespace tread::internal {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLargestFile = std::size_t{1} << 30;

// Lines that were left out for one reason, told in one message.
class LeftOut {
 public:
  explicit LeftOut(Error kind) : kind_(std::move(kind)) {}
  // `what` says more about a line; that of the first is told.
  void add(int line, std::string_view what) {
    constexpr std::size_t kNamed = 5;
    if (count_++ == 0) first_ = what;
    if (named_.size() < kNamed) named_.push_back(line);
  }
  [[nodiscard]] bool empty() const { return count_ == 0; }
  // The first of them as an error of its own.
  [[nodiscard]] Error first(const fs::path& path) const {
    Error error = kind_;
    error.what = first_;
    error.where = line_place(path.string(), named_.front());
    return error;
  }
  [[nodiscard]] Error all(const fs::path& path) const {
    Error error = first(path);
    if (count_ == 1) {
      error.what += "; the line was left out";
      return error;
    }
    const std::size_t others = count_ - named_.size();
    error.what +=
        fmt::format("; {} lines were left out for the like: {}{}", count_, fmt::join(named_, ", "),
                    others > 0 ? fmt::format(" and {} more", others) : "");
    return error;
  }

 private:
  Error kind_;
  std::string first_;
  std::vector<int> named_;
  std::size_t count_ = 0;
};

// Up to `most` fields between commas, without the blanks around them; the last holds the rest.
std::vector<std::string_view> comma_fields(std::string_view line, std::size_t most) {
  std::vector<std::string_view> fields;
  for (;;) {
    const std::size_t comma = fields.size() + 1 < most ? line.find(',') : std::string_view::npos;
    fields.push_back(trimmed(line.substr(0, comma)));
    if (comma == std::string_view::npos) return fields;
    line.remove_prefix(comma + 1);
  }
}

// The stamp of a line, whose numbers go into `numbers`; or what is wrong with it.
tl::expected<StampedRow, std::string> parse_row(const TextLine& line, const CsvLayout& layout,
                                                std::vector<double>& numbers) {
  const std::size_t columns = 1 + layout.numbers;
  const auto fields = comma_fields(line.text, columns + 1);
  if (fields.size() < columns || (fields.size() > columns && !layout.more_columns)) {
    return tl::unexpected(
        fmt::format("{} columns than {}", fields.size() < columns ? "fewer" : "more", columns));
  }
  const auto stamp_ns = parse_number<std::int64_t>(fields[0]);
  if (!stamp_ns || *stamp_ns < 0) {
    return tl::unexpected(in_quotes(fields[0]) + " is not a time in whole nanoseconds");
  }
  for (std::size_t i = 0; i < layout.numbers; ++i) {
    const auto number = parse_finite(fields[i + 1]);
    if (!number) return tl::unexpected(in_quotes(fields[i + 1]) + " is not a finite number");
    numbers[i] = *number;
  }
  const StampedRow row{*stamp_ns, line.number, numbers};
  const char* wrong = layout.wrong == nullptr ? nullptr : layout.wrong(row);
  if (wrong != nullptr) return tl::unexpected(std::string(wrong));
  return row;
}

// True for the rows that make up the longest series of increasing times.
std::vector<bool> in_order_of_time(const StampedTable& rows) {
  constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  std::vector<std::size_t> last_of_length;  // the row with the earliest time that ends a series
  std::vector<std::size_t> before(rows.size(), kNone);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto place =
        std::lower_bound(last_of_length.begin(), last_of_length.end(), rows[i].stamp_ns,
                         [&](std::size_t a, std::int64_t t) { return rows[a].stamp_ns < t; });
    if (place != last_of_length.begin()) before[i] = *(place - 1);
    if (place == last_of_length.end()) {
      last_of_length.push_back(i);
    } else if (rows[i].stamp_ns < rows[*place].stamp_ns) {  // of equal times the first stays
      *place = i;
    }
  }
  std::vector<bool> kept(rows.size(), false);
  for (std::size_t i = last_of_length.empty() ? kNone : last_of_length.back(); i != kNone;
       i = before[i]) {
    kept[i] = true;
  }
  return kept;
}

Result<StampedTable> read(const fs::path& path, const CsvLayout& layout,
                          std::vector<Error>* problems) {
  const auto text = read_file(path, kLargestFile);
  if (!text) return forward(text);
  LeftOut damaged({ErrorCode::kBadFormat, "", "",
                   fmt::format("Correct or remove such lines; one is: {}", layout.line)});
  LeftOut disordered({ErrorCode::kBadValue, "", "", "Sort the lines by time and remove doubles"});
  StampedTable rows(layout.numbers);
  std::vector<double> numbers(layout.numbers);
  for (const TextLine& line : lines_with_content(*text)) {
    const auto row = parse_row(line, layout, numbers);
    if (row) {
      rows.add(*row);
    } else {
      damaged.add(line.number, row.error());
    }
  }
  const std::vector<bool> kept = in_order_of_time(rows);
  StampedTable ordered(layout.numbers);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (kept[i]) {
      ordered.add(rows[i]);
    } else {
      disordered.add(rows[i].line, "the time does not fit between those around it");
    }
  }
  for (const LeftOut* lines : {&damaged, &disordered}) {
    if (lines->empty()) continue;
    if (problems == nullptr || ordered.size() == 0) {
      return tl::unexpected<Error>(lines->first(path));
    }
    problems->push_back(lines->all(path));
  }
  if (ordered.size() > 0) return ordered;
  return fail(ErrorCode::kBadFormat, "there is no line with numbers in it", path.string(),
              fmt::format("Write lines of: {}", layout.line));
}

}  // namespace

Result<StampedTable> read_stamped_csv(const fs::path& path, const CsvLayout& layout,
                                      std::vector<Error>* problems) {
  return with_memory_checked(path.string(), "Give a part of the file",
                             [&] { return read(path, layout, problems); });
}

}  // namespace tread::internal
