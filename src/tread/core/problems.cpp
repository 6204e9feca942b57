#include "tread/core/problems.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>

namespace tread {
namespace {

// The text with one '#' for each number, sign and exponent included.
std::string without_numbers(const std::string& text) {
  std::string left;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto is_digit = [&](std::size_t at) {
      return at < text.size() && text[at] >= '0' && text[at] <= '9';
    };
    if (!is_digit(i)) {
      left += text[i];
      continue;
    }
    left += '#';
    while (
        is_digit(i + 1) || (i + 1 < text.size() && text[i + 1] == '.' && is_digit(i + 2)) ||
        (i + 2 < text.size() && text[i + 1] == 'e' && (text[i + 2] == '+' || text[i + 2] == '-'))) {
      i += is_digit(i + 1) ? 1 : 2;
    }
  }
  return left;
}

struct Kind {
  ErrorCode code;
  std::string what;
  std::string remedy;
  std::size_t count;
  [[nodiscard]] bool is(const Kind& other) const {
    return code == other.code && what == other.what && remedy == other.remedy;
  }
};

}  // namespace

std::vector<Error> distinct_problems(const std::vector<Error>& problems, std::size_t most) {
  std::vector<Kind> kinds;
  std::vector<Error> firsts;
  std::size_t beyond = 0;
  for (const Error& problem : problems) {
    const Kind kind{problem.code, without_numbers(problem.what), without_numbers(problem.remedy),
                    1};
    const auto known =
        std::find_if(kinds.begin(), kinds.end(), [&](const Kind& other) { return other.is(kind); });
    if (known != kinds.end()) {
      ++known->count;
    } else if (kinds.size() < most) {
      kinds.push_back(kind);
      firsts.push_back(problem);
    } else {
      ++beyond;
    }
  }
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    if (kinds[i].count > 1) {
      firsts[i].what += fmt::format(" (and {} more like it)", kinds[i].count - 1);
    }
  }
  if (beyond > 0) {
    firsts.push_back({ErrorCode::kBadValue, fmt::format("and {} problems of other kinds", beyond),
                      "", "Mend the ones above first"});
  }
  return firsts;
}

}  // namespace tread
