// Sources of RGB-D frames on disk: depth images, with or without colour and reference poses. What a
// folder is, is found out from what is in it.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tread/core/result.hpp"
#include "tread/geometry/samples.hpp"
#include "tread/geometry/trajectory.hpp"
#include "tread/io/rgbd_camera.hpp"
#include "tread/io/rgbd_folder.hpp"

namespace tread {

// Yields frames in order of time, strictly increasing. Not to be shared by two threads.
class RgbdSource {
 public:
  RgbdSource() = default;
  virtual ~RgbdSource() = default;
  RgbdSource(const RgbdSource&) = delete;
  RgbdSource& operator=(const RgbdSource&) = delete;

  // Of the depth images; its size is known.
  [[nodiscard]] virtual const RgbdCamera& camera() const = 0;
  // Frames that next() will try to read, also those that will turn out to be bad.
  [[nodiscard]] virtual int frame_count() const = 0;
  // Whether truth() has any.
  [[nodiscard]] virtual bool has_poses() const = 0;
  // The reference, T_world_camera: all poses of the file that holds them (also between the frames
  // and beyond them), else those of the frames. Empty if there is none.
  [[nodiscard]] virtual const Trajectory& truth() const = 0;
  // What was found wrong and could be left out: lines of lists, poses; a camera that is assumed.
  // next() adds one entry, which then counts: colour images of another size than the depth images.
  [[nodiscard]] virtual const std::vector<Error>& problems() const = 0;
  // What it is: "TUM RGB-D folder".
  [[nodiscard]] virtual std::string kind() const = 0;
  // The next frame; empty after the last. An error names the file: an image, depth or colour, that
  // is missing or cannot be read, or depth of another size than the camera (than most images where
  // that names none). The next call goes on with the frame behind it.
  [[nodiscard]] virtual Result<std::optional<RgbdFrame>> next() = 0;
};

struct RgbdOptions {
  std::filesystem::path camera;  // see read_rgbd_camera; empty: what the folder brings
  double depth_per_metre = 0.0;  // units of the depth images; 0: what the layout has
  std::filesystem::path poses;   // TUM trajectory; empty: what the folder brings
};

// `path` is one of
//   a folder of frame-NNNNNN.depth.png (7-Scenes, 3DMatch; also the folder of a scene with one
//     seq-NN in it): 16-bit PNG, millimetres, 0 and 65535 unknown. Optional for each are
//     .color.png or .color.jpg, and .pose.txt, a 4x4 matrix, T_world_camera. 30 Hz, frame 0 at
//     0 s. Camera: camera.yaml or camera-intrinsics.txt there, the latter also in the folder above;
//     else that of 7-Scenes.
//   a folder of TUM RGB-D: depth.txt and perhaps rgb.txt ("time file" a line), 5000 units per
//     metre, 0 unknown. Each depth image goes with the colour image nearest in time within 20 ms;
//     or, if there is an associations.txt (assoc*.txt), the frames are its lines ("time file time
//     file", in either order). Optional is groundtruth.txt. Camera: as above (not from the folder
//     above); else the published one of freiburg1, 2 or 3 by the folder's name (also fr1, fr2,
//     fr3), without its distortion; else ROS's default for a Kinect, 525.
//   seq.txt, or a folder with it: "K fx fy cx cy depth_scale width height", then lines of
//     "t depth_file colour_file tx ty tz qx qy qz qw"; files are named from its folder, colour_file
//     may be -, and the pose may be left out. 0 and 65535 are unknown.
// A folder that is several of them is the first. An options.camera comes before all others. A
// camera that nobody gave is only assumed for images of 640x480, and is among problems().
//
// Poses are T_world_camera, optical axes of the depth camera into the world of the data, as they
// are: which way is up there, they do not say. Poses that come with times (groundtruth.txt,
// options.poses) are interpolated, see pose_at; a frame outside their span, or in a gap of more
// than 0.1 s (1 s with options.poses), has none.
[[nodiscard]] Result<std::unique_ptr<RgbdSource>> open_rgbd_source(
    const std::filesystem::path& path, const RgbdOptions& options = {});

}  // namespace tread
