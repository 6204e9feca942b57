// Options are plain structs with defaults. Each is described once, in a function
// `OptionSet describe(XOptions&)`; YAML files, the command line and help texts all go through
// that description, so that a name, a range and a meaning are written in one place.
#pragma once

#include <array>
#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tread/core/result.hpp"

namespace tread {

// A described field, bound to a live struct.
struct OptionField {
  std::string name;     // path: "sad.window_px"
  std::string meaning;  // one line
  std::string range;    // "odd, 3 to 31"; empty if any value will do
  std::function<Status(std::string_view text)> parse;
  std::function<std::string()> print;
  std::function<bool()> in_range;
  bool given = false;   // by set(), not left as it was
  bool recent = false;  // given since the last settle()
};

// What must hold between fields, each of which may be in range on its own.
struct OptionRule {
  std::vector<std::string> names;  // paths of the fields
  std::string must;                // "the nearest depth must be less than the farthest"
  std::function<bool()> holds;
};

// Knots (x, y) of a piecewise-linear function, x increasing.
using Knots = std::vector<std::array<double, 2>>;

// The fields of one options struct. Points into the struct, so must not outlive it.
class OptionSet {
 public:
  void add(std::string name, bool& value, std::string meaning);
  void add(std::string name, int& value, std::string meaning, int low, int high);
  void add_odd(std::string name, int& value, std::string meaning, int low, int high);
  void add(std::string name, double& value, std::string meaning, double low = -kInfinity,
           double high = kInfinity);
  void add(std::string name, Knots& value, std::string meaning);
  template <class Enum>
  void add_choice(std::string name, Enum& value, std::string meaning,
                  std::vector<std::pair<std::string, Enum>> choices) {
    std::vector<std::string> names;
    for (const auto& choice : choices) names.push_back(choice.first);
    add_choice_index(
        std::move(name), std::move(meaning), std::move(names),
        [&value, choices](std::size_t i) { value = choices[i].second; },
        [&value, choices] {
          std::size_t i = 0;
          while (i < choices.size() && choices[i].second != value) ++i;
          return i;
        });
  }
  // A switch with which the program chooses the value of the field `chosen` by itself. Giving that
  // value turns it off: see settle().
  void add_automatic(std::string name, bool& value, std::string meaning, std::string chosen);
  // A condition between fields that are described above; check() asks for it, set() does not, since
  // fields come in any order.
  void require(std::vector<std::string> names, std::string must, std::function<bool()> holds);
  // The fields and rules of a nested struct, under "name.".
  void add_group(const std::string& name, OptionSet group);

  // Sets one field from text. An unknown name is refused with the nearest known one; text that
  // cannot be read or is out of range leaves the field as it was.
  [[nodiscard]] Status set(std::string_view name, std::string_view text);
  // Whether set() has set this field: what a user gives, no default may override.
  [[nodiscard]] bool given(std::string_view name) const;
  // To be called when one source of settings (a file, the command line) is through: turns off the
  // automatic switches whose value it has given without naming the switch, in whatever order.
  void settle();
  // The first field that is out of range, else the first rule that is broken, with the names and
  // values of all its fields.
  [[nodiscard]] Status check() const;
  [[nodiscard]] const std::vector<OptionField>& fields() const { return fields_; }

 private:
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();
  void add_choice_index(std::string name, std::string meaning, std::vector<std::string> names,
                        std::function<void(std::size_t)> assign,
                        std::function<std::size_t()> current);
  struct Automatic {
    std::string name;
    std::string chosen;
  };
  [[nodiscard]] const OptionField* find(std::string_view name) const;
  [[nodiscard]] Error unknown(std::string_view name) const;

  std::vector<OptionField> fields_;
  std::vector<OptionRule> rules_;
  std::vector<Automatic> automatic_;
};

// Checks a struct by its description, in which the whole struct is named: "sad.window_px: ...".
template <class Options>
[[nodiscard]] Status check_options(const Options& options) {
  Options copy = options;
  return describe(copy).check();
}

// The entry nearest to `word` by edit distance, empty if none is near enough to be meant.
[[nodiscard]] std::string nearest_name(std::string_view word,
                                       const std::vector<std::string>& names);

}  // namespace tread
