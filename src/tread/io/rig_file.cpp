#include "tread/io/rig_file.hpp"

#include <fmt/format.h>

#include <utility>

#include "tread/io/atomic_file.hpp"
#include "tread/io/rig_formats.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;
using internal::Field;
using internal::RigDocument;

constexpr std::size_t kLargestFile = std::size_t{1} << 20;
constexpr const char* kKnownFormats =
    "Give a rig file of this program (tread_rig: 1), of OpenCV, Kalibr or KITTI, a pair "
    "LEFT.yaml,RIGHT.yaml of ROS camera_info or EuRoC sensor.yaml, a folder with such a pair, or "
    "bumblebee2-640 or bumblebee2-1024";

bool is_there(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

bool is_folder(const fs::path& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored);
}

Result<RigDocument> parse(const std::string& text, const std::string& file) {
  const std::size_t start = text.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  const bool xml = start != std::string::npos && text[start] == '<';
  auto root = xml ? internal::parse_xml(text, file) : internal::parse_yaml(text, file);
  if (!root) return forward(root);
  return RigDocument{file, std::move(*root)};
}

Result<RigDocument> load(const fs::path& path) {
  const auto text = read_file(path, kLargestFile);
  if (!text) return forward(text);
  return parse(*text, path.string());
}

Result<StereoRig> read_one_file(const fs::path& path, ImageSize size) {
  const std::string file = path.string();
  const auto text = read_file(path, kLargestFile);
  if (!text) return forward(text);
  if (internal::is_kitti(*text)) return internal::read_kitti_rig(*text, file, size);
  const auto document = parse(*text, file);
  if (!document) return forward(document);
  const Field root = document->field();
  if (internal::is_own(root)) return internal::read_own_rig(root);
  if (internal::is_kalibr(root)) return internal::read_kalibr_rig(root);
  if (internal::is_opencv_intrinsics(root)) return internal::read_opencv_rig(root, root, size);
  if (internal::is_camera_info(root) || internal::is_euroc_sensor(root)) {
    return fail(ErrorCode::kBadArgument, "this is the calibration of one camera", file,
                "Give the pair, LEFT.yaml,RIGHT.yaml, or the folder that holds both");
  }
  return fail(ErrorCode::kBadFormat, "not a rig file that is known here", file, kKnownFormats);
}

// The IMU of imu0/sensor.yaml, if that stands beside the folder cam0 of the left camera.
Status add_euroc_imu(const Field& left, const fs::path& left_folder, StereoRig& rig) {
  const fs::path path = left_folder.parent_path() / "imu0" / "sensor.yaml";
  if (left_folder.filename() != "cam0" || !is_there(path)) return {};
  const auto document = load(path);
  if (!document) return forward(document);
  const auto T_body_left = internal::read_euroc_place(left);
  if (!T_body_left) return forward(T_body_left);
  const auto imu = internal::read_euroc_imu(document->field(), *T_body_left);
  if (!imu) return forward(imu);
  rig.imu = *imu;
  return {};
}

Result<StereoRig> read_pair(const fs::path& first_path, const fs::path& second_path,
                            ImageSize size) {
  const auto first = load(first_path);
  if (!first) return forward(first);
  const auto second = load(second_path);
  if (!second) return forward(second);
  const Field left = first->field(), right = second->field();
  if (internal::is_euroc_sensor(left)) {
    Result<StereoRig> rig = internal::read_euroc_rig(left, right);
    if (!rig) return rig;
    if (Status done = add_euroc_imu(left, first_path.parent_path(), *rig); !done) {
      return forward(done);
    }
    return rig;
  }
  if (internal::is_opencv_intrinsics(left)) return internal::read_opencv_rig(left, right, size);
  if (internal::is_camera_info(left)) return internal::read_camera_info_rig(left, right);
  return fail(ErrorCode::kBadFormat, "not the calibration of a camera that is known here",
              first_path.string(), kKnownFormats);
}

Result<StereoRig> read_folder(const fs::path& folder, ImageSize size) {
  for (const fs::path& place : {folder, folder / "mav0"}) {
    if (is_there(place / "cam0" / "sensor.yaml")) {
      return read_pair(place / "cam0" / "sensor.yaml", place / "cam1" / "sensor.yaml", size);
    }
  }
  const std::pair<const char*, const char*> kPairs[] = {
      {"left.yaml", "right.yaml"}, {"left.yml", "right.yml"}, {"intrinsics.yml", "extrinsics.yml"}};
  for (const auto& [first, second] : kPairs) {
    if (is_there(folder / first)) return read_pair(folder / first, folder / second, size);
  }
  return fail(ErrorCode::kNotFound, "no calibration in this folder", folder.string(),
              "Expected cam0/sensor.yaml and cam1/sensor.yaml, or left.yaml and right.yaml, or "
              "intrinsics.yml and extrinsics.yml; or give a rig file itself");
}

Result<StereoRig> read_any(const std::string& path, ImageSize size) {
  if (is_folder(path)) return read_folder(path, size);
  if (is_there(path)) return read_one_file(path, size);
  if (const auto known = named_rig(path)) return *known;
  const std::size_t comma = path.find(',');
  if (comma != std::string::npos) {
    return read_pair(path.substr(0, comma), path.substr(comma + 1), size);
  }
  return fail(ErrorCode::kNotFound, "no such file, folder or known rig", path, kKnownFormats);
}

}  // namespace

Result<StereoRig> read_rig(const std::string& path, ImageSize size) {
  Result<StereoRig> rig = read_any(path, size);
  if (!rig) return rig;
  if (rig->name.empty()) {
    const fs::path named = fs::path(path.substr(0, path.find(','))).lexically_normal();
    rig->name = (named.has_filename() ? named : named.parent_path()).stem().string();
  }
  Status sound = internal::check_whole_rig(*rig);
  if (!sound) {
    sound.error().where = path + ": " + sound.error().where;
    return forward(sound);
  }
  return rig;
}

}  // namespace tread
