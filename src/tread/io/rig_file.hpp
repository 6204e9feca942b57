// Calibration files of a stereo rig: our YAML, and as they are: OpenCV stereo calibration, KITTI
// calib.txt, EuRoC sensor.yaml pairs, Kalibr camchain, ROS camera_info YAML pairs.
#pragma once

#include <filesystem>
#include <string>

#include "tread/core/result.hpp"
#include "tread/geometry/stereo_rig.hpp"

namespace tread {

// Finds out what the file (or folder) is from its content. `path` is one of
//   our rig YAML (key "tread_rig: 1")      OpenCV YAML/XML with M1 D1 M2 D2 R T (or K1,
//   cameraMatrix1) KITTI calib.txt (P0 P1; with or without the names, or object/raw style P_rect)
//   Kalibr camchain YAML (cam0, cam1 with T_cn_cnm1)
//   a folder with cam0/sensor.yaml and cam1/sensor.yaml (EuRoC/ASL; also its mav0 parent)
//   a folder with left.yaml and right.yaml (ROS camera_info), or "left.yaml,right.yaml"
//   the name of a known rig ("bumblebee2-640")
// `size` is used for formats that do not store an image size (KITTI); {0, 0} if not known.
[[nodiscard]] Result<StereoRig> read_rig(const std::string& path, ImageSize size = {});

// Our own format; what read_rig reads back is equal.
[[nodiscard]] Status write_rig(const std::filesystem::path& path, const StereoRig& rig);

}  // namespace tread
