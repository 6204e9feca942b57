#include "tread/geometry/trajectory_error.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>

namespace tread {
namespace {

using Eigen::Vector3d;

Vector3d mean_of(const std::vector<Vector3d>& points) {
  Vector3d sum = Vector3d::Zero();
  for (const Vector3d& p : points) sum += p;
  return sum / static_cast<double>(points.size());
}

TrajectoryError statistics_of(const std::vector<Isometry3d>& errors, std::size_t unmatched) {
  TrajectoryError result;
  result.compared = errors.size();
  result.unmatched = unmatched;
  std::vector<double> distances;
  const auto count = static_cast<double>(errors.size());
  for (const Isometry3d& error : errors) {
    const double distance = error.translation().norm();
    const double angle = so3_log(error.linear()).norm();
    distances.push_back(distance);
    result.mean_m += distance / count;
    result.rmse_m += distance * distance / count;
    result.rmse_rad += angle * angle / count;
    result.largest_m = std::max(result.largest_m, distance);
    result.largest_rad = std::max(result.largest_rad, angle);
  }
  result.rmse_m = std::sqrt(result.rmse_m);
  result.rmse_rad = std::sqrt(result.rmse_rad);
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  result.median_m = *middle;
  return result;
}

tl::unexpected<Error> nothing_common() {
  return fail(ErrorCode::kNotFound, "the trajectories have no times in common", "trajectory",
              "Check that both count time from the same moment");
}

}  // namespace

Result<Isometry3d> align_points(const std::vector<Vector3d>& from,
                                const std::vector<Vector3d>& to) {
  const auto refuse = [](const char* what, const char* remedy) {
    return fail(ErrorCode::kBadArgument, what, "alignment", remedy);
  };
  if (from.size() != to.size() || from.size() < 3) {
    return refuse("fewer than three pairs of points", "Give as many points of both");
  }
  const Vector3d from_mean = mean_of(from), to_mean = mean_of(to);
  if (!from_mean.allFinite() || !to_mean.allFinite()) {
    return refuse("a point is not finite", "Leave out what is not known");
  }
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < from.size(); ++i) {
    covariance += (to[i] - to_mean) * (from[i] - from_mean).transpose();
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Vector3d& spread = svd.singularValues();
  constexpr double kLine = 1e-9;  // of the largest spread
  if (!(spread[1] > kLine * spread[0])) {
    return refuse("the points lie on one line", "Any turn about it would do: give others");
  }
  Vector3d sign = Vector3d::Ones();
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0) sign[2] = -1.0;
  Isometry3d T = Isometry3d::Identity();
  T.linear() = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
  T.translation() = to_mean - T.linear() * from_mean;
  return T;
}

Result<TrajectoryError> absolute_trajectory_error(const Trajectory& estimate,
                                                  const Trajectory& truth) {
  std::vector<Isometry3d> estimated, known;
  for (const StampedPose& pose : estimate) {
    const auto there = pose_at(truth, pose.stamp_ns);
    if (!there) continue;
    estimated.push_back(pose.pose);
    known.push_back(*there);
  }
  if (known.empty()) return nothing_common();
  std::vector<Vector3d> from, to;
  for (const Isometry3d& T : estimated) from.push_back(T.translation());
  for (const Isometry3d& T : known) to.push_back(T.translation());
  const auto aligned = align_points(from, to);
  const Isometry3d move = aligned ? *aligned : known.front() * estimated.front().inverse();
  std::vector<Isometry3d> errors;
  for (std::size_t i = 0; i < known.size(); ++i) {
    errors.push_back(known[i].inverse() * move * estimated[i]);
  }
  return statistics_of(errors, estimate.size() - known.size());
}

Result<TrajectoryError> relative_pose_error(const Trajectory& estimate, const Trajectory& truth,
                                            double span_s) {
  constexpr double kLongest_s = 1e6;
  if (!(span_s > 0.0) || span_s > kLongest_s) {
    return fail(ErrorCode::kBadArgument, "the span is not above 0", "trajectory", "Give seconds");
  }
  const auto span_ns = static_cast<std::int64_t>(std::llround(1e9 * span_s));
  std::vector<Isometry3d> errors;
  std::size_t unmatched = 0;
  for (const StampedPose& begin : estimate) {
    if (begin.stamp_ns > std::numeric_limits<std::int64_t>::max() - span_ns) continue;
    const auto end = pose_at(estimate, begin.stamp_ns + span_ns);
    if (!end) continue;  // the estimate ends, or has a gap
    const auto true_begin = pose_at(truth, begin.stamp_ns);
    const auto true_end = pose_at(truth, begin.stamp_ns + span_ns);
    if (!true_begin || !true_end) {
      ++unmatched;
      continue;
    }
    const Isometry3d moved = begin.pose.inverse() * *end;
    const Isometry3d truly = true_begin->inverse() * *true_end;
    errors.push_back(truly.inverse() * moved);
  }
  if (errors.empty()) return nothing_common();
  return statistics_of(errors, unmatched);
}

}  // namespace tread
