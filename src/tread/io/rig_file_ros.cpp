// ROS camera_info of a stereo pair, as camera_calibration writes it (camera_matrix, ...) and as the
// message is printed (K or k, ...). It holds no pose of the cameras, but their rectification:
//   x_rectified = R x_camera for each camera, and P_right[3] = -f b,
// so that p_left = R_left^T (R_right p_right + (b, 0, 0)).
#include <fmt/format.h>

#include "tread/io/rig_formats.hpp"

namespace tread::internal {
namespace {

using Matrix34 = Eigen::Matrix<double, 3, 4>;

struct CameraInfo {
  CameraModel camera;
  ImageSize size;
  Eigen::Matrix3d R_rectified_camera = Eigen::Matrix3d::Identity();
  Matrix34 P = Matrix34::Zero();
};

Result<int> read_side(const Field& root, std::initializer_list<const char*> names) {
  const Result<Field> field = root.at_any(names);
  if (!field) return forward(field);
  return field->whole_number();
}

Result<CameraModel> read_camera(const Field& root) {
  const Result<Field> matrix = root.at_any({"camera_matrix", "K", "k"});
  if (!matrix) return forward(matrix);
  const auto pinhole = read_pinhole_matrix(*matrix);
  if (!pinhole) return forward(pinhole);
  const Result<Field> name = root.at("distortion_model");
  if (!name) return forward(name);
  const auto distortion = distortion_of_name(*name);
  if (!distortion) return forward(distortion);
  const Result<Field> field = root.at_any({"distortion_coefficients", "D", "d"});
  if (!field) return forward(field);
  const auto data = field->find("data");
  const auto coefficients = (data ? *data : *field).numbers();
  if (!coefficients) return forward(coefficients);
  return make_camera(*pinhole, *distortion, *coefficients, *field);
}

Result<CameraInfo> read_info(const Field& root) {
  CameraInfo info;
  const auto width = read_side(root, {"image_width", "width"});
  if (!width) return forward(width);
  const auto height = read_side(root, {"image_height", "height"});
  if (!height) return forward(height);
  info.size = {*width, *height};
  const auto camera = read_camera(root);
  if (!camera) return forward(camera);
  info.camera = *camera;
  const Result<Field> rotation = root.at_any({"rectification_matrix", "R", "r"});
  if (!rotation) return forward(rotation);
  const auto R = read_rotation(*rotation);
  if (!R) return forward(R);
  info.R_rectified_camera = *R;
  const Result<Field> projection = root.at_any({"projection_matrix", "P", "p"});
  if (!projection) return forward(projection);
  const auto P = projection->matrix(3, 4);
  if (!P) return forward(P);
  info.P = Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(P->data());
  if (!(info.P(0, 0) > 0.0)) {
    return projection->error(ErrorCode::kBadValue, "focal length is not above 0",
                             "Calibrate the pair as a stereo pair");
  }
  return info;
}

// The images need no rectification: nothing is distorted or turned, and P is K.
bool comes_rectified(const CameraInfo& info) {
  const auto* pinhole = std::get_if<PinholeCamera>(&info.camera);
  if (pinhole == nullptr) return false;
  Eigen::Matrix3d K;
  K << pinhole->fx, pinhole->skew, pinhole->cx, 0.0, pinhole->fy, pinhole->cy, 0.0, 0.0, 1.0;
  return info.R_rectified_camera == Eigen::Matrix3d::Identity() && info.P.leftCols<3>() == K;
}

}  // namespace

bool is_camera_info(const Field& root) {
  return root.find_any({"projection_matrix", "camera_matrix"}).has_value() ||
         (root.find_any({"K", "k"}) && root.find_any({"P", "p"}));
}

Result<StereoRig> read_camera_info_rig(const Field& left_field, const Field& right_field) {
  const auto left = read_info(left_field);
  if (!left) return forward(left);
  const auto right = read_info(right_field);
  if (!right) return forward(right);
  if (Status same = check_same_size(left->size, right->size, right_field); !same) {
    return forward(same);
  }
  const double baseline_m = left->P(0, 3) / left->P(0, 0) - right->P(0, 3) / right->P(0, 0);
  if (!(baseline_m > 0.0)) {
    return right_field.error(
        ErrorCode::kBadValue,
        fmt::format("the baseline is {:g} m (projection matrix, row 1, column 4)", baseline_m),
        "Calibrate the two as a stereo pair, or exchange left and right");
  }
  StereoRig rig;
  rig.size = left->size;
  rig.left = left->camera;
  rig.right = right->camera;
  const Eigen::Matrix3d R_left_rectified = left->R_rectified_camera.transpose();
  rig.T_left_right.linear() = R_left_rectified * right->R_rectified_camera;
  rig.T_left_right.translation() = R_left_rectified.col(0) * baseline_m;
  rig.rectified = comes_rectified(*left) && comes_rectified(*right);
  return rig;
}

}  // namespace tread::internal
