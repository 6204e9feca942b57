// Internal to io and sim: a YAML or XML file as a tree of plain values, and `Field`, a place in it that
// reads values and words error messages. Keeps the parsers' own types and exceptions in two files.
#pragma once

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tread/core/result.hpp"

namespace tread::internal {

struct TextNode {
  enum class Kind { kNothing, kScalar, kSequence, kMap };
  Kind kind = Kind::kNothing;
  int line = 0;                   // from 1; 0 if not known
  std::string scalar;             // kScalar
  std::vector<std::string> keys;  // kMap: one an item, none twice
  std::vector<TextNode> items;    // kSequence, kMap
};

// Both refuse what is nested or repeated (aliases) beyond any calibration file. `file` is for
// messages. OpenCV's own dialect of YAML ("%YAML:1.0") is understood.
[[nodiscard]] Result<TextNode> parse_yaml(const std::string& text, const std::string& file);
// Elements and text, as cv::FileStorage writes them: a child element is an entry of a map,
// elements called "_" are a sequence. Attributes and comments are skipped.
[[nodiscard]] Result<TextNode> parse_xml(const std::string& text, const std::string& file);

// A whole text that is a finite number.
[[nodiscard]] std::optional<double> parse_finite(std::string_view text);

// A place in a tree. The tree must outlive it.
class Field {
 public:
  Field(const TextNode& root, std::string file) : node_(&root), file_(std::move(file)) {}

  [[nodiscard]] bool is_map() const { return node_->kind == TextNode::Kind::kMap; }
  // The entry of a map; at() fails if it is missing, find() is then empty.
  [[nodiscard]] std::optional<Field> find(std::string_view key) const;
  [[nodiscard]] Result<Field> at(std::string_view key) const;
  // All entries of a map in the order of the file.
  [[nodiscard]] Result<std::vector<std::pair<std::string, Field>>> entries() const;
  // All items of a sequence, as "name[0]", "name[1]", ...
  [[nodiscard]] Result<std::vector<Field>> items() const;
  // The first that is there of several names for the same.
  [[nodiscard]] std::optional<Field> find_any(std::initializer_list<const char*> keys) const;
  [[nodiscard]] Result<Field> at_any(std::initializer_list<const char*> keys) const;
  // Refuses entries of other names, with the nearest of these.
  [[nodiscard]] Status allow_only(const std::vector<std::string>& names) const;

  [[nodiscard]] Result<double> number() const;
  [[nodiscard]] Result<int> whole_number() const;
  [[nodiscard]] Result<bool> truth() const;
  [[nodiscard]] Result<std::string> text() const;
  // A sequence of numbers, or of rows of numbers, or text with numbers apart by blanks.
  [[nodiscard]] Result<std::vector<double>> numbers() const;
  // The same, `count` of them.
  [[nodiscard]] Result<std::vector<double>> numbers(std::size_t count) const;
  // rows * cols numbers, row by row: a sequence, or a map with `data` and perhaps `rows`, `cols`.
  [[nodiscard]] Result<std::vector<double>> matrix(int rows, int cols) const;

  // "rig.yaml:12: left.fx"
  [[nodiscard]] std::string where() const;
  [[nodiscard]] const std::string& file() const { return file_; }
  [[nodiscard]] int line() const { return node_->line; }
  // "objects[3].pallet", whatever the file is called and its lines are.
  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] tl::unexpected<Error> error(ErrorCode code, std::string what,
                                            std::string remedy) const {
    return fail(code, std::move(what), where(), std::move(remedy));
  }

 private:
  [[nodiscard]] Field child(std::string_view key, const TextNode& node) const;
  [[nodiscard]] Status append_numbers(const TextNode& node, int depth,
                                      std::vector<double>& values) const;
  const TextNode* node_;
  std::string file_;
  std::string path_;
};

}  // namespace tread::internal
