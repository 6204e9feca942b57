// The command line of a benchmark.
#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tread/core/options.hpp"
#include "tread/io/text.hpp"

namespace tread::bench {

//   bench::Arguments arguments("stereo_speed");
//   arguments.flag("--json", json).number("--turns", turns, 1).options(described);
//   if (const auto status = arguments.read(argc, argv)) return *status;
class Arguments {
 public:
  explicit Arguments(std::string program) : program_(std::move(program)) {}

  // What is referred to is written by read().
  Arguments& flag(const char* name, bool& given) {
    flags_.emplace_back(name, &given);
    return *this;
  }
  Arguments& number(const char* name, int& value, int least) {
    numbers_.push_back({name, &value, least});
    return *this;
  }
  // Words of the form name=value.
  Arguments& options(OptionSet& set) {
    options_ = &set;
    return *this;
  }

  // The exit status if the program shall end now: after --help, or what it does not know.
  [[nodiscard]] std::optional<int> read(int argc, char** argv) const {
    for (int i = 1; i < argc; ++i) {
      const std::string_view word = argv[i];
      if (word == "--help" || word == "-h") {
        fmt::print("{}", usage());
        return 0;
      }
      if (set_flag(word)) continue;
      if (i + 1 < argc && set_number(word, argv[i + 1])) {
        ++i;
        continue;
      }
      const std::size_t equals = word.find('=');
      if (options_ == nullptr || equals == std::string_view::npos) {
        fmt::print(stderr, "{}", usage());
        return 2;
      }
      const Status done =
          options_->set(std::string(word.substr(0, equals)), std::string(word.substr(equals + 1)));
      if (!done) {
        fmt::print(stderr, "{}\n", done.error().message());
        return 2;
      }
    }
    return std::nullopt;
  }

 private:
  struct Number {
    const char* name;
    int* value;
    int least;
  };
  [[nodiscard]] std::string usage() const {
    std::string text = "usage: " + program_;
    for (const auto& [name, given] : flags_) text += fmt::format(" [{}]", name);
    for (const Number& number : numbers_) text += fmt::format(" [{} N]", number.name);
    return text + (options_ != nullptr ? " [name=value ...]\n" : "\n");
  }
  [[nodiscard]] bool set_flag(std::string_view word) const {
    for (const auto& [name, given] : flags_) {
      if (word != name) continue;
      *given = true;
      return true;
    }
    return false;
  }
  [[nodiscard]] bool set_number(std::string_view word, std::string_view text) const {
    for (const Number& number : numbers_) {
      const auto value = parse_number<int>(text);
      if (word != number.name || !value || *value < number.least) continue;
      *number.value = *value;
      return true;
    }
    return false;
  }

  std::string program_;
  std::vector<std::pair<const char*, bool*>> flags_;
  std::vector<Number> numbers_;
  OptionSet* options_ = nullptr;
};

}  // namespace tread::bench
