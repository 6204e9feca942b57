// A folder of stereo images as a source. The list of frames, the rig, the poses and the samples of
// the IMU are read when it is opened; images one pair at a time.
#include "tread/io/source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <system_error>
#include <utility>
#include <vector>

#include "tread/io/atomic_file.hpp"
#include "tread/io/image_file.hpp"
#include "tread/io/imu_file.hpp"
#include "tread/io/recording_folder.hpp"
#include "tread/io/rig_file.hpp"
#include "tread/io/stereo_folder.hpp"
#include "tread/io/stereo_poses.hpp"
#include "tread/io/text.hpp"
#include "tread/io/trajectory_file.hpp"
#include "tread/io/usual_image_size.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;

constexpr double kKittiCameraHeight_m = 1.65;  // Geiger, Lenz, Stiller, Urtasun 2013, Fig. 3
constexpr std::int64_t kBeforeFirstFrame_ns = 1'000'000'000;  // samples that come with it

class FolderSource : public StereoSource {
 public:
  FolderSource(StereoFolder folder, StereoRig rig, std::vector<std::optional<Isometry3d>> poses,
               std::vector<ImuSample> imu, std::vector<Error> problems, const ImageReading& reading)
      : folder_(std::move(folder)),
        reading_(reading),
        rig_(std::move(rig)),
        poses_(std::move(poses)),
        imu_(std::move(imu)),
        problems_(std::move(problems)) {}

  [[nodiscard]] const StereoRig& rig() const override { return rig_; }
  [[nodiscard]] int frame_count() const override { return static_cast<int>(folder_.frames.size()); }
  [[nodiscard]] bool has_poses() const override { return !poses_.empty(); }
  [[nodiscard]] bool has_imu() const override { return !imu_.empty(); }
  [[nodiscard]] const std::vector<Error>& problems() const override { return problems_; }
  [[nodiscard]] std::string kind() const override {
    return folder_.kind == StereoFolder::Kind::kKitti ? "KITTI odometry folder"
                                                      : "folder of left and right images";
  }
  [[nodiscard]] Result<std::optional<StereoFrame>> next() override {
    if (next_ >= folder_.frames.size()) return std::optional<StereoFrame>{};
    const std::size_t index = next_++;
    return with_memory_checked(folder_.frames[index].name, "Give it more memory, or smaller images",
                               [&] { return read(index); });
  }

 private:
  [[nodiscard]] Result<std::optional<StereoFrame>> read(std::size_t index);
  [[nodiscard]] Status check_size(ImageView<const std::uint8_t> image, const fs::path& path) const;
  [[nodiscard]] std::vector<ImuSample> imu_until(std::int64_t stamp_ns) const;

  StereoFolder folder_;
  ImageReading reading_;
  StereoRig rig_;
  std::vector<std::optional<Isometry3d>> poses_;  // none, or one a frame
  std::vector<ImuSample> imu_;                    // by time
  std::vector<Error> problems_;
  std::size_t next_ = 0;
  std::optional<std::int64_t> given_until_ns_;  // time of the last frame that was given out
};

Status FolderSource::check_size(ImageView<const std::uint8_t> image, const fs::path& path) const {
  if (image.width == rig_.size.width && image.height == rig_.size.height) return {};
  return fail(ErrorCode::kBadFormat,
              fmt::format("{}x{} pixels, but the rig has {}x{}", image.width, image.height,
                          rig_.size.width, rig_.size.height),
              path.string(), "Give images as they were calibrated, or another rig file");
}

// Those after the last frame that was given out: a frame that cannot be read leaves no gap.
std::vector<ImuSample> FolderSource::imu_until(std::int64_t stamp_ns) const {
  const auto after = [&](std::int64_t limit_ns) {
    return std::upper_bound(
        imu_.begin(), imu_.end(), limit_ns,
        [](std::int64_t limit, const ImuSample& sample) { return limit < sample.stamp_ns; });
  };
  const auto begin = after(given_until_ns_.value_or(stamp_ns - kBeforeFirstFrame_ns));
  const auto end = after(stamp_ns);
  return begin < end ? std::vector<ImuSample>(begin, end) : std::vector<ImuSample>{};
}

Result<std::optional<StereoFrame>> FolderSource::read(std::size_t index) {
  const StereoFolder::Frame& from = folder_.frames[index];
  if (from.left.empty() || from.right.empty()) {
    const bool no_left = from.left.empty();
    return fail(ErrorCode::kNotFound,
                fmt::format("there is no {} image of this name", no_left ? "left" : "right"),
                (no_left ? from.right : from.left).string(), "Add it, or move this one away");
  }
  auto left = read_grey_and_colour(from.left, reading_);
  if (!left) return forward(left);
  auto right = read_grey(from.right, reading_);
  if (!right) return forward(right);
  if (const Status size = check_size(left->grey, from.left); !size) return forward(size);
  if (const Status size = check_size(*right, from.right); !size) return forward(size);
  StereoFrame frame;
  frame.stamp_ns = from.stamp_ns;
  frame.name = from.name;
  frame.left = std::move(left->grey);
  frame.right = std::move(*right);
  frame.left_colour = std::move(left->colour);
  if (!poses_.empty()) frame.T_world_left = poses_[index];
  frame.imu = imu_until(frame.stamp_ns);
  given_until_ns_ = frame.stamp_ns;
  return std::optional<StereoFrame>(std::move(frame));
}

bool is_there(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

Result<ImageSize> find_image_size(const StereoFolder& folder) {
  std::vector<std::vector<fs::path>> images;
  for (const StereoFolder::Frame& frame : folder.frames) {
    std::vector<fs::path>& pair = images.emplace_back();
    for (const fs::path& path : {frame.left, frame.right}) {
      if (!path.empty()) pair.push_back(path);
    }
  }
  return usual_image_size(images);
}

// What read_rig shall be given.
Result<std::string> find_rig(const fs::path& path, const StereoFolder& folder,
                             const SourceOptions& options) {
  if (!options.rig.empty()) return options.rig;
  const bool kitti = folder.kind == StereoFolder::Kind::kKitti;
  const std::vector<const char*> names =
      kitti ? std::vector<const char*>{"calib.txt", "rig.yaml"}
            : std::vector<const char*>{"rig.yaml", "calib.txt", "camchain.yaml"};
  for (const char* name : names) {
    if (is_there(path / name)) return (path / name).string();
  }
  const std::array<const char*, 5> pairs = {"cam0/sensor.yaml", "mav0/cam0/sensor.yaml",
                                            "left.yaml", "left.yml", "intrinsics.yml"};
  for (const char* name : pairs) {
    if (is_there(path / name)) return path.string();
  }
  return fail(ErrorCode::kNotFound, fmt::format("there is no {}", names.front()), path.string(),
              "Put the calibration of the cameras there, or give it with --rig");
}

// A projection matrix of calib.txt by its name.
Result<std::array<double, 12>> kitti_projection(const std::string& text, const std::string& name,
                                                const fs::path& path) {
  for (const TextLine& line : lines_with_content(text)) {
    const auto fields = split_fields(line.text);
    if (fields.size() != 13 || fields[0] != name + ":") continue;
    std::array<double, 12> P{};
    for (std::size_t i = 0; i < 12; ++i) {
      const auto number = parse_number<double>(fields[i + 1]);
      if (!number || !std::isfinite(*number)) {
        return fail(ErrorCode::kBadFormat, in_quotes(fields[i + 1]) + " is not a number",
                    line_place(path.string(), line.number), "Correct this line");
      }
      P[i] = *number;
    }
    return P;
  }
  return fail(ErrorCode::kNotFound, fmt::format("there is no matrix {}", name), path.string(),
              "Use image_0 and image_1, or give another rig with --rig");
}

// The cameras of image_2 and image_3, and where the former sits in camera 0, of which the poses
// are. read_rig would take P0 and P1, which stand in the same file.
struct ColourCameras {
  StereoRig rig;
  Isometry3d T_0_2 = Isometry3d::Identity();
};

Result<ColourCameras> read_colour_cameras(const fs::path& path, ImageSize size) {
  const auto text = read_file(path, std::size_t{1} << 20);
  if (!text) return forward(text);
  const auto P2 = kitti_projection(*text, "P2", path);
  if (!P2) return forward(P2);
  const auto P3 = kitti_projection(*text, "P3", path);
  if (!P3) return forward(P3);
  // P = K [I | t] with t the place of camera 0 in this camera. Only its x is used: y and z, some
  // millimetres, are against the laser scanner; the published images have equal rows.
  const auto camera = [](const std::array<double, 12>& P) {
    return PinholeCamera{P[0], P[5], P[2], P[6], P[1]};
  };
  const auto x_of_camera_0 = [](const std::array<double, 12>& P) { return P[3] / P[0]; };
  ColourCameras cameras;
  cameras.rig.name = "calib";
  cameras.rig.size = size;
  cameras.rig.left = camera(*P2);
  cameras.rig.right = camera(*P3);
  cameras.rig.T_left_right.translation().x() = x_of_camera_0(*P2) - x_of_camera_0(*P3);
  cameras.rig.rectified = true;
  cameras.T_0_2.translation().x() = -x_of_camera_0(*P2);
  Status checked = check_rig(cameras.rig);
  if (!checked) {
    checked.error().where = path.string() + ": " + checked.error().where;
    return forward(checked);
  }
  return cameras;
}

// Times of KITTI: line n of times.txt is that of frame n.
Status read_frame_times(const fs::path& path, StereoFolder& folder) {
  const auto times_ns = read_times(path);
  if (!times_ns) return forward(times_ns);
  for (StereoFolder::Frame& frame : folder.frames) {
    const auto number = static_cast<std::size_t>(frame.number);
    if (number >= times_ns->size()) {
      return fail(ErrorCode::kBadFormat,
                  fmt::format("{} times, too few for frame {}", times_ns->size(), frame.name),
                  path.string(), "Add the times that are missing, or remove the file for 10 Hz");
    }
    frame.stamp_ns = (*times_ns)[number];
  }
  return {};
}

// The samples of imu0/data.csv, if it is there. The images are of use without them: what is wrong
// with the file is among the problems.
std::vector<ImuSample> find_imu_samples(const fs::path& path, const StereoFolder& folder,
                                        std::vector<Error>& problems) {
  fs::path file = path / "imu0" / "data.csv";
  if (!is_there(file)) file = path / "mav0" / "imu0" / "data.csv";
  if (!is_there(file)) return {};
  auto samples = read_imu(file, &problems);
  if (!samples) {
    problems.push_back(samples.error());
    return {};
  }
  const std::int64_t first_ns = folder.frames.front().stamp_ns - kBeforeFirstFrame_ns;
  if (samples->front().stamp_ns > folder.frames.back().stamp_ns ||
      samples->back().stamp_ns <= first_ns) {
    problems.push_back({ErrorCode::kBadValue, "no sample is of the time of the images",
                        file.string(), "Name the images by their times in nanoseconds"});
    return {};
  }
  return std::move(*samples);
}

}  // namespace

Result<std::unique_ptr<StereoSource>> open_stereo_source(const fs::path& path,
                                                         const SourceOptions& options) {
  if (const Status whole = internal::RecordingFolder::finish_interrupted(path); !whole) {
    return forward(whole);
  }
  auto folder = find_stereo_folder(path);
  if (!folder) return forward(folder);
  const bool kitti = folder->kind == StereoFolder::Kind::kKitti;
  if (kitti && is_there(path / "times.txt")) {
    const Status timed = read_frame_times(path / "times.txt", *folder);
    if (!timed) return forward(timed);
  }
  const auto size = find_image_size(*folder);
  if (!size) return forward(size);
  const auto rig_path = find_rig(path, *folder, options);
  if (!rig_path) return forward(rig_path);

  ColourCameras cameras;
  if (options.rig.empty() && folder->left_folder == "image_2") {
    auto read = read_colour_cameras(*rig_path, *size);
    if (!read) return forward(read);
    cameras = std::move(*read);
  } else {
    auto read = read_rig(*rig_path, *size);
    if (!read) return forward(read);
    cameras.rig = std::move(*read);
  }
  if (cameras.rig.size == ImageSize{}) cameras.rig.size = *size;
  if (kitti && !cameras.rig.mount) {
    cameras.rig.mount = level_mount(kKittiCameraHeight_m, 0.0, true);
  }

  std::vector<Error> problems;
  auto poses = internal::read_frame_poses(
      {path, options.poses, *folder, cameras.rig, cameras.T_0_2}, problems);
  if (!poses) return forward(poses);
  std::vector<ImuSample> imu;
  if (cameras.rig.imu) imu = find_imu_samples(path, *folder, problems);
  return std::make_unique<FolderSource>(std::move(*folder), std::move(cameras.rig),
                                        std::move(*poses), std::move(imu), std::move(problems),
                                        options.images);
}

}  // namespace tread
