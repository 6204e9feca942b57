// Kalibr's camchain and EuRoC's (ASL's) sensor.yaml: close relatives, one made with the other.
//   Kalibr: camN.T_cn_cnm1 maps points of camera N-1 into camera N, T_cam_imu those of the IMU.
//   EuRoC:  T_BS maps points of the sensor into the body, whose frame there is the IMU's.
#include <fmt/format.h>

#include <set>
#include <utility>

#include "tread/io/rig_formats.hpp"
#include "tread/io/text.hpp"

namespace tread::internal {
namespace {

struct ReadCamera {
  CameraModel model;
  ImageSize size;
};

Status check_projection(const Field& camera) {
  const Result<Field> field = camera.at("camera_model");
  if (!field) return forward(field);
  const Result<std::string> model = field->text();
  if (!model) return forward(model);
  if (*model == "pinhole") return {};
  const std::set<std::string> kOthers = {"omni", "eucm", "ds"};
  return field->error(
      kOthers.contains(*model) ? ErrorCode::kUnsupported : ErrorCode::kBadValue,
      fmt::format("the camera model {} is not handled", in_quotes(*model)),
      "Calibrate again with pinhole-radtan, or pinhole-equi for lenses above 100 degrees");
}

// Both name their entries alike but for the distortion coefficients.
Result<ReadCamera> read_camera(const Field& camera, const char* coefficients_name) {
  if (Status done = check_projection(camera); !done) return forward(done);
  const Result<Field> intrinsics = camera.at("intrinsics");
  if (!intrinsics) return forward(intrinsics);
  const auto values = intrinsics->numbers(4);
  if (!values) return forward(values);
  const PinholeCamera pinhole{(*values)[0], (*values)[1], (*values)[2], (*values)[3], 0.0};

  const Result<Field> name = camera.at("distortion_model");
  if (!name) return forward(name);
  const auto distortion = distortion_of_name(*name);
  if (!distortion) return forward(distortion);
  const Result<Field> field = camera.at(coefficients_name);
  if (!field) return forward(field);
  const auto coefficients = field->numbers();
  if (!coefficients) return forward(coefficients);
  const auto model = make_camera(pinhole, *distortion, *coefficients, *field);
  if (!model) return forward(model);

  const Result<Field> resolution = camera.at("resolution");
  if (!resolution) return forward(resolution);
  const auto size = read_size(*resolution);
  if (!size) return forward(size);
  return ReadCamera{*model, *size};
}

Result<StereoRig> read_pair(const Field& left_field, const Field& right_field,
                            const char* coefficients_name) {
  const auto left = read_camera(left_field, coefficients_name);
  if (!left) return forward(left);
  const auto right = read_camera(right_field, coefficients_name);
  if (!right) return forward(right);
  if (Status same = check_same_size(left->size, right->size, right_field); !same) {
    return forward(same);
  }
  StereoRig rig;
  rig.size = left->size;
  rig.left = left->model;
  rig.right = right->model;
  return rig;
}

Result<Isometry3d> transform_at(const Field& camera, const char* name) {
  const Result<Field> field = camera.at(name);
  if (!field) return forward(field);
  return read_transform(*field);
}

}  // namespace

bool is_kalibr(const Field& root) {
  return root.find("cam0").has_value();
}

bool is_euroc_sensor(const Field& root) {
  return root.find("T_BS").has_value() || root.find("sensor_type").has_value();
}

Result<StereoRig> read_kalibr_rig(const Field& root) {
  const Result<Field> left = root.at("cam0"), right = root.at("cam1");
  if (!left) return forward(left);
  if (!right) return forward(right);
  Result<StereoRig> rig = read_pair(*left, *right, "distortion_coeffs");
  if (!rig) return rig;
  const auto T_right_left = transform_at(*right, "T_cn_cnm1");
  if (!T_right_left) return forward(T_right_left);
  rig->T_left_right = T_right_left->inverse();
  if (left->find("T_cam_imu")) {
    const auto T_left_imu = transform_at(*left, "T_cam_imu");
    if (!T_left_imu) return forward(T_left_imu);
    rig->imu.emplace().T_imu_left = T_left_imu->inverse();  // its noise is in another file
  }
  return rig;
}

Result<StereoRig> read_euroc_rig(const Field& left, const Field& right) {
  Result<StereoRig> rig = read_pair(left, right, "distortion_coefficients");
  if (!rig) return rig;
  const auto T_body_left = read_euroc_place(left), T_body_right = read_euroc_place(right);
  if (!T_body_left) return forward(T_body_left);
  if (!T_body_right) return forward(T_body_right);
  rig->T_left_right = T_body_left->inverse() * *T_body_right;
  return rig;
}

Result<Isometry3d> read_euroc_place(const Field& sensor) {
  return transform_at(sensor, "T_BS");
}

Result<Imu> read_euroc_imu(const Field& root, const Isometry3d& T_body_left) {
  const Result<Field> type = root.at("sensor_type");
  if (!type) return forward(type);
  const Result<std::string> name = type->text();
  if (!name) return forward(name);
  if (*name != "imu") {
    return type->error(ErrorCode::kBadValue, fmt::format("{} is no IMU", in_quotes(*name)),
                       "Write 'sensor_type: imu', or move the file away");
  }
  const auto T_body_imu = read_euroc_place(root);
  if (!T_body_imu) return forward(T_body_imu);
  Imu imu;
  imu.T_imu_left = T_body_imu->inverse() * T_body_left;
  for (const auto& [key, value] : {std::pair("gyroscope_noise_density", &imu.gyro_noise),
                                   std::pair("gyroscope_random_walk", &imu.gyro_walk),
                                   std::pair("accelerometer_noise_density", &imu.accel_noise),
                                   std::pair("accelerometer_random_walk", &imu.accel_walk),
                                   std::pair("rate_hz", &imu.rate_hz)}) {
    const Result<Field> field = root.at(key);
    if (!field) return forward(field);
    const Result<double> number = field->number();
    if (!number) return forward(number);
    *value = *number;
  }
  return imu;
}

}  // namespace tread::internal
