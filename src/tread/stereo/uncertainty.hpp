// How sure a match is, from the shape of its cost (StereoOptions::rate): the probability that it is
// right, and the standard deviation of its disparity if it is, so that a map can weigh its points.
//
// The cost of a right match is noise; noise of n moves the minimum of a V of slope s by about n /
// s. So both follow from one number, the residual c / (max(l, r) - c) of disparity.hpp. What
// follows was measured on the pairs of bench/stereo_accuracy, each set counting once:
// docs/stereo.md.
#pragma once

#include <cstdint>

#include "tread/stereo/depth.hpp"
#include "tread/stereo/stereo_matcher.hpp"

namespace tread {

struct MatchUncertainty {
  float confidence = 0.0F;  // share of such matches that are within 1 px of the truth
  float sigma_px = 0.0F;    // root mean square error of those
};
// Of a match with default checks; fewer checks let more wrong ones through.
[[nodiscard]] MatchUncertainty match_uncertainty(StereoMethod method, std::uint8_t residual);

// The standard deviation along the optical axis, metres, of each point of the cloud that
// depth_cloud makes of the same depth image: row by row where the depth is known. The residual must
// be of the same size (StereoOptions::rate). `sigma_m` keeps its memory.
void depth_sigmas(ImageView<const float> depth, ImageView<const std::uint8_t> residual,
                  const RectifiedRig& rig, StereoMethod method, std::vector<float>& sigma_m);

}  // namespace tread
