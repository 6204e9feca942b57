// Semi-global matching as its definition says, in plain C++: what the vectorised kernel must equal
// bit for bit, and what machines without vectors use.
#pragma once

#include "tread/stereo/sgm_kernel.hpp"

namespace tread {

// As sgm_census_row.
void census_row_plain(ImageView<const std::uint8_t> image, int y, Image<std::uint8_t>& census);
void match_sgm_plain(const SgmImages& images, const SgmOptions& options, const MatchOutput& out);

}  // namespace tread
