// Internal to io: one reader a format of rig file, behind read_rig(), and what they share.
#pragma once

#include <string>
#include <vector>

#include "tread/geometry/stereo_rig.hpp"
#include "tread/io/text_tree.hpp"

namespace tread::internal {

// A parsed file and what messages call it.
struct RigDocument {
  std::string file;
  TextNode root;
  [[nodiscard]] Field field() const { return Field(root, file); }
};

[[nodiscard]] Result<StereoRig> read_own_rig(const Field& root);
[[nodiscard]] Result<StereoRig> read_kalibr_rig(const Field& root);
[[nodiscard]] Result<StereoRig> read_euroc_rig(const Field& left, const Field& right);
// T_BS of a sensor.yaml: the sensor's axes into those of the body.
[[nodiscard]] Result<Isometry3d> read_euroc_place(const Field& sensor);
// Of imu0/sensor.yaml, and where the left camera sits in the body.
[[nodiscard]] Result<Imu> read_euroc_imu(const Field& imu, const Isometry3d& T_body_left);
[[nodiscard]] Result<StereoRig> read_camera_info_rig(const Field& left, const Field& right);
// One file with everything, or intrinsics and extrinsics apart (the same file twice otherwise).
[[nodiscard]] Result<StereoRig> read_opencv_rig(const Field& intrinsics, const Field& extrinsics,
                                                ImageSize size);
[[nodiscard]] Result<StereoRig> read_kitti_rig(const std::string& text, const std::string& file,
                                               ImageSize size);

[[nodiscard]] bool is_own(const Field& root);
[[nodiscard]] bool is_kalibr(const Field& root);
[[nodiscard]] bool is_euroc_sensor(const Field& root);
[[nodiscard]] bool is_camera_info(const Field& root);
[[nodiscard]] bool is_opencv_intrinsics(const Field& root);
[[nodiscard]] bool is_kitti(const std::string& text);

enum class Distortion { kBrown, kEquidistant };

// Of the names that ROS, Kalibr and EuRoC use. `field` holds the name.
[[nodiscard]] Result<Distortion> distortion_of_name(const Field& field);
// Brown: 0, 4, 5, 8, 12 or 14 coefficients in OpenCV's order (the thin prism and tilt terms, from
// the ninth on, must be zero); a pinhole camera if all are zero. Equidistant: 4.
[[nodiscard]] Result<CameraModel> make_camera(const PinholeCamera& pinhole, Distortion distortion,
                                              const std::vector<double>& coefficients,
                                              const Field& where);
// The pinhole of [fx s cx; 0 fy cy; 0 0 1].
[[nodiscard]] Result<PinholeCamera> read_pinhole_matrix(const Field& field);
// [width, height]
[[nodiscard]] Result<ImageSize> read_size(const Field& field);
[[nodiscard]] Result<Eigen::Matrix3d> read_rotation(const Field& field);
// A 4x4 matrix [R t; 0 0 0 1].
[[nodiscard]] Result<Isometry3d> read_transform(const Field& field);
// check_rig, and of a rig that comes rectified rectified_rig.
[[nodiscard]] Status check_whole_rig(const StereoRig& rig);
// Both cameras of a pair must have images of one size.
[[nodiscard]] Status check_same_size(const ImageSize& left, const ImageSize& right,
                                     const Field& where);

}  // namespace tread::internal
