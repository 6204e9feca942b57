// Sources of stereo frames on disk. What a folder is, is found out from what is in it.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "tread/core/result.hpp"
#include "tread/geometry/samples.hpp"
#include "tread/geometry/stereo_rig.hpp"
#include "tread/geometry/trajectory.hpp"
#include "tread/io/image_file.hpp"

namespace tread {

// Yields frames in order of time. Not to be shared by two threads.
class StereoSource {
 public:
  StereoSource() = default;
  virtual ~StereoSource() = default;
  StereoSource(const StereoSource&) = delete;
  StereoSource& operator=(const StereoSource&) = delete;

  [[nodiscard]] virtual const StereoRig& rig() const = 0;
  // Frames that next() will try to read, also those that will turn out to be bad.
  [[nodiscard]] virtual int frame_count() const = 0;
  [[nodiscard]] virtual bool has_poses() const = 0;
  // Frames come with the samples of an IMU, and the rig knows where it sits.
  [[nodiscard]] virtual bool has_imu() const = 0;
  // What was found wrong on opening and could be left out: lines of the trajectory or of the IMU.
  [[nodiscard]] virtual const std::vector<Error>& problems() const = 0;
  // What it is: "KITTI odometry folder".
  [[nodiscard]] virtual std::string kind() const = 0;
  // The next frame; empty after the last. An error names the file: an image that is missing, cannot
  // be read, or has another size than the rig (than most images where the calibration names none).
  // The next call goes on with the frame behind it, which then has the samples of both.
  [[nodiscard]] virtual Result<std::optional<StereoFrame>> next() = 0;
};

struct SourceOptions {
  std::string rig;    // rig file or name, see read_rig; empty: what the folder brings
  std::string poses;  // trajectory file (TUM, or KITTI); empty: what the folder brings
  ImageReading images = {};
};

// `path` is one of
//   a KITTI odometry sequence: image_0 image_1 (or image_2 image_3, image_l image_r), calib.txt,
//     times.txt if there (else 10 Hz), poses.txt if there (also ../../poses/NN.txt). The published
//     mount height of KITTI, 1.65 m, level, is used unless the rig file brings one; image_2 and
//     image_3 take P2 and P3 of calib.txt.
//   a folder of left/right images with a rig file: left/ and right/ (or image_left and
//     image_right; cam0/data and cam1/data, also in mav0/), or NAME_left.png beside NAME_right.png;
//     rig.yaml in it, or what else read_rig finds in the folder, or options.rig; poses.txt if
//     there. File stems that are whole numbers of 16 or more digits are stamps in nanoseconds;
//     otherwise frames are numbered at 10 Hz.
//     EuRoC/ASL folders: also imu0/data.csv (read_imu), if the rig has an IMU, and
//     state_groundtruth_estimate0/data.csv (read_euroc_poses), both also in mav0/.
// Frames are in order of their numbers if all stems are numbers, else of their names, and are
// paired by name; a stem that is a number below 16 digits is the number of the frame.
//
// Poses of KITTI (12 numbers a line) are matched by frame number, map the left camera into the
// first left one, and are turned into a world with x forward, y left, z up whose origin is on the
// ground below the first camera: T_world_left = T_body_left(mount) T_first_left. Without a mount
// (only in the second kind of folder) that origin is in the first camera. Poses in TUM format (8
// numbers a line) are matched by time (see pose_at) and taken as T_world_left as they are. A frame
// that has none has no T_world_left; so one whose line cannot be read, which is among problems().
// The truth of EuRoC is that of the body, T_world_left = T_world_body T_body_left, found by time;
// T_body_left is T_imu_left of the rig (times T_BS of imu0/sensor.yaml, if there), else T_BS of
// cam0/sensor.yaml.
[[nodiscard]] Result<std::unique_ptr<StereoSource>> open_stereo_source(
    const std::filesystem::path& path, const SourceOptions& options = {});

}  // namespace tread
