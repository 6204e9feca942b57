#include "tread/geometry/camera.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

namespace tread {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kPi = std::numbers::pi;

std::vector<PinholeCamera> pinholes() {
  return {{333.3, 333.3, 319.5, 239.5, 0.0}, {700.0, 650.0, 300.0, 260.0, 1.7}};
}

BrownCamera brown(std::array<double, 5> K, std::array<double, 5> P, std::array<double, 3> D) {
  return {{458.7, 457.3, 367.2, 248.4, 0.0}, 0.0, 0.0, K, P, D};
}

std::vector<BrownCamera> browns() {
  std::vector<BrownCamera> cameras = {
      brown({}, {}, {}),
      brown({-0.2834, 0.0739}, {1.76e-05, 1.94e-4}, {}),           // a usual barrel lens
      brown({0.15, 0.02, 0.01}, {-1e-3, 2e-3}, {}),                // pincushion
      brown({-0.5}, {}, {}),                                       // folds at r = 0.816
      brown({0.8, -0.2, 0.05}, {3e-4, -2e-4}, {1.1, -0.1, 0.03}),  // rational
      brown({0.0, 0.3, -0.5, 0.1, -0.02}, {1e-3, 1e-3, 0.5, -0.1, 0.02}, {}),
  };
  BrownCamera all = brown({-0.2, 0.08, -0.02, 0.004, -0.0005}, {2e-3, -1e-3, 0.3, 0.1, -0.05},
                          {0.05, 0.02, 0.01});
  all.pinhole.skew = -2.5;
  all.lx = 0.03;
  all.ly = -0.02;
  cameras.push_back(all);
  return cameras;
}

std::vector<KannalaBrandtCamera> wide_cameras() {
  return {{190.9, 190.8, 254.9, 256.8, {}},
          {190.9, 190.8, 254.9, 256.8, {0.00348, 0.000715, -0.00205, 0.000203}},
          {300.0, 310.0, 320.0, 240.0, {-0.05, 0.01, -0.02, 0.001}},
          {300.0, 310.0, 320.0, 240.0, {0.1, 0.05, 0.02, 0.01}}};
}

// Points in front of the camera, near the axis and far from it.
std::vector<Vector3d> points_in_front() {
  std::vector<Vector3d> points;
  for (double z : {0.3, 2.0}) {
    for (double x : {-0.9, -0.31, 0.0, 0.002, 0.4, 0.77}) {
      for (double y : {-0.62, 0.0, 0.003, 0.35}) points.push_back({x * z, y * z, z});
    }
  }
  return points;
}

// Derivative by a five point stencil: error h^4.
template <class F>
Vector2d numeric_derivative(const F& f, double h) {
  return (8.0 * (f(h) - f(-h)) - (f(2.0 * h) - f(-2.0 * h))) / (12.0 * h);
}

template <class Camera>
int check_jacobians(const Camera& camera, const std::vector<Vector3d>& points) {
  int checked = 0;
  for (const Vector3d& p : points) {
    PointJacobian J_point;
    ParameterJacobian J_params;
    const Projection at = camera.project(p, &J_point, &J_params);
    if (!at.valid) {
      EXPECT_TRUE(J_point.isZero(0.0) && J_params.isZero(0.0));
      continue;
    }
    ++checked;
    EXPECT_EQ(at.pixel, camera.project(p).pixel);
    for (int i = 0; i < 3; ++i) {
      const auto moved = [&](double h) { return camera.project(p + h * Vector3d::Unit(i)).pixel; };
      const Vector2d numeric = numeric_derivative(moved, 1e-4 * p.norm());
      EXPECT_LT((numeric - J_point.col(i)).norm(), 1e-6 * (1.0 + numeric.norm()))
          << "point " << p.transpose() << " axis " << i;
    }
    EXPECT_EQ(J_params.cols(), Camera::kParameters);
    for (int i = 0; i < Camera::kParameters; ++i) {
      const auto moved = [&](double h) {
        VectorXd values = camera.parameters();
        values[i] += h;
        Camera changed = camera;
        changed.set_parameters(values);
        return changed.project(p).pixel;
      };
      const Vector2d numeric = numeric_derivative(moved, 1e-4);
      EXPECT_LT((numeric - J_params.col(i)).norm(), 1e-6 * (1.0 + numeric.norm()))
          << "point " << p.transpose() << " parameter " << i;
    }
  }
  return checked;
}

TEST(Camera, PinholeJacobians) {
  for (const PinholeCamera& camera : pinholes()) {
    EXPECT_EQ(check_jacobians(camera, points_in_front()), 48);
  }
}

TEST(Camera, BrownJacobians) {
  for (const BrownCamera& camera : browns()) {
    EXPECT_GE(check_jacobians(camera, points_in_front()), 30);
  }
}

TEST(Camera, KannalaBrandtJacobiansAlsoBehindTheImagePlane) {
  std::vector<Vector3d> points = points_in_front();
  for (double z : {0.0, -0.3}) {
    points.insert(points.end(), {{0.5, 0.4, z}, {-0.7, 0.1, z}, {0.0, 0.9, z}});
  }
  int checked = 0;
  for (const KannalaBrandtCamera& camera : wide_cameras()) {
    checked += check_jacobians(camera, points);
  }
  EXPECT_GE(checked, 4 * 48 + 12);
}

TEST(Camera, BrownIsOpenCVsModelWithTheTangentialTermsExchanged) {
  const double k1 = 0.4, k2 = -0.11, p1 = 3e-3, p2 = -2e-3, k3 = 0.02;
  const double k4 = 0.3, k5 = 0.05, k6 = -0.01;
  BrownCamera camera = brown({k1, k2, k3}, {p2, p1}, {k4, k5, k6});
  for (const Vector3d& p : points_in_front()) {
    const double x = p.x() / p.z(), y = p.y() / p.z();
    const double r2 = x * x + y * y, r4 = r2 * r2, r6 = r4 * r2;
    const double radial = (1 + k1 * r2 + k2 * r4 + k3 * r6) / (1 + k4 * r2 + k5 * r4 + k6 * r6);
    const double xd = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x);
    const double yd = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y;
    const Projection at = camera.project(p);
    ASSERT_TRUE(at.valid);
    EXPECT_NEAR(at.pixel.x(), camera.pinhole.fx * xd + camera.pinhole.cx, 1e-10);
    EXPECT_NEAR(at.pixel.y(), camera.pinhole.fy * yd + camera.pinhole.cy, 1e-10);
  }
}

TEST(Camera, KannalaBrandtFollowsItsFormula) {
  for (const KannalaBrandtCamera& camera : wide_cameras()) {
    for (double theta = 0.05; theta < camera.largest_theta() && theta < 3.0; theta += 0.1) {
      for (double phi : {-2.5, -0.3, 0.0, 1.0, 3.0}) {
        const Vector3d p(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi),
                         std::cos(theta));
        double theta_d = theta;
        for (int i = 0; i < 4; ++i) {
          theta_d += camera.k[static_cast<std::size_t>(i)] * std::pow(theta, 2 * i + 3);
        }
        const Projection at = camera.project(2.5 * p);
        ASSERT_TRUE(at.valid);
        EXPECT_NEAR(at.pixel.x(), camera.fx * theta_d * std::cos(phi) + camera.cx, 1e-9);
        EXPECT_NEAR(at.pixel.y(), camera.fy * theta_d * std::sin(phi) + camera.cy, 1e-9);
      }
    }
  }
}

// Every pixel that has a bearing is where that bearing is projected to.
template <class Camera>
int check_pixel_round_trip(const Camera& camera) {
  int valid = 0;
  for (int v = -20; v <= 500; v += 26) {
    for (int u = -20; u <= 780; u += 25) {
      const Vector2d pixel(u, v);
      const Unprojection ray = camera.unproject(pixel);
      if (!ray.valid) continue;
      ++valid;
      EXPECT_NEAR(ray.bearing.norm(), 1.0, 1e-14);
      const Projection back = camera.project(3.0 * ray.bearing);
      EXPECT_TRUE(back.valid) << pixel.transpose();
      EXPECT_LT((back.pixel - pixel).norm(), 1e-9) << pixel.transpose();
    }
  }
  return valid;
}

TEST(Camera, UnprojectedPixelsProjectBack) {
  constexpr int kPixels = 21 * 33;
  for (const PinholeCamera& camera : pinholes()) {
    EXPECT_EQ(check_pixel_round_trip(camera), kPixels);
  }
  for (const BrownCamera& camera : browns()) EXPECT_GT(check_pixel_round_trip(camera), 250);
  for (const KannalaBrandtCamera& camera : wide_cameras()) {
    EXPECT_GT(check_pixel_round_trip(camera), 250);
  }
}

TEST(Camera, ProjectedBearingsComeBackOverTheWholeDomain) {
  int checked = 0;
  for (const BrownCamera& camera : browns()) {
    const double end = std::min(2.0, 0.98 * camera.largest_radius());
    for (double r = 0.0; r < end; r += 0.05) {
      for (double phi = 0.1; phi < 2.0 * kPi; phi += 0.7) {
        const Vector3d bearing =
            Vector3d(camera.lx + r * std::cos(phi), camera.ly + r * std::sin(phi), 1.0)
                .normalized();
        const Projection at = camera.project(bearing);
        if (!at.valid) continue;  // folded by the tangential terms
        const Unprojection back = camera.unproject(at.pixel);
        ++checked;
        ASSERT_TRUE(back.valid) << "r " << r << " phi " << phi;
        EXPECT_LT((back.bearing - bearing).norm(), 1e-10) << "r " << r << " phi " << phi;
      }
    }
  }
  EXPECT_GT(checked, 1000);
  for (const KannalaBrandtCamera& camera : wide_cameras()) {
    for (double theta = 0.0; theta < 0.98 * camera.largest_theta(); theta += 0.04) {
      const Vector3d bearing(std::sin(theta) * 0.6, std::sin(theta) * -0.8, std::cos(theta));
      const Unprojection back = camera.unproject(camera.project(bearing).pixel);
      ASSERT_TRUE(back.valid) << theta;
      EXPECT_LT((back.bearing - bearing).norm(), 1e-10) << theta;
    }
  }
}

TEST(Camera, LargestRadiusOfKnownPolynomials) {
  EXPECT_EQ(brown({}, {}, {}).largest_radius(), kInfinity);
  EXPECT_EQ(brown({0.1, 0.2}, {}, {}).largest_radius(), kInfinity);
  // (r - r^3 / 2)' = 0 at r = sqrt(2/3)
  EXPECT_NEAR(brown({-0.5}, {}, {}).largest_radius(), std::sqrt(2.0 / 3.0), 1e-12);
  // r / (1 + r^2 / 2) is largest at sqrt(2); r / (1 - r^2) grows up to its pole
  EXPECT_NEAR(brown({}, {}, {0.5}).largest_radius(), std::sqrt(2.0), 1e-12);
  EXPECT_NEAR(brown({}, {}, {-1.0}).largest_radius(), 1.0, 1e-12);
  // 1 - 3 s + 5 b s^2 with a dip that stays above zero, and one that does not
  EXPECT_EQ(brown({-1.0, 0.4501}, {}, {}).largest_radius(), kInfinity);
  EXPECT_NEAR(brown({-1.0, 0.4499}, {}, {}).largest_radius(),
              std::sqrt((3.0 - std::sqrt(0.002)) / 4.499), 1e-10);
}

TEST(Camera, LargestThetaOfKnownPolynomials) {
  EXPECT_EQ((KannalaBrandtCamera{1, 1, 0, 0, {}}.largest_theta()), kPi);
  const KannalaBrandtCamera folds{1, 1, 0, 0, {-1.0 / 3.0, 0, 0, 0}};
  EXPECT_NEAR(folds.largest_theta(), 1.0, 1e-12);
  EXPECT_TRUE(folds.project({std::sin(0.999), 0, std::cos(0.999)}).valid);
  EXPECT_FALSE(folds.project({std::sin(1.001), 0, std::cos(1.001)}).valid);
  EXPECT_FALSE(folds.unproject({0.7, 0.0}).valid);  // the largest image radius is 2/3
  EXPECT_TRUE(folds.unproject({0.66, 0.0}).valid);
}

TEST(Camera, DomainEndsWhereADenseScanSeesTheRadiusShrink) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  int finite = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const BrownCamera camera = brown({uniform(random), uniform(random), 0.3 * uniform(random)}, {},
                                     {uniform(random), 0.5 * uniform(random), 0.0});
    const auto radial = [&camera](double r) {
      const double s = r * r;
      const double Q = 1 + camera.D[0] * s + camera.D[1] * s * s;
      return Q > 0.0 ? r * (1 + s * (camera.K[0] + s * (camera.K[1] + s * camera.K[2]))) / Q
                     : -kInfinity;
    };
    const double step = 1e-4;
    double scanned = step;
    while (scanned < 3.0 && radial(scanned + step) > radial(scanned)) scanned += step;
    const double border = camera.largest_radius();
    if (scanned >= 3.0) {
      EXPECT_GT(border, 3.0 - 2.0 * step);
      continue;
    }
    ++finite;
    // The scan steps over dips narrower than its step, never the other way round.
    EXPECT_NEAR(border, scanned, 2.0 * step);
    EXPECT_TRUE(camera.project({border * (1 - 1e-9), 0.0, 1.0}).valid);
    EXPECT_FALSE(camera.project({0.0, border * (1 + 1e-9), 1.0}).valid);
  }
  EXPECT_GT(finite, 100);
}

TEST(Camera, PointsOutsideTheDomainAreFlagged) {
  const double nan = std::nan("");
  for (const CameraModel& camera :
       {CameraModel(pinholes()[0]), CameraModel(browns()[1]), CameraModel(browns()[6])}) {
    EXPECT_FALSE(project(camera, {0.1, 0.1, 0.0}).valid);
    EXPECT_FALSE(project(camera, {0.1, 0.1, -1.0}).valid);
    EXPECT_FALSE(project(camera, {nan, 0.0, 1.0}).valid);
    EXPECT_FALSE(project(camera, {0.0, 0.0, nan}).valid);
    EXPECT_FALSE(project(camera, {kInfinity, 0.0, 1.0}).valid);
    EXPECT_FALSE(project(camera, {1.0, 0.0, 1e-320}).valid);
    EXPECT_FALSE(unproject(camera, {nan, 0.0}).valid);
    EXPECT_FALSE(unproject(camera, {0.0, kInfinity}).valid);
  }
  const CameraModel wide = wide_cameras()[0];
  EXPECT_FALSE(project(wide, {0.0, 0.0, -1.0}).valid);
  EXPECT_FALSE(project(wide, {0.0, 0.0, 0.0}).valid);
  EXPECT_FALSE(project(wide, {nan, 0.0, 1.0}).valid);
  EXPECT_FALSE(project(wide, {0.0, kInfinity, 1.0}).valid);
  EXPECT_FALSE(unproject(wide, {nan, 0.0}).valid);
  EXPECT_FALSE(unproject(wide, {254.9 + 191.0 * 3.2, 256.8}).valid);  // beyond 180 degrees
  EXPECT_TRUE(unproject(wide, {254.9, 256.8}).bearing.isApprox(Vector3d::UnitZ()));
}

TEST(Camera, TangentialTermsThatFoldTheImageEndTheDomain) {
  // With x_d = x + 3 P1 x^2 on the row y = 0, the image folds at x = -1 / (6 P1).
  const BrownCamera camera = brown({}, {0.5}, {});
  EXPECT_TRUE(camera.project({-0.30, 0.0, 1.0}).valid);
  EXPECT_FALSE(camera.project({-0.34, 0.0, 1.0}).valid);
}

TEST(Camera, UnprojectRefusesPixelsThatNoBearingReaches) {
  const BrownCamera folds = brown({-0.5}, {}, {});
  const double reach = std::sqrt(2.0 / 3.0) * 2.0 / 3.0;  // largest distorted radius
  const PinholeCamera& k = folds.pinhole;
  EXPECT_TRUE(folds.unproject({k.cx + 0.999 * reach * k.fx, k.cy}).valid);
  EXPECT_FALSE(folds.unproject({k.cx + 1.001 * reach * k.fx, k.cy}).valid);
  EXPECT_FALSE(folds.unproject({1e9, 1e9}).valid);
  BrownCamera nowhere = folds;
  nowhere.K[0] = std::nan("");
  EXPECT_FALSE(nowhere.unproject({k.cx + 1.0, k.cy}).valid);
}

TEST(Camera, ParametersGoThereAndBack) {
  const auto check = [](auto camera) {
    const VectorXd values = VectorXd::LinSpaced(decltype(camera)::kParameters, 1.0, 9.0);
    camera.set_parameters(values);
    EXPECT_EQ(camera.parameters(), values);
  };
  check(PinholeCamera{});
  check(BrownCamera{});
  check(KannalaBrandtCamera{});
}

TEST(Camera, PinholePartOfEachModel) {
  EXPECT_EQ(pinhole_of(pinholes()[1]).skew, 1.7);
  EXPECT_EQ(pinhole_of(browns()[6]).skew, -2.5);
  const PinholeCamera wide = pinhole_of(wide_cameras()[2]);
  EXPECT_EQ(wide.parameters(), (PinholeCamera{300.0, 310.0, 320.0, 240.0, 0.0}.parameters()));
}

TEST(Camera, ScaledKeepsTheCornersOfTheImage) {
  const Vector3d p(0.2, -0.1, 0.9);
  for (const CameraModel& camera :
       {CameraModel(pinholes()[1]), CameraModel(browns()[6]), CameraModel(wide_cameras()[1])}) {
    for (double factor : {0.5, 0.25, 2.0}) {
      const Vector2d full = project(camera, p).pixel;
      const Vector2d small = project(scaled(camera, factor), p).pixel;
      const Vector2d expected = (full.array() + 0.5) * factor - 0.5;
      EXPECT_LT((small - expected).norm(), 1e-10);
    }
  }
}

TEST(Camera, CheckNamesTheParameterAndTheRemedy) {
  EXPECT_TRUE(check_camera(pinholes()[0], "left"));
  PinholeCamera flat = pinholes()[0];
  flat.fy = 0.0;
  EXPECT_EQ(check_camera(flat, "left").error().message(),
            "left.fy: focal length is 0. Write the focal length in pixels, above 0.");
  flat.fy = -3.0;
  EXPECT_EQ(check_camera(flat, "left").error().what, "focal length is negative");
  BrownCamera bent = browns()[6];
  EXPECT_TRUE(check_camera(bent, "left"));
  bent.P[3] = kInfinity;
  EXPECT_EQ(check_camera(bent, "right").error().where, "right.P4");
  bent = browns()[6];
  bent.D[2] = std::nan("");
  EXPECT_EQ(check_camera(bent, "right").error().where, "right.D3");
  KannalaBrandtCamera wide = wide_cameras()[0];
  EXPECT_TRUE(check_camera(wide, "cam"));
  wide.k[3] = std::nan("");
  EXPECT_EQ(check_camera(wide, "cam").error().where, "cam.k4");
}

}  // namespace
}  // namespace tread
