// Times never pass through a floating-point number: a double of seconds since 1970 is only good to
// 0.2 microseconds.
#include "tread/io/trajectory_file.hpp"

#include <fmt/format.h>

#include <array>
#include <cassert>
#include <cmath>

#include "tread/io/atomic_file.hpp"
#include "tread/io/stamped_csv.hpp"
#include "tread/io/text.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLargestFile = std::size_t{1} << 30;
constexpr const char* kCorrectLine = "Correct or remove this line";
constexpr const char* kZeroQuaternion = "the quaternion is zero";

// The first N fields as finite numbers; there are at least so many.
template <std::size_t N>
Result<std::array<double, N>> finite_numbers(std::span<const std::string_view> fields,
                                             const std::string& place, const char* remedy) {
  std::array<double, N> numbers{};
  for (std::size_t i = 0; i < N; ++i) {
    const std::string_view text = fields[i];
    const auto number = parse_number<double>(text);
    if (!number || !std::isfinite(*number)) {
      return fail(ErrorCode::kBadFormat, in_quotes(text) + " is not a finite number", place,
                  remedy);
    }
    numbers[i] = *number;
  }
  return numbers;
}

// x, y, z, w
bool is_zero(const Eigen::Vector4d& q) {
  return q.cwiseAbs().maxCoeff() < 1e-6;
}

Isometry3d pose_of(const Eigen::Vector3d& p, const Eigen::Vector4d& q) {
  // Scaled first, so that its square neither overflows nor vanishes.
  const Eigen::Vector4d unit = (q / q.cwiseAbs().maxCoeff()).normalized();
  Isometry3d pose = Isometry3d::Identity();
  pose.linear() = Eigen::Quaterniond(unit[3], unit[0], unit[1], unit[2]).toRotationMatrix();
  pose.translation() = p;
  return pose;
}

// Of a row of EuRoC: qw comes first.
Eigen::Vector4d quaternion_of(const internal::StampedRow& row) {
  return {row.numbers[4], row.numbers[5], row.numbers[6], row.numbers[3]};
}

tl::unexpected<Error> not_increasing(const std::string& place) {
  return fail(ErrorCode::kBadValue, "the time is not later than that of the line before", place,
              "Sort the lines by time and remove doubles");
}

Result<StampedPose> parse_tum_line(std::string_view line, const std::string& place) {
  const auto fields = split_fields(line);
  if (fields.size() != 8) {
    return fail(ErrorCode::kBadFormat, fmt::format("{} fields instead of 8", fields.size()), place,
                "A line of a TUM trajectory is: time tx ty tz qx qy qz qw");
  }
  const auto stamp_ns = parse_stamp(fields[0], place);
  if (!stamp_ns) return forward(stamp_ns);
  const auto pose = parse_tum_pose(std::span(fields).subspan(1), place);
  if (!pose) return forward(pose);
  return StampedPose{*stamp_ns, *pose};
}

// The pose of a 3x4 matrix, row by row.
Result<Isometry3d> pose_of_rows(std::span<const double, 12> rows, const std::string& place) {
  Isometry3d T = Isometry3d::Identity();
  T.matrix().topRows<3>() =
      Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(rows.data());
  if (!is_rigid(T)) {
    return fail(ErrorCode::kBadValue, "the 3x3 part is not a rotation", place,
                "Check that the matrix is written row by row and has no scale");
  }
  T.linear() = Eigen::Quaterniond(T.linear()).normalized().toRotationMatrix();
  return T;
}

Result<Isometry3d> parse_kitti_line(std::string_view line, const std::string& place) {
  const auto fields = split_fields(line);
  if (fields.size() != 12) {
    return fail(ErrorCode::kBadFormat, fmt::format("{} fields instead of 12", fields.size()), place,
                "A line of KITTI poses is a 3x4 matrix, row by row");
  }
  const auto numbers = finite_numbers<12>(fields, place, kCorrectLine);
  if (!numbers) return forward(numbers);
  return pose_of_rows(*numbers, place);
}

Result<std::vector<TextLine>> lines_of(const std::string& text, const fs::path& path) {
  auto lines = lines_with_content(text);
  if (!lines.empty()) return lines;
  return fail(ErrorCode::kBadFormat, "the file is empty", path.string(),
              "Check that this is the right file");
}

}  // namespace

Result<std::int64_t> parse_stamp(std::string_view text, const std::string& place) {
  const auto stamp_ns = parse_seconds_as_ns(text);
  if (stamp_ns) return *stamp_ns;
  return fail(ErrorCode::kBadFormat, in_quotes(text) + " is not a time in seconds", place,
              "Write seconds, as 1305031102.175304");
}

Result<Isometry3d> parse_tum_pose(std::span<const std::string_view> fields,
                                  const std::string& place) {
  assert(fields.size() == 7);
  const auto numbers = finite_numbers<7>(fields, place, kCorrectLine);
  if (!numbers) return forward(numbers);
  const auto& n = *numbers;
  const Eigen::Vector4d q(n[3], n[4], n[5], n[6]);
  if (is_zero(q)) {
    return fail(ErrorCode::kBadValue, kZeroQuaternion, place,
                "Write the rotation as qx qy qz qw; none is 0 0 0 1");
  }
  return pose_of({n[0], n[1], n[2]}, q);
}

Result<Trajectory> read_tum_trajectory(const fs::path& path, std::vector<Error>* bad_lines) {
  const auto text = read_file(path, kLargestFile);
  if (!text) return forward(text);
  const auto lines = lines_of(*text, path);
  if (!lines) return forward(lines);
  Trajectory trajectory;
  for (const TextLine& line : *lines) {
    const std::string place = line_place(path.string(), line.number);
    Result<StampedPose> pose = parse_tum_line(line.text, place);
    if (pose && !trajectory.empty() && pose->stamp_ns <= trajectory.back().stamp_ns) {
      pose = not_increasing(place);
    }
    if (pose) {
      trajectory.push_back(*pose);
    } else if (bad_lines != nullptr) {
      bad_lines->push_back(pose.error());
    } else {
      return forward(pose);
    }
  }
  return trajectory;
}

Status write_tum_trajectory(const fs::path& path, const Trajectory& trajectory) {
  std::string text = "# time tx ty tz qx qy qz qw\n";
  for (const StampedPose& stamped : trajectory) {
    const Eigen::Vector3d p = stamped.pose.translation();
    Eigen::Quaterniond q(stamped.pose.linear());
    if (q.w() < 0.0) q.coeffs() = -q.coeffs();  // one text for one rotation
    text += fmt::format("{} {} {} {} {} {} {} {}\n", print_ns_as_seconds(stamped.stamp_ns), p.x(),
                        p.y(), p.z(), q.x(), q.y(), q.z(), q.w());
  }
  return write_file(path, text);
}

Result<std::vector<std::optional<Isometry3d>>> read_kitti_poses(const fs::path& path,
                                                                std::vector<Error>* bad_lines) {
  const auto text = read_file(path, kLargestFile);
  if (!text) return forward(text);
  const auto lines = lines_of(*text, path);
  if (!lines) return forward(lines);
  std::vector<std::optional<Isometry3d>> poses;
  for (const TextLine& line : *lines) {
    const auto pose = parse_kitti_line(line.text, line_place(path.string(), line.number));
    if (!pose && bad_lines == nullptr) return forward(pose);
    if (!pose) bad_lines->push_back(pose.error());
    poses.push_back(pose ? std::optional(*pose) : std::nullopt);
  }
  return poses;
}

Result<Trajectory> read_euroc_poses(const fs::path& path, std::vector<Error>* problems) {
  const internal::CsvLayout layout{7, true, "time in ns, px, py, pz, qw, qx, qy, qz",
                                   [](const internal::StampedRow& row) {
                                     return is_zero(quaternion_of(row)) ? kZeroQuaternion : nullptr;
                                   }};
  const auto rows = internal::read_stamped_csv(path, layout, problems);
  if (!rows) return forward(rows);
  Trajectory trajectory;
  for (std::size_t i = 0; i < rows->size(); ++i) {
    const internal::StampedRow row = (*rows)[i];
    const auto& n = row.numbers;
    trajectory.push_back({row.stamp_ns, pose_of({n[0], n[1], n[2]}, quaternion_of(row))});
  }
  return trajectory;
}

Result<Isometry3d> read_pose_matrix(const fs::path& path) {
  const auto text = read_file(path, std::size_t{1} << 16);
  if (!text) return forward(text);
  std::vector<std::string_view> fields;
  for (const TextLine& line : lines_with_content(*text)) {
    const auto of_line = split_fields(line.text);
    fields.insert(fields.end(), of_line.begin(), of_line.end());
  }
  constexpr const char* kRemedy = "Write a 4x4 matrix, row by row, its last row 0 0 0 1";
  if (fields.size() != 16) {
    return fail(ErrorCode::kBadFormat, fmt::format("{} fields instead of 16", fields.size()),
                path.string(), kRemedy);
  }
  const auto numbers = finite_numbers<16>(fields, path.string(), kRemedy);
  if (!numbers) return forward(numbers);
  const auto& n = *numbers;
  if (n[12] != 0.0 || n[13] != 0.0 || n[14] != 0.0 || n[15] != 1.0) {
    return fail(ErrorCode::kBadFormat, "the last row is not 0 0 0 1", path.string(), kRemedy);
  }
  return pose_of_rows(std::span(n).first<12>(), path.string());
}

Result<std::vector<std::int64_t>> read_times(const fs::path& path) {
  const auto text = read_file(path, kLargestFile);
  if (!text) return forward(text);
  const auto lines = lines_of(*text, path);
  if (!lines) return forward(lines);
  std::vector<std::int64_t> times_ns;
  for (const TextLine& line : *lines) {
    const std::string place = line_place(path.string(), line.number);
    const auto stamp_ns = parse_stamp(line.text, place);
    if (!stamp_ns) return forward(stamp_ns);
    if (!times_ns.empty() && *stamp_ns <= times_ns.back()) return not_increasing(place);
    times_ns.push_back(*stamp_ns);
  }
  return times_ns;
}

}  // namespace tread
