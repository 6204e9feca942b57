// The camera of depth images: a pinhole without distortion, and files that hold one.
#pragma once

#include <filesystem>

#include "tread/core/result.hpp"
#include "tread/geometry/camera.hpp"

namespace tread {

struct RgbdCamera {
  PinholeCamera pinhole;  // pixels
  ImageSize size;         // of the depth images; {0, 0} where not known
};

// The file is one of
//   four numbers, fx fy cx cy
//   nine numbers, [fx s cx; 0 fy cy; 0 0 1], in any number of lines (3DMatch camera-intrinsics.txt)
//   YAML with fx, fy, cx, cy and perhaps width and height
//   ROS camera_info YAML (camera_matrix; of distortion_coefficients all must be zero)
//   a rig file of this program (see rig_file.hpp), of which the left camera is taken
// Errors name file, line, field and remedy. A lens with distortion is refused: depth images are
// not undistorted here.
[[nodiscard]] Result<RgbdCamera> read_rgbd_camera(const std::filesystem::path& path);

}  // namespace tread
