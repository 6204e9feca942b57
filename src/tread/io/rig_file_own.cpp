// Our own rig YAML; the format is described in rig_file.hpp.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <numbers>

#include "tread/io/atomic_file.hpp"
#include "tread/io/rig_file.hpp"
#include "tread/io/rig_formats.hpp"
#include "tread/io/text.hpp"

namespace tread {
namespace internal {
namespace {

using Eigen::Vector3d;

constexpr int kVersion = 1;
constexpr double kDegree = std::numbers::pi / 180.0;

// A number if the name is there, else what `value` was.
Status read_optional(const Field& map, const char* name, double& value) {
  const auto field = map.find(name);
  if (!field) return {};
  const Result<double> number = field->number();
  if (!number) return forward(number);
  value = *number;
  return {};
}

Status read_required(const Field& map, const char* name, double& value) {
  const Result<Field> field = map.at(name);
  if (!field) return forward(field);
  return read_optional(map, name, value);
}

// Up to N numbers; those not written are 0.
template <std::size_t N>
Status read_terms(const Field& map, const char* name, std::array<double, N>& terms) {
  const auto field = map.find(name);
  if (!field) return {};
  const auto values = field->numbers();
  if (!values) return forward(values);
  if (values->size() > N) {
    return field->error(ErrorCode::kBadFormat,
                        fmt::format("at most {} terms, found {}", N, values->size()),
                        fmt::format("Write up to {} numbers", N));
  }
  std::copy(values->begin(), values->end(), terms.begin());
  return {};
}

// skew apart, which not every model has
Status read_pinhole(const Field& map, PinholeCamera& camera) {
  for (const auto& [name, value] : {std::pair("fx", &camera.fx), std::pair("fy", &camera.fy),
                                    std::pair("cx", &camera.cx), std::pair("cy", &camera.cy)}) {
    if (Status done = read_required(map, name, *value); !done) return done;
  }
  return {};
}

Result<CameraModel> read_pinhole_camera(const Field& map) {
  if (Status done = map.allow_only({"model", "fx", "fy", "cx", "cy", "skew"}); !done) {
    return forward(done);
  }
  PinholeCamera camera;
  if (Status done = read_pinhole(map, camera); !done) return forward(done);
  if (Status done = read_optional(map, "skew", camera.skew); !done) return forward(done);
  return camera;
}

Result<CameraModel> read_brown_camera(const Field& map) {
  Status done = map.allow_only(
      {"model", "fx", "fy", "cx", "cy", "skew", "lens_centre", "K", "P", "D", "opencv_distortion"});
  if (!done) return forward(done);
  BrownCamera camera;
  if (done = read_pinhole(map, camera.pinhole); !done) return forward(done);
  if (done = read_optional(map, "skew", camera.pinhole.skew); !done) return forward(done);
  if (const auto field = map.find("opencv_distortion")) {
    if (map.find_any({"K", "P", "D", "lens_centre"})) {
      return field->error(ErrorCode::kBadFormat, "stands beside K, P, D or lens_centre",
                          "Write either OpenCV's coefficients or Brown's terms");
    }
    const auto coefficients = field->numbers();
    if (!coefficients) return forward(coefficients);
    return make_camera(camera.pinhole, Distortion::kBrown, *coefficients, *field);
  }
  if (const auto field = map.find("lens_centre")) {
    const auto values = field->numbers(2);
    if (!values) return forward(values);
    camera.lx = (*values)[0];
    camera.ly = (*values)[1];
  }
  if (done = read_terms(map, "K", camera.K); !done) return forward(done);
  if (done = read_terms(map, "P", camera.P); !done) return forward(done);
  if (done = read_terms(map, "D", camera.D); !done) return forward(done);
  return camera;
}

Result<CameraModel> read_kannala_brandt_camera(const Field& map) {
  if (Status done = map.allow_only({"model", "fx", "fy", "cx", "cy", "k"}); !done) {
    return forward(done);
  }
  PinholeCamera pinhole;
  if (Status done = read_pinhole(map, pinhole); !done) return forward(done);
  const Result<Field> field = map.at("k");
  if (!field) return forward(field);
  const auto k = field->numbers(4);
  if (!k) return forward(k);
  return make_camera(pinhole, Distortion::kEquidistant, *k, *field);
}

Result<CameraModel> read_camera(const Field& root, const char* name) {
  const Result<Field> map = root.at(name);
  if (!map) return forward(map);
  const Result<Field> model = map->at("model");
  if (!model) return forward(model);
  const Result<std::string> word = model->text();
  if (!word) return forward(word);
  if (*word == "pinhole") return read_pinhole_camera(*map);
  if (*word == "brown") return read_brown_camera(*map);
  if (*word == "kannala_brandt") return read_kannala_brandt_camera(*map);
  return model->error(ErrorCode::kBadValue, in_quotes(*word) + " is not a camera model",
                      "Write pinhole, brown or kannala_brandt");
}

// {translation_m, and at most one of rotation, rpy_rad, rpy_deg}
Result<Isometry3d> read_pose(const Field& map) {
  Status done = map.allow_only({"translation_m", "rotation", "rpy_rad", "rpy_deg"});
  if (!done) return forward(done);
  const Result<Field> translation = map.at("translation_m");
  if (!translation) return forward(translation);
  const auto t = translation->numbers(3);
  if (!t) return forward(t);
  Isometry3d T = Isometry3d::Identity();
  T.translation() = Vector3d((*t)[0], (*t)[1], (*t)[2]);

  const auto matrix = map.find("rotation");
  const auto radians = map.find("rpy_rad"), degrees = map.find("rpy_deg");
  if (int{matrix.has_value()} + int{radians.has_value()} + int{degrees.has_value()} > 1) {
    return map.error(ErrorCode::kBadFormat, "more than one rotation",
                     "Write one of rotation, rpy_rad and rpy_deg");
  }
  if (matrix) {
    const auto R = read_rotation(*matrix);
    if (!R) return forward(R);
    T.linear() = *R;
  } else if (radians || degrees) {
    const auto rpy = (radians ? radians : degrees)->numbers(3);
    if (!rpy) return forward(rpy);
    const double unit = radians ? 1.0 : kDegree;
    T.linear() = rotation_from_yaw_pitch_roll(unit * (*rpy)[2], unit * (*rpy)[1], unit * (*rpy)[0]);
  }
  return T;
}

Result<CameraMount> read_mount(const Field& map) {
  Status done = map.allow_only({"height_m", "pitch_rad", "pitch_deg", "T_body_left", "assumed"});
  if (!done) return forward(done);
  bool assumed = false;
  if (const auto field = map.find("assumed")) {
    const Result<bool> value = field->truth();
    if (!value) return forward(value);
    assumed = *value;
  }
  if (const auto pose = map.find("T_body_left")) {
    if (const auto other = map.find_any({"height_m", "pitch_rad", "pitch_deg"})) {
      return other->error(ErrorCode::kBadFormat, "stands beside T_body_left",
                          "Write either T_body_left, or height_m and pitch_deg");
    }
    const auto T = read_pose(*pose);
    if (!T) return forward(T);
    return CameraMount{*T, assumed};
  }
  double height_m = 0.0;
  if (done = read_required(map, "height_m", height_m); !done) return forward(done);
  const auto degrees = map.find("pitch_deg"), radians = map.find("pitch_rad");
  if (degrees && radians) {
    return degrees->error(ErrorCode::kBadFormat, "stands beside pitch_rad",
                          "Write one of pitch_deg and pitch_rad");
  }
  double pitch = 0.0;
  if (done = read_required(map, radians ? "pitch_rad" : "pitch_deg", pitch); !done) {
    return forward(done);
  }
  return level_mount(height_m, radians ? pitch : pitch * kDegree, assumed);
}

Result<Imu> read_imu_section(const Field& map) {
  Status done = map.allow_only(
      {"T_imu_left", "gyro_noise", "accel_noise", "gyro_walk", "accel_walk", "rate_hz"});
  if (!done) return forward(done);
  const Result<Field> pose = map.at("T_imu_left");
  if (!pose) return forward(pose);
  const auto T = read_pose(*pose);
  if (!T) return forward(T);
  Imu imu;
  imu.T_imu_left = *T;
  for (const auto& [name, value] :
       {std::pair("gyro_noise", &imu.gyro_noise), std::pair("accel_noise", &imu.accel_noise),
        std::pair("gyro_walk", &imu.gyro_walk), std::pair("accel_walk", &imu.accel_walk),
        std::pair("rate_hz", &imu.rate_hz)}) {
    if (done = read_optional(map, name, *value); !done) return forward(done);
  }
  return imu;
}

Result<Isometry3d> read_T_left_right(const Field& root, bool rectified) {
  const auto baseline = root.find("baseline_m"), pose = root.find("T_left_right");
  if (baseline && pose) {
    return baseline->error(ErrorCode::kBadFormat, "stands beside T_left_right",
                           "Write one of baseline_m and T_left_right");
  }
  if (pose) return read_pose(*pose);
  if (!baseline) {
    return root.error(ErrorCode::kNotFound,
                      rectified ? "'baseline_m' is missing" : "'T_left_right' is missing",
                      rectified ? "Add 'baseline_m: ...', metres"
                                : "Add 'T_left_right: {translation_m: [...], rotation: [...]}'");
  }
  if (!rectified) {
    return baseline->error(ErrorCode::kBadFormat, "does not say how the cameras are turned",
                           "Write T_left_right, or 'rectified: true' if the images come so");
  }
  const Result<double> value = baseline->number();
  if (!value) return forward(value);
  if (!(*value > 0.0)) {
    return baseline->error(ErrorCode::kBadValue, "the baseline is not above 0",
                           "Write the distance of the cameras in metres");
  }
  Isometry3d T = Isometry3d::Identity();
  T.translation().x() = *value;
  return T;
}

Status check_version(const Field& root) {
  const Result<Field> field = root.at("tread_rig");
  if (!field) return forward(field);
  const Result<int> version = field->whole_number();
  if (!version) return forward(version);
  if (*version == kVersion) return {};
  return field->error(ErrorCode::kUnsupported, fmt::format("version {} is not known", *version),
                      fmt::format("This program reads version {}", kVersion));
}

// ---- writing

std::string list(const Eigen::VectorXd& values) {
  return fmt::format("[{}]", fmt::join(values.data(), values.data() + values.size(), ", "));
}

std::string print_pinhole(const PinholeCamera& camera) {
  return fmt::format("  fx: {}\n  fy: {}\n  cx: {}\n  cy: {}\n", camera.fx, camera.fy, camera.cx,
                     camera.cy);
}

std::string print_camera(const CameraModel& camera) {
  const PinholeCamera pinhole = pinhole_of(camera);
  if (const auto* wide = std::get_if<KannalaBrandtCamera>(&camera)) {
    return fmt::format("  model: kannala_brandt\n{}  k: [{}]\n", print_pinhole(pinhole),
                       fmt::join(wide->k, ", "));
  }
  const std::string common = print_pinhole(pinhole) + fmt::format("  skew: {}\n", pinhole.skew);
  const auto* brown = std::get_if<BrownCamera>(&camera);
  if (brown == nullptr) return "  model: pinhole\n" + common;
  return fmt::format("  model: brown\n{}  lens_centre: [{}, {}]\n  K: [{}]\n  P: [{}]\n  D: [{}]\n",
                     common, brown->lx, brown->ly, fmt::join(brown->K, ", "),
                     fmt::join(brown->P, ", "), fmt::join(brown->D, ", "));
}

std::string print_pose(const Isometry3d& T, const std::string& indent) {
  std::string text =
      fmt::format("{}translation_m: {}\n{}rotation:\n", indent, list(T.translation()), indent);
  for (int row = 0; row < 3; ++row) {
    text += fmt::format("{}  - {}\n", indent, list(T.linear().row(row).transpose()));
  }
  return text;
}

bool only_baseline(const Isometry3d& T) {
  return T.linear() == Eigen::Matrix3d::Identity() && T.translation().x() > 0.0 &&
         T.translation().tail<2>() == Eigen::Vector2d::Zero();
}

std::string print_rig(const StereoRig& rig) {
  std::string text =
      fmt::format("tread_rig: {}\nname: {}\nsize: [{}, {}]\nrectified: {}\n", kVersion,
                  yaml_text(rig.name), rig.size.width, rig.size.height, rig.rectified);
  text += "left:\n" + print_camera(rig.left) + "right:\n" + print_camera(rig.right);
  text += rig.rectified && only_baseline(rig.T_left_right)
              ? fmt::format("baseline_m: {}\n", rig.T_left_right.translation().x())
              : "T_left_right:\n" + print_pose(rig.T_left_right, "  ");
  if (rig.mount) {
    text += "mount:\n  T_body_left:\n" + print_pose(rig.mount->T_body_left, "    ") +
            fmt::format("  assumed: {}\n", rig.mount->assumed);
  }
  if (rig.imu) {
    text += "imu:\n  T_imu_left:\n" + print_pose(rig.imu->T_imu_left, "    ") +
            fmt::format(
                "  gyro_noise: {}\n  accel_noise: {}\n  gyro_walk: {}\n  accel_walk: {}\n"
                "  rate_hz: {}\n",
                rig.imu->gyro_noise, rig.imu->accel_noise, rig.imu->gyro_walk, rig.imu->accel_walk,
                rig.imu->rate_hz);
  }
  return text;
}

}  // namespace

bool is_own(const Field& root) {
  return root.find("tread_rig").has_value();
}

Result<StereoRig> read_own_rig(const Field& root) {
  if (Status done = check_version(root); !done) return forward(done);
  Status done = root.allow_only({"tread_rig", "name", "size", "rectified", "left", "right",
                                 "T_left_right", "baseline_m", "mount", "imu"});
  if (!done) return forward(done);
  StereoRig rig;
  if (const auto field = root.find("name")) {
    const Result<std::string> name = field->text();
    if (!name) return forward(name);
    rig.name = *name;
  }
  const Result<Field> size_field = root.at("size");
  if (!size_field) return forward(size_field);
  const auto size = read_size(*size_field);
  if (!size) return forward(size);
  rig.size = *size;
  if (const auto field = root.find("rectified")) {
    const Result<bool> rectified = field->truth();
    if (!rectified) return forward(rectified);
    rig.rectified = *rectified;
  }
  const auto left = read_camera(root, "left"), right = read_camera(root, "right");
  if (!left) return forward(left);
  if (!right) return forward(right);
  rig.left = *left;
  rig.right = *right;
  const auto T = read_T_left_right(root, rig.rectified);
  if (!T) return forward(T);
  rig.T_left_right = *T;
  if (const auto field = root.find("mount")) {
    const auto mount = read_mount(*field);
    if (!mount) return forward(mount);
    rig.mount = *mount;
  }
  if (const auto field = root.find("imu")) {
    const auto imu = read_imu_section(*field);
    if (!imu) return forward(imu);
    rig.imu = *imu;
  }
  return rig;
}

}  // namespace internal

Status write_rig(const std::filesystem::path& path, const StereoRig& rig) {
  // What cannot be read back is not written.
  if (Status sound = internal::check_whole_rig(rig); !sound) return sound;
  return write_file(path, internal::print_rig(rig));
}

}  // namespace tread
