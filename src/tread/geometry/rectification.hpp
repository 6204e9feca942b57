// Rectification: turns the images of two calibrated cameras so that rows correspond.
// Method: both cameras are rotated about their centres until their x axes lie along the baseline
// and their z axes are parallel to the mean viewing direction made perpendicular to it (Fusiello,
// Trucco, Verri 2000). Any CameraModel; bilinear sampling from tables made once.
#pragma once

#include <cstdint>

#include "tread/core/image.hpp"
#include "tread/core/timer.hpp"
#include "tread/geometry/stereo_rig.hpp"

namespace tread {

struct RectificationOptions {
  double focal_scale = 1.0;  // focal length of the result / mean focal length of the inputs
};

// For each pixel of the rectified image the place in the original, in 1/32 pixel; kOutside where
// the original has nothing.
struct RemapTable {
  static constexpr int kFractionBits = 5;
  static constexpr std::int32_t kOutside = INT32_MIN;
  struct Entry {
    std::int32_t u = kOutside;
    std::int32_t v = kOutside;
  };
  Image<Entry> entries;
};

struct Rectification {
  RectifiedRig rig;
  Eigen::Matrix3d R_rectified_left = Eigen::Matrix3d::Identity();  // left optical axes turned
  Eigen::Matrix3d R_rectified_right = Eigen::Matrix3d::Identity();
  RemapTable left;
  RemapTable right;
};

// Fails if the rig is not sound or its baseline runs along the viewing direction.
[[nodiscard]] Result<Rectification> make_rectification(const StereoRig& rig,
                                                       const RectificationOptions& options = {});

// Samples `input` by the table; pixels the original does not have become 0. The input must have
// the size the table was made for.
void remap(ImageView<const std::uint8_t> input, const RemapTable& table,
           ImageView<std::uint8_t> output, const Context& context = {});
void remap(ImageView<const Rgb> input, const RemapTable& table, ImageView<Rgb> output,
           const Context& context = {});

}  // namespace tread
