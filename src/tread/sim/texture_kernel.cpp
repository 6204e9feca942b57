#include "tread/sim/texture_kernel.hpp"

#include <algorithm>

#include "tread/sim/hash_noise_kernel.hpp"

// This file is compiled once for every instruction set; what is outside `#if HWY_ONCE` lies in a
// name space of that set. The loops over the points of a block are plain: compilers make vectors
// of them, and with Highway's pragmas those of the set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tread/sim/texture_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tread::HWY_NAMESPACE {
namespace {

constexpr int kN = kTextureBlock;
constexpr float kLeastPixelM = 1e-5F;  // nothing is finer
using Lanes = float[kN];

// Sixteen points and what has been summed up for them.
struct Block {
  alignas(64) Lanes u, v, w, sun_u, sun_v, sun_w;
  alignas(64) Lanes pixel;  // footprint
  alignas(64) Lanes sharp;  // 1 / (1.2 footprint)
  alignas(64) Lanes sum, hue, relief;
  float sharpest = 0.0F;  // of all: finer octaves none of them sees
  std::uint32_t seed = 0;
};

// A lattice step that is seen through a pixel: not at all below 1.2 pixels, in full from 2.4.
HWY_INLINE float seen(float step, float sharp) {
  return clamped(step * sharp - 1.0F);
}
HWY_INLINE float within(float x, float low, float high) {
  return low + (high - low) * clamped((x - low) / (high - low));
}
// Like a sine of period 1.
HWY_INLINE float wave(float x) {
  const float t = x - static_cast<float>(lattice_floor(x)) - 0.5F;
  return 16.0F * t * (magnitude(t) - 0.5F);
}

constexpr float kAhead = 0.3F;  // steps towards the sun, to see whether the surface rises

// Octaves of noise with steps from `coarse` down to `fine` metres.
struct Octaves {
  float coarse = 1.0F, fine = 0.002F;
  float height = 0.1F;  // of the coarsest
  float gain = 1.0F;    // from one to the next
  float relief = 0.0F;  // how much the sun makes of it
  std::uint32_t salt = 0;
  float stretch = 1.0F;  // along u in the plane, along w in space
};

HWY_INLINE void add_flat_step(Block& b, float fu, float fv, float height, std::uint32_t seed) {
  const float step = 1.0F / fv;
  for (int i = 0; i < kN; ++i) {
    b.sum[i] += seen(step, b.sharp[i]) * height * gradient_noise(b.u[i] * fu, b.v[i] * fv, seed);
  }
}
HWY_INLINE void add_flat_relief(Block& b, float fu, float fv, float height, float relief,
                                std::uint32_t seed) {
  const float step = 1.0F / fv;
  for (int i = 0; i < kN; ++i) {
    const float u = b.u[i] * fu, v = b.v[i] * fv, share = seen(step, b.sharp[i]) * height;
    const float here = gradient_noise(u, v, seed);
    const float there = gradient_noise(u + kAhead * b.sun_u[i], v + kAhead * b.sun_v[i], seed);
    b.sum[i] += share * here;
    b.relief[i] += share * relief * (here - there);
  }
}

void add_flat(Block& b, const Octaves& o) {
  float height = o.height;
  std::uint32_t seed = b.seed ^ hash_mix(o.salt);
  for (float step = o.coarse; step >= o.fine && seen(step, b.sharpest) > 0.0F;
       step *= 0.5F, height *= o.gain, seed += kHashStepZ) {
    const float fv = 1.0F / step, fu = fv / o.stretch;
    if (o.relief > 0.0F) {
      add_flat_relief(b, fu, fv, height, o.relief, seed);
    } else {
      add_flat_step(b, fu, fv, height, seed);
    }
  }
}

HWY_INLINE void add_solid_step(Block& b, float f, float fw, float height, std::uint32_t seed) {
  const float step = 1.0F / f;
  for (int i = 0; i < kN; ++i) {
    b.sum[i] +=
        seen(step, b.sharp[i]) * height * gradient_noise(b.u[i] * f, b.v[i] * f, b.w[i] * fw, seed);
  }
}
HWY_INLINE void add_solid_relief(Block& b, float f, float fw, float height, float relief,
                                 std::uint32_t seed) {
  const float step = 1.0F / f;
  for (int i = 0; i < kN; ++i) {
    const float u = b.u[i] * f, v = b.v[i] * f, w = b.w[i] * fw;
    const float share = seen(step, b.sharp[i]) * height;
    const float here = gradient_noise(u, v, w, seed);
    const float there = gradient_noise(u + kAhead * b.sun_u[i], v + kAhead * b.sun_v[i],
                                       w + kAhead * b.sun_w[i], seed);
    b.sum[i] += share * here;
    b.relief[i] += share * relief * (here - there);
  }
}

void add_solid(Block& b, const Octaves& o) {
  float height = o.height;
  std::uint32_t seed = b.seed ^ hash_mix(o.salt);
  for (float step = o.coarse; step >= o.fine && seen(step, b.sharpest) > 0.0F;
       step *= 0.5F, height *= o.gain, seed += kHashStepZ) {
    const float f = 1.0F / step, fw = f / o.stretch;
    if (o.relief > 0.0F) {
      add_solid_relief(b, f, fw, height, o.relief, seed);
    } else {
      add_solid_step(b, f, fw, height, seed);
    }
  }
}

// Noise of one step as hue.
void add_hue(Block& b, float step, float height, std::uint32_t salt) {
  const std::uint32_t seed = b.seed ^ hash_mix(salt);
  const float f = 1.0F / step;
  for (int i = 0; i < kN; ++i) {
    b.hue[i] +=
        height * seen(step, b.sharp[i]) * gradient_noise(b.u[i] * f, b.v[i] * f, b.w[i] * f, seed);
  }
}

// Clods: crumbs of several sizes with dark gaps between.
void soil(Block& b) {
  add_flat(b, {1.7F, 0.05F, 0.22F, 0.95F, 0.0F, 1});
  add_flat(b, {0.064F, 0.002F, 0.30F, 0.95F, 1.6F, 2});
  add_hue(b, 0.6F, 1.6F, 3);
  for (const float step : {0.045F, 0.016F}) {
    if (seen(step, b.sharpest) <= 0.0F) continue;
    for (int i = 0; i < kN; ++i) {
      const Cellular clod = cellular(b.u[i] / step, b.v[i] / step, b.seed + 77U);
      const float share = seen(step, b.sharp[i]);
      const float round = 0.55F - clod.nearest;  // a dome
      b.sum[i] += share * 0.35F * (round - 0.35F);
      b.relief[i] += share * 0.5F * (clod.dx * b.sun_u[i] + clod.dy * b.sun_v[i]);
    }
  }
}

// Stones of three sizes: the smaller lie in the gaps between the larger.
void gravel(Block& b) {
  Lanes tone, tilt, tint, cover;  // of what lies on top
  for (int i = 0; i < kN; ++i) tone[i] = tilt[i] = tint[i] = cover[i] = 0.0F;
  std::uint32_t seed = b.seed;
  for (const float step : {0.048F, 0.021F, 0.009F}) {
    seed += kHashStepZ;
    if (seen(step, b.sharpest) <= 0.0F) break;
    const float f = 1.0F / step;
    for (int i = 0; i < kN; ++i) {
      const Cellular stone = cellular(b.u[i] * f, b.v[i] * f, seed);
      const float share = seen(step, b.sharp[i]) * (1.0F - cover[i]);
      // Squared distances differ in proportion to how far the gap is.
      const float edge = smooth_step(0.02F, 0.16F + b.pixel[i] * f, stone.second - stone.nearest);
      const std::uint32_t h = hash_mix(stone.stone);
      const float there = edge * static_cast<float>(unit(h << 12) < 0.72F);
      const float dome = 0.25F - stone.nearest;
      tone[i] +=
          share * (there * (0.75F * signed_unit(h) + 0.5F * dome + 0.2F) - (1.0F - edge) * 0.30F);
      tilt[i] += share * there * 1.3F * (stone.dx * b.sun_u[i] + stone.dy * b.sun_v[i]);
      tint[i] += share * there * signed_unit(h * kHashStepX);
      cover[i] += share * there;
    }
  }
  for (int i = 0; i < kN; ++i) {
    b.sum[i] += 0.55F * tone[i];
    b.relief[i] += tilt[i];
    b.hue[i] += tint[i];
  }
  add_flat(b, {1.6F, 0.08F, 0.20F, 0.9F, 0.0F, 4});
  add_flat(b, {0.012F, 0.002F, 0.25F, 0.9F, 0.6F, 5});
}

// Ripples of the wind, and grains.
void sand(Block& b) {
  const std::uint32_t seed = b.seed;
  for (int i = 0; i < kN; ++i) {
    const float bend = 0.7F * fbm(b.u[i] * 1.4F, b.v[i] * 1.4F, 2, 0.5F, seed + 1U);
    const float along = (0.92F * b.u[i] + 0.39F * b.v[i]) * (1.0F / 0.11F) + 2.2F * bend +
                        0.8F * gradient_noise(b.u[i] * 5.0F, b.v[i] * 5.0F, seed + 2U);
    const float share = seen(0.055F, b.sharp[i]) *
                        (0.55F + gradient_noise(b.u[i] * 0.9F, b.v[i] * 0.9F, seed + 3U));
    const float here = wave(along),
                there = wave(along + 0.12F * (0.92F * b.sun_u[i] + 0.39F * b.sun_v[i]));
    b.sum[i] += 0.07F * share * here;
    b.relief[i] += 0.75F * share * (here - there);
  }
  add_flat(b, {1.4F, 0.012F, 0.19F, 0.97F, 0.8F, 6});
  add_flat(b, {0.008F, 0.002F, 0.26F, 1.0F, 0.7F, 7});
  add_hue(b, 0.5F, 1.5F, 8);
}

// Blades lie over each other in all directions; between them it is dark.
void grass(Block& b) {
  constexpr float kTurns[4][2] = {{1.0F, 0.0F}, {0.35F, 0.94F}, {-0.62F, 0.78F}, {0.87F, -0.5F}};
  constexpr float kThin = 0.007F, kWide = 0.022F;           // m
  constexpr float kTopOfWide = 0.187F, kTopOfAll = 0.250F;  // mean of the highest
  Lanes top;
  for (int i = 0; i < kN; ++i) top[i] = -0.4F;
  std::uint32_t seed = b.seed;
  for (int layer = 0; layer < 8; ++layer) {
    seed += kHashStepZ;
    const float width = layer < 4 ? kThin : kWide, length = 6.0F * width;
    if (seen(width, b.sharpest) <= 0.0F) continue;
    const float c = kTurns[layer % 4][0], s = kTurns[layer % 4][1];
    for (int i = 0; i < kN; ++i) {
      const float along = (c * b.u[i] + s * b.v[i]) / length;
      const float across = (c * b.v[i] - s * b.u[i]) / width;
      const float high = gradient_noise(along, across, seed);
      // Those that are too thin to be seen are not on top.
      const float share = layer < 4 ? seen(width, b.sharp[i]) : 1.0F;
      top[i] = larger_of(top[i], share * (high + 0.4F) - 0.4F);
    }
  }
  for (int i = 0; i < kN; ++i) {
    const float mean = kTopOfWide + seen(kThin, b.sharp[i]) * (kTopOfAll - kTopOfWide);
    const float over = seen(kWide, b.sharp[i]) * (top[i] - mean);
    b.sum[i] += 1.35F * over;
    b.hue[i] += 1.3F * over;
  }
  add_flat(b, {2.2F, 0.03F, 0.34F, 0.96F, 0.0F, 9});
  add_flat(b, {0.02F, 0.003F, 0.30F, 0.9F, 0.6F, 10});
  add_hue(b, 1.1F, 2.4F, 11);
  add_hue(b, 0.13F, 1.2F, 12);
}

// Stains, fine aggregate, and pores of air.
void concrete(Block& b) {
  add_solid(b, {1.6F, 0.03F, 0.20F, 0.97F, 0.0F, 13});
  add_solid(b, {0.02F, 0.002F, 0.21F, 0.92F, 0.4F, 14});
  add_hue(b, 0.8F, 2.0F, 15);
  constexpr float kStep = 0.035F;
  if (seen(0.5F * kStep, b.sharpest) <= 0.0F) return;
  for (int i = 0; i < kN; ++i) {
    const Cellular pore = cellular((b.u[i] + 0.31F * b.w[i]) / kStep,
                                   (b.v[i] + 0.73F * b.w[i]) / kStep, b.seed + 16U);
    const float size = unit(hash_mix(pore.stone));
    const float dark =
        1.0F - smooth_step(0.3F, 1.0F, pore.nearest / (0.012F * size * size + 1e-4F));
    b.sum[i] -= 0.45F * seen(0.5F * kStep, b.sharp[i]) * dark;
  }
}

// Boards 0.1 m wide, each with its own tone and grain, dark gaps between.
void planks(Block& b) {
  constexpr float kWidth = 0.1F, kGap = 0.004F;
  for (int i = 0; i < kN; ++i) {
    const float at = b.v[i] / kWidth + 0.5F;
    const std::int32_t board = lattice_floor(at);
    const float in = at - static_cast<float>(board) - 0.5F;  // -0.5 to 0.5
    const std::uint32_t h = hash_lattice(board, lattice_floor(b.w[i] + 100.5F), b.seed);
    // Where along the tree it was cut, and how far from its heart.
    const float u = b.u[i] + 37.0F * unit(h), v = b.v[i] + 0.3F * unit(h * kHashStepX);
    const float bend = gradient_noise(u * 1.1F, v * 9.0F, b.seed + 17U);
    const float rings = wave(v * 38.0F + 2.6F * bend);
    b.sum[i] += 0.30F * signed_unit(h) + 0.10F * seen(0.013F, b.sharp[i]) * rings;
    b.hue[i] += 0.8F * signed_unit(h * kHashStepY);
    // The gap, as much as the pixel sees of it.
    const float to_gap = kWidth * (0.5F - magnitude(in));
    const float blur = 0.5F * b.pixel[i] + 0.0005F;
    const float covered = clamped((to_gap + blur - 0.5F * kGap) / (2.0F * blur));
    b.sum[i] -= 0.75F * (1.0F - covered) * clamped(kGap / blur);
    b.relief[i] -= 0.5F * (1.0F - covered) * clamped(kGap / blur);
  }
  // Grain: streaks along the board.
  add_flat(b, {0.10F, 0.002F, 0.20F, 1.0F, 0.25F, 18, 11.0F});
  add_flat(b, {0.8F, 0.006F, 0.19F, 0.95F, 0.0F, 19, 2.5F});
}

// Layers, cracks and lichen.
void rock(Block& b) {
  add_solid(b, {1.3F, 0.04F, 0.26F, 0.95F, 0.9F, 20});
  add_solid(b, {0.03F, 0.002F, 0.22F, 0.95F, 1.2F, 21});
  add_hue(b, 0.35F, 2.2F, 22);
  const std::uint32_t seed = b.seed + 23U;
  constexpr float kWidth = 0.035F;
  for (const float step : {0.4F, 0.11F}) {
    if (seen(0.3F * step, b.sharpest) <= 0.0F) continue;
    const float f = 1.0F / step;
    for (int i = 0; i < kN; ++i) {
      // Bent by finer noise, which makes it jagged.
      const float bend = 0.35F * gradient_noise(b.u[i] * 4.3F * f, b.v[i] * 4.3F * f,
                                                b.w[i] * 4.3F * f, seed + 1U);
      const float n = gradient_noise(b.u[i] * f + bend, b.v[i] * f - bend, b.w[i] * f, seed);
      // As wide as a pixel at least, and then as much fainter.
      const float width = kWidth + b.pixel[i] * f;
      const float crack = 1.0F - smooth_step(0.0F, width, magnitude(n));
      b.sum[i] += seen(0.3F * step, b.sharp[i]) * (0.03F - 0.36F * kWidth / width * crack);
    }
  }
}

// Ridges upwards with dark furrows.
void bark(Block& b) {
  const std::uint32_t seed = b.seed + 24U;
  for (const float step : {0.07F, 0.03F}) {
    if (seen(0.5F * step, b.sharpest) <= 0.0F) continue;
    const float f = 1.0F / step, fw = 0.16F * f;
    for (int i = 0; i < kN; ++i) {
      const float n = gradient_noise(b.u[i] * f, b.v[i] * f, b.w[i] * fw, seed);
      const float furrow = 1.0F - smooth_step(0.0F, 0.22F, magnitude(n));
      b.sum[i] += 0.5F * seen(0.5F * step, b.sharp[i]) * (0.42F - furrow);
    }
  }
  add_solid(b, {0.09F, 0.002F, 0.30F, 0.95F, 1.0F, 25, 4.0F});
  add_solid(b, {1.0F, 0.05F, 0.20F, 0.9F, 0.0F, 26});
  add_hue(b, 0.25F, 2.0F, 27);
}

void leaves(Block& b) {
  add_solid(b, {0.9F, 0.004F, 0.42F, 0.96F, 0.8F, 28});
  add_hue(b, 0.35F, 2.2F, 29);
  add_hue(b, 0.05F, 1.4F, 30);
}

// Folds that hang, and threads.
void cloth(Block& b) {
  add_solid(b, {0.22F, 0.03F, 0.26F, 0.85F, 1.8F, 31, 2.5F});
  add_solid(b, {0.02F, 0.002F, 0.20F, 0.95F, 0.5F, 32});
  add_hue(b, 0.1F, 1.5F, 33);
}

void skin(Block& b) {
  add_solid(b, {0.12F, 0.002F, 0.14F, 0.95F, 0.5F, 34});
  add_hue(b, 0.15F, 1.1F, 35);
  add_hue(b, 0.05F, 0.7F, 36);
}

void look(Surface surface, Block& b) {
  switch (surface) {
    case Surface::kSoil:
      return soil(b);
    case Surface::kGravel:
      return gravel(b);
    case Surface::kSand:
      return sand(b);
    case Surface::kGrass:
      return grass(b);
    case Surface::kConcrete:
      return concrete(b);
    case Surface::kPlanks:
      return planks(b);
    case Surface::kRock:
      return rock(b);
    case Surface::kBark:
      return bark(b);
    case Surface::kLeaves:
      return leaves(b);
    case Surface::kCloth:
      return cloth(b);
    case Surface::kSkin:
      return skin(b);
    case Surface::kPlain:
      return;
  }
}

void texture_here(Surface surface, float contrast, std::uint32_t seed, const TextureRows& rows) {
  Block b;
  b.seed = hash_mix(seed + 0x51ED270BU);
  for (int first = 0; first < rows.count; first += kN) {
    b.sharpest = 0.0F;
    for (int i = 0; i < kN; ++i) {
      b.u[i] = rows.u[first + i];
      b.v[i] = rows.v[first + i];
      b.w[i] = rows.w[first + i];
      b.sun_u[i] = rows.sun_u[first + i];
      b.sun_v[i] = rows.sun_v[first + i];
      b.sun_w[i] = rows.sun_w[first + i];
      b.pixel[i] = std::max(rows.footprint_m[first + i], kLeastPixelM);
      b.sharp[i] = 1.0F / (1.2F * b.pixel[i]);
      b.sharpest = std::max(b.sharpest, b.sharp[i]);
      b.sum[i] = b.hue[i] = b.relief[i] = 0.0F;
    }
    look(surface, b);
    for (int i = 0; i < kN; ++i) {
      rows.value[first + i] = within(1.0F + contrast * b.sum[i], 0.12F, 2.4F);
      rows.hue[first + i] = within(contrast * b.hue[i], -1.0F, 1.0F);
      rows.relief[first + i] = within(1.0F + contrast * b.relief[i], 0.1F, 1.9F);
    }
  }
}

}  // namespace
}  // namespace tread::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tread {

HWY_EXPORT(texture_here);

void texture_rows(Surface surface, float contrast, std::uint32_t seed, const TextureRows& rows) {
  HWY_DYNAMIC_DISPATCH(texture_here)(surface, contrast, seed, rows);
}

}  // namespace tread
#endif
