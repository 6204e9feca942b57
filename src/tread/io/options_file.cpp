#include "tread/io/options_file.hpp"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <set>
#include <vector>

#include "tread/io/atomic_file.hpp"

namespace tread {
namespace {

constexpr int kDeepest = 16;

Status apply(const YAML::Node& node, const std::string& prefix, const std::string& file,
             OptionSet& options, int depth) {
  const auto at = [&](const YAML::Node& place, const std::string& name) {
    return fmt::format("{}:{}: {}", file, place.Mark().line + 1, name);
  };
  if (!node.IsMap() || depth > kDeepest) {
    return fail(ErrorCode::kBadFormat, "keys with values are expected here",
                at(node, prefix.empty() ? "options" : prefix), "Write 'name: value'");
  }
  std::set<std::string> seen;
  for (const auto& entry : node) {
    const std::string key = entry.first.Scalar();
    const std::string name = prefix.empty() ? key : prefix + "." + key;
    if (!seen.insert(key).second) {
      return fail(ErrorCode::kBadFormat, "this is given twice", at(entry.first, name),
                  "Keep one of them");
    }
    if (entry.second.IsMap()) {
      if (Status done = apply(entry.second, name, file, options, depth + 1); !done) return done;
      continue;
    }
    if (!entry.second.IsScalar()) {
      return fail(ErrorCode::kBadFormat, "one value is expected here", at(entry.first, name),
                  "Write 'name: value'");
    }
    Status done = options.set(name, entry.second.Scalar());
    if (done) continue;
    done.error().where = at(entry.first, done.error().where);
    return done;
  }
  return {};
}

std::vector<std::string> split(const std::string& name) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  for (std::size_t dot = name.find('.'); dot != std::string::npos; dot = name.find('.', begin)) {
    parts.push_back(name.substr(begin, dot - begin));
    begin = dot + 1;
  }
  parts.push_back(name.substr(begin));
  return parts;
}

}  // namespace

Status read_options(const std::filesystem::path& path, OptionSet& options) {
  const Result<std::string> text = read_file(path, std::size_t{1} << 20);
  if (!text) return forward(text);
  try {
    const YAML::Node root = YAML::Load(*text);
    if (root.IsNull()) return {};
    Status done = apply(root, "", path.string(), options, 0);
    if (done) options.settle();
    return done;
  } catch (const YAML::Exception& error) {
    return fail(ErrorCode::kBadFormat, error.msg,
                fmt::format("{}:{}", path.string(), error.mark.line + 1), "Correct the YAML");
  }
}

std::string options_as_yaml(const OptionSet& options) {
  std::string text;
  std::vector<std::string> open;  // the groups that the lines so far are in
  for (const OptionField& field : options.fields()) {
    std::vector<std::string> parts = split(field.name);
    const std::string leaf = parts.back();
    parts.pop_back();
    std::size_t common = 0;
    while (common < open.size() && common < parts.size() && open[common] == parts[common]) ++common;
    for (std::size_t i = common; i < parts.size(); ++i) {
      text += fmt::format("{}{}:\n", std::string(2 * i, ' '), parts[i]);
    }
    open = parts;
    const std::string value = field.print();
    const bool quoted = value.find_first_of(": #") != std::string::npos;
    text += fmt::format("{}{}: {}{}{}  # {}{}{}\n", std::string(2 * parts.size(), ' '), leaf,
                        quoted ? "\"" : "", value, quoted ? "\"" : "", field.meaning,
                        field.range.empty() ? "" : "; ", field.range);
  }
  return text;
}

}  // namespace tread
