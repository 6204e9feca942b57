// Block matching as its definition says, in plain C++: what the vectorised kernel must equal bit
// for bit, and what takes the windows whose sums are too large for it.
#pragma once

#include "tread/stereo/sad_kernel.hpp"

namespace tread {

// Rows first to last - 1 of `disparity`, which has the size of the images.
void match_rows_plain(const SadImages& images, const SadOptions& options, int first, int last,
                      Image<Disparity>& disparity);

}  // namespace tread
