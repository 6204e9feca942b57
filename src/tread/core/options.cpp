#include "tread/core/options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <charconv>
#include <cmath>
#include <numeric>

namespace tread {
namespace {

std::string_view trimmed(std::string_view text) {
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

template <class T>
bool read_number(std::string_view text, T& value) {
  text = trimmed(text);
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  T read{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), read);
  if (error != std::errc() || end != text.data() + text.size()) return false;
  value = read;
  return true;
}

tl::unexpected<Error> unreadable(std::string_view name, std::string_view text,
                                 const std::string& expected) {
  return fail(ErrorCode::kBadValue, fmt::format("'{}' is not {}", text, expected),
              std::string(name), fmt::format("Give {}", expected));
}

std::string range_text(double low, double high) {
  if (std::isinf(low) && std::isinf(high)) return "";
  if (std::isinf(high)) return fmt::format("{:g} or more", low);
  if (std::isinf(low)) return fmt::format("{:g} or less", high);
  return fmt::format("{:g} to {:g}", low, high);
}

template <class T>
OptionField number_field(std::string name, T& value, std::string meaning, std::string range,
                         std::function<bool(T)> allowed, const std::string& kind) {
  OptionField field;
  field.parse = [name, &value, range, allowed, kind](std::string_view text) -> Status {
    T read{};
    if (!read_number(text, read)) return unreadable(name, text, kind);
    if (!allowed(read)) {
      return fail(ErrorCode::kBadValue, fmt::format("{} is out of range", trimmed(text)), name,
                  fmt::format("Give {}, {}", kind, range));
    }
    value = read;
    return {};
  };
  field.print = [&value] { return fmt::format("{}", value); };
  field.in_range = [&value, allowed] { return allowed(value); };
  field.name = std::move(name);
  field.meaning = std::move(meaning);
  field.range = std::move(range);
  return field;
}

bool increasing(const Knots& knots) {
  for (std::size_t i = 0; i < knots.size(); ++i) {
    if (!std::isfinite(knots[i][0]) || !std::isfinite(knots[i][1])) return false;
    if (i > 0 && knots[i][0] <= knots[i - 1][0]) return false;
  }
  return !knots.empty();
}

// "0.04:1 0.16:20 0.64:100"
bool read_knots(std::string_view text, Knots& knots) {
  Knots read;
  text = trimmed(text);
  while (!text.empty()) {
    const std::size_t end = std::min(text.find_first_of(" ,"), text.size());
    const std::string_view pair = text.substr(0, end);
    const std::size_t colon = pair.find(':');
    std::array<double, 2> knot{};
    if (colon == std::string_view::npos || !read_number(pair.substr(0, colon), knot[0]) ||
        !read_number(pair.substr(colon + 1), knot[1])) {
      return false;
    }
    read.push_back(knot);
    text = end == text.size() ? std::string_view{} : trimmed(text.substr(end + 1));
  }
  if (!increasing(read)) return false;
  knots = std::move(read);
  return true;
}

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row.back();
}

}  // namespace

void OptionSet::add(std::string name, bool& value, std::string meaning) {
  OptionField field;
  field.parse = [name, &value](std::string_view text) -> Status {
    const std::string_view word = trimmed(text);
    const bool yes = word == "true" || word == "yes" || word == "on" || word == "1";
    const bool no = word == "false" || word == "no" || word == "off" || word == "0";
    if (!yes && !no) return unreadable(name, text, "true or false");
    value = yes;
    return {};
  };
  field.print = [&value] { return std::string(value ? "true" : "false"); };
  field.in_range = [] { return true; };
  field.name = std::move(name);
  field.meaning = std::move(meaning);
  field.range = "true or false";
  fields_.push_back(std::move(field));
}

void OptionSet::add(std::string name, int& value, std::string meaning, int low, int high) {
  fields_.push_back(number_field<int>(
      std::move(name), value, std::move(meaning), fmt::format("{} to {}", low, high),
      [low, high](int v) { return v >= low && v <= high; }, "a whole number"));
}

void OptionSet::add_odd(std::string name, int& value, std::string meaning, int low, int high) {
  fields_.push_back(number_field<int>(
      std::move(name), value, std::move(meaning), fmt::format("odd, {} to {}", low, high),
      [low, high](int v) { return v >= low && v <= high && v % 2 != 0; }, "a whole number"));
}

void OptionSet::add(std::string name, double& value, std::string meaning, double low, double high) {
  fields_.push_back(number_field<double>(
      std::move(name), value, std::move(meaning), range_text(low, high),
      [low, high](double v) { return !std::isnan(v) && v >= low && v <= high; }, "a number"));
}

void OptionSet::add(std::string name, Knots& value, std::string meaning) {
  OptionField field;
  field.parse = [name, &value](std::string_view text) -> Status {
    if (read_knots(text, value)) return {};
    return unreadable(name, text, "knots x:y with x increasing, as '0.04:1 0.16:20'");
  };
  field.print = [&value] {
    std::string text;
    for (const auto& knot : value) {
      text += fmt::format("{}{}:{}", text.empty() ? "" : " ", knot[0], knot[1]);
    }
    return text;
  };
  field.in_range = [&value] { return increasing(value); };
  field.name = std::move(name);
  field.meaning = std::move(meaning);
  field.range = "knots x:y, x increasing";
  fields_.push_back(std::move(field));
}

void OptionSet::add_choice_index(std::string name, std::string meaning,
                                 std::vector<std::string> names,
                                 std::function<void(std::size_t)> assign,
                                 std::function<std::size_t()> current) {
  const std::string range = fmt::format("{}", fmt::join(names, ", "));
  OptionField field;
  field.parse = [name, names, range, assign](std::string_view text) -> Status {
    const auto found = std::find(names.begin(), names.end(), trimmed(text));
    if (found == names.end()) return unreadable(name, text, "one of " + range);
    assign(static_cast<std::size_t>(found - names.begin()));
    return {};
  };
  field.print = [names, current] {
    const std::size_t i = current();
    return i < names.size() ? names[i] : std::string("?");
  };
  field.in_range = [names, current] { return current() < names.size(); };
  field.name = std::move(name);
  field.meaning = std::move(meaning);
  field.range = range;
  fields_.push_back(std::move(field));
}

void OptionSet::add_automatic(std::string name, bool& value, std::string meaning,
                              std::string chosen) {
  automatic_.push_back({name, std::move(chosen)});
  add(std::move(name), value, std::move(meaning));
}

void OptionSet::add_group(const std::string& name, OptionSet group) {
  const std::string prefix = name + ".";
  for (OptionField& field : group.fields_) {
    field.name.insert(0, prefix);
    fields_.push_back(std::move(field));
  }
  for (OptionRule& rule : group.rules_) {
    for (std::string& field : rule.names) field.insert(0, prefix);
    rules_.push_back(std::move(rule));
  }
  for (Automatic& pair : group.automatic_) {
    automatic_.push_back({prefix + pair.name, prefix + pair.chosen});
  }
}

void OptionSet::require(std::vector<std::string> names, std::string must,
                        std::function<bool()> holds) {
  for ([[maybe_unused]] const std::string& name : names) assert(find(name) != nullptr);
  rules_.push_back({std::move(names), std::move(must), std::move(holds)});
}

const OptionField* OptionSet::find(std::string_view name) const {
  const auto found = std::find_if(fields_.begin(), fields_.end(),
                                  [name](const OptionField& field) { return field.name == name; });
  return found == fields_.end() ? nullptr : &*found;
}

Status OptionSet::set(std::string_view name, std::string_view text) {
  for (OptionField& field : fields_) {
    if (field.name != name) continue;
    Status done = field.parse(text);
    if (!done) {
      done.error().where = field.name;  // the whole path, also inside groups
      return done;
    }
    field.given = field.recent = true;
    return done;
  }
  return tl::unexpected<Error>(unknown(name));
}

// What to say of a name that is none of the fields.
Error OptionSet::unknown(std::string_view name) const {
  std::vector<std::string> names, top, within;
  for (const OptionField& field : fields_) {
    names.push_back(field.name);
    const std::size_t dot = field.name.find('.');
    std::string first =
        dot == std::string::npos ? field.name : field.name.substr(0, dot) + ".(...)";
    if (top.empty() || top.back() != first) top.push_back(std::move(first));
    const bool inside = field.name.size() > name.size() && field.name.starts_with(name) &&
                        field.name[name.size()] == '.';
    if (inside) within.push_back(field.name);
  }
  if (!within.empty()) {
    constexpr std::size_t kShown = 4;
    const std::size_t all = within.size();
    within.resize(std::min(all, kShown));
    return {ErrorCode::kNotFound, "this is a group of options and has no value of its own",
            std::string(name),
            fmt::format("Name one of its {} options: {}{}", all, fmt::join(within, ", "),
                        all > kShown ? ", ..." : "")};
  }
  const std::string near = nearest_name(name, names);
  return {ErrorCode::kNotFound, "unknown option", std::string(name),
          near.empty() ? fmt::format("Known are: {}", fmt::join(top, ", "))
                       : fmt::format("Did you mean '{}'?", near)};
}

bool OptionSet::given(std::string_view name) const {
  const OptionField* field = find(name);
  return field != nullptr && field->given;
}

void OptionSet::settle() {
  for (const Automatic& pair : automatic_) {
    const OptionField* own = find(pair.name);
    const OptionField* chosen = find(pair.chosen);
    if (own == nullptr || chosen == nullptr || own->recent || !chosen->recent) continue;
    [[maybe_unused]] const Status off = own->parse("false");
  }
  for (OptionField& field : fields_) field.recent = false;
}

Status OptionSet::check() const {
  for (const OptionField& field : fields_) {
    if (field.in_range()) continue;
    return fail(ErrorCode::kBadValue, fmt::format("{} is out of range", field.print()), field.name,
                fmt::format("Give {}", field.range));
  }
  for (const OptionRule& rule : rules_) {
    if (rule.holds()) continue;
    std::vector<std::string> values;
    for (const std::string& name : rule.names) values.push_back(find(name)->print());
    return fail(ErrorCode::kBadValue,
                fmt::format("{}, but {}", fmt::join(values, " and "), rule.must),
                fmt::format("{}", fmt::join(rule.names, ", ")),
                rule.names.size() > 1 ? "Change one of them" : "Change it");
  }
  return {};
}

std::string nearest_name(std::string_view word, const std::vector<std::string>& names) {
  std::string nearest;
  // Further than half the word's length is a different word.
  std::size_t best = std::max<std::size_t>(2, word.size() / 2) + 1;
  for (const std::string& name : names) {
    std::size_t distance = edit_distance(word, name);
    const std::size_t dot = name.rfind('.');
    if (dot != std::string::npos) {  // the last part alone may be what was meant
      distance =
          std::min(distance, 1 + edit_distance(word, std::string_view(name).substr(dot + 1)));
    }
    if (distance < best) {
      best = distance;
      nearest = name;
    }
  }
  return nearest;
}

}  // namespace tread
