// Which motions the measurements of one frame tell, and which they do not.
#pragma once

#include "tread/core/options.hpp"
#include "tread/geometry/pose.hpp"

namespace tread {

struct ObservabilityOptions {
  // Residuals of neighbouring pixels err alike: a hundred say as much as this many hundredths.
  double correlation = 50.0;
  // A direction counts as known if the frame tells it to this part of the mean depth.
  double limit = 0.008;
  [[nodiscard]] bool operator==(const ObservabilityOptions&) const = default;
};
[[nodiscard]] OptionSet describe(ObservabilityOptions& options);

struct Observability {
  // Directions, columns of unit length, that the measurements do not tell: twists (v, w) with w
  // times the mean depth. Of size 6 x 0 to 6 x 6.
  Eigen::Matrix<double, 6, Eigen::Dynamic> unknown{6, 0};
  // One standard deviation in the worst direction: metres at the mean depth.
  double worst_m = 0.0;
  [[nodiscard]] bool all_known() const { return unknown.cols() == 0; }
};

// `information`: that of structure alone, with the part that noise adds taken off: cross of
// NormalEquations, for a twist (v, w) about the camera, 1/m^2 and so on. mean_depth_m makes
// rotations and translations comparable.
[[nodiscard]] Observability find_observability(const Matrix6d& information, double mean_depth_m,
                                               const ObservabilityOptions& options);

}  // namespace tread
