// Depth images and point clouds from disparity: Z = b f / D, X = u Z / f, Y = v Z / f with (u, v)
// relative to the principal point, all of them pixels, b and Z metres (paper Q, Eq. 1).
#pragma once

#include "tread/core/options.hpp"
#include "tread/core/timer.hpp"
#include "tread/geometry/cloud.hpp"
#include "tread/geometry/stereo_rig.hpp"
#include "tread/stereo/disparity.hpp"
#include "tread/stereo/sad_matcher.hpp"

namespace tread {

struct DepthOptions {
  // Nearer and farther pixels are unknown; the defaults are paper Q's. Nearest below farthest.
  double min_depth_m = 0.8;
  double max_depth_m = 4.0;
};
[[nodiscard]] OptionSet describe(DepthOptions& options);

// Depth along the optical axis, metres, NaN where there is no match or outside the gate. `depth` is
// resized.
void depth_image(ImageView<const Disparity> disparity, const RectifiedRig& rig,
                 const DepthOptions& options, Image<float>& depth, const Context& context = {});

// One point for every pixel of known depth, row by row, in optical axes of the rectified left
// camera whichever image was the reference. `colour` is empty or of the size of the depth image.
// `cloud` keeps its memory.
void depth_cloud(ImageView<const float> depth, const RectifiedRig& rig, Reference reference,
                 ImageView<const Rgb> colour, PointCloud& cloud, const Context& context = {});

// Standard deviation of a depth whose disparity is uncertain by sigma_px (Eq. 2 with the step of
// the disparity where the paper prints the disparity).
[[nodiscard]] inline double depth_sigma_m(const RectifiedRig& rig, double depth_m,
                                          double sigma_px = 0.25) {
  return rig.depth_resolution_m(depth_m, sigma_px);
}

}  // namespace tread
