// Camera models: where a point in front of the camera lands in the image, and back.
//
// Points are in camera optical axes: x right, y down, z forward, metres. Pixels are (u, v), u to
// the right, v down; (0, 0) is the centre of the top left pixel. A model is a plain struct;
// CameraModel is a variant of them, without virtual calls.
//
// Every model M has
//   Projection project(p, J_point*, J_params*)  pixel, and whether p is in the model's domain
//   Unprojection unproject(pixel)               unit bearing, and whether the pixel has one
//   parameters() / set_parameters()             the vector that J_params refers to
// project() is valid only where the model is one-to-one: there unproject(project(p)) is p / |p|.
// Elsewhere, and for what is not finite, the pixel and the Jacobians are zero.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <variant>

#include "tread/core/result.hpp"

namespace tread {

struct Projection {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  bool valid = false;  // in front of the camera and inside the model's one-to-one domain; the
                       // image border does not matter here
};

struct Unprojection {
  Eigen::Vector3d bearing = Eigen::Vector3d::UnitZ();  // unit length
  bool valid = false;
};

using PointJacobian = Eigen::Matrix<double, 2, 3>;  // d pixel / d point
using ParameterJacobian = Eigen::Matrix<double, 2, Eigen::Dynamic>;

struct ImageSize {
  int width = 0;
  int height = 0;
  [[nodiscard]] bool operator==(const ImageSize&) const = default;
};

// u = fx x + skew y + cx, v = fy y + cy, with (x, y) = (X/Z, Y/Z). Valid for Z > 0.
// Parameters: fx fy cx cy skew.
struct PinholeCamera {
  static constexpr int kParameters = 5;
  double fx = 0.0, fy = 0.0, cx = 0.0, cy = 0.0, skew = 0.0;

  [[nodiscard]] Projection project(const Eigen::Vector3d& p, PointJacobian* J_point = nullptr,
                                   ParameterJacobian* J_params = nullptr) const;
  [[nodiscard]] Unprojection unproject(const Eigen::Vector2d& pixel) const;
  [[nodiscard]] Eigen::VectorXd parameters() const;
  void set_parameters(const Eigen::VectorXd& values);
};

// Pinhole after Brown's distortion with a lens centre (lx, ly), up to the ten terms of paper Q
// (K1..K5, P1..P5), used in the forward direction, and an optional rational denominator:
//   d = (x - lx, y - ly), r^2 = |d|^2
//   radial = (K1 r^2 + ... + K5 r^10), ratio = (1 + radial) / (1 + D1 r^2 + D2 r^4 + D3 r^6)
//   x_d = lx + d_x ratio + (P1 (r^2 + 2 d_x^2) + 2 P2 d_x d_y)(1 + P3 r^2 + P4 r^4 + P5 r^6)
//   y_d = ly + d_y ratio + (P2 (r^2 + 2 d_y^2) + 2 P1 d_x d_y)(1 + P3 r^2 + P4 r^4 + P5 r^6)
//   u = fx x_d + skew y_d + cx, v = fy y_d + cy
// NOTE the order of P1 and P2 is Brown's; OpenCV's (k1 k2 p1 p2 k3 k4 k5 k6) is
// K1 = k1, K2 = k2, P2 = p1, P1 = p2, K3 = k3, D1..D3 = k4..k6.
// Valid for Z > 0, r within the radius up to which the radial part grows, and where the tangential
// terms do not fold the image (the determinant of the distortion is positive).
// Parameters: fx fy cx cy skew lx ly K1..K5 P1..P5 D1..D3.
struct BrownCamera {
  static constexpr int kParameters = 20;
  PinholeCamera pinhole;
  double lx = 0.0, ly = 0.0;
  std::array<double, 5> K{};
  std::array<double, 5> P{};
  std::array<double, 3> D{};

  [[nodiscard]] Projection project(const Eigen::Vector3d& p, PointJacobian* J_point = nullptr,
                                   ParameterJacobian* J_params = nullptr) const;
  [[nodiscard]] Unprojection unproject(const Eigen::Vector2d& pixel) const;
  [[nodiscard]] Eigen::VectorXd parameters() const;
  void set_parameters(const Eigen::VectorXd& values);
  // Largest r at which the radial part still grows (infinity if it does up to 1e6). A few us.
  [[nodiscard]] double largest_radius() const;
};

// Kannala and Brandt 2006, the four-term form that OpenCV calls fisheye and Kalibr equidistant:
//   theta = atan2(sqrt(X^2 + Y^2), Z)
//   theta_d = theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8)
//   u = fx theta_d cos(phi) + cx, v = fy theta_d sin(phi) + cy, phi = atan2(Y, X)
// Also valid beyond 90 degrees from the axis, as far as theta_d grows.
// Parameters: fx fy cx cy k1 k2 k3 k4.
struct KannalaBrandtCamera {
  static constexpr int kParameters = 8;
  double fx = 0.0, fy = 0.0, cx = 0.0, cy = 0.0;
  std::array<double, 4> k{};

  [[nodiscard]] Projection project(const Eigen::Vector3d& p, PointJacobian* J_point = nullptr,
                                   ParameterJacobian* J_params = nullptr) const;
  [[nodiscard]] Unprojection unproject(const Eigen::Vector2d& pixel) const;
  [[nodiscard]] Eigen::VectorXd parameters() const;
  void set_parameters(const Eigen::VectorXd& values);
  // Largest theta at which theta_d still grows, at most pi.
  [[nodiscard]] double largest_theta() const;
};

using CameraModel = std::variant<PinholeCamera, BrownCamera, KannalaBrandtCamera>;

[[nodiscard]] Projection project(const CameraModel& camera, const Eigen::Vector3d& p);
[[nodiscard]] Unprojection unproject(const CameraModel& camera, const Eigen::Vector2d& pixel);
// The pinhole part of any model (fx, fy, cx, cy, skew).
[[nodiscard]] PinholeCamera pinhole_of(const CameraModel& camera);
// Finite parameters and focal lengths above zero; `where` names the camera in the message.
[[nodiscard]] Status check_camera(const CameraModel& camera, const std::string& where);
// The model of the image shrunk by `factor` (0.5: half size), pixel centres on whole numbers.
[[nodiscard]] CameraModel scaled(const CameraModel& camera, double factor);

}  // namespace tread
