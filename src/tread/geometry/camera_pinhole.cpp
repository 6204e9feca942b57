#include <cassert>
#include <cmath>

#include "tread/geometry/camera.hpp"

namespace tread {

Projection PinholeCamera::project(const Eigen::Vector3d& p, PointJacobian* J_point,
                                  ParameterJacobian* J_params) const {
  if (J_point != nullptr) J_point->setZero();
  if (J_params != nullptr) J_params->setZero(2, kParameters);
  if (!(p.z() > 0.0)) return {};
  const double w = 1.0 / p.z();
  const double x = p.x() * w, y = p.y() * w;
  const Eigen::Vector2d pixel(fx * x + skew * y + cx, fy * y + cy);
  if (!pixel.allFinite()) return {};
  if (J_point != nullptr) {
    *J_point << fx * w, skew * w, -(fx * x + skew * y) * w,  //
        0.0, fy * w, -fy * y * w;
  }
  if (J_params != nullptr) {
    *J_params << x, 0.0, 1.0, 0.0, y,  //
        0.0, y, 0.0, 1.0, 0.0;
  }
  return {pixel, true};
}

Unprojection PinholeCamera::unproject(const Eigen::Vector2d& pixel) const {
  const double y = (pixel.y() - cy) / fy;
  const double x = (pixel.x() - cx - skew * y) / fx;
  const Eigen::Vector3d ray(x, y, 1.0);
  const double length = ray.norm();
  if (!std::isfinite(length)) return {};
  return {ray / length, true};
}

Eigen::VectorXd PinholeCamera::parameters() const {
  Eigen::VectorXd values(kParameters);
  values << fx, fy, cx, cy, skew;
  return values;
}

void PinholeCamera::set_parameters(const Eigen::VectorXd& values) {
  assert(values.size() == kParameters);
  fx = values[0];
  fy = values[1];
  cx = values[2];
  cy = values[3];
  skew = values[4];
}

}  // namespace tread
