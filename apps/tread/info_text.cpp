// Kinds are told by content: a trajectory by the number of fields of its first line, as their names
// (.txt) tell nothing.
#include "info_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "tread/io/image_file.hpp"
#include "tread/io/text.hpp"
#include "tread/io/trajectory_file.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;

Status info_waypoints(const std::vector<TextLine>& lines, const fs::path& path, Output& output) {
  std::vector<Eigen::Vector2d> points;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    const std::string_view text = lines[i].text;
    const std::size_t comma = std::min(text.find(','), text.size());
    const auto x = parse_number<double>(trimmed(text.substr(0, comma)));
    const auto y = parse_number<double>(trimmed(text.substr(std::min(comma + 1, text.size()))));
    if (!x || !y || !std::isfinite(*x) || !std::isfinite(*y)) {
      return fail(ErrorCode::kBadFormat, in_quotes(text) + " is not a waypoint",
                  line_place(path.string(), lines[i].number), "Write x,y in metres");
    }
    points.emplace_back(*x, *y);
  }
  double length_m = 0.0;
  for (std::size_t i = 1; i < points.size(); ++i) length_m += (points[i] - points[i - 1]).norm();
  output.values["waypoints"] = points.size();
  output.values["length_m"] = length_m;
  say_kind("path",
           points.empty() ? "no waypoints (there was no plan)"
                          : fmt::format("{} waypoints, {:.1f} m", points.size(), length_m),
           output);
  return {};
}

// The plain "key: value" lines of a YAML file.
std::map<std::string, std::string> keys_of(const std::vector<TextLine>& lines) {
  std::map<std::string, std::string> keys;
  for (const TextLine& line : lines) {
    const std::size_t colon = line.text.find(':');
    if (colon == std::string_view::npos) continue;
    keys.emplace(std::string(line.text.substr(0, colon)),
                 std::string(trimmed(line.text.substr(colon + 1))));
  }
  return keys;
}

Status info_nav2(std::map<std::string, std::string>& keys, const fs::path& path, Output& output) {
  const fs::path image = path.parent_path() / keys["image"];
  const auto size = read_image_size(image);
  if (!size) return forward(size);
  for (const char* key : {"image", "mode", "resolution", "origin"}) {
    if (keys.contains(key)) output.values[key] = keys[key];
  }
  output.values["size_px"] = {size->width, size->height};
  const auto cell_m = parse_number<double>(keys["resolution"]);
  say_kind("map for Nav2's map server",
           fmt::format("{}, {}x{} cells of {}{}", keys["image"], size->width, size->height,
                       cell_m ? fmt::format("{:g} m", *cell_m) : keys["resolution"],
                       keys.contains("mode") ? ", mode " + keys["mode"] : ""),
           output);
  return {};
}

Status info_poses(std::size_t fields, const fs::path& path, Output& output) {
  std::size_t poses = 0;
  double seconds = 0.0;
  if (fields == 8) {
    const auto trajectory = read_tum_trajectory(path);
    if (!trajectory) return forward(trajectory);
    poses = trajectory->size();
    if (poses > 0) {
      seconds =
          1e-9 * static_cast<double>(trajectory->back().stamp_ns - trajectory->front().stamp_ns);
    }
  } else {
    const auto matrices = read_kitti_poses(path);
    if (!matrices) return forward(matrices);
    poses = matrices->size();
  }
  output.values["poses"] = poses;
  say_kind(
      fields == 8 ? "trajectory (TUM)" : "trajectory (KITTI poses, without times)",
      fmt::format("{} poses{}", poses, seconds > 0.0 ? fmt::format(", {:.1f} s", seconds) : ""),
      output);
  return {};
}

Status info_times(const fs::path& path, Output& output) {
  const auto times = read_times(path);
  if (!times) return forward(times);
  output.values["times"] = times->size();
  say_kind("times of frames", fmt::format("{} times", times->size()), output);
  return {};
}

}  // namespace

void say_kind(const std::string& kind, const std::string& rest, Output& output) {
  output.values["kind"] = kind;
  output.line(kind + ": " + rest);
}

std::optional<Status> info_text(const fs::path& path, Output& output) {
  const auto text = read_file(path, std::size_t{1} << 28);
  if (!text) return forward(text);
  if (text->find('\0') != std::string::npos) return std::nullopt;
  if (text->starts_with("<!DOCTYPE html") || text->starts_with("<!doctype html")) {
    say_kind("web page", "a report of tread is one; open it in a browser", output);
    return Status{};
  }
  const std::vector<TextLine> lines = lines_with_content(*text);
  if (lines.empty()) return std::nullopt;
  const std::string_view first = lines.front().text;
  if (first == "x_m,y_m") return info_waypoints(lines, path, output);
  auto keys = keys_of(lines);
  if (keys.contains("image") && keys.contains("resolution") && keys.contains("origin")) {
    return info_nav2(keys, path, output);
  }
  for (const char* option : {"stereo", "local", "global", "cost", "plan", "lethal_cost"}) {
    if (!keys.contains(option) || keys.contains("tread_rig")) continue;
    say_kind("options", "for --config of depth, map or plan", output);
    return Status{};
  }
  // Matrices of a calibration have twelve numbers too, but are no rigid motions.
  const auto fields = split_fields(first);
  const bool numbers = std::all_of(fields.begin(), fields.end(), [](std::string_view field) {
    return parse_number<double>(field).has_value();
  });
  const bool calibration = path.filename().string().starts_with("calib");
  if (!numbers || calibration) return std::nullopt;
  if (fields.size() == 8 || fields.size() == 12) return info_poses(fields.size(), path, output);
  if (fields.size() == 1) return info_times(path, output);
  return std::nullopt;
}

}  // namespace tread
