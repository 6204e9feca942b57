// What OpenCV's stereo calibration leaves behind: M1 D1 M2 D2 R T, where x_right = R x_left + T.
// The unit of T is that of the calibration board's squares, which the file does not tell.
#include <fmt/format.h>

#include "tread/io/rig_formats.hpp"

namespace tread::internal {
namespace {

Result<CameraModel> read_camera(const Field& root, std::initializer_list<const char*> matrix_names,
                                std::initializer_list<const char*> distortion_names) {
  const Result<Field> matrix = root.at_any(matrix_names);
  if (!matrix) return forward(matrix);
  const auto pinhole = read_pinhole_matrix(*matrix);
  if (!pinhole) return forward(pinhole);
  const Result<Field> field = root.at_any(distortion_names);
  if (!field) return forward(field);
  const auto data = field->find("data");
  const auto coefficients = (data ? *data : *field).numbers();
  if (!coefficients) return forward(coefficients);
  Distortion distortion = Distortion::kBrown;
  if (const auto name = root.find("distortion_model")) {
    const auto named = distortion_of_name(*name);
    if (!named) return forward(named);
    distortion = *named;
  }
  return make_camera(*pinhole, distortion, *coefficients, *field);
}

Result<ImageSize> read_image_size(const Field& intrinsics, const Field& extrinsics,
                                  ImageSize given) {
  for (const Field& root : {intrinsics, extrinsics}) {
    if (const auto pair = root.find_any({"imageSize", "image_size", "size"})) {
      return read_size(*pair);
    }
    const auto width = root.find_any({"image_width", "imageWidth", "width"});
    const auto height = root.find_any({"image_height", "imageHeight", "height"});
    if (!width || !height) continue;
    const Result<int> columns = width->whole_number(), rows = height->whole_number();
    if (!columns) return forward(columns);
    if (!rows) return forward(rows);
    return ImageSize{*columns, *rows};
  }
  if (given != ImageSize{}) return given;
  return intrinsics.error(ErrorCode::kNotFound, "the image size is not in the file",
                          "Add 'image_width: ...' and 'image_height: ...'");
}

Result<Isometry3d> read_T_left_right(const Field& root) {
  const Result<Field> rotation = root.at("R"), translation = root.at("T");
  if (!rotation) return forward(rotation);
  if (!translation) return forward(translation);
  const auto R = read_rotation(*rotation);
  if (!R) return forward(R);
  const auto data = translation->find("data");
  const auto t = (data ? *data : *translation).numbers(3);
  if (!t) return forward(t);
  Isometry3d T_right_left = Isometry3d::Identity();
  T_right_left.linear() = *R;
  T_right_left.translation() = Eigen::Vector3d((*t)[0], (*t)[1], (*t)[2]);
  constexpr double kLongestBaselineM = 10.0;
  const double baseline = T_right_left.translation().norm();
  if (baseline > kLongestBaselineM) {
    return translation->error(
        ErrorCode::kBadValue,
        fmt::format("a baseline of {:g} m: the unit is probably not metres", baseline),
        "Write T in metres (it has the unit of the calibration board's squares)");
  }
  return T_right_left.inverse();
}

}  // namespace

bool is_opencv_intrinsics(const Field& root) {
  return root.find_any({"M1", "K1", "cameraMatrix1"}).has_value();
}

Result<StereoRig> read_opencv_rig(const Field& intrinsics, const Field& extrinsics,
                                  ImageSize size) {
  StereoRig rig;
  const auto left = read_camera(intrinsics, {"M1", "K1", "cameraMatrix1"}, {"D1", "distCoeffs1"});
  if (!left) return forward(left);
  const auto right = read_camera(intrinsics, {"M2", "K2", "cameraMatrix2"}, {"D2", "distCoeffs2"});
  if (!right) return forward(right);
  const auto T = read_T_left_right(extrinsics);
  if (!T) return forward(T);
  const auto found = read_image_size(intrinsics, extrinsics, size);
  if (!found) return forward(found);
  rig.left = *left;
  rig.right = *right;
  rig.T_left_right = *T;
  rig.size = *found;
  return rig;
}

}  // namespace tread::internal
