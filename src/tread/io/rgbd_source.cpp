// A folder of RGB-D images as a source. The list of frames, the camera and the poses are read when
// it is opened; images one frame at a time.
#include "tread/io/rgbd_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <system_error>
#include <utility>

#include "tread/io/image_file.hpp"
#include "tread/io/trajectory_file.hpp"
#include "tread/io/usual_image_size.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;
using Kind = RgbdFolder::Kind;

class RgbdFolderSource : public RgbdSource {
 public:
  RgbdFolderSource(RgbdFolder folder, const RgbdCamera& camera)
      : folder_(std::move(folder)), camera_(camera) {}

  [[nodiscard]] const RgbdCamera& camera() const override { return camera_; }
  [[nodiscard]] int frame_count() const override { return static_cast<int>(folder_.frames.size()); }
  [[nodiscard]] bool has_poses() const override { return !folder_.truth.empty(); }
  [[nodiscard]] const Trajectory& truth() const override { return folder_.truth; }
  [[nodiscard]] const std::vector<Error>& problems() const override { return folder_.problems; }
  [[nodiscard]] std::string kind() const override {
    if (folder_.kind == Kind::kTum) return "TUM RGB-D folder";
    return folder_.kind == Kind::kList ? "list of RGB-D images" : "7-Scenes or 3DMatch folder";
  }
  [[nodiscard]] Result<std::optional<RgbdFrame>> next() override {
    if (next_ >= folder_.frames.size()) return std::optional<RgbdFrame>{};
    const RgbdFolder::Frame& from = folder_.frames[next_++];
    return with_memory_checked(from.name, "Give it more memory, or smaller images",
                               [&] { return read(from); });
  }

 private:
  [[nodiscard]] Result<std::optional<RgbdFrame>> read(const RgbdFolder::Frame& from);
  void count_odd_colour(const fs::path& path, ImageSize colour);

  RgbdFolder folder_;
  RgbdCamera camera_;
  std::size_t next_ = 0;
  int odd_colours_ = 0;          // colour images of another size than the depth images
  std::size_t odd_problem_ = 0;  // their entry in the problems
};

// One entry of the problems for all of them, which names the first.
void RgbdFolderSource::count_odd_colour(const fs::path& path, ImageSize colour) {
  if (odd_colours_++ == 0) {
    odd_problem_ = folder_.problems.size();
    folder_.problems.push_back(
        {ErrorCode::kBadFormat,
         fmt::format("{}x{} pixels, but the depth image has {}x{}; used without colour",
                     colour.width, colour.height, camera_.size.width, camera_.size.height),
         path.string(), "Give colour images that are registered to the depth images"});
    return;
  }
  std::string& what = folder_.problems[odd_problem_].what;
  what.resize(std::min(what.size(), what.find(" (and ")));
  what += fmt::format(" (and {} more like it)", odd_colours_ - 1);
}

Result<std::optional<RgbdFrame>> RgbdFolderSource::read(const RgbdFolder::Frame& from) {
  if (from.depth.empty()) {
    return fail(ErrorCode::kNotFound, "there is no depth image of this name", from.colour.string(),
                "Add it, or move this one away");
  }
  auto depth = read_depth_image(from.depth, folder_.depth_per_metre, folder_.full_depth_is_unknown);
  if (!depth) return forward(depth);
  if (ImageSize{depth->width, depth->height} != camera_.size) {
    return fail(ErrorCode::kBadFormat,
                fmt::format("{}x{} pixels, but the camera has {}x{}", depth->width, depth->height,
                            camera_.size.width, camera_.size.height),
                from.depth.string(), "Give images as they were calibrated, or another camera file");
  }
  RgbdFrame frame;
  frame.stamp_ns = from.stamp_ns;
  frame.name = from.name;
  frame.depth = std::move(*depth);
  frame.T_world_camera = from.T_world_camera;
  if (from.colour.empty()) return std::optional<RgbdFrame>(std::move(frame));
  auto colour = read_grey_and_colour(from.colour);
  if (!colour) return forward(colour);
  if (same_size(colour->grey, frame.depth)) {
    frame.grey = std::move(colour->grey);
    frame.rgb = std::move(colour->colour);
  } else {
    count_odd_colour(from.colour, {colour->grey.width, colour->grey.height});
  }
  return std::optional<RgbdFrame>(std::move(frame));
}

// ---- the camera

constexpr ImageSize kKinectSize = {640, 480};

// A camera that was published with a data set, or is usual for its sensor.
struct PublishedCamera {
  PinholeCamera pinhole;
  std::string_view origin;  // for the message, if it is a guess
};

bool is_letter_or_digit(char c) {
  return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
}

// Whether a folder's name says that it is of one of TUM's three cameras: freiburg1 anywhere, fr1 as
// a word or the beginning of one.
bool names_tum_camera(std::string name, char number) {
  for (char& c : name) c = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  if (name.find(std::string("freiburg") + number) != std::string::npos) return true;
  const std::string word = std::string("fr") + number;
  for (std::size_t at = name.find(word); at != std::string::npos; at = name.find(word, at + 1)) {
    const std::size_t end = at + word.size();
    const bool begins = at == 0 || !is_letter_or_digit(name[at - 1]);
    if (begins && (end == name.size() || name[end] < '0' || name[end] > '9')) return true;
  }
  return false;
}

// The folder's name, and, of a link, that of the folder behind it.
std::array<std::string, 2> names_of_folder(const fs::path& path) {
  const auto last_of = [](const fs::path& whole) {
    return (whole.has_filename() ? whole : whole.parent_path()).filename().string();
  };
  std::error_code ignored;
  return {last_of(fs::absolute(path, ignored).lexically_normal()),
          last_of(fs::canonical(path, ignored))};
}

// Of the depth images as they are published. The distortion that TUM gives with the first two is of
// the colour camera and is left out.
PublishedCamera published_camera(const RgbdFolder& folder) {
  if (folder.kind != Kind::kTum) {
    return {{585.0, 585.0, 320.0, 240.0, 0.0}, "that of 7-Scenes, f 585, c (320, 240)"};
  }
  constexpr std::array<std::pair<char, PinholeCamera>, 3> kTum = {{
      {'1', {517.3, 516.5, 318.6, 255.3, 0.0}},
      {'2', {520.9, 521.0, 325.1, 249.7, 0.0}},
      {'3', {535.4, 539.2, 320.1, 247.6, 0.0}},
  }};
  const auto names = names_of_folder(folder.path);
  for (const auto& [number, pinhole] : kTum) {
    for (const std::string& name : names) {
      if (names_tum_camera(name, number)) return {pinhole, ""};
    }
  }
  return {{525.0, 525.0, 319.5, 239.5, 0.0}, "ROS's default for a Kinect, f 525, c (319.5, 239.5)"};
}

bool is_there(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

// The file that holds the camera; empty if there is none.
fs::path find_camera_file(const RgbdFolder& folder) {
  for (const char* name : {"camera.yaml", "camera-intrinsics.txt"}) {
    if (is_there(folder.path / name)) return folder.path / name;
  }
  if (folder.kind != Kind::kFrames) return {};
  std::error_code error;
  const fs::path above = fs::canonical(folder.path, error).parent_path() / "camera-intrinsics.txt";
  return !error && is_there(above) ? above : fs::path{};
}

Result<ImageSize> usual_depth_size(const RgbdFolder& folder) {
  std::vector<std::vector<fs::path>> images;
  for (const RgbdFolder::Frame& frame : folder.frames) {
    if (!frame.depth.empty()) images.push_back({frame.depth});
  }
  return usual_image_size(images);
}

Result<RgbdCamera> find_camera(RgbdFolder& folder, const RgbdOptions& options) {
  const bool list = folder.camera.has_value() && options.camera.empty();
  const fs::path file = options.camera.empty() ? find_camera_file(folder) : options.camera;
  RgbdCamera camera;
  if (list) {
    camera = *folder.camera;
  } else if (!file.empty()) {
    const auto read = read_rgbd_camera(file);
    if (!read) return forward(read);
    camera = *read;
  }
  if (camera.size == ImageSize{} && folder.camera) camera.size = folder.camera->size;
  if (camera.size == ImageSize{}) {
    const auto size = usual_depth_size(folder);
    if (!size) return forward(size);
    camera.size = *size;
  }
  if (list || !file.empty()) return camera;

  constexpr const char* kRemedy =
      "Put a camera-intrinsics.txt with fx fy cx cy there, or give a file with --camera";
  if (camera.size != kKinectSize) {
    return fail(ErrorCode::kNotFound,
                fmt::format("there is no camera-intrinsics.txt, and no camera is known for {}x{}",
                            camera.size.width, camera.size.height),
                folder.path.string(), kRemedy);
  }
  const PublishedCamera published = published_camera(folder);
  if (!published.origin.empty()) {
    folder.problems.push_back(
        {ErrorCode::kNotFound,
         fmt::format("there is no camera-intrinsics.txt; assumed is {}", published.origin),
         folder.path.string(), kRemedy});
  }
  camera.pinhole = published.pinhole;
  return camera;
}

// ---- opening

// The trajectory that the caller gave in place of the folder's.
Status replace_poses(RgbdFolder& folder, const fs::path& path) {
  std::vector<Error> bad_lines;
  auto read = read_tum_trajectory(path, &bad_lines);
  if (!read) return forward(read);
  if (read->empty()) return tl::unexpected<Error>(bad_lines.front());  // a file has lines
  folder.problems.insert(folder.problems.end(), bad_lines.begin(), bad_lines.end());
  folder.truth = std::move(*read);
  for (RgbdFolder::Frame& frame : folder.frames) {
    frame.T_world_camera = pose_at(folder.truth, frame.stamp_ns);
  }
  return {};
}

Result<std::unique_ptr<RgbdSource>> open(const fs::path& path, const RgbdOptions& options) {
  auto folder = find_rgbd_folder(path);
  if (!folder) return forward(folder);
  if (options.depth_per_metre != 0.0) folder->depth_per_metre = options.depth_per_metre;
  const Status units = check_depth_units(folder->depth_per_metre, path.string());
  if (!units) return forward(units);
  if (!options.poses.empty()) {
    const Status replaced = replace_poses(*folder, options.poses);
    if (!replaced) return forward(replaced);
  }
  const auto camera = find_camera(*folder, options);
  if (!camera) return forward(camera);
  return std::make_unique<RgbdFolderSource>(std::move(*folder), *camera);
}

}  // namespace

Result<std::unique_ptr<RgbdSource>> open_rgbd_source(const fs::path& path,
                                                     const RgbdOptions& options) {
  return with_memory_checked(path.string(), "Close other programs, or give a part of it",
                             [&] { return open(path, options); });
}

}  // namespace tread
