// Images that the tests of stereo make themselves.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <random>

#include "tread/core/image.hpp"

namespace tread::testing {

inline Image<std::uint8_t> random_image(int width, int height, unsigned seed) {
  std::mt19937 random(seed);
  Image<std::uint8_t> image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) image(x, y) = static_cast<std::uint8_t>(random() & 255U);
  }
  return image;
}

// A smooth random texture that can be sampled anywhere: a sum of waves, values 0 to 255.
class Texture {
 public:
  explicit Texture(unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    for (Wave& wave : waves_) {
      const double length_px = 4.0 + 20.0 * unit(random);
      const double angle = 6.2832 * unit(random);
      wave = {6.2832 / length_px * std::cos(angle), 6.2832 / length_px * std::sin(angle),
              6.2832 * unit(random)};
    }
  }
  [[nodiscard]] double operator()(double u, double v) const {
    double sum = 0.0;
    for (const Wave& wave : waves_) sum += std::sin(wave.ku * u + wave.kv * v + wave.phase);
    return 127.5 + 127.5 * std::tanh(sum / std::sqrt(2.0 * kWaves));
  }

 private:
  struct Wave {
    double ku = 0.0, kv = 0.0, phase = 0.0;
  };
  static constexpr int kWaves = 40;
  Wave waves_[kWaves];
};

struct Pair {
  Image<std::uint8_t> left;
  Image<std::uint8_t> right;
};

// A pair whose left image has the given disparity at each pixel: the right image is the texture,
// the left one is looked up in it.
inline Pair textured_pair(int width, int height, unsigned seed,
                          const std::function<double(int x, int y)>& disparity) {
  const Texture texture(seed);
  Pair pair{Image<std::uint8_t>(width, height), Image<std::uint8_t>(width, height)};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      pair.left(x, y) = static_cast<std::uint8_t>(std::lround(texture(x - disparity(x, y), y)));
      pair.right(x, y) = static_cast<std::uint8_t>(std::lround(texture(x, y)));
    }
  }
  return pair;
}

}  // namespace tread::testing
