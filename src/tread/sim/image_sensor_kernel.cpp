#include "tread/sim/image_sensor_kernel.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "tread/sim/hash_noise_kernel.hpp"

// Compiled once for every instruction set, as texture_kernel.cpp is.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tread/sim/image_sensor_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tread::HWY_NAMESPACE {
namespace {

// The sum of the eight bytes of two hashes as a normal distribution: of variance 1, not above 4.9,
// its fourth moment 2.85 for 3.
HWY_INLINE float normal_of(std::uint32_t key, std::uint32_t pixel) {
  const std::uint32_t a = hash_mix(key ^ (pixel * kHashStepX)), b = hash_mix(a + kHashStepY);
  const std::uint32_t pairs =
      (a & 0x00FF00FFU) + ((a >> 8) & 0x00FF00FFU) + (b & 0x00FF00FFU) + ((b >> 8) & 0x00FF00FFU);
  const auto sum = static_cast<float>(static_cast<std::int32_t>((pairs & 0xFFFFU) + (pairs >> 16)));
  constexpr float kSigma = 209.0174F;  // sqrt(8 (256^2 - 1) / 12)
  return (sum - 1020.0F) * (1.0F / kSigma);
}

void expose_row_here(const SensorRow& row) {
  constexpr int kN = 64;
  alignas(64) std::int32_t place[kN];
  for (int first = 0; first < row.count; first += kN) {
    const int count = std::min(kN, row.count - first);
    const float* light = row.light + first * row.step;
    const float* vignetting = row.vignetting + first;
    const float well = row.full_well, electrons = row.electrons, read = row.read_variance;
    const float scale = row.gain / well;
    const std::uint32_t key = row.key;
    const std::ptrdiff_t step = row.step;
    for (int i = 0; i < count; ++i) {
      const float arrived = electrons * light[i * step] * vignetting[i];
      // The well is full before the amplifier is at its end, or after.
      const float held = well * clamped(arrived / well);
      const float noisy =
          held + std::sqrt(held + read) * normal_of(key, static_cast<std::uint32_t>(first + i));
      const float signal = clamped(noisy * scale);
      place[i] = static_cast<std::int32_t>(
          std::sqrt(magnitude(signal)) * static_cast<float>(kResponseSteps - 1) + 0.5F);
    }
    std::uint8_t* out = row.out + first * row.out_step;
    for (int i = 0; i < count; ++i) out[i * row.out_step] = row.response[place[i]];
  }
}

}  // namespace
}  // namespace tread::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tread {

HWY_EXPORT(expose_row_here);

void expose_row(const SensorRow& row) {
  HWY_DYNAMIC_DISPATCH(expose_row_here)(row);
}

}  // namespace tread
#endif
