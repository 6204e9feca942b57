// Brown's distortion with its derivatives. With s = r^2, N(s) = 1 + K1 s + ... + K5 s^5 and
// Q(s) = 1 + D1 s + D2 s^2 + D3 s^3 the radial part r N / Q grows where
//   h(s) = N Q + 2 s (N' Q - N Q') > 0 and Q > 0 from 0 to s,
// two polynomials, of degree 8 and 3. The tangential terms can fold the image inside that radius
// too: a point is also refused where the determinant of the distortion is not positive.
#include <Eigen/LU>
#include <cassert>
#include <cmath>

#include "tread/geometry/camera.hpp"
#include "tread/geometry/positive_polynomial.hpp"

namespace tread {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using internal::evaluate;
using internal::evaluate_derivative;
using internal::Polynomial;

struct RadialPart {
  Polynomial<6> N{};
  Polynomial<4> Q{};
  Polynomial<9> h{};  // sign of the derivative of r N / Q, as long as Q > 0

  explicit RadialPart(const BrownCamera& camera) {
    N[0] = Q[0] = 1.0;
    for (std::size_t i = 0; i < 5; ++i) N[i + 1] = camera.K[i];
    for (std::size_t j = 0; j < 3; ++j) Q[j + 1] = camera.D[j];
    for (std::size_t i = 0; i < N.size(); ++i) {
      for (std::size_t j = 0; j < Q.size(); ++j) {
        h[i + j] += N[i] * Q[j] * (1.0 + 2.0 * (static_cast<double>(i) - static_cast<double>(j)));
      }
    }
  }
  [[nodiscard]] bool grows_up_to(double s) const {
    return internal::positive_up_to(Q, s) && internal::positive_up_to(h, s);
  }
};

// The distortion at d = (x - lx, y - ly) and what its Jacobians are made of.
struct Distortion {
  double s, n, q, ratio;  // r^2, N, Q, N / Q
  double spread;          // 1 + P3 s + P4 s^2 + P5 s^3
  Vector2d tangential;    // without `spread`
  Vector2d distorted;     // (x_d, y_d)
  Matrix2d J;             // d distorted / d d
  bool one_to_one = false;
};

Distortion distort(const BrownCamera& camera, const RadialPart& radial, const Vector2d& d) {
  Distortion out{};
  const double s = d.squaredNorm();
  const Polynomial<4> spread_terms = {1.0, camera.P[2], camera.P[3], camera.P[4]};
  out.s = s;
  out.n = evaluate(radial.N, s);
  out.q = evaluate(radial.Q, s);
  out.ratio = out.n / out.q;
  out.spread = evaluate(spread_terms, s);
  const double P1 = camera.P[0], P2 = camera.P[1];
  const double xy2 = 2.0 * d.x() * d.y();
  out.tangential = {P1 * (s + 2.0 * d.x() * d.x()) + P2 * xy2,
                    P2 * (s + 2.0 * d.y() * d.y()) + P1 * xy2};
  out.distorted = Vector2d(camera.lx, camera.ly) + out.ratio * d + out.spread * out.tangential;

  const double ratio_slope =
      (evaluate_derivative(radial.N, s) - out.ratio * evaluate_derivative(radial.Q, s)) / out.q;
  const double spread_slope = evaluate_derivative(spread_terms, s);
  const double cross = 2.0 * (P1 * d.y() + P2 * d.x());
  Matrix2d J_tangential;
  J_tangential << 6.0 * P1 * d.x() + 2.0 * P2 * d.y(), cross,  //
      cross, 6.0 * P2 * d.y() + 2.0 * P1 * d.x();
  const Eigen::RowVector2d J_s = 2.0 * d.transpose();
  out.J = out.ratio * Matrix2d::Identity() + ratio_slope * d * J_s + out.spread * J_tangential +
          spread_slope * out.tangential * J_s;
  out.one_to_one = out.distorted.allFinite() && radial.grows_up_to(s) && out.J.determinant() > 0.0;
  return out;
}

// d (x_d, y_d) / d (lx, ly, K, P, D): columns 5 to 19 of the parameters.
Eigen::Matrix<double, 2, 15> distortion_jacobian(const Distortion& at, const Vector2d& d) {
  Eigen::Matrix<double, 2, 15> J;
  J.leftCols<2>() = Matrix2d::Identity() - at.J;
  double power = 1.0;
  for (int i = 0; i < 5; ++i) {
    power *= at.s;
    J.col(2 + i) = d * (power / at.q);
  }
  const double xy2 = 2.0 * d.x() * d.y();
  J.col(7) = at.spread * Vector2d(at.s + 2.0 * d.x() * d.x(), xy2);
  J.col(8) = at.spread * Vector2d(xy2, at.s + 2.0 * d.y() * d.y());
  power = 1.0;
  for (int i = 0; i < 3; ++i) {
    power *= at.s;
    J.col(9 + i) = at.tangential * power;
    J.col(12 + i) = d * (-at.ratio * power / at.q);
  }
  return J;
}

}  // namespace

Projection BrownCamera::project(const Eigen::Vector3d& p, PointJacobian* J_point,
                                ParameterJacobian* J_params) const {
  if (J_point != nullptr) J_point->setZero();
  if (J_params != nullptr) J_params->setZero(2, kParameters);
  if (!(p.z() > 0.0)) return {};
  const double w = 1.0 / p.z();
  const double x = p.x() * w, y = p.y() * w;
  const Vector2d d(x - lx, y - ly);
  const Distortion at = distort(*this, RadialPart(*this), d);
  if (!at.one_to_one) return {};

  Matrix2d A;  // d pixel / d distorted
  A << pinhole.fx, pinhole.skew, 0.0, pinhole.fy;
  const Vector2d pixel = A * at.distorted + Vector2d(pinhole.cx, pinhole.cy);
  if (!pixel.allFinite()) return {};
  if (J_point != nullptr) {
    Eigen::Matrix<double, 2, 3> J_normalised;
    J_normalised << w, 0.0, -x * w, 0.0, w, -y * w;
    *J_point = A * at.J * J_normalised;
  }
  if (J_params != nullptr) {
    J_params->leftCols<5>() << at.distorted.x(), 0.0, 1.0, 0.0, at.distorted.y(),  //
        0.0, at.distorted.y(), 0.0, 1.0, 0.0;
    J_params->rightCols<15>() = A * distortion_jacobian(at, d);
  }
  return {pixel, true};
}

Unprojection BrownCamera::unproject(const Vector2d& pixel) const {
  const double y_d = (pixel.y() - pinhole.cy) / pinhole.fy;
  const Vector2d target((pixel.x() - pinhole.cx - pinhole.skew * y_d) / pinhole.fx, y_d);
  if (!target.allFinite()) return {};

  // Newton's method that never leaves the one-to-one domain: there the distortion grows along
  // every ray, so that a shorter step always comes nearer if there is a solution.
  const RadialPart radial(*this);
  Vector2d d = target - Vector2d(lx, ly);
  Distortion at = distort(*this, radial, d);
  for (int halving = 0; halving < 60 && !at.one_to_one; ++halving) {
    d *= 0.5;
    at = distort(*this, radial, d);
  }
  if (!at.one_to_one) return {};
  constexpr int kIterations = 100;
  constexpr double kShortestStep = 1e-6;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const Vector2d residual = at.distorted - target;
    const Vector2d step = at.J.inverse() * residual;
    double fraction = 1.0;
    Distortion next{};
    for (; fraction > kShortestStep; fraction *= 0.5) {
      next = distort(*this, radial, d - fraction * step);
      if (next.one_to_one && (next.distorted - target).norm() < residual.norm()) break;
    }
    if (fraction <= kShortestStep) break;
    d -= fraction * step;
    at = next;
  }
  constexpr double kSolved = 1e-13;
  if ((at.distorted - target).norm() > kSolved * (1.0 + target.norm())) return {};
  return {Eigen::Vector3d(d.x() + lx, d.y() + ly, 1.0).normalized(), true};
}

Eigen::VectorXd BrownCamera::parameters() const {
  Eigen::VectorXd values(kParameters);
  values.head<5>() = pinhole.parameters();
  values.segment<2>(5) << lx, ly;
  values.segment<5>(7) = Eigen::Map<const Eigen::Matrix<double, 5, 1>>(K.data());
  values.segment<5>(12) = Eigen::Map<const Eigen::Matrix<double, 5, 1>>(P.data());
  values.segment<3>(17) = Eigen::Map<const Eigen::Vector3d>(D.data());
  return values;
}

void BrownCamera::set_parameters(const Eigen::VectorXd& values) {
  assert(values.size() == kParameters);
  pinhole.set_parameters(values.head<5>());
  lx = values[5];
  ly = values[6];
  Eigen::Map<Eigen::Matrix<double, 5, 1>>(K.data()) = values.segment<5>(7);
  Eigen::Map<Eigen::Matrix<double, 5, 1>>(P.data()) = values.segment<5>(12);
  Eigen::Map<Eigen::Vector3d>(D.data()) = values.segment<3>(17);
}

double BrownCamera::largest_radius() const {
  const RadialPart radial(*this);
  constexpr double kLimit = 1e12;  // of r^2: nothing is seen closer than 1e-6 rad to the plane
  return std::sqrt(std::min(internal::first_sign_change(radial.Q, kLimit),
                            internal::first_sign_change(radial.h, kLimit)));
}

}  // namespace tread
