#include "tread/sim/sky_kernel.hpp"

#include "tread/sim/hash_noise_kernel.hpp"

// Compiled once for every instruction set, as texture_kernel.cpp is.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tread/sim/sky_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tread::HWY_NAMESPACE {
namespace {

constexpr int kN = 16;
using Lanes = float[kN];

void cloud_here(const float* x, const float* y, const float* z, int count, std::uint32_t seed,
                float* cloud) {
  constexpr int kOctaves = 6;
  for (int first = 0; first < count; first += kN) {
    alignas(64) Lanes u, v, sum;
    for (int i = 0; i < kN; ++i) {
      // On a layer that bends down towards the horizon.
      const float scale = 1.6F / (larger_of(z[first + i], 0.0F) + 0.12F);
      u[i] = x[first + i] * scale;
      v[i] = y[first + i] * scale;
      sum[i] = 0.0F;
    }
    float height = 1.0F, frequency = 1.0F;
    for (int k = 0; k < kOctaves; ++k, height *= 0.62F, frequency *= 2.0F) {
      const std::uint32_t layer = seed + static_cast<std::uint32_t>(k) * kHashStepZ;
      for (int i = 0; i < kN; ++i) {
        sum[i] += height * gradient_noise(frequency * u[i], frequency * v[i], layer);
      }
    }
    for (int i = 0; i < kN; ++i) {
      const float above = smooth_step(-0.06F, 0.19F, z[first + i]);
      cloud[first + i] = smooth_step(-0.12F, 0.55F, sum[i]) * above;
    }
  }
}

}  // namespace
}  // namespace tread::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tread {

HWY_EXPORT(cloud_here);

void cloud_rows(const float* x, const float* y, const float* z, int count, std::uint32_t seed,
                float* cloud) {
  HWY_DYNAMIC_DISPATCH(cloud_here)(x, y, z, count, seed, cloud);
}

}  // namespace tread
#endif
