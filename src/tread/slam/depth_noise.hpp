// How far a measured depth may be off, by its distance: what weights, truncation and gates are made
// of. One standard deviation, metres.
#pragma once

#include "tread/core/options.hpp"

namespace tread {

// sigma(z) = constant + quadratic z^2. The default is that of structured light (Khoshelham and
// Elberink 2012: 1.4 mm at 1 m). For stereo it is z^2 sigma_d / (f b): stereo_noise.
struct DepthNoise {
  double constant_m = 0.0005;
  double quadratic_per_m = 0.0014;
  [[nodiscard]] double sigma_m(double depth_m) const {
    return constant_m + quadratic_per_m * depth_m * depth_m;
  }
  [[nodiscard]] bool operator==(const DepthNoise&) const = default;
};
[[nodiscard]] inline OptionSet describe(DepthNoise& noise) {
  OptionSet set;
  set.add("constant_m", noise.constant_m, "error of any depth, m", 1e-6, 1.0);
  set.add("quadratic_per_m", noise.quadratic_per_m, "what grows with the square of the depth, 1/m",
          0.0, 1.0);
  return set;
}

// focal_px * baseline_m: what a disparity of one pixel is the depth of.
[[nodiscard]] inline DepthNoise stereo_noise(double focal_px, double baseline_m,
                                             double sigma_disparity_px = 0.25) {
  return {0.0005, sigma_disparity_px / (focal_px * baseline_m)};
}

}  // namespace tread
