#include "tread/slam/observability.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>

namespace tread {

OptionSet describe(ObservabilityOptions& options) {
  OptionSet set;
  set.add("correlation", options.correlation, "pixels that say as much as one that is by itself",
          1.0, 10'000.0);
  set.add("limit", options.limit, "a direction is known if told to this part of the mean depth",
          1e-6, 1.0);
  return set;
}

Observability find_observability(const Matrix6d& information, double mean_depth_m,
                                 const ObservabilityOptions& options) {
  Vector6d scale;
  scale << 1.0, 1.0, 1.0, 1.0 / mean_depth_m, 1.0 / mean_depth_m, 1.0 / mean_depth_m;
  const Matrix6d scaled = scale.asDiagonal() * information * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(0.5 * (scaled + scaled.transpose()));
  const double limit_m = options.limit * mean_depth_m;
  const double least = options.correlation / (limit_m * limit_m);
  Observability found;
  int unknown = 0;
  while (unknown < 6 && !(eigen.eigenvalues()(unknown) >= least)) ++unknown;
  found.unknown = eigen.eigenvectors().leftCols(unknown);
  const double smallest = eigen.eigenvalues()(0);
  found.worst_m = smallest > 0.0 ? std::sqrt(options.correlation / smallest)
                                 : std::numeric_limits<double>::infinity();
  return found;
}

}  // namespace tread
