#include "tread/io/rig_formats.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "tread/io/text.hpp"

namespace tread::internal {
namespace {

// Files print rotations with few digits; what is further from one than this is a mistake.
constexpr double kRotationTolerance = 1e-3;
// What is nearer than this is kept to the bit.
constexpr double kExactRotation = 1e-9;

}  // namespace

Result<Distortion> distortion_of_name(const Field& field) {
  const Result<std::string> name = field.text();
  if (!name) return forward(name);
  const std::vector<std::string> brown = {"radtan", "radial-tangential", "plumb_bob",
                                          "rational_polynomial", "none"};
  const std::vector<std::string> equidistant = {"equidistant", "fisheye"};
  if (std::find(brown.begin(), brown.end(), *name) != brown.end()) return Distortion::kBrown;
  if (std::find(equidistant.begin(), equidistant.end(), *name) != equidistant.end()) {
    return Distortion::kEquidistant;
  }
  return field.error(ErrorCode::kUnsupported,
                     fmt::format("the distortion model {} is not handled", in_quotes(*name)),
                     fmt::format("Calibrate with one of: {}, {}", fmt::join(brown, ", "),
                                 fmt::join(equidistant, ", ")));
}

Result<CameraModel> make_camera(const PinholeCamera& pinhole, Distortion distortion,
                                const std::vector<double>& c, const Field& where) {
  const std::size_t n = c.size();
  if (distortion == Distortion::kEquidistant) {
    if (n != 4) {
      return where.error(ErrorCode::kBadFormat,
                         fmt::format("an equidistant lens has 4 coefficients, found {}", n),
                         "Write k1 k2 k3 k4");
    }
    if (pinhole.skew != 0.0) {
      return where.error(ErrorCode::kUnsupported, "an equidistant lens with skew is not handled",
                         "Calibrate without skew");
    }
    return KannalaBrandtCamera{
        pinhole.fx, pinhole.fy, pinhole.cx, pinhole.cy, {c[0], c[1], c[2], c[3]}};
  }
  if (n != 0 && n != 4 && n != 5 && n != 8 && n != 12 && n != 14) {
    return where.error(ErrorCode::kBadFormat,
                       fmt::format("expected 4, 5, 8, 12 or 14 coefficients, found {}", n),
                       "Write k1 k2 p1 p2 [k3 [k4 k5 k6]]");
  }
  const auto is_zero = [](double v) { return v == 0.0; };
  if (n > 8 && !std::all_of(c.begin() + 8, c.end(), is_zero)) {
    return where.error(ErrorCode::kUnsupported, "thin prism and tilt terms are not handled",
                       "Calibrate without them: at most 8 coefficients");
  }
  if (std::all_of(c.begin(), c.end(), is_zero)) return pinhole;
  BrownCamera camera;
  camera.pinhole = pinhole;
  camera.K = {c[0], c[1], n > 4 ? c[4] : 0.0, 0.0, 0.0};
  camera.P = {c[3], c[2], 0.0, 0.0, 0.0};
  if (n >= 8) camera.D = {c[5], c[6], c[7]};
  return camera;
}

Result<PinholeCamera> read_pinhole_matrix(const Field& field) {
  const auto m = field.matrix(3, 3);
  if (!m) return forward(m);
  return PinholeCamera{(*m)[0], (*m)[4], (*m)[2], (*m)[5], (*m)[1]};
}

Result<ImageSize> read_size(const Field& field) {
  const auto values = field.numbers(2);
  if (!values) return forward(values);
  for (const double value : *values) {
    // Bounds before the conversion; check_rig has the true ones.
    if (value >= 1.0 && value <= 1e6 && value == static_cast<int>(value)) continue;
    return field.error(ErrorCode::kBadValue, fmt::format("{} is not a size in pixels", value),
                       "Write [width, height] in whole pixels");
  }
  return ImageSize{static_cast<int>((*values)[0]), static_cast<int>((*values)[1])};
}

Result<Eigen::Matrix3d> read_rotation(const Field& field) {
  const auto m = field.matrix(3, 3);
  if (!m) return forward(m);
  Isometry3d T = Isometry3d::Identity();
  T.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(m->data());
  if (!is_rigid(T, kRotationTolerance)) {
    return field.error(ErrorCode::kBadValue, "not a rotation",
                       "Write an orthonormal right-handed matrix, row by row");
  }
  if (is_rigid(T, kExactRotation)) return Eigen::Matrix3d(T.linear());
  return Eigen::Quaterniond(T.linear()).normalized().toRotationMatrix();
}

Result<Isometry3d> read_transform(const Field& field) {
  const auto m = field.matrix(4, 4);
  if (!m) return forward(m);
  Isometry3d T = Isometry3d::Identity();
  T.matrix() = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(m->data());
  const bool last_row = T.matrix().row(3) == Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0);
  if (!last_row || !is_rigid(T, kRotationTolerance)) {
    return field.error(ErrorCode::kBadValue, "not a rigid motion",
                       "Write [R t; 0 0 0 1] row by row, R orthonormal and right-handed");
  }
  if (!is_rigid(T, kExactRotation)) {
    T.linear() = Eigen::Quaterniond(T.linear()).normalized().toRotationMatrix();
  }
  return T;
}

Status check_whole_rig(const StereoRig& rig) {
  Status sound = check_rig(rig);
  if (!sound || !rig.rectified) return sound;
  const Result<RectifiedRig> rectified = rectified_rig(rig);
  if (!rectified) return forward(rectified);
  return {};
}

Status check_same_size(const ImageSize& left, const ImageSize& right, const Field& where) {
  if (left == right) return {};
  return where.error(
      ErrorCode::kUnsupported,
      fmt::format("the images of the two cameras differ in size: {} x {} and {} x {}", left.width,
                  left.height, right.width, right.height),
      "Calibrate both cameras with images of one size");
}

}  // namespace tread::internal
