#include "tread/slam/corner_patch.hpp"

#include <Eigen/LU>
#include <cmath>

namespace tread {
namespace {

constexpr int kRadius = CornerPatch::kRadius;
constexpr int kSide = CornerPatch::kSide;
constexpr std::size_t kPixels = static_cast<std::size_t>(kSide) * kSide;

// The middle counts more than the rim, which is sooner on another surface. Sum 1.
const std::array<float, kPixels>& weights() {
  static const std::array<float, kPixels> kWeights = [] {
    std::array<float, kPixels> w{};
    double sum = 0.0;
    constexpr double kSigma = 0.6 * kRadius;
    std::size_t k = 0;
    for (int y = -kRadius; y <= kRadius; ++y) {
      for (int x = -kRadius; x <= kRadius; ++x, ++k) {
        const double value = std::exp(-(x * x + y * y) / (2.0 * kSigma * kSigma));
        w[k] = static_cast<float>(value);
        sum += value;
      }
    }
    for (float& value : w) value /= static_cast<float>(sum);
    return w;
  }();
  return kWeights;
}

float sample(ImageView<const std::uint8_t> image, float x, float y) {
  const int u = static_cast<int>(x), v = static_cast<int>(y);
  const float fu = x - static_cast<float>(u), fv = y - static_cast<float>(v);
  const std::uint8_t* above = image.row(v) + u;
  const std::uint8_t* below = above + image.stride;
  const float a = above[0], b = above[1], c = below[0], d = below[1];
  const float upper = a + fu * (b - a), lower = c + fu * (d - c);
  return upper + fv * (lower - upper);
}

bool is_inside(ImageView<const std::uint8_t> image, const Eigen::Vector2d& place, double reach) {
  return place.x() >= reach && place.y() >= reach && place.x() < image.width - 1 - reach &&
         place.y() < image.height - 1 - reach;
}

}  // namespace

std::optional<CornerPatch> CornerPatch::take(ImageView<const std::uint8_t> image,
                                             const Eigen::Vector2d& place) {
  if (!is_inside(image, place, kRadius + 1)) return std::nullopt;
  CornerPatch patch;
  const auto& w = weights();
  const auto px = static_cast<float>(place.x()), py = static_cast<float>(place.y());
  Matrix6f H = Matrix6f::Zero();
  float mean = 0.0F;
  std::size_t k = 0;
  for (int y = -kRadius; y <= kRadius; ++y) {
    for (int x = -kRadius; x <= kRadius; ++x, ++k) {
      const float u = px + static_cast<float>(x), v = py + static_cast<float>(y);
      patch.values_[k] = sample(image, u, v);
      patch.slope_x_[k] = 0.5F * (sample(image, u + 1.0F, v) - sample(image, u - 1.0F, v));
      patch.slope_y_[k] = 0.5F * (sample(image, u, v + 1.0F) - sample(image, u, v - 1.0F));
      mean += w[k] * patch.values_[k];
      const float gx = patch.slope_x_[k], gy = patch.slope_y_[k];
      const auto fx = static_cast<float>(x), fy = static_cast<float>(y);
      Eigen::Matrix<float, 6, 1> J;
      J << gx, gy, gx * fx, gx * fy, gy * fx, gy * fy;
      H.noalias() += w[k] * J * J.transpose();
    }
  }
  for (k = 0; k < kPixels; ++k) {
    patch.values_[k] -= mean;
    patch.spread_ += w[k] * patch.values_[k] * patch.values_[k];
  }
  constexpr float kLeastSpread = 4.0F;  // grey values squared
  const Eigen::FullPivLU<Matrix6f> solver(H);
  if (patch.spread_ < kLeastSpread || !solver.isInvertible()) return std::nullopt;
  patch.inverse_ = solver.inverse();
  return patch;
}

std::optional<double> CornerPatch::align(ImageView<const std::uint8_t> image, Warp& warp) const {
  constexpr int kIterations = 12;
  constexpr double kSettled_px = 0.01;
  constexpr double kLargestStep_px = 2.0;
  const auto& w = weights();
  std::array<float, kPixels> here;
  std::optional<double> correlation;
  for (int i = 0; i < kIterations; ++i) {
    const double reach = kRadius * std::max(warp.A.row(0).lpNorm<1>(), warp.A.row(1).lpNorm<1>());
    if (!is_inside(image, warp.place, reach + 1.0)) return std::nullopt;
    const Eigen::Matrix2f A = warp.A.cast<float>();
    const Eigen::Vector2f p = warp.place.cast<float>();
    float mean = 0.0F, squares = 0.0F, product = 0.0F;
    std::size_t k = 0;
    for (int y = -kRadius; y <= kRadius; ++y) {
      const auto fy = static_cast<float>(y);
      for (int x = -kRadius; x <= kRadius; ++x, ++k) {
        const auto fx = static_cast<float>(x);
        const float value =
            sample(image, p.x() + A(0, 0) * fx + A(0, 1) * fy, p.y() + A(1, 0) * fx + A(1, 1) * fy);
        here[k] = value;
        mean += w[k] * value;
        squares += w[k] * value * value;
        product += w[k] * value * values_[k];
      }
    }
    const float spread = squares - mean * mean;
    if (!(spread > 1.0F)) return std::nullopt;
    correlation = product / std::sqrt(spread * spread_);
    // Gain that makes the contrast that of the patch.
    const float gain = std::sqrt(spread_ / spread);
    Eigen::Matrix<float, 6, 1> g = Eigen::Matrix<float, 6, 1>::Zero();
    k = 0;
    for (int y = -kRadius; y <= kRadius; ++y) {
      const auto fy = static_cast<float>(y);
      for (int x = -kRadius; x <= kRadius; ++x, ++k) {
        const auto fx = static_cast<float>(x);
        const float e = w[k] * (gain * (here[k] - mean) - values_[k]);
        const float ex = e * slope_x_[k], ey = e * slope_y_[k];
        g(0) += ex;
        g(1) += ey;
        g(2) += ex * fx;
        g(3) += ex * fy;
        g(4) += ey * fx;
        g(5) += ey * fy;
      }
    }
    const Eigen::Matrix<double, 6, 1> step = (inverse_ * g).cast<double>();
    if (!step.allFinite() || step.head<2>().norm() > kLargestStep_px) return std::nullopt;
    // The warp before the inverse of the step.
    Eigen::Matrix2d change;
    change << 1.0 + step(2), step(3), step(4), 1.0 + step(5);
    if (!(change.determinant() > 0.2)) return std::nullopt;
    warp.A = (warp.A * change.inverse()).eval();
    warp.place -= warp.A * step.head<2>();
    if (step.head<2>().norm() < kSettled_px && step.tail<4>().norm() * kRadius < 0.1) {
      return correlation;
    }
  }
  return std::nullopt;
}

}  // namespace tread
