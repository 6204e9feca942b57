// Reading PLY: a text header that declares elements (rows) and their properties (columns), then the
// rows, as text or as packed binary (Turk 1994). Memory is bounded by the size of the file: a
// header that promises more rows than the file can hold is refused before anything is read.
#include "tread/io/mesh_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>

#include "tread/io/atomic_file.hpp"
#include "tread/io/text.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little,
              "binary PLY is read as it lies in memory");

enum class Scalar { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };

struct ScalarName {
  std::string_view name;
  Scalar scalar;
};
constexpr std::array<ScalarName, 16> kScalarNames = {{{"char", Scalar::kInt8},
                                                      {"int8", Scalar::kInt8},
                                                      {"uchar", Scalar::kUint8},
                                                      {"uint8", Scalar::kUint8},
                                                      {"short", Scalar::kInt16},
                                                      {"int16", Scalar::kInt16},
                                                      {"ushort", Scalar::kUint16},
                                                      {"uint16", Scalar::kUint16},
                                                      {"int", Scalar::kInt32},
                                                      {"int32", Scalar::kInt32},
                                                      {"uint", Scalar::kUint32},
                                                      {"uint32", Scalar::kUint32},
                                                      {"float", Scalar::kFloat},
                                                      {"float32", Scalar::kFloat},
                                                      {"double", Scalar::kDouble},
                                                      {"float64", Scalar::kDouble}}};

std::size_t size_of(Scalar scalar) {
  constexpr std::array<std::size_t, 8> kSizes = {1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<std::size_t>(scalar)];
}

std::optional<Scalar> scalar_of(std::string_view name) {
  for (const ScalarName& known : kScalarNames) {
    if (known.name == name) return known.scalar;
  }
  return std::nullopt;
}

struct Property {
  std::string name;
  Scalar scalar = Scalar::kFloat;
  std::size_t offset = 0;  // in a binary row
};

struct Element {
  std::string name;
  std::size_t count = 0;
  std::vector<Property> properties;
  std::size_t row_bytes = 0;
  bool has_list = false;  // rows differ in length

  [[nodiscard]] std::optional<std::size_t> find(std::string_view property) const {
    for (std::size_t i = 0; i < properties.size(); ++i) {
      if (properties[i].name == property) return i;
    }
    return std::nullopt;
  }
};

struct Header {
  bool ascii = false;
  std::vector<Element> elements;
  std::size_t bytes = 0;
  int lines = 0;
};

Result<Property> parse_property(const std::vector<std::string_view>& fields,
                                const std::string& place) {
  const auto scalar = fields.size() == 3 ? scalar_of(fields[1]) : std::nullopt;
  if (!scalar) {
    return fail(ErrorCode::kBadFormat, "a property that cannot be read", place,
                "Write: property float x");
  }
  return Property{std::string(fields[2]), *scalar, 0};
}

// One line of the header behind "ply". False at its end.
Result<bool> parse_header_line(std::string_view line, const std::string& place, Header& header,
                               bool& has_format) {
  const auto fields = split_fields(line);
  if (fields.empty() || fields[0] == "comment" || fields[0] == "obj_info") return true;
  if (fields[0] == "end_header") return false;
  if (fields[0] == "format" && fields.size() == 3) {
    header.ascii = fields[1] == "ascii";
    has_format = true;
    if (header.ascii || fields[1] == "binary_little_endian") return true;
    return fail(ErrorCode::kUnsupported, in_quotes(fields[1]) + " is not read", place,
                "Convert it to ascii or binary_little_endian, with MeshLab for example");
  }
  if (fields[0] == "element" && fields.size() == 3) {
    const auto count = parse_number<std::uint64_t>(fields[2]);
    if (!count) {
      return fail(ErrorCode::kBadFormat, in_quotes(fields[2]) + " is not a number of rows", place,
                  "Write: element vertex 100");
    }
    header.elements.push_back({std::string(fields[1]), *count, {}, 0, false});
    return true;
  }
  if (fields[0] == "property" && !header.elements.empty()) {
    Element& element = header.elements.back();
    if (fields.size() == 5 && fields[1] == "list") {
      element.has_list = true;
      return true;
    }
    auto property = parse_property(fields, place);
    if (!property) return forward(property);
    property->offset = element.row_bytes;
    element.row_bytes += size_of(property->scalar);
    element.properties.push_back(std::move(*property));
    return true;
  }
  return fail(ErrorCode::kBadFormat,
              in_quotes(line) + " does not belong in the header of a PLY file", place,
              "Check that the file is not damaged");
}

Result<Header> parse_header(std::string_view bytes, const fs::path& path) {
  Header header;
  bool has_format = false;
  const auto bad = [&](const std::string& what) {
    return fail(ErrorCode::kBadFormat, what, path.string(), "Check that this is a PLY file");
  };
  while (header.bytes < bytes.size()) {
    const std::string_view rest = bytes.substr(header.bytes);
    const std::size_t end = rest.find('\n');
    constexpr std::size_t kLongestHeader = std::size_t{1} << 20;
    if (end == std::string_view::npos || header.bytes + end > kLongestHeader) break;
    const std::string_view line = trimmed(rest.substr(0, end));
    header.bytes += end + 1;
    ++header.lines;
    if (header.lines == 1) {
      if (line != "ply") return bad("the file does not begin with 'ply'");
      continue;
    }
    const auto more =
        parse_header_line(line, line_place(path.string(), header.lines), header, has_format);
    if (!more) return forward(more);
    if (*more) continue;
    if (!has_format) return bad("the header names no format");
    return header;
  }
  return bad("the header does not end");
}

// The columns of the vertex rows that are read.
struct Columns {
  std::array<std::size_t, 3> xyz{};
  std::optional<std::array<std::size_t, 3>> rgb;
};

Result<Columns> find_columns(const Element& vertex, const fs::path& path) {
  if (vertex.has_list) {
    return fail(ErrorCode::kUnsupported, "element vertex has a list property", path.string(),
                "Save it without, with MeshLab for example");
  }
  Columns columns;
  const std::array<const char*, 3> axes = {"x", "y", "z"};
  const std::array<const char*, 3> channels = {"red", "green", "blue"};
  std::array<std::size_t, 3> rgb{};
  int colours = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = vertex.find(axes[i]);
    if (!axis) {
      return fail(ErrorCode::kBadFormat, fmt::format("element vertex has no {}", axes[i]),
                  path.string(), "Points need x, y and z");
    }
    columns.xyz[i] = *axis;
    const auto channel = vertex.find(channels[i]);
    if (!channel) continue;
    if (vertex.properties[*channel].scalar != Scalar::kUint8) {
      return fail(ErrorCode::kUnsupported, fmt::format("{} is not of type uchar", channels[i]),
                  path.string(), "Save colours as uchar, 0 to 255");
    }
    rgb[i] = *channel;
    ++colours;
  }
  if (colours == 3) columns.rgb = rgb;
  return columns;
}

template <class T>
double load(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return static_cast<double>(value);
}

double load_scalar(Scalar scalar, const char* bytes) {
  switch (scalar) {
    case Scalar::kInt8:
      return load<std::int8_t>(bytes);
    case Scalar::kUint8:
      return load<std::uint8_t>(bytes);
    case Scalar::kInt16:
      return load<std::int16_t>(bytes);
    case Scalar::kUint16:
      return load<std::uint16_t>(bytes);
    case Scalar::kInt32:
      return load<std::int32_t>(bytes);
    case Scalar::kUint32:
      return load<std::uint32_t>(bytes);
    case Scalar::kFloat:
      return load<float>(bytes);
    case Scalar::kDouble:
      break;
  }
  return load<double>(bytes);
}

// Beyond the range of float the conversion is undefined; infinite is what is meant.
float narrowed(double value) {
  constexpr double kLargest = std::numeric_limits<float>::max();
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  if (value > kLargest) return kInfinity;
  return value < -kLargest ? -kInfinity : static_cast<float>(value);
}

tl::unexpected<Error> truncated(const fs::path& path, std::size_t promised) {
  return fail(ErrorCode::kUnreadable,
              fmt::format("the file ends before the {} rows its header promises", promised),
              path.string(), "Copy or write it again");
}

// Bytes before the vertices, if they can be counted.
Result<std::size_t> bytes_before(const Header& header, std::size_t vertex, std::size_t available,
                                 const fs::path& path) {
  std::size_t bytes = 0;
  for (std::size_t i = 0; i < vertex; ++i) {
    const Element& element = header.elements[i];
    if (element.has_list) {
      return fail(ErrorCode::kUnsupported,
                  "element " + in_quotes(element.name) + " with lists comes before the vertices",
                  path.string(), "Save the vertices first");
    }
    if (element.row_bytes == 0) continue;
    if (element.count > (available - bytes) / element.row_bytes) {
      return truncated(path, element.count);
    }
    bytes += element.count * element.row_bytes;
  }
  return bytes;
}

Result<PointCloud> read_binary(std::string_view body, const Element& vertex, const Columns& columns,
                               const fs::path& path) {
  if (vertex.count > body.size() / vertex.row_bytes) return truncated(path, vertex.count);
  PointCloud cloud;
  cloud.points.reserve(vertex.count);
  if (columns.rgb) cloud.colours.reserve(vertex.count);
  const auto value = [&](const char* row, std::size_t column) {
    const Property& property = vertex.properties[column];
    return narrowed(load_scalar(property.scalar, row + property.offset));
  };
  const auto byte = [&](const char* row, std::size_t column) {
    return static_cast<std::uint8_t>(row[vertex.properties[column].offset]);
  };
  for (std::size_t i = 0; i < vertex.count; ++i) {
    const char* row = body.data() + i * vertex.row_bytes;
    cloud.points.emplace_back(value(row, columns.xyz[0]), value(row, columns.xyz[1]),
                              value(row, columns.xyz[2]));
    if (!columns.rgb) continue;
    const auto& rgb = *columns.rgb;
    cloud.colours.push_back({byte(row, rgb[0]), byte(row, rgb[1]), byte(row, rgb[2])});
  }
  return cloud;
}

Result<PointCloud> read_ascii(std::string_view body, int first_line, std::size_t skipped,
                              const Element& vertex, const Columns& columns, const fs::path& path) {
  PointCloud cloud;
  int number = first_line;
  std::size_t row = 0;
  while (row < skipped + vertex.count) {
    if (body.empty()) return truncated(path, vertex.count);
    ++number;
    const std::size_t end = std::min(body.find('\n'), body.size());
    // A line without its end may have lost digits.
    if (end == body.size()) return truncated(path, vertex.count);
    const auto fields = split_fields(trimmed(body.substr(0, end)));
    body.remove_prefix(end + 1);
    if (fields.empty()) continue;
    if (row++ < skipped) continue;
    const std::string place = line_place(path.string(), number);
    if (fields.size() != vertex.properties.size()) {
      return fail(ErrorCode::kBadFormat,
                  fmt::format("{} numbers instead of {}", fields.size(), vertex.properties.size()),
                  place, "Copy or write the file again");
    }
    std::array<float, 3> xyz{};
    std::array<std::uint8_t, 3> rgb{};
    for (std::size_t i = 0; i < 3; ++i) {
      const auto coordinate = parse_number<double>(fields[columns.xyz[i]]);
      const auto channel =
          columns.rgb ? parse_number<std::uint8_t>(fields[(*columns.rgb)[i]]) : std::uint8_t{0};
      if (!coordinate || !channel) {
        return fail(ErrorCode::kBadFormat, "a number that cannot be read", place,
                    "Copy or write the file again");
      }
      xyz[i] = narrowed(*coordinate);
      rgb[i] = *channel;
    }
    cloud.points.emplace_back(xyz[0], xyz[1], xyz[2]);
    if (columns.rgb) cloud.colours.push_back({rgb[0], rgb[1], rgb[2]});
  }
  return cloud;
}

Result<PointCloud> read(const fs::path& path) {
  const auto bytes = read_file(path, std::size_t{1} << 33);
  if (!bytes) return forward(bytes);
  const auto header = parse_header(*bytes, path);
  if (!header) return forward(header);
  const auto vertex = std::find_if(header->elements.begin(), header->elements.end(),
                                   [](const Element& e) { return e.name == "vertex"; });
  if (vertex == header->elements.end()) {
    return fail(ErrorCode::kBadFormat, "there is no element vertex", path.string(),
                "Check that this is a point cloud or a mesh");
  }
  const auto columns = find_columns(*vertex, path);
  if (!columns) return forward(columns);
  const std::string_view body = std::string_view(*bytes).substr(header->bytes);
  const auto index = static_cast<std::size_t>(vertex - header->elements.begin());
  if (!header->ascii) {
    const auto skipped = bytes_before(*header, index, body.size(), path);
    if (!skipped) return forward(skipped);
    return read_binary(body.substr(*skipped), *vertex, *columns, path);
  }
  // Every row of text has at least two bytes, so more rows than bytes cannot be; that also keeps
  // the sums below from overflowing.
  std::size_t rows_before = 0;
  for (std::size_t i = 0; i <= index; ++i) {
    const std::size_t count = header->elements[i].count;
    if (count > body.size()) return truncated(path, count);
    if (i < index) rows_before += count;
  }
  return read_ascii(body, header->lines, rows_before, *vertex, *columns, path);
}

}  // namespace

Result<PointCloud> read_ply(const fs::path& path) {
  return with_memory_checked(path.string(), "Give it more memory, or thin out the points",
                             [&] { return read(path); });
}

}  // namespace tread
