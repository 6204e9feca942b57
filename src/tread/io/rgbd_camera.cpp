#include "tread/io/rgbd_camera.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <variant>
#include <vector>

#include "tread/io/atomic_file.hpp"
#include "tread/io/rig_formats.hpp"
#include "tread/io/text.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;
using internal::Field;

constexpr std::size_t kLargestFile = std::size_t{1} << 20;

tl::unexpected<Error> distorted(const std::string& where) {
  return fail(ErrorCode::kUnsupported, "the lens has distortion, depth images shall have none",
              where, "Undistort the images, and give the camera that they then have");
}

Result<PinholeCamera> pinhole_of_numbers(const std::vector<double>& n, const fs::path& path) {
  if (n.size() == 4) return PinholeCamera{n[0], n[1], n[2], n[3], 0.0};
  if (n.size() != 9) {
    return fail(ErrorCode::kBadFormat, fmt::format("{} numbers instead of 4 or 9", n.size()),
                path.string(), "Write fx fy cx cy, or the 3x3 camera matrix, row by row");
  }
  if (n[3] != 0.0 || n[6] != 0.0 || n[7] != 0.0 || n[8] != 1.0) {
    return fail(ErrorCode::kBadFormat, "this is not the matrix of a camera", path.string(),
                "Write fx 0 cx, 0 fy cy, 0 0 1 in three lines");
  }
  return PinholeCamera{n[0], n[4], n[2], n[5], n[1]};
}

Result<RgbdCamera> camera_of_text(const std::vector<TextLine>& lines, const fs::path& path) {
  std::vector<double> numbers;
  for (const TextLine& line : lines) {
    for (const std::string_view field : split_fields(line.text)) {
      const auto number = parse_number<double>(field);
      if (!number) {
        return fail(ErrorCode::kBadFormat, in_quotes(field) + " is not a number",
                    line_place(path.string(), line.number),
                    "Write fx fy cx cy, or the 3x3 camera matrix, row by row");
      }
      numbers.push_back(*number);
    }
  }
  const auto pinhole = pinhole_of_numbers(numbers, path);
  if (!pinhole) return forward(pinhole);
  return RgbdCamera{*pinhole, {}};
}

// Width and height by the names that are there; {0, 0} without them.
Result<ImageSize> read_optional_size(const Field& root) {
  ImageSize size;
  const auto width = root.find_any({"width", "image_width"});
  const auto height = root.find_any({"height", "image_height"});
  if (!width && !height) return size;
  if (!width || !height) {
    return (width ? *width : *height)
        .error(ErrorCode::kBadFormat, "stands alone", "Write both width and height, or neither");
  }
  for (const auto& [field, side] : {std::pair(*width, &size.width), {*height, &size.height}}) {
    const auto value = field.whole_number();
    if (!value) return forward(value);
    if (*value < 1) {
      return field.error(ErrorCode::kBadValue, fmt::format("{} is not a size in pixels", *value),
                         "Write the size of the depth images");
    }
    *side = *value;
  }
  return size;
}

Result<PinholeCamera> read_fx_fy_cx_cy(const Field& root) {
  const Status known = root.allow_only({"fx", "fy", "cx", "cy", "width", "height"});
  if (!known) return forward(known);
  PinholeCamera pinhole;
  for (const auto& [name, value] : {std::pair("fx", &pinhole.fx), std::pair("fy", &pinhole.fy),
                                    std::pair("cx", &pinhole.cx), std::pair("cy", &pinhole.cy)}) {
    const auto field = root.at(name);
    if (!field) return forward(field);
    const auto number = field->number();
    if (!number) return forward(number);
    *value = *number;
  }
  return pinhole;
}

Result<RgbdCamera> camera_of_yaml(const Field& root) {
  if (internal::is_own(root)) {
    const auto rig = internal::read_own_rig(root);
    if (!rig) return forward(rig);
    const auto* pinhole = std::get_if<PinholeCamera>(&rig->left);
    if (pinhole == nullptr) return distorted(root.where() + ": left");
    return RgbdCamera{*pinhole, rig->size};
  }
  const auto size = read_optional_size(root);
  if (!size) return forward(size);
  const auto matrix = root.find_any({"camera_matrix", "K", "k"});
  const auto pinhole = matrix ? internal::read_pinhole_matrix(*matrix) : read_fx_fy_cx_cy(root);
  if (!pinhole) return forward(pinhole);
  if (const auto terms = root.find_any({"distortion_coefficients", "D", "d"})) {
    const auto data = terms->is_map() ? terms->find("data") : std::nullopt;
    const auto values = (data ? *data : *terms).numbers();
    if (!values) return forward(values);
    const auto is_zero = [](double value) { return value == 0.0; };
    if (!std::all_of(values->begin(), values->end(), is_zero)) return distorted(terms->where());
  }
  return RgbdCamera{*pinhole, *size};
}

}  // namespace

Result<RgbdCamera> read_rgbd_camera(const fs::path& path) {
  const auto text = read_file(path, kLargestFile);
  if (!text) return forward(text);
  const auto lines = lines_with_content(*text);
  const bool numbers =
      !lines.empty() && parse_number<double>(split_fields(lines.front().text).front()).has_value();
  Result<RgbdCamera> camera;
  if (lines.empty()) {
    return fail(ErrorCode::kBadFormat, "the file is empty", path.string(),
                "Write fx fy cx cy, or the 3x3 camera matrix, row by row");
  } else if (numbers) {
    camera = camera_of_text(lines, path);
  } else {
    const auto root = internal::parse_yaml(*text, path.string());
    if (!root) return forward(root);
    camera = camera_of_yaml(Field(*root, path.string()));
  }
  if (!camera) return camera;
  const Status checked = check_camera(camera->pinhole, path.string() + ": camera");
  if (!checked) return forward(checked);
  return camera;
}

}  // namespace tread
