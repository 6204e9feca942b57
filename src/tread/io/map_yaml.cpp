#include "tread/io/map_yaml.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "tread/io/atomic_file.hpp"
#include "tread/io/text.hpp"
#include "tread/io/text_tree.hpp"

namespace tread {
namespace {

using internal::Field;

// Puts the text of an entry into `value`.
Status read_text(const Field& parent, const char* key, std::string& value) {
  const auto field = parent.at(key);
  if (!field) return forward(field);
  auto text = field->text();
  if (!text) return forward(text);
  value = std::move(*text);
  return {};
}

Status read_file_name(const Field& parent, std::string& name) {
  if (Status read = read_text(parent, "file", name); !read) return read;
  if (is_plain_file_name(name)) return {};
  return parent.at("file")->error(ErrorCode::kBadValue,
                                  in_quotes(name) + " is not a file of this folder",
                                  "Write a name without '/'");
}

Status read_size(const Field& parent, GridGeometry& geometry) {
  const auto field = parent.at("size_cells");
  if (!field) return forward(field);
  const auto size = field->numbers(2);
  if (!size) return forward(size);
  constexpr double kMost = 1 << 24;
  for (const double count : *size) {
    if (count >= 1.0 && count <= kMost && count == std::floor(count)) continue;
    return field->error(ErrorCode::kBadValue, fmt::format("{} is not a number of cells", count),
                        "Write [COLUMNS, ROWS], whole numbers from 1");
  }
  geometry.columns = static_cast<int>((*size)[0]);
  geometry.rows = static_cast<int>((*size)[1]);
  return {};
}

Status read_geometry(const Field& parent, GridGeometry& geometry) {
  const auto resolution_field = parent.at("resolution_m");
  if (!resolution_field) return forward(resolution_field);
  const auto resolution_m = resolution_field->number();
  if (!resolution_m) return forward(resolution_m);
  if (!(*resolution_m > 0.0)) {
    return resolution_field->error(ErrorCode::kBadValue,
                                   fmt::format("{} is not a resolution", *resolution_m),
                                   "Write metres a cell, above zero");
  }
  const auto origin_field = parent.at("origin_m");
  if (!origin_field) return forward(origin_field);
  const auto origin = origin_field->numbers(2);
  if (!origin) return forward(origin);
  geometry.resolution_m = *resolution_m;
  geometry.origin = {(*origin)[0], (*origin)[1]};
  return read_size(parent, geometry);
}

Status read_layer_entry(const std::string& name, const Field& field, MapIndex& index) {
  if (!is_layer_name(name)) {
    return field.error(ErrorCode::kBadValue, in_quotes(name) + " is not a name of a layer",
                       "Use letters, digits, '_' and '-'");
  }
  Status known =
      field.allow_only({"file", "unit", "meaning", "resolution_m", "origin_m", "size_cells"});
  if (!known) return known;
  MapLayer layer;
  layer.name = name;
  std::string file;
  if (Status read = read_file_name(field, file); !read) return read;
  if (Status read = read_text(field, "unit", layer.unit); !read) return read;
  if (Status read = read_text(field, "meaning", layer.meaning); !read) return read;
  if (Status read = read_geometry(field, layer.grid.geometry); !read) return read;
  index.map.layers.push_back(std::move(layer));
  index.files.push_back(std::move(file));
  return {};
}

// A number of the map may be infinite or NaN, in YAML's words.
Result<double> read_number(const Field& field) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const auto text = field.text();
  if (text && *text == ".inf") return kInfinity;
  if (text && *text == "-.inf") return -kInfinity;
  if (text && *text == ".nan") return std::numeric_limits<double>::quiet_NaN();
  return field.number();
}

Status check_version(const Field& root, const std::string& where) {
  const auto field = root.find("tread_map");
  if (!field) {
    return fail(ErrorCode::kBadFormat, "this is not a map of tread: there is no key tread_map",
                where, "Give the folder of a map, or its map.yaml");
  }
  const auto version = field->whole_number();
  if (!version) return forward(version);
  if (*version == 1) return {};
  if (*version > 1) {
    return field->error(ErrorCode::kUnsupported,
                        fmt::format("a map of version {}, this program reads version 1", *version),
                        "Use the newer program that wrote it");
  }
  return field->error(ErrorCode::kBadValue, fmt::format("there is no version {}", *version),
                      "Write tread_map: 1");
}

std::string yaml_number(double value) {
  if (std::isnan(value)) return ".nan";
  if (std::isinf(value)) return value > 0.0 ? ".inf" : "-.inf";
  return fmt::format("{}", value);
}

}  // namespace

bool is_layer_name(const std::string& name) {
  constexpr std::string_view kAllowed =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-";
  constexpr std::size_t kLongest = 100;
  return !name.empty() && name.size() <= kLongest &&
         name.find_first_not_of(kAllowed) == std::string::npos;
}

std::string print_map_yaml(const MapLayers& map) {
  std::string text = fmt::format("tread_map: 1\nframe: {}\nlayers:{}\n", yaml_text(map.frame),
                                 map.layers.empty() ? " {}" : "");
  for (const MapLayer& layer : map.layers) {
    const GridGeometry& g = layer.grid.geometry;
    text += fmt::format(
        "  {0}:\n    file: {0}.tif\n    unit: {1}\n    meaning: {2}\n"
        "    resolution_m: {3}\n    origin_m: [{4}, {5}]\n    size_cells: [{6}, {7}]\n",
        layer.name, yaml_text(layer.unit), yaml_text(layer.meaning), yaml_number(g.resolution_m),
        yaml_number(g.origin.x()), yaml_number(g.origin.y()), g.columns, g.rows);
  }
  if (!map.numbers.empty()) text += "numbers:\n";
  for (const auto& [name, value] : map.numbers) {
    text += fmt::format("  {}: {}\n", yaml_text(name), yaml_number(value));
  }
  return text;
}

Result<MapIndex> parse_map_yaml(const std::string& text, const std::string& where) {
  const auto tree = internal::parse_yaml(text, where);
  if (!tree) return forward(tree);
  const Field root(*tree, where);
  if (Status version = check_version(root, where); !version) return forward(version);
  Status known = root.allow_only({"tread_map", "frame", "layers", "numbers"});
  if (!known) return forward(known);
  MapIndex index;
  if (Status read = read_text(root, "frame", index.map.frame); !read) return forward(read);
  const auto layers = root.at("layers");
  if (!layers) return forward(layers);
  const auto entries = layers->entries();
  if (!entries) return forward(entries);
  for (const auto& [name, field] : *entries) {
    if (Status read = read_layer_entry(name, field, index); !read) return forward(read);
  }
  const auto numbers = root.find("numbers");
  if (!numbers) return index;
  const auto values = numbers->entries();
  if (!values) return forward(values);
  for (const auto& [name, field] : *values) {
    const auto value = read_number(field);
    if (!value) return forward(value);
    index.map.numbers[name] = *value;
  }
  return index;
}

}  // namespace tread
