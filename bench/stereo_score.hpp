// Scores of a disparity image against ground truth, shared by the benchmark and the test that holds
// its figures.
#pragma once

#include <cmath>
#include <vector>

#include "tread/core/image.hpp"

namespace tread::bench {

struct Score {
  double density = 0;  // share of the pixels of known truth that are estimated, per cent
  double bad1 = 0;     // share of those estimated that are off by more than 1 px, per cent
  double bad2 = 0;     // by more than 2 px
  double error = 0;    // mean absolute error of those estimated, px
  double missed2 = 0;  // of all pixels of known truth: not estimated or off by more than 2 px
  double ms = 0;
};

// Unknown is NaN in both.
inline Score score(const Image<float>& estimate, const Image<float>& truth) {
  double known = 0, estimated = 0, bad1 = 0, bad2 = 0, error = 0;
  for (int y = 0; y < truth.height; ++y) {
    for (int x = 0; x < truth.width; ++x) {
      if (std::isnan(truth(x, y))) continue;
      ++known;
      if (std::isnan(estimate(x, y))) continue;
      ++estimated;
      const double off = std::abs(estimate(x, y) - truth(x, y));
      error += off;
      bad1 += off > 1.0 ? 1 : 0;
      bad2 += off > 2.0 ? 1 : 0;
    }
  }
  return {100 * estimated / known,
          100 * bad1 / estimated,
          100 * bad2 / estimated,
          error / estimated,
          100 * (known - estimated + bad2) / known,
          0};
}

inline Score mean_of(const std::vector<Score>& scores) {
  Score mean;
  const double n = static_cast<double>(scores.size());
  for (const Score& s : scores) {
    mean.density += s.density / n;
    mean.bad1 += s.bad1 / n;
    mean.bad2 += s.bad2 / n;
    mean.error += s.error / n;
    mean.missed2 += s.missed2 / n;
    mean.ms += s.ms / n;
  }
  return mean;
}

}  // namespace tread::bench
