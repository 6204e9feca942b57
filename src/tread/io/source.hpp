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

namespace tread {

// Yields frames in order of time. Not to be shared by two threads.
class StereoSource {
 public:
  StereoSource() = default;
  virtual ~StereoSource() = default;
  StereoSource(const StereoSource&) = delete;
  StereoSource& operator=(const StereoSource&) = delete;

  [[nodiscard]] virtual const StereoRig& rig() const = 0;
  [[nodiscard]] virtual int frame_count() const = 0;
  [[nodiscard]] virtual bool has_poses() const = 0;
  // What it is: "KITTI odometry folder".
  [[nodiscard]] virtual std::string kind() const = 0;
  // The next frame; empty after the last. After an error the next call goes on with the frame
  // behind the bad one.
  [[nodiscard]] virtual Result<std::optional<StereoFrame>> next() = 0;
};

struct SourceOptions {
  std::string rig;    // rig file or name, see read_rig; empty: what the folder brings
  std::string poses;  // trajectory file (TUM, or KITTI); empty: what the folder brings
};

// `path` is one of
//   a KITTI odometry sequence: image_0 image_1 (or image_2 image_3, image_l image_r), calib.txt,
//     times.txt if there (else 10 Hz), poses.txt if there (also ../../poses/NN.txt). Poses map the
//     left camera into the first left camera; the world is x forward, y left, z up below it. The
//     published mount height of KITTI, 1.65 m, level, is used unless the rig file brings one.
//   a folder of left/right images with a rig file: left/ and right/ (or cam0/data, cam1/data;
//     image_left, image_right), or NAME_left.png beside NAME_right.png; rig.yaml in it or
//     options.rig. File stems that are whole numbers of 16 or more digits are stamps in
//     nanoseconds; otherwise frames are numbered at 10 Hz.
// TUM poses are matched by time (see pose_at), KITTI poses by frame number.
[[nodiscard]] Result<std::unique_ptr<StereoSource>> open_stereo_source(
    const std::filesystem::path& path, const SourceOptions& options = {});

}  // namespace tread
