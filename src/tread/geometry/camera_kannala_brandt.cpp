// Kannala-Brandt (equidistant with four terms). With q = theta^2 the image radius grows where
// 1 + 3 k1 q + 5 k2 q^2 + 7 k3 q^3 + 9 k4 q^4 > 0 from 0 to q.
#include <cassert>
#include <cmath>
#include <numbers>

#include "tread/geometry/camera.hpp"
#include "tread/geometry/positive_polynomial.hpp"

namespace tread {
namespace {

using internal::Polynomial;

Polynomial<5> radius_terms(const std::array<double, 4>& k) {
  return {1.0, k[0], k[1], k[2], k[3]};
}

Polynomial<5> slope_terms(const std::array<double, 4>& k) {
  return {1.0, 3.0 * k[0], 5.0 * k[1], 7.0 * k[2], 9.0 * k[3]};
}

// The theta of an image radius: Newton's steps, halving the bracket where they leave it. NaN if
// the radius is beyond the domain.
double theta_of_radius(const std::array<double, 4>& k, double radius) {
  const Polynomial<5> terms = radius_terms(k), slopes = slope_terms(k);
  double low = 0.0, high = std::numbers::pi;
  double theta = std::min(radius, high);
  constexpr int kIterations = 100;
  for (int i = 0; i < kIterations; ++i) {
    const double q = theta * theta;
    const bool inside = internal::positive_up_to(slopes, q);
    const double error = theta * internal::evaluate(terms, q) - radius;
    (!inside || error > 0.0 ? high : low) = theta;
    double next = theta - error / internal::evaluate(slopes, q);
    if (!inside || !(next >= low && next <= high)) next = 0.5 * (low + high);
    if (next == theta) break;
    theta = next;
  }
  const double q = theta * theta;
  const double error = std::abs(theta * internal::evaluate(terms, q) - radius);
  const bool solved = error <= 1e-13 * (1.0 + radius) && internal::positive_up_to(slopes, q);
  return solved ? theta : std::nan("");
}

}  // namespace

Projection KannalaBrandtCamera::project(const Eigen::Vector3d& p, PointJacobian* J_point,
                                        ParameterJacobian* J_params) const {
  if (J_point != nullptr) J_point->setZero();
  if (J_params != nullptr) J_params->setZero(2, kParameters);
  const double rho = std::hypot(p.x(), p.y());
  const double distance2 = p.squaredNorm();
  if (!std::isfinite(distance2) || !(distance2 > 0.0)) return {};
  if (rho == 0.0 && p.z() < 0.0) return {};  // straight behind lies on a ring, not on a pixel

  const double theta = std::atan2(rho, p.z());
  const double q = theta * theta;
  const Polynomial<5> slopes = slope_terms(k);
  if (!internal::positive_up_to(slopes, q)) return {};
  const double theta_d = theta * internal::evaluate(radius_terms(k), q);
  const double c = rho > 0.0 ? p.x() / rho : 1.0;  // cos(phi), sin(phi)
  const double s = rho > 0.0 ? p.y() / rho : 0.0;

  if (J_point != nullptr) {
    const double slope = internal::evaluate(slopes, q);
    const double along = slope * p.z() / distance2;  // d theta_d / d rho
    const double across = rho > 0.0 ? theta_d / rho : 1.0 / p.z();
    const double depth = -slope * rho / distance2;  // d theta_d / d Z
    *J_point << fx * (c * c * along + s * s * across), fx * c * s * (along - across),
        fx * c * depth,  //
        fy * c * s * (along - across), fy * (s * s * along + c * c * across), fy * s * depth;
  }
  if (J_params != nullptr) {
    J_params->leftCols<4>() << theta_d * c, 0.0, 1.0, 0.0, 0.0, theta_d * s, 0.0, 1.0;
    double power = theta;
    for (int i = 0; i < 4; ++i) {
      power *= q;
      J_params->col(4 + i) << fx * c * power, fy * s * power;
    }
  }
  return {{fx * theta_d * c + cx, fy * theta_d * s + cy}, true};
}

Unprojection KannalaBrandtCamera::unproject(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d m((pixel.x() - cx) / fx, (pixel.y() - cy) / fy);
  const double radius = m.norm();
  if (!std::isfinite(radius)) return {};
  if (radius == 0.0) return {Eigen::Vector3d::UnitZ(), true};
  const double theta = theta_of_radius(k, radius);
  if (!std::isfinite(theta)) return {};
  const Eigen::Vector2d side = std::sin(theta) / radius * m;
  return {Eigen::Vector3d(side.x(), side.y(), std::cos(theta)), true};
}

Eigen::VectorXd KannalaBrandtCamera::parameters() const {
  Eigen::VectorXd values(kParameters);
  values << fx, fy, cx, cy, k[0], k[1], k[2], k[3];
  return values;
}

void KannalaBrandtCamera::set_parameters(const Eigen::VectorXd& values) {
  assert(values.size() == kParameters);
  fx = values[0];
  fy = values[1];
  cx = values[2];
  cy = values[3];
  for (std::size_t i = 0; i < 4; ++i) k[i] = values[static_cast<Eigen::Index>(4 + i)];
}

double KannalaBrandtCamera::largest_theta() const {
  constexpr double kFullCircle = std::numbers::pi * std::numbers::pi;
  const double q = internal::first_sign_change(slope_terms(k), kFullCircle);
  return std::min(std::sqrt(q), std::numbers::pi);
}

}  // namespace tread
