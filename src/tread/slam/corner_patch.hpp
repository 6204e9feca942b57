// What surrounds a corner where it was first seen, and where that is in a later image: aligned
// under an affine warp and another exposure (Baker and Matthews 2004, inverse compositional). A
// corner that is only followed drifts off by a little with every image; its patch brings it back.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>

#include "tread/core/image.hpp"

namespace tread {

class CornerPatch {
 public:
  static constexpr int kRadius = 8;
  static constexpr int kSide = 2 * kRadius + 1;

  // Empty where the image ends within the patch, or if the patch shows no corner.
  [[nodiscard]] static std::optional<CornerPatch> take(ImageView<const std::uint8_t> image,
                                                       const Eigen::Vector2d& place);

  // Where an offset x of the patch is in another image: place + A x.
  struct Warp {
    Eigen::Vector2d place = Eigen::Vector2d::Zero();
    Eigen::Matrix2d A = Eigen::Matrix2d::Identity();
  };
  // Refines a warp that is right to a pixel or two; the correlation of both patches there, or empty
  // if it does not settle or leaves the image.
  [[nodiscard]] std::optional<double> align(ImageView<const std::uint8_t> image, Warp& warp) const;

 private:
  using Matrix6f = Eigen::Matrix<float, 6, 6>;
  std::array<float, kSide * kSide> values_{}, slope_x_{}, slope_y_{};  // weighted mean zero
  float spread_ = 0.0F;                                                // weighted sum of squares
  Matrix6f inverse_ = Matrix6f::Zero();
};

}  // namespace tread
