// An image and its slopes at one resolution, for direct alignment.
#pragma once

#include <array>

#include "tread/core/image.hpp"
#include "tread/core/timer.hpp"
#include "tread/slam/align_kernel.hpp"
#include "tread/slam/depth_level.hpp"

namespace tread {

// Noise of deviation one in the intensity makes slopes of this deviation.
inline constexpr double kSlopeNoise = 0.433;

struct GreyLevel {
  Image<float> intensity;  // 0 to 255
  Image<float> gx, gy;     // Sobel, grey values a pixel; zero at the border
};

// The first level is the image at half its resolution (`halved`) or as it is; each following one
// has half the size of the one before, as build_pyramid's.
void build_grey_pyramid(ImageView<const std::uint8_t> grey, bool halved,
                        std::array<GreyLevel, 3>& levels, const Context& context = {});

[[nodiscard]] GreyLevel with_slopes(const Image<float>& intensity);
// The level that would follow.
[[nodiscard]] GreyLevel halved(const GreyLevel& level);

// Grey noise of an image, one standard deviation: from second differences, whose median does not
// see edges (after Immerkaer 1996).
[[nodiscard]] double grey_noise(const Image<float>& intensity);

// The pixels of a level with a depth and a slope of at least `least_slope`; if these are more than
// `most`, those with the steepest slopes.
void choose_photo_points(const GreyLevel& grey, const DepthLevel& depth, double least_slope,
                         int most, PhotoPoints& points);

}  // namespace tread
