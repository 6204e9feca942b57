// The textures themselves, sixteen points at a time, for every instruction set that the machine may
// have.
#pragma once

#include <cstdint>

#include "tread/sim/texture.hpp"

namespace tread {

inline constexpr int kTextureBlock = 16;

// texture() for surfaces that have one and a contrast above 0.
void texture_rows(Surface surface, float contrast, std::uint32_t seed, const TextureRows& rows);

}  // namespace tread
