// The textures themselves, sixteen points at a time, for every instruction set that the machine may
// have.
#pragma once

#include <cstdint>

#include "tread/sim/texture.hpp"

namespace tread {

inline constexpr int kTextureBlock = 16;

// texture() for surfaces that have one and a contrast above 0.
void texture_rows(Surface surface, float contrast, std::uint32_t seed, const TextureRows& rows);

// How much cloud there is in directions of unit length above the horizon, 0 to 1; 0 below it.
// Rows of a whole number of sixteens.
void cloud_rows(const float* x, const float* y, const float* z, int count, std::uint32_t seed,
                float* cloud);

}  // namespace tread
