// Rows of depth images, vectorised. Beyond the border lies nothing: NaN.
#pragma once

#include "tread/slam/depth_level.hpp"

namespace tread {

// Surfaces up to this steep (tangent of the angle to the image plane) are smoothed as one.
inline constexpr float kSmoothSlope = 1.5F;

// Row y of the half image. Single precision throughout, as the noise model.
void halve_depth_row(ImageView<const float> depth, const DepthNoise& noise, int y, float* half);
void smooth_depth_row(ImageView<const float> depth, const DepthNoise& noise, float focal_px,
                      int spacing, int y, float* smooth);
// NaN at creases: where the depth bends by more than its noise and this part of the distance of
// neighbours. What is found there is how the pixels happen to fall on the edge.
inline constexpr float kLargestBend = 0.25F;
void normal_row(const Pinhole& camera, const DepthNoise& noise, ImageView<const float> depth, int y,
                float* nx, float* ny, float* nz);

}  // namespace tread
