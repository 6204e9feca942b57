// Poses from a file of their own, for the frames of a folder.
#include "tread/io/stereo_poses.hpp"

#include <fmt/format.h>

#include <cstddef>
#include <system_error>
#include <utility>

#include "tread/io/atomic_file.hpp"
#include "tread/io/rig_formats.hpp"
#include "tread/io/text.hpp"
#include "tread/io/trajectory_file.hpp"

namespace tread::internal {
namespace {

namespace fs = std::filesystem;

bool is_there(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

// Poses as they come from the file, in the order of its lines or by time.
struct PoseFile {
  std::vector<std::optional<Isometry3d>> by_number;
  Trajectory by_time;
  std::vector<Error> bad_lines;
};

// TUM or KITTI, told apart by the number of fields of the first line that has as many as either.
// A damaged line costs its pose, not the drive; but one pose there must be.
Result<PoseFile> read_poses(const fs::path& path) {
  const auto text = read_file(path, std::size_t{1} << 30);
  if (!text) return forward(text);
  const auto lines = lines_with_content(*text);
  PoseFile poses;
  std::size_t fields = lines.empty() ? 0 : split_fields(lines.front().text).size();
  for (const TextLine& line : lines) {
    const std::size_t here = split_fields(line.text).size();
    if (here != 8 && here != 12) continue;
    fields = here;
    break;
  }
  if (fields == 12) {
    auto read = read_kitti_poses(path, &poses.bad_lines);
    if (!read) return forward(read);
    poses.by_number = std::move(*read);
    if (poses.bad_lines.size() < poses.by_number.size()) return poses;
    return tl::unexpected<Error>(poses.bad_lines.front());
  }
  if (fields == 8) {
    auto read = read_tum_trajectory(path, &poses.bad_lines);
    if (!read) return forward(read);
    poses.by_time = std::move(*read);
    if (!poses.by_time.empty()) return poses;
    return tl::unexpected<Error>(poses.bad_lines.front());
  }
  return fail(ErrorCode::kBadFormat, fmt::format("{} numbers in the first line", fields),
              path.string(), "Write 8 (TUM: time tx ty tz qx qy qz qw) or 12 (KITTI: 3x4 matrix)");
}

fs::path find_poses(const FramePoseRequest& of) {
  if (!of.file.empty()) return of.file;
  if (is_there(of.path / "poses.txt")) return of.path / "poses.txt";
  if (of.folder.kind != StereoFolder::Kind::kKitti) return {};
  // sequences/07 and poses/07.txt
  std::error_code error;
  const fs::path whole = fs::canonical(of.path, error);
  const fs::path beside =
      whole.parent_path().parent_path() / "poses" / (whole.filename().string() + ".txt");
  return !error && is_there(beside) ? beside : fs::path{};
}

FramePoses poses_of_frames(const PoseFile& poses, const FramePoseRequest& of) {
  const Isometry3d T_world_first =
      of.rig.mount ? of.rig.mount->T_body_left : level_mount(0.0, 0.0, true).T_body_left;
  FramePoses found;
  for (const StereoFolder::Frame& frame : of.folder.frames) {
    const auto number = static_cast<std::size_t>(frame.number);
    if (!poses.by_time.empty()) {
      found.push_back(pose_at(poses.by_time, frame.stamp_ns));
    } else if (number < poses.by_number.size() && poses.by_number[number]) {
      found.emplace_back(T_world_first * of.T_0_left.inverse() * *poses.by_number[number] *
                         of.T_0_left);
    } else {
      found.emplace_back(std::nullopt);
    }
  }
  return found;
}

// ---- EuRoC

Result<Isometry3d> read_place_in_body(const fs::path& sensor_file) {
  const auto text = read_file(sensor_file, std::size_t{1} << 20);
  if (!text) return forward(text);
  const auto root = parse_yaml(*text, sensor_file.string());
  if (!root) return forward(root);
  return read_euroc_place(Field(*root, sensor_file.string()));
}

// `place` is the folder that holds cam0 and imu0. The rig comes first: it may be another
// calibration than the folder's.
Result<Isometry3d> find_T_body_left(const fs::path& place, const StereoRig& rig) {
  const fs::path imu = place / "imu0" / "sensor.yaml", left = place / "cam0" / "sensor.yaml";
  if (rig.imu) {
    if (!is_there(imu)) return rig.imu->T_imu_left;  // the body of these data sets is the IMU
    const auto T_body_imu = read_place_in_body(imu);
    if (!T_body_imu) return forward(T_body_imu);
    return *T_body_imu * rig.imu->T_imu_left;
  }
  if (is_there(left)) return read_place_in_body(left);
  return fail(ErrorCode::kNotFound, "the poses are left out: where the camera sits is not known",
              left.string(), "Add this file, or the section imu to the rig");
}

Result<FramePoses> read_euroc_truth(const fs::path& place, const fs::path& file,
                                    const FramePoseRequest& of, std::vector<Error>& problems) {
  const auto T_body_left = find_T_body_left(place, of.rig);
  if (!T_body_left) {
    problems.push_back(T_body_left.error());
    return FramePoses{};
  }
  const auto T_world_body = read_euroc_poses(file, &problems);
  if (!T_world_body) return forward(T_world_body);
  FramePoses found;
  for (const StereoFolder::Frame& frame : of.folder.frames) {
    const auto pose = pose_at(*T_world_body, frame.stamp_ns);
    found.push_back(pose ? std::optional<Isometry3d>(*pose * *T_body_left) : std::nullopt);
  }
  return found;
}

}  // namespace

Result<FramePoses> read_frame_poses(const FramePoseRequest& of, std::vector<Error>& problems) {
  if (const fs::path file = find_poses(of); !file.empty()) {
    auto read = read_poses(file);
    if (!read) return forward(read);
    problems.insert(problems.end(), read->bad_lines.begin(), read->bad_lines.end());
    return poses_of_frames(*read, of);
  }
  for (const fs::path& place : {of.path, of.path / "mav0"}) {
    const fs::path file = place / "state_groundtruth_estimate0" / "data.csv";
    if (is_there(file)) return read_euroc_truth(place, file, of, problems);
  }
  return FramePoses{};
}

}  // namespace tread::internal
