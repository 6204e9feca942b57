#include "tread/io/rgbd_folder.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <string_view>
#include <system_error>

#include "tread/io/text.hpp"
#include "tread/io/trajectory_file.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;
using Kind = RgbdFolder::Kind;

constexpr std::string_view kUnderstood =
    "Give a folder with frame-NNNNNN.depth.png (7-Scenes, 3DMatch), or with depth.txt (TUM RGB-D), "
    "or with a seq.txt that begins with 'K fx fy cx cy depth_scale width height'";

// ---- which kind it is

constexpr std::string_view kFrame = "frame-";
constexpr std::string_view kDepth = ".depth.png";
constexpr std::string_view kPose = ".pose.txt";

// frame-000012.depth.png taken apart.
struct FrameFile {
  std::int64_t number = 0;
  std::string stem;    // "frame-000012"
  std::string suffix;  // ".depth.png"
};

std::optional<FrameFile> parse_frame_file(const std::string& name) {
  constexpr std::size_t kMostDigits = 9;
  if (!name.starts_with(kFrame)) return std::nullopt;
  const std::size_t end = std::min(name.find('.'), name.size());
  const std::string digits = name.substr(kFrame.size(), end - kFrame.size());
  const bool only_digits = digits.find_first_not_of("0123456789") == std::string::npos;
  if (digits.empty() || digits.size() > kMostDigits || !only_digits) return std::nullopt;
  const auto number = parse_number<std::int64_t>(digits);
  if (!number) return std::nullopt;
  return FrameFile{*number, name.substr(0, end), name.substr(end)};
}

bool is_depth_of_frame(const std::string& name) {
  const auto file = parse_frame_file(name);
  return file && file->suffix == kDepth;
}

// Names in a folder that `wanted` takes, sorted, at most `most` of them.
template <class Wanted>
std::vector<std::string> names_in(const fs::path& folder, const Wanted& wanted,
                                  std::size_t most = std::size_t(-1)) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end && names.size() < most;
       at.increment(error)) {
    std::string name = at->path().filename().string();
    if (wanted(name)) names.push_back(std::move(name));
  }
  std::sort(names.begin(), names.end());
  return names;
}

bool has_frames(const fs::path& folder) {
  return !names_in(folder, is_depth_of_frame, 1).empty();
}

bool is_file(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

bool is_folder(const fs::path& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored);
}

// Whether the first line of content is that of a list; of a large file only the head is read.
bool is_list(const fs::path& path) {
  if (!is_file(path)) return false;
  std::string head(4096, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(std::max<std::streamsize>(file.gcount(), 0)));
  const auto lines = lines_with_content(head);
  return !lines.empty() && split_fields(lines.front().text).front() == "K";
}

fs::path find_associations(const fs::path& folder) {
  const auto names = names_in(folder, [](const std::string& name) {
    return name.starts_with("assoc") && name.ends_with(".txt");
  });
  if (names.empty()) return {};
  const auto usual = std::find(names.begin(), names.end(), "associations.txt");
  return folder / (usual != names.end() ? *usual : names.front());
}

bool is_tum(const fs::path& folder) {
  if (is_file(folder / "depth.txt")) return true;
  return is_folder(folder / "depth") && !find_associations(folder).empty();
}

// seq-01, seq-02 ... of a scene of 7-Scenes, as it is unpacked.
std::vector<std::string> sequences_in(const fs::path& folder) {
  return names_in(folder, [&](const std::string& name) {
    return name.starts_with("seq-") && has_frames(folder / name);
  });
}

// ---- frame-NNNNNN.*

struct FoundFrame {
  RgbdFolder::Frame frame;
  fs::path pose;
};

constexpr std::int64_t stamp_at_30_hz(std::int64_t number) {
  return (number * 100'000'000 + 1) / 3;  // rounded; numbers have at most nine digits
}

// By number. Of two names with one number, as frame-1 and frame-000001, the first stays.
std::map<std::int64_t, FoundFrame> find_frames(const fs::path& path, std::vector<Error>& problems) {
  std::map<std::int64_t, FoundFrame> found;
  for (const std::string& name : names_in(path, parse_frame_file)) {
    const FrameFile file = *parse_frame_file(name);
    const bool colour = file.suffix == ".color.png" || file.suffix == ".color.jpg";
    if (!colour && file.suffix != kDepth && file.suffix != kPose) continue;
    FoundFrame& entry = found[file.number];
    if (entry.frame.name.empty()) entry.frame.name = file.stem;
    if (entry.frame.name != file.stem) {
      problems.push_back({ErrorCode::kBadFormat,
                          fmt::format("{} has the same number and is used", entry.frame.name),
                          (path / name).string(), "Move one of the two away"});
    } else if (file.suffix == kPose) {
      entry.pose = path / name;
    } else {
      (colour ? entry.frame.colour : entry.frame.depth) = path / name;
    }
  }
  return found;
}

Result<RgbdFolder> read_frames_folder(const fs::path& path) {
  RgbdFolder folder;
  folder.kind = Kind::kFrames;
  folder.path = path;
  folder.full_depth_is_unknown = true;
  for (auto& [number, found] : find_frames(path, folder.problems)) {
    RgbdFolder::Frame& frame = found.frame;
    frame.stamp_ns = stamp_at_30_hz(number);
    if (!found.pose.empty()) {
      const auto pose = read_pose_matrix(found.pose);
      if (pose) {
        frame.T_world_camera = *pose;
        folder.truth.push_back({frame.stamp_ns, *pose});
      } else {
        folder.problems.push_back(pose.error());
      }
    }
    if (!frame.depth.empty() || !frame.colour.empty()) folder.frames.push_back(std::move(frame));
  }
  return folder;
}

}  // namespace

std::string internal::rgbd_frame_name(const fs::path& depth) {
  std::string name = depth.stem().string();
  if (name.ends_with(".depth")) name.resize(name.size() - std::string_view(".depth").size());
  return name;
}

bool looks_like_rgbd(const fs::path& path) {
  if (!is_folder(path)) return is_list(path);
  return has_frames(path) || is_tum(path) || is_list(path / "seq.txt") ||
         !sequences_in(path).empty();
}

Result<RgbdFolder> find_rgbd_folder(const fs::path& path) {
  std::error_code ignored;
  if (!fs::exists(path, ignored)) {
    return fail(ErrorCode::kNotFound, "no such folder", path.string(), "Check the name");
  }
  if (!is_folder(path)) {
    if (is_list(path)) return internal::read_rgbd_list(path);
    return fail(ErrorCode::kUnsupported, "this is neither a folder nor a list of RGB-D images",
                path.string(), std::string(kUnderstood));
  }
  if (has_frames(path)) return read_frames_folder(path);
  if (is_tum(path)) return internal::read_tum_folder(path, find_associations(path));
  if (is_list(path / "seq.txt")) return internal::read_rgbd_list(path / "seq.txt");
  const auto sequences = sequences_in(path);
  if (sequences.size() == 1) return read_frames_folder(path / sequences.front());
  if (sequences.size() > 1) {
    return fail(ErrorCode::kBadArgument,
                fmt::format("there are {} sequences in it", sequences.size()), path.string(),
                fmt::format("Give one of them: {}", fmt::join(sequences, ", ")));
  }
  std::error_code error;
  const fs::directory_iterator listing(path, error);
  if (!error) {
    return fail(ErrorCode::kNotFound, "no RGB-D images are found in it", path.string(),
                std::string(kUnderstood));
  }
  return fail(ErrorCode::kUnreadable, fmt::format("cannot be listed: {}", error.message()),
              path.string(), "Check its permissions");
}

}  // namespace tread
