// A point seen by a rectified pair of cameras, and how what is seen changes with the point.
#pragma once

#include <cmath>
#include <limits>

#include "tread/geometry/pose.hpp"
#include "tread/geometry/stereo_rig.hpp"

namespace tread {

// Where a point is in both images, pixels. The row is one in a rectified pair.
struct StereoSight {
  double u = 0.0;
  double v = 0.0;
  double u_right = std::numeric_limits<double>::quiet_NaN();  // not found there
  [[nodiscard]] bool has_right() const { return std::isfinite(u_right); }
  [[nodiscard]] Eigen::Vector3d vector() const { return {u, v, u_right}; }
};

// (u, v, u_right) of a point q, left optical axes, z > 0: u = f x / z + c, u_right = u - d with the
// disparity d of RectifiedRig. J, if asked for, is d (u, v, u_right) / d q.
[[nodiscard]] inline Eigen::Vector3d stereo_projection(const RectifiedRig& rig,
                                                       const Eigen::Vector3d& q,
                                                       Eigen::Matrix3d* J = nullptr) {
  const double inverse = 1.0 / q.z();
  const double x = q.x() * inverse, y = q.y() * inverse;
  const double u = rig.fx_px * x + rig.cx_px;
  const double spread = rig.fx_px * rig.baseline_m * inverse;
  if (J != nullptr) {
    const double a = rig.fx_px * inverse, b = rig.fy_px * inverse;
    *J << a, 0.0, -a * x, 0.0, b, -b * y, a, 0.0, -a * x + spread * inverse;
  }
  return {u, rig.fy_px * y + rig.cy_px, u - spread + rig.cx_offset_px};
}

inline constexpr double kLeastDepth_m = 0.05;  // nearer points, and those behind it, are not seen

// What is seen of a point q less what should be, pixels; the third is zero, and its row of J, where
// the right camera does not see it.
[[nodiscard]] inline Eigen::Vector3d sight_residual(const RectifiedRig& rig,
                                                    const Eigen::Vector3d& q,
                                                    const StereoSight& sight,
                                                    Eigen::Matrix3d* J = nullptr) {
  Eigen::Vector3d r = stereo_projection(rig, q, J) - sight.vector();
  if (sight.has_right()) return r;
  r.z() = 0.0;
  if (J != nullptr) J->row(2).setZero();
  return r;
}

// The point, left optical axes, of a sight with a right pixel and a disparity above that of
// infinity.
[[nodiscard]] inline Eigen::Vector3d point_of(const RectifiedRig& rig, const StereoSight& sight) {
  return rig.point(sight.u, sight.v, rig.depth_m(sight.u - sight.u_right));
}

// d q / d (v, w) of a point q = T^-1 p in the camera, for T <- T exp(v, w).
[[nodiscard]] inline Eigen::Matrix<double, 3, 6> point_by_twist(const Eigen::Vector3d& q) {
  Eigen::Matrix<double, 3, 6> J;
  J << -Eigen::Matrix3d::Identity(), hat(q);
  return J;
}

}  // namespace tread
