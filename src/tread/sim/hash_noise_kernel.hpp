// Noise for textures and ground, by hashing the corners of a lattice: no tables and no state, so
// that a place has one value on every machine, in every order and in any number of threads.
//
// Every function is a few branch-free lines over plain values, which compilers turn into vector
// code where it is called in a loop, and which a GPU could run as it is. Lattices have unit
// spacing; coordinates must stay within 2^31. Value noise: Perlin and Hoffert 1989; gradient noise:
// Perlin 2002 (fade of degree five); cellular: Worley 1996. Some 3 ns in 2D without vectors.
#pragma once

#include <cstdint>

namespace tread {

// Mixes all bits (two multiplications, as in Wellons' search for hashes of low bias).
[[nodiscard, gnu::always_inline]] constexpr std::uint32_t hash_mix(std::uint32_t h) {
  h ^= h >> 16;
  h *= 0x7FEB352DU;
  h ^= h >> 15;
  h *= 0x846CA68BU;
  return h ^ (h >> 16);
}

// Each axis steps by a large odd number, so that near lattice points differ in many bits.
inline constexpr std::uint32_t kHashStepX = 0x9E3779B1U, kHashStepY = 0x85EBCA77U,
                               kHashStepZ = 0xC2B2AE3DU;

[[nodiscard, gnu::always_inline]] constexpr std::uint32_t hash_lattice(std::int32_t x,
                                                                       std::int32_t y,
                                                                       std::uint32_t seed) {
  return hash_mix(static_cast<std::uint32_t>(x) * kHashStepX ^
                  static_cast<std::uint32_t>(y) * kHashStepY ^ seed);
}
[[nodiscard, gnu::always_inline]] constexpr std::uint32_t hash_lattice(std::int32_t x,
                                                                       std::int32_t y,
                                                                       std::int32_t z,
                                                                       std::uint32_t seed) {
  return hash_mix(static_cast<std::uint32_t>(x) * kHashStepX ^
                  static_cast<std::uint32_t>(y) * kHashStepY ^
                  static_cast<std::uint32_t>(z) * kHashStepZ ^ seed);
}

// hash_lattice() of points beside (x, y), with one multiplication an axis instead of one a point.
struct LatticeSteps {
  std::uint32_t x = 0, y = 0, seed = 0;
  [[gnu::always_inline]] constexpr LatticeSteps(std::int32_t ix, std::int32_t iy,
                                                std::uint32_t of_seed)
      : x(static_cast<std::uint32_t>(ix) * kHashStepX),
        y(static_cast<std::uint32_t>(iy) * kHashStepY),
        seed(of_seed) {}
  [[nodiscard, gnu::always_inline]] constexpr std::uint32_t at(std::uint32_t dx,
                                                               std::uint32_t dy) const {
    return hash_mix((x + dx * kHashStepX) ^ (y + dy * kHashStepY) ^ seed);
  }
};

// A hash as a number from -1 to 1, and from 0 to 1 (24 bits: what a float holds).
[[nodiscard, gnu::always_inline]] constexpr float signed_unit(std::uint32_t h) {
  return static_cast<float>(static_cast<std::int32_t>(h) >> 8) * (1.0F / 8388608.0F);
}
[[nodiscard, gnu::always_inline]] constexpr float unit(std::uint32_t h) {
  return static_cast<float>(static_cast<std::int32_t>(h >> 8)) * (1.0F / 16777216.0F);
}

// std::floor as a whole number, without a call or a branch.
[[nodiscard, gnu::always_inline]] constexpr std::int32_t lattice_floor(float x) {
  const auto i = static_cast<std::int32_t>(x);
  return i - static_cast<std::int32_t>(x < static_cast<float>(i));
}

[[nodiscard, gnu::always_inline]] constexpr float mix(float a, float b, float share) {
  return a + share * (b - a);
}
[[nodiscard, gnu::always_inline]] constexpr float magnitude(float x) {
  return x < 0.0F ? -x : x;
}
// Cut to 0 to 1, to 1e-7; by magnitudes, since two comparisons in a row are a branch to compilers.
[[nodiscard, gnu::always_inline]] constexpr float clamped(float x) {
  return 0.5F * (magnitude(x) - magnitude(x - 1.0F) + 1.0F);
}
[[nodiscard, gnu::always_inline]] constexpr float larger_of(float a, float b) {
  return 0.5F * (a + b + magnitude(a - b));
}
// 0 below `low`, 1 above `high`, without a corner between.
[[nodiscard, gnu::always_inline]] constexpr float smooth_step(float low, float high, float x) {
  const float t = clamped((x - low) / (high - low));
  return t * t * (3.0F - 2.0F * t);
}
[[nodiscard, gnu::always_inline]] constexpr float fade(float t) {
  return t * t * t * (t * (t * 6.0F - 15.0F) + 10.0F);
}

// From -1 to 1; standard deviation 0.455 in 2D and 0.40 in 3D.
[[nodiscard, gnu::always_inline]] constexpr float value_noise(float x, float y,
                                                              std::uint32_t seed) {
  const std::int32_t ix = lattice_floor(x), iy = lattice_floor(y);
  const float fx = fade(x - static_cast<float>(ix)), fy = fade(y - static_cast<float>(iy));
  const float low =
      mix(signed_unit(hash_lattice(ix, iy, seed)), signed_unit(hash_lattice(ix + 1, iy, seed)), fx);
  const float high = mix(signed_unit(hash_lattice(ix, iy + 1, seed)),
                         signed_unit(hash_lattice(ix + 1, iy + 1, seed)), fx);
  return mix(low, high, fy);
}
[[nodiscard, gnu::always_inline]] constexpr float value_noise(float x, float y, float z,
                                                              std::uint32_t seed) {
  const std::int32_t iz = lattice_floor(z);
  const std::uint32_t below = static_cast<std::uint32_t>(iz) * kHashStepZ;
  return mix(value_noise(x, y, seed ^ below), value_noise(x, y, seed ^ (below + kHashStepZ)),
             fade(z - static_cast<float>(iz)));
}

// A plane through a lattice point, whose slopes are the halves of its hash.
[[nodiscard, gnu::always_inline]] constexpr float slope_at(std::uint32_t h, float dx, float dy) {
  const float gx = static_cast<float>(static_cast<std::int32_t>(h << 16) >> 16);
  const float gy = static_cast<float>(static_cast<std::int32_t>(h) >> 16);
  return (gx * dx + gy * dy) * (1.0F / 32768.0F);
}
[[nodiscard, gnu::always_inline]] constexpr float slope_at(std::uint32_t h, float dx, float dy,
                                                           float dz) {
  const float gx = static_cast<float>(static_cast<std::int32_t>(h << 22) >> 22);
  const float gy = static_cast<float>(static_cast<std::int32_t>(h << 12) >> 22);
  const float gz = static_cast<float>(static_cast<std::int32_t>(h) >> 22);
  return (gx * dx + gy * dy + gz * dz) * (1.0F / 512.0F);
}

// 0 at lattice points, within -1.5 and 1.5 between them; standard deviation 0.175 in 2D and 0.19 in
// 3D. Less of it changes slowly over many squares than of value noise: an octave is an octave.
[[nodiscard, gnu::always_inline]] constexpr float gradient_noise(float x, float y,
                                                                 std::uint32_t seed) {
  const std::int32_t ix = lattice_floor(x), iy = lattice_floor(y);
  const float dx = x - static_cast<float>(ix), dy = y - static_cast<float>(iy);
  const float fx = fade(dx);
  const LatticeSteps h(ix, iy, seed);
  const float low = mix(slope_at(h.at(0, 0), dx, dy), slope_at(h.at(1, 0), dx - 1.0F, dy), fx);
  const float high =
      mix(slope_at(h.at(0, 1), dx, dy - 1.0F), slope_at(h.at(1, 1), dx - 1.0F, dy - 1.0F), fx);
  return mix(low, high, fade(dy));
}
[[nodiscard, gnu::always_inline]] constexpr float gradient_noise(float x, float y, float z,
                                                                 std::uint32_t seed) {
  const std::int32_t ix = lattice_floor(x), iy = lattice_floor(y), iz = lattice_floor(z);
  const float dx = x - static_cast<float>(ix), dy = y - static_cast<float>(iy),
              dz = z - static_cast<float>(iz);
  const float fx = fade(dx), fy = fade(dy);
  const std::uint32_t below = static_cast<std::uint32_t>(iz) * kHashStepZ;
  float layer[2] = {0.0F, 0.0F};
  for (std::uint32_t k = 0; k < 2; ++k) {
    const float ez = dz - static_cast<float>(k);
    const LatticeSteps h(ix, iy, seed ^ (below + k * kHashStepZ));
    const float low =
        mix(slope_at(h.at(0, 0), dx, dy, ez), slope_at(h.at(1, 0), dx - 1.0F, dy, ez), fx);
    const float high = mix(slope_at(h.at(0, 1), dx, dy - 1.0F, ez),
                           slope_at(h.at(1, 1), dx - 1.0F, dy - 1.0F, ez), fx);
    layer[k] = mix(low, high, fy);
  }
  return mix(layer[0], layer[1], fade(dz));
}

// Octaves of gradient noise, each of twice the frequency and `gain` times the height of the last.
[[nodiscard, gnu::always_inline]] constexpr float fbm(float x, float y, int octaves, float gain,
                                                      std::uint32_t seed) {
  float sum = 0.0F, height = 1.0F;
  for (int i = 0; i < octaves; ++i, x *= 2.0F, y *= 2.0F, height *= gain) {
    sum += height * gradient_noise(x, y, seed + static_cast<std::uint32_t>(i) * kHashStepZ);
  }
  return sum;
}
[[nodiscard, gnu::always_inline]] constexpr float fbm(float x, float y, float z, int octaves,
                                                      float gain, std::uint32_t seed) {
  float sum = 0.0F, height = 1.0F;
  for (int i = 0; i < octaves; ++i, x *= 2.0F, y *= 2.0F, z *= 2.0F, height *= gain) {
    sum += height * gradient_noise(x, y, z, seed + static_cast<std::uint32_t>(i) * kHashStepZ);
  }
  return sum;
}

// The stone at a place: one a lattice square, at a random place in it.
struct Cellular {
  float dx = 0.0F, dy = 0.0F;  // from the middle of the nearest stone to the place
  float nearest = 0.0F;        // squared distance to it
  float second = 0.0F;         // and to the next
  std::uint32_t stone = 0;     // hash of the nearest
};
// The stone of hash h in the square (i, j) from that of the place, which lies at (fx, fy) in it.
[[gnu::always_inline]] constexpr void see_stone(Cellular& found, std::uint32_t h, float i, float j,
                                                float fx, float fy) {
  const auto jitter_x = static_cast<float>(static_cast<std::int32_t>(h & 0xFFFFU)),
             jitter_y = static_cast<float>(static_cast<std::int32_t>(h >> 16));
  const float dx = fx - i - jitter_x * (1.0F / 65536.0F),
              dy = fy - j - jitter_y * (1.0F / 65536.0F);
  const float d = dx * dx + dy * dy;
  const bool nearer = d < found.nearest;
  const float other = nearer ? found.nearest : d;
  found.second = other < found.second ? other : found.second;
  found.dx = nearer ? dx : found.dx;
  found.dy = nearer ? dy : found.dy;
  found.stone = nearer ? h : found.stone;
  found.nearest = nearer ? d : found.nearest;
}
[[nodiscard, gnu::always_inline]] constexpr Cellular cellular(float x, float y,
                                                              std::uint32_t seed) {
  const std::int32_t ix = lattice_floor(x), iy = lattice_floor(y);
  const float fx = x - static_cast<float>(ix), fy = y - static_cast<float>(iy);
  const LatticeSteps h(ix - 1, iy - 1, seed);
  Cellular found;
  found.nearest = found.second = 8.0F;
  // Written out: compilers make no vectors of loops within loops.
  see_stone(found, h.at(0, 0), -1.0F, -1.0F, fx, fy);
  see_stone(found, h.at(1, 0), 0.0F, -1.0F, fx, fy);
  see_stone(found, h.at(2, 0), 1.0F, -1.0F, fx, fy);
  see_stone(found, h.at(0, 1), -1.0F, 0.0F, fx, fy);
  see_stone(found, h.at(1, 1), 0.0F, 0.0F, fx, fy);
  see_stone(found, h.at(2, 1), 1.0F, 0.0F, fx, fy);
  see_stone(found, h.at(0, 2), -1.0F, 1.0F, fx, fy);
  see_stone(found, h.at(1, 2), 0.0F, 1.0F, fx, fy);
  see_stone(found, h.at(2, 2), 1.0F, 1.0F, fx, fy);
  return found;
}

}  // namespace tread
