#include "tread/geometry/trajectory.hpp"

#include <algorithm>

namespace tread {

std::optional<Isometry3d> pose_at(const Trajectory& trajectory, std::int64_t stamp_ns,
                                  std::int64_t max_gap_ns) {
  const auto after = std::lower_bound(
      trajectory.begin(), trajectory.end(), stamp_ns,
      [](const StampedPose& pose, std::int64_t stamp) { return pose.stamp_ns < stamp; });
  if (after == trajectory.end()) return std::nullopt;
  if (after->stamp_ns == stamp_ns) return after->pose;
  if (after == trajectory.begin()) return std::nullopt;
  const StampedPose& before = *(after - 1);

  // Unsigned: the distance of two stamps of opposite sign may not fit into a signed number.
  const auto distance = [&before](std::int64_t stamp) {
    return static_cast<std::uint64_t>(stamp) - static_cast<std::uint64_t>(before.stamp_ns);
  };
  const std::uint64_t gap = distance(after->stamp_ns);
  if (max_gap_ns < 0 || gap > static_cast<std::uint64_t>(max_gap_ns)) return std::nullopt;
  const double fraction = static_cast<double>(distance(stamp_ns)) / static_cast<double>(gap);
  Isometry3d pose = Isometry3d::Identity();
  pose.translation() =
      (1.0 - fraction) * before.pose.translation() + fraction * after->pose.translation();
  const Eigen::Matrix3d R_before_after = before.pose.linear().transpose() * after->pose.linear();
  pose.linear() = before.pose.linear() * so3_exp(fraction * so3_log(R_before_after));
  return pose;
}

}  // namespace tread
