// How far an estimated trajectory is from the true one, after Sturm, Engelhard, Endres, Burgard,
// Cremers 2012: the absolute error of the whole, and the relative error over a span of time.
//
//   const auto whole = absolute_trajectory_error(estimate, truth);
//   const auto drift = relative_pose_error(estimate, truth, 1.0);   // over one second
//   if (whole && drift) fmt::print("{} m, {} m/s\n", whole->rmse_m, drift->rmse_m);
#pragma once

#include "tread/core/result.hpp"
#include "tread/geometry/trajectory.hpp"

namespace tread {

// The rigid motion that takes points `from` onto points `to` with the least sum of squared
// distances (Umeyama 1991, without scale). Errors: fewer than three points, as many of both not
// given, points that are not finite, or all on one line, around which any turn would do.
[[nodiscard]] Result<Isometry3d> align_points(const std::vector<Eigen::Vector3d>& from,
                                              const std::vector<Eigen::Vector3d>& to);

struct TrajectoryError {
  std::size_t compared = 0;   // poses, or pairs of poses
  std::size_t unmatched = 0;  // for which there was no truth
  double rmse_m = 0.0;
  double mean_m = 0.0;
  double median_m = 0.0;
  double largest_m = 0.0;
  double rmse_rad = 0.0;  // of the rotation
  double largest_rad = 0.0;
};

// Each estimated pose is compared with the truth at its time (pose_at), after the estimate has been
// moved as a whole to fit best; a trajectory on one line or at one place is moved so that its first
// compared pose fits. Errors: no common times.
[[nodiscard]] Result<TrajectoryError> absolute_trajectory_error(const Trajectory& estimate,
                                                                const Trajectory& truth);

// The motion of the estimate from each of its poses to `span_s` later (pose_at) against the true
// motion: E = (T_i^-1 T_j)_true^-1 (T_i^-1 T_j)_estimated. Errors: no common times, a span not
// above 0.
[[nodiscard]] Result<TrajectoryError> relative_pose_error(const Trajectory& estimate,
                                                          const Trajectory& truth, double span_s);

}  // namespace tread
