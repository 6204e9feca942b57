// One row of an image sensor, for every instruction set that the machine may have.
#pragma once

#include <cstddef>
#include <cstdint>

namespace tread {

inline constexpr int kResponseSteps = 4096;

struct SensorRow {
  const float* light = nullptr;
  std::ptrdiff_t step = 1;  // from the light of a pixel to that of the next
  const float* vignetting = nullptr;
  int count = 0;
  float electrons = 0.0F;  // of light 1
  float full_well = 0.0F;
  float read_variance = 0.0F;
  float gain = 1.0F;
  std::uint32_t key = 0;                   // of the noise of this row
  const std::uint8_t* response = nullptr;  // kResponseSteps bytes, by the square root of the signal
  std::uint8_t* out = nullptr;
  std::ptrdiff_t out_step = 1;
};
void expose_row(const SensorRow& row);

}  // namespace tread
