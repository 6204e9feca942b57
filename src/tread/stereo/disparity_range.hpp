// How large the disparities of a scene are, from one pair: so that a user need not know.
#pragma once

#include "tread/stereo/stereo_matcher.hpp"

namespace tread {

// The number of disparities to search from options.sad.min_disparity_px on: matches the pair at a
// quarter of its size over half its width, takes the disparity that one in two hundred matches
// exceeds, adds a quarter, and rounds up to 16. At least 64; 64 also where hardly anything matches;
// never more than fit the image. Errors: as StereoMatcher's. Timed as one stage, "stereo/range".
// Cost: a sixty-fourth of a match at full size over the same range.
[[nodiscard]] Result<int> estimate_num_disparities(ImageView<const std::uint8_t> left,
                                                   ImageView<const std::uint8_t> right,
                                                   const StereoOptions& options,
                                                   const Context& context = {});

}  // namespace tread
