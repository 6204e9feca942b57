// The XML that cv::FileStorage writes. Read here and not with OpenCV because that prints its errors
// to the terminal, and what it makes of damaged files is not ours to promise.
#include <fmt/format.h>

#include <algorithm>

#include "tread/io/text.hpp"
#include "tread/io/text_tree.hpp"

namespace tread::internal {
namespace {

constexpr std::string_view kBlanks = " \t\r\n";
constexpr int kDeepest = 16;
constexpr int kMostNodes = 20000;

class XmlReader {
 public:
  XmlReader(std::string_view text, const std::string& file) : text_(text), file_(file) {}

  Result<TextNode> document() {
    if (text_.starts_with("\xEF\xBB\xBF")) at_ = 3;
    if (Status done = skip_to_markup(nullptr); !done) return forward(done);
    std::string name;
    return element(0, name);
  }

 private:
  // Counts on from the last call: at_ only grows.
  int line() {
    for (; counted_ < at_; ++counted_) line_ += text_[counted_] == '\n' ? 1 : 0;
    return line_;
  }
  tl::unexpected<Error> broken(const std::string& what) {
    return fail(ErrorCode::kBadFormat, "not XML: " + what, fmt::format("{}:{}", file_, line()),
                "Correct the syntax there; the file may be cut short");
  }
  [[nodiscard]] bool looking_at(std::string_view what) const {
    return text_.substr(at_).starts_with(what);
  }

  // Over text (kept in `text` if asked for), comments and declarations to the next tag.
  Status skip_to_markup(std::string* text) {
    for (;;) {
      const std::size_t tag = text_.find('<', at_);
      if (tag == std::string_view::npos) return broken("a tag is missing");
      if (text != nullptr) text->append(text_.substr(at_, tag - at_));
      at_ = tag;
      const bool comment = looking_at("<!--");
      if (!comment && !looking_at("<?")) return {};
      const std::string_view closing = comment ? "-->" : "?>";
      const std::size_t end = text_.find(closing, at_);
      if (end == std::string_view::npos) return broken("a comment does not end");
      at_ = end + closing.size();
    }
  }

  // at_ is at "<name".
  Result<TextNode> element(int depth, std::string& name) {
    if (depth > kDeepest || ++nodes_ > kMostNodes) {
      return broken("nested or repeated beyond any calibration file");
    }
    TextNode node;
    node.line = line();
    const std::size_t end = text_.find('>', at_);
    if (end == std::string_view::npos) return broken("a tag does not end");
    std::string_view tag = text_.substr(at_ + 1, end - at_ - 1);
    const bool is_empty = tag.ends_with('/');
    if (is_empty) tag.remove_suffix(1);
    name = tag.substr(0, tag.find_first_of(kBlanks));
    if (name.empty() || name.front() == '!' || name.front() == '/') {
      return broken(in_quotes(name) + " is not the start of an element");
    }
    at_ = end + 1;
    if (is_empty) return node;
    if (Status done = content(depth, name, node); !done) return forward(done);
    return node;
  }

  Status content(int depth, const std::string& name, TextNode& node) {
    std::string text;
    for (;;) {
      if (Status done = skip_to_markup(&text); !done) return done;
      if (looking_at("</")) break;
      std::string key;
      Result<TextNode> item = element(depth + 1, key);
      if (!item) return forward(item);
      if (std::find(node.keys.begin(), node.keys.end(), key) != node.keys.end() && key != "_") {
        return broken(in_quotes(key) + " is there twice");
      }
      node.keys.push_back(std::move(key));
      node.items.push_back(std::move(*item));
    }
    const std::string closing = "</" + name + ">";
    if (!looking_at(closing)) return broken(in_quotes(closing) + " is missing");
    at_ += closing.size();
    if (!node.items.empty()) {
      const bool list =
          std::all_of(node.keys.begin(), node.keys.end(), [](auto& key) { return key == "_"; });
      node.kind = list ? TextNode::Kind::kSequence : TextNode::Kind::kMap;
      if (list) node.keys.clear();
      return {};
    }
    std::replace(text.begin(), text.end(), '\n', ' ');
    std::string_view value = trimmed(text);
    if (value.size() >= 2 && value.front() == '"' && value.back() == '"') {
      value = value.substr(1, value.size() - 2);
    }
    node.kind = value.empty() ? TextNode::Kind::kNothing : TextNode::Kind::kScalar;
    node.scalar = value;
    return {};
  }

  std::string_view text_;
  const std::string& file_;
  std::size_t at_ = 0;
  std::size_t counted_ = 0;
  int line_ = 1;
  int nodes_ = 0;
};

}  // namespace

Result<TextNode> parse_xml(const std::string& text, const std::string& file) {
  return XmlReader(text, file).document();
}

}  // namespace tread::internal
