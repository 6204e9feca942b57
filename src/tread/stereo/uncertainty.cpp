#include "tread/stereo/uncertainty.hpp"

#include <array>
#include <cassert>
#include <cmath>

namespace tread {
namespace {

// At residuals of 1/16 times 1, 2, 4, ... 128, and of pixels that were filled.
struct Curve {
  std::array<float, 8> wrong;
  std::array<float, 8> sigma_px;
  MatchUncertainty filled;
};

constexpr Curve kSad = {{0.013F, 0.013F, 0.014F, 0.020F, 0.069F, 0.161F, 0.262F, 0.363F},
                        {0.200F, 0.208F, 0.219F, 0.230F, 0.314F, 0.393F, 0.460F, 0.490F},
                        {0.948F, 0.280F}};
constexpr Curve kSgm = {{0.015F, 0.016F, 0.019F, 0.031F, 0.084F, 0.249F, 0.385F, 0.487F},
                        {0.251F, 0.262F, 0.279F, 0.291F, 0.329F, 0.413F, 0.470F, 0.516F},
                        {0.660F, 0.390F}};

// Straight between the knots over the logarithm of the residual.
float between(const std::array<float, 8>& knots, float octave) {
  const float at = std::fmin(std::fmax(octave, 0.0F), 7.0F);
  const auto low = static_cast<std::size_t>(std::fmin(at, 6.0F));
  const float t = at - static_cast<float>(low);
  return (1.0F - t) * knots[low] + t * knots[low + 1];
}

}  // namespace

MatchUncertainty match_uncertainty(StereoMethod method, std::uint8_t residual) {
  const Curve& curve = method == StereoMethod::kSgm ? kSgm : kSad;
  if (residual == kNoResidual) return curve.filled;
  const float octave = std::log2(std::fmax(1.0F, static_cast<float>(residual)));
  return {1.0F - between(curve.wrong, octave), between(curve.sigma_px, octave)};
}

void depth_sigmas(ImageView<const float> depth, ImageView<const std::uint8_t> residual,
                  const RectifiedRig& rig, StereoMethod method, std::vector<float>& sigma_m) {
  assert(same_size(depth, residual));
  // r = step Z^2 / (b f), the step being the disparity's standard deviation (Eq. 2).
  std::array<float, 256> factor{};
  for (int i = 0; i < 256; ++i) {
    const float sigma_px = match_uncertainty(method, static_cast<std::uint8_t>(i)).sigma_px;
    factor[static_cast<std::size_t>(i)] = sigma_px / static_cast<float>(rig.baseline_m * rig.fx_px);
  }
  sigma_m.clear();
  for (int y = 0; y < depth.height; ++y) {
    const float* row = depth.row(y);
    const std::uint8_t* rated = residual.row(y);
    for (int x = 0; x < depth.width; ++x) {
      if (std::isnan(row[x])) continue;
      sigma_m.push_back(factor[rated[x]] * row[x] * row[x]);
    }
  }
}

}  // namespace tread
