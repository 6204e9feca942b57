// Block matching as its definition says, in plain C++: what the vectorised kernel must equal bit
// for bit, and what takes the windows whose sums are too large for it.
#pragma once

#include <algorithm>

#include "tread/stereo/sad_kernel.hpp"

namespace tread {

// Of a match of this cost; its slope is 0 or less where there is no minimum.
[[nodiscard]] inline std::uint8_t residual_of(int cost, int slope) {
  if (slope <= 0) return kLargestResidual;
  return static_cast<std::uint8_t>(std::min(cost * kResidualScale / slope, int{kLargestResidual}));
}

// Rows first to last - 1 of the output, which has the size of the images.
void match_rows_plain(const SadImages& images, const SadOptions& options, int first, int last,
                      const MatchOutput& out);

}  // namespace tread
