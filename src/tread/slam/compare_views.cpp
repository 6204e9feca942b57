#include "tread/slam/compare_views.hpp"

#include <Eigen/Cholesky>
#include <cmath>

namespace tread {
namespace {

bool holds(const Overlap& overlap, const LoopOptions& limits) {
  return overlap.seen >= limits.least_overlap * overlap.known &&
         overlap.agree >= limits.least_agree * overlap.seen &&
         overlap.through <= limits.most_through * overlap.seen && overlap.seen > 0;
}

}  // namespace

Overlap overlap_of(const DepthLevel& image, const DepthLevel& other,
                   const Isometry3d& T_other_image, const DepthNoise& noise, double gate) {
  const Eigen::Matrix3f R = T_other_image.linear().cast<float>();
  const Eigen::Vector3f t = T_other_image.translation().cast<float>();
  Overlap out;
  for (int y = 0; y < image.height(); ++y) {
    const float* row = image.depth.row(y);
    for (int x = 0; x < image.width(); ++x) {
      const float z = row[x];
      if (!(z > 0.0F)) continue;
      ++out.known;
      const Eigen::Vector3f ray((static_cast<float>(x) - image.camera.cx) / image.camera.fx,
                                (static_cast<float>(y) - image.camera.cy) / image.camera.fy, 1.0F);
      const Eigen::Vector3f q = R * (z * ray) + t;
      if (!(q.z() > 0.0F)) continue;
      const float u = std::nearbyint(q.x() / q.z() * other.camera.fx + other.camera.cx);
      const float v = std::nearbyint(q.y() / q.z() * other.camera.fy + other.camera.cy);
      if (!(u >= 0.0F && v >= 0.0F && u < static_cast<float>(other.width()) &&
            v < static_cast<float>(other.height()))) {
        continue;
      }
      const float there = other.depth(static_cast<int>(u), static_cast<int>(v));
      if (!(there > 0.0F)) continue;
      ++out.seen;
      // A pixel is a patch: on a slope its depths spread by some part of its width.
      const double patch = 3.0 * static_cast<double>(q.z() / other.camera.fx);
      const double limit = gate * std::hypot(noise.sigma_m(static_cast<double>(z)),
                                             noise.sigma_m(static_cast<double>(there))) +
                           patch;
      const auto behind = static_cast<double>(q.z() - there);
      if (std::abs(behind) <= limit) ++out.agree;
      if (behind < -limit) ++out.through;
    }
  }
  return out;
}

std::optional<ViewPose> compare_views(const AlignFrame& frame,
                                      const std::array<DepthLevel, 3>& place,
                                      const PlaceMatch& match, const DepthNoise& noise,
                                      const AlignOptions& options, const LoopOptions& limits,
                                      const Context& context) {
  const ScopedTimer timer(context, "slam/compare_views");
  constexpr double kGate = 3.0;
  constexpr double kMostApart = 0.06;  // of the mean depth: corners and depths, each by itself
  PosePrior prior;
  prior.T_world_camera = match.T_place_query;
  // Corners hold where depth tells nothing; their places err alike where depths are wrong, so they
  // count as less than they say.
  constexpr double kDoubt = 4.0;
  prior.information = (kDoubt * match.covariance).ldlt().solve(Matrix6d::Identity());
  prior.information = (0.5 * (prior.information + prior.information.transpose())).eval();
  const Isometry3d T_place = Isometry3d::Identity();
  const Alignment found = align(frame, &place, T_place, nullptr, prior, noise, options, context);
  if (!found.T_world_camera.matrix().allFinite() || !found.covariance.allFinite() ||
      found.measured < 100 || !(found.depth_rms <= limits.largest_rms)) {
    return std::nullopt;
  }
  const double mean = mean_depth(frame.depth[1].depth);
  const Isometry3d apart = match.T_place_query.inverse() * found.T_world_camera;
  const double shift = apart.translation().norm() + so3_log(apart.linear()).norm() * mean;
  if (!(shift <= kMostApart * mean)) return std::nullopt;
  const Isometry3d& T = found.T_world_camera;
  if (!holds(overlap_of(frame.depth[1], place[1], T, noise, kGate), limits) ||
      !holds(overlap_of(place[1], frame.depth[1], T.inverse(), noise, kGate), limits)) {
    return std::nullopt;
  }
  return ViewPose{T, found.covariance};
}

}  // namespace tread
