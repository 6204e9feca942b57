// KITTI's calib.txt: 3x4 projection matrices of the rectified cameras, row by row. Odometry and
// object: "P0: ..." to "P3: ..."; raw: "P_rect_00: ..." with "S_rect_00: width height"; cut-down
// copies: the bare numbers of P0 and P1. Cameras 0 and 1 are grey, 2 and 3 colour; the first two
// are taken if there, else the others.
//
// P[3] is -f times the camera's place along x. The other two entries of the fourth column (some
// millimetres on the colour cameras) move a camera against the laser scanner, but the published
// images have equal rows for equal points all the same, so they are left out.
#include <fmt/format.h>

#include <array>
#include <optional>

#include "tread/io/rig_formats.hpp"
#include "tread/io/text.hpp"

namespace tread::internal {
namespace {

using ProjectionValues = std::array<double, 12>;

struct KittiFile {
  std::array<std::optional<ProjectionValues>, 4> P;
  std::optional<ImageSize> size;
  int bare_lines = 0;  // without a name
};

// "P0:" and "P_rect_00:" are 0; -1 if the word names no projection matrix.
int camera_of_name(std::string_view word) {
  for (int i = 0; i < 4; ++i) {
    if (word == fmt::format("P{}:", i) || word == fmt::format("P_rect_0{}:", i)) return i;
  }
  return -1;
}

Result<ProjectionValues> read_projection(const std::vector<std::string_view>& words,
                                         const std::string& where) {
  ProjectionValues values{};
  if (words.size() != values.size()) {
    return fail(ErrorCode::kBadFormat,
                fmt::format("expected 12 numbers of a projection matrix, found {}", words.size()),
                where, "Write the 3 x 4 matrix row by row; the file may be cut short");
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto value = parse_finite(words[i]);
    if (!value) {
      return fail(ErrorCode::kBadValue, in_quotes(words[i]) + " is not a finite number", where,
                  "Write the 3 x 4 matrix row by row");
    }
    values[i] = *value;
  }
  if (!(values[0] > 0.0) || !(values[5] > 0.0)) {
    return fail(ErrorCode::kBadValue, "focal length is not above 0", where,
                "Check the order: the 3 x 4 matrix row by row");
  }
  return values;
}

Status read_line(std::vector<std::string_view> words, const std::string& where, KittiFile& file) {
  int camera = camera_of_name(words[0]);
  if (camera >= 0) {
    words.erase(words.begin());
  } else if (parse_finite(words[0])) {
    while (++camera < 4 && file.P[static_cast<std::size_t>(camera)]) continue;
    constexpr int kMost = 5;  // the four cameras and the laser scanner
    if (++file.bare_lines > kMost) {
      return fail(ErrorCode::kBadFormat, "more than five matrices: this is no calibration", where,
                  "Poses are given with --poses; the calibration is calib.txt");
    }
    if (camera == 4) return {};
  } else if (words[0] == "S_rect_00:" && words.size() == 3) {
    const auto width = parse_finite(words[1]), height = parse_finite(words[2]);
    constexpr double kMost = 1e6;
    if (width && height && *width >= 1.0 && *height >= 1.0 && *width < kMost && *height < kMost) {
      file.size = ImageSize{static_cast<int>(*width), static_cast<int>(*height)};
    }
    return {};
  } else {
    return {};  // other sensors and the cameras before rectification
  }
  const auto values = read_projection(words, where);
  if (!values) return forward(values);
  file.P[static_cast<std::size_t>(camera)] = *values;
  return {};
}

Result<KittiFile> read_lines(std::string_view text, const std::string& file) {
  KittiFile read;
  for (const TextLine& line : lines_with_content(text)) {
    Status done = read_line(split_fields(line.text), line_place(file, line.number), read);
    if (!done) return forward(done);
  }
  return read;
}

PinholeCamera pinhole_of_projection(const ProjectionValues& P) {
  return {P[0], P[5], P[2], P[6], P[1]};
}

}  // namespace

bool is_kitti(const std::string& text) {
  bool first = true;
  for (const TextLine& line : lines_with_content(text)) {
    const std::string_view word = split_fields(line.text).front();
    if ((first && parse_finite(word)) || camera_of_name(word) >= 0) return true;
    first = false;
  }
  return false;
}

Result<StereoRig> read_kitti_rig(const std::string& text, const std::string& file, ImageSize size) {
  const auto read = read_lines(text, file);
  if (!read) return forward(read);
  const bool colour = !(read->P[0] && read->P[1]) && read->P[2] && read->P[3];
  const auto& P_left = read->P[colour ? 2 : 0];
  const auto& P_right = read->P[colour ? 3 : 1];
  if (!P_left || !P_right) {
    return fail(ErrorCode::kNotFound, fmt::format("'{}' is missing", P_left ? "P1" : "P0"), file,
                "Add the projection matrices of both cameras, P0 and P1 (or P2 and P3)");
  }
  if (!read->size && size == ImageSize{}) {
    return fail(ErrorCode::kNotFound, "the image size is not in the file", file,
                "Open the folder of the sequence instead, or add 'S_rect_00: width height'");
  }
  StereoRig rig;
  rig.size = read->size ? *read->size : size;
  rig.left = pinhole_of_projection(*P_left);
  rig.right = pinhole_of_projection(*P_right);
  rig.T_left_right.translation().x() = (*P_left)[3] / (*P_left)[0] - (*P_right)[3] / (*P_right)[0];
  rig.rectified = true;
  return rig;
}

}  // namespace tread::internal
