// Internal to io: the tables of EuRoC/ASL folders, "stamp in ns,number,number,..." a line.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "tread/core/result.hpp"

namespace tread::internal {

struct StampedRow {
  std::int64_t stamp_ns = 0;  // not negative
  int line = 0;
  std::span<const double> numbers;  // as many as the layout says
};

// Rows of one layout, whose numbers lie one behind the other.
class StampedTable {
 public:
  explicit StampedTable(std::size_t numbers = 0) : columns_(numbers) {}
  [[nodiscard]] std::size_t size() const { return stamps_ns_.size(); }
  [[nodiscard]] StampedRow operator[](std::size_t row) const {
    return {stamps_ns_[row], lines_[row], std::span(numbers_).subspan(row * columns_, columns_)};
  }
  void add(const StampedRow& row) {
    stamps_ns_.push_back(row.stamp_ns);
    lines_.push_back(row.line);
    numbers_.insert(numbers_.end(), row.numbers.begin(), row.numbers.end());
  }

 private:
  std::size_t columns_;
  std::vector<std::int64_t> stamps_ns_;
  std::vector<int> lines_;
  std::vector<double> numbers_;
};

struct CsvLayout {
  std::size_t numbers = 0;    // that are read behind the stamp, all finite
  bool more_columns = false;  // further ones may follow, whatever they are
  const char* line = "";      // "time in ns, wx, wy", for messages
  // What is wrong with numbers that were read; nothing if they are fine.
  const char* (*wrong)(const StampedRow& row) = nullptr;
};

// The rows in strictly increasing order of time; lines that start with '#' are skipped. A line that
// cannot be read, or whose time does not fit those around it (as few as possible are left out; of
// two of one time the second), is left out: one entry in `problems` for each of the two kinds says
// how many and names the first few. Without `problems` the first such line is the error of the
// whole; so it is if no line is left.
[[nodiscard]] Result<StampedTable> read_stamped_csv(const std::filesystem::path& path,
                                                    const CsvLayout& layout,
                                                    std::vector<Error>* problems);

}  // namespace tread::internal
