// Block matching as its definition says, in plain C++: what the vectorised kernel must equal bit
// for bit, and what takes the windows whose sums are too large for it.
#pragma once

#include <algorithm>

#include "tread/stereo/sad_kernel.hpp"

namespace tread {

// Of a match of this cost, with a slope above 0.
[[nodiscard]] inline std::uint8_t residual_of(int cost, int slope) {
  return static_cast<std::uint8_t>(std::min(cost * kResidualScale / slope, int{kNoResidual}));
}

// Rows first to last - 1 of the output, which has the size of the images.
void match_rows_plain(const SadImages& images, const SadOptions& options, int first, int last,
                      const MatchOutput& out);

}  // namespace tread
