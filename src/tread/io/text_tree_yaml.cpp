#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <set>

#include "tread/io/text_tree.hpp"

namespace tread::internal {
namespace {

constexpr int kDeepest = 16;
constexpr int kMostNodes = 20000;

tl::unexpected<Error> too_large(const std::string& where) {
  return fail(ErrorCode::kBadFormat, "nested or repeated beyond any calibration file", where,
              "Write the values without aliases, in a file of their own");
}

// OpenCV writes "%YAML:1.0", which YAML's grammar has no place for. Blanked, lines keep their
// numbers.
std::string without_opencv_header(std::string text) {
  if (text.starts_with("\xEF\xBB\xBF")) text.replace(0, 3, "   ");
  const std::size_t start = std::min(text.find_first_not_of(" \r\n"), text.size());
  if (text.compare(start, 6, "%YAML:") != 0) return text;
  const std::size_t end = std::min(text.find('\n', start), text.size());
  return text.replace(start, end - start, end - start, ' ');
}

// Counts nodes, because aliases let a short text stand for an endless tree.
Result<TextNode> convert(const YAML::Node& from, const std::string& file, int depth, int& nodes) {
  TextNode node;
  node.line = from.Mark().line >= 0 ? from.Mark().line + 1 : 0;
  const std::string where = fmt::format("{}:{}", file, node.line);
  if (++nodes > kMostNodes || depth > kDeepest) return too_large(where);
  if (from.IsScalar()) {
    node.kind = TextNode::Kind::kScalar;
    node.scalar = from.Scalar();
  } else if (from.IsSequence()) {
    node.kind = TextNode::Kind::kSequence;
    for (const YAML::Node& item : from) {
      Result<TextNode> converted = convert(item, file, depth + 1, nodes);
      if (!converted) return converted;
      node.items.push_back(std::move(*converted));
    }
  } else if (from.IsMap()) {
    node.kind = TextNode::Kind::kMap;
    std::set<std::string> seen;
    for (const auto& entry : from) {
      const std::string line = fmt::format("{}:{}", file, entry.first.Mark().line + 1);
      if (!entry.first.IsScalar()) {
        return fail(ErrorCode::kBadFormat, "a name is not a text", line,
                    "Write each name once, as 'name: value'");
      }
      if (!seen.insert(entry.first.Scalar()).second) {
        return fail(ErrorCode::kBadFormat, "the name is there twice",
                    line + ": " + entry.first.Scalar(), "Write each name once, as 'name: value'");
      }
      Result<TextNode> converted = convert(entry.second, file, depth + 1, nodes);
      if (!converted) return converted;
      node.keys.push_back(entry.first.Scalar());
      node.items.push_back(std::move(*converted));
    }
  }
  return node;
}

}  // namespace

Result<TextNode> parse_yaml(const std::string& text, const std::string& file) {
  try {
    int nodes = 0;
    return convert(YAML::Load(without_opencv_header(text)), file, 0, nodes);
  } catch (const YAML::Exception& exception) {
    return fail(ErrorCode::kBadFormat, "not YAML: " + exception.msg,
                fmt::format("{}:{}", file, exception.mark.line + 1),
                "Correct the syntax there; the file may be cut short");
  } catch (const std::exception& exception) {
    return fail(ErrorCode::kBadFormat, fmt::format("not YAML: {}", exception.what()), file,
                "Correct the syntax; the file may be cut short");
  }
}

}  // namespace tread::internal
