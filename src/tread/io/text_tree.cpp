#include "tread/io/text_tree.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tread/core/options.hpp"
#include "tread/io/text.hpp"

namespace tread::internal {

using Kind = TextNode::Kind;

std::optional<double> parse_finite(std::string_view text) {
  const auto value = parse_number<double>(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

Field Field::child(std::string_view key, const TextNode& node) const {
  Field field(node, file_);
  field.path_ = path_.empty() ? std::string(key) : fmt::format("{}.{}", path_, key);
  return field;
}

std::string Field::where() const {
  std::string text = node_->line > 0 ? fmt::format("{}:{}", file_, node_->line) : file_;
  if (!path_.empty()) text += ": " + path_;
  return text;
}

std::optional<Field> Field::find(std::string_view key) const {
  if (!is_map()) return std::nullopt;
  for (std::size_t i = 0; i < node_->keys.size(); ++i) {
    if (node_->keys[i] == key) return child(key, node_->items[i]);
  }
  return std::nullopt;
}

Result<Field> Field::at(std::string_view key) const {
  if (const auto found = find(key)) return *found;
  if (!is_map()) {
    return error(ErrorCode::kBadFormat, fmt::format("expected entries, with '{}' among them", key),
                 fmt::format("Write '{}: ...' indented below", key));
  }
  return error(ErrorCode::kNotFound, fmt::format("'{}' is missing", key),
               fmt::format("Add '{}: ...'", key));
}

Result<std::vector<std::pair<std::string, Field>>> Field::entries() const {
  if (!is_map()) {
    return error(ErrorCode::kBadFormat, "expected entries", "Write 'name: value' lines");
  }
  std::vector<std::pair<std::string, Field>> all;
  for (std::size_t i = 0; i < node_->keys.size(); ++i) {
    all.emplace_back(node_->keys[i], child(node_->keys[i], node_->items[i]));
  }
  return all;
}

Result<std::vector<Field>> Field::items() const {
  if (node_->kind != Kind::kSequence) {
    return error(ErrorCode::kBadFormat, "expected a list", "Write a list, '- ...' lines or [...]");
  }
  std::vector<Field> all;
  for (std::size_t i = 0; i < node_->items.size(); ++i) {
    Field item(node_->items[i], file_);
    item.path_ = fmt::format("{}[{}]", path_, i);
    all.push_back(std::move(item));
  }
  return all;
}

std::optional<Field> Field::find_any(std::initializer_list<const char*> keys) const {
  for (const char* key : keys) {
    if (const auto found = find(key)) return found;
  }
  return std::nullopt;
}

Result<Field> Field::at_any(std::initializer_list<const char*> keys) const {
  if (const auto found = find_any(keys)) return *found;
  return at(*keys.begin());
}

Status Field::allow_only(const std::vector<std::string>& names) const {
  if (!is_map()) {
    return error(ErrorCode::kBadFormat, "expected entries",
                 fmt::format("Write 'name: value' lines; known are: {}", fmt::join(names, ", ")));
  }
  for (std::size_t i = 0; i < node_->keys.size(); ++i) {
    const std::string& key = node_->keys[i];
    if (std::find(names.begin(), names.end(), key) != names.end()) continue;
    const std::string near = nearest_name(key, names);
    return child(key, node_->items[i])
        .error(ErrorCode::kBadFormat, "unknown name",
               near.empty() ? fmt::format("Known are: {}", fmt::join(names, ", "))
                            : fmt::format("Did you mean '{}'?", near));
  }
  return {};
}

Result<double> Field::number() const {
  if (node_->kind == Kind::kScalar) {
    if (const auto value = parse_finite(node_->scalar)) return *value;
    return error(ErrorCode::kBadValue, in_quotes(node_->scalar) + " is not a finite number",
                 "Write a number");
  }
  return error(ErrorCode::kBadFormat, "expected a number", "Write a number");
}

Result<int> Field::whole_number() const {
  if (node_->kind == Kind::kScalar) {
    if (const auto value = parse_number<int>(node_->scalar)) return *value;
    return error(ErrorCode::kBadValue, in_quotes(node_->scalar) + " is not a whole number",
                 "Write a whole number");
  }
  return error(ErrorCode::kBadFormat, "expected a whole number", "Write a whole number");
}

Result<bool> Field::truth() const {
  if (node_->kind == Kind::kScalar && node_->scalar == "true") return true;
  if (node_->kind == Kind::kScalar && node_->scalar == "false") return false;
  return error(ErrorCode::kBadValue, "expected true or false", "Write true or false");
}

Result<std::string> Field::text() const {
  if (node_->kind == Kind::kScalar) return node_->scalar;
  return error(ErrorCode::kBadFormat, "expected a text", "Write one word or a quoted text");
}

Status Field::append_numbers(const TextNode& node, int depth, std::vector<double>& values) const {
  if (node.kind == Kind::kScalar) {
    for (const std::string_view word : split_fields(node.scalar)) {
      const auto value = parse_finite(word);
      if (!value) {
        return error(ErrorCode::kBadValue, in_quotes(word) + " is not a finite number",
                     "Write numbers only");
      }
      values.push_back(*value);
    }
    return {};
  }
  if (node.kind != Kind::kSequence || depth == 0) {
    return error(ErrorCode::kBadFormat, "expected a list of numbers", "Write [1.0, 2.0, ...]");
  }
  for (const TextNode& item : node.items) {
    if (Status done = append_numbers(item, depth - 1, values); !done) return done;
  }
  return {};
}

Result<std::vector<double>> Field::numbers() const {
  std::vector<double> values;
  if (Status done = append_numbers(*node_, 2, values); !done) return forward(done);
  return values;
}

Result<std::vector<double>> Field::numbers(std::size_t count) const {
  Result<std::vector<double>> values = numbers();
  if (values && values->size() != count) {
    return error(ErrorCode::kBadFormat,
                 fmt::format("expected {} numbers, found {}", count, values->size()),
                 fmt::format("Write {} numbers", count));
  }
  return values;
}

Result<std::vector<double>> Field::matrix(int rows, int cols) const {
  const auto count = static_cast<std::size_t>(rows * cols);
  if (!is_map()) return numbers(count);
  for (const auto& [name, expected] : {std::pair("rows", rows), std::pair("cols", cols)}) {
    const auto stated = find(name);
    if (!stated) continue;
    const Result<int> value = stated->whole_number();
    if (!value) return forward(value);
    if (*value != expected) {
      return stated->error(
          ErrorCode::kBadFormat,
          fmt::format("expected a {} x {} matrix, found {} {}", rows, cols, *value, name),
          fmt::format("Write {} rows of {} numbers", rows, cols));
    }
  }
  const Result<Field> data = at("data");
  if (!data) return forward(data);
  return data->numbers(count);
}

}  // namespace tread::internal
