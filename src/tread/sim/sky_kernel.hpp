// Clouds, sixteen directions at a time, for every instruction set that the machine may have.
#pragma once

#include <cstdint>

namespace tread {

// How much cloud there is in directions of unit length, 0 to 1; 0 below the horizon. Rows of a
// whole number of sixteens.
void cloud_rows(const float* x, const float* y, const float* z, int count, std::uint32_t seed,
                float* cloud);

}  // namespace tread
