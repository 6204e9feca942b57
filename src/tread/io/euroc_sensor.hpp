// Internal to io: sensor.yaml of EuRoC/ASL, as text.
#pragma once

#include <string>

#include "tread/geometry/stereo_rig.hpp"

namespace tread::internal {

// `where` names the camera in the error about a model that the format cannot express.
[[nodiscard]] Result<std::string> print_euroc_camera(const CameraModel& camera, ImageSize size,
                                                     const Isometry3d& T_body_camera,
                                                     double rate_hz, const std::string& where);
[[nodiscard]] std::string print_euroc_imu(const Imu& imu, const Isometry3d& T_body_imu);
[[nodiscard]] std::string print_euroc_gnss(const Eigen::Vector3d& p_body_antenna_m, double rate_hz);

}  // namespace tread::internal
