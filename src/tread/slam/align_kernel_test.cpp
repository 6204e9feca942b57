// The vectorised sums against the residual of one pixel or point, and that against its own slope.
#include "tread/slam/align_kernel.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "instruction_sets.hpp"

namespace tread {
namespace {

using Eigen::Vector3d;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double in(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  float float_in(double low, double high) { return static_cast<float>(in(low, high)); }
  bool chance(double p) { return in(0.0, 1.0) < p; }

 private:
  std::mt19937 engine_;
};

void set_motion(const Isometry3d& T, float* R, float* t) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) R[3 * i + j] = static_cast<float>(T.linear()(i, j));
    t[i] = static_cast<float>(T.translation()[i]);
  }
}

Isometry3d motion_of(const float* R, const float* t) {
  Isometry3d T = Isometry3d::Identity();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) T.linear()(i, j) = R[3 * i + j];
    T.translation()[i] = t[i];
  }
  return T;
}

Isometry3d random_motion(Random& random, double metres, double radians) {
  Vector6d twist;
  for (int i = 0; i < 6; ++i) twist[i] = (i < 3 ? metres : radians) * random.in(-1.0, 1.0);
  return se3_exp(twist);
}

// The sums by definition, and the same of absolute values: what rounding is measured by.
struct PlainSums {
  NormalEquations sums, size;

  void add(const Residual& one) {
    if (!(one.weight > 0.0F)) return;
    const Vector6d J = Eigen::Map<const Eigen::Matrix<float, 6, 1>>(one.J).cast<double>();
    const Vector6d K = Eigen::Map<const Eigen::Matrix<float, 6, 1>>(one.K).cast<double>();
    add_to(sums, J, K, one.r, one.weight);
    add_to(size, J.cwiseAbs(), K.cwiseAbs(), std::abs(one.r), one.weight);
  }
  void expect_equal(const NormalEquations& other, bool with_cross) const {
    EXPECT_EQ(other.count, sums.count);
    EXPECT_NEAR(other.error, sums.error, kRounding * size.error);
    EXPECT_NEAR(other.weight, sums.weight, kRounding * size.weight);
    expect_near(other.H, sums.H, size.H);
    expect_near(other.g, sums.g, size.g);
    expect_near(other.cross, with_cross ? sums.cross : Matrix6d(Matrix6d::Zero()), size.cross);
  }

 private:
  static constexpr double kRounding = 1e-5;
  static void expect_near(const Eigen::MatrixXd& is, const Eigen::MatrixXd& expected,
                          const Eigen::MatrixXd& scale) {
    EXPECT_TRUE(((is - expected).array().abs() <= kRounding * scale.array()).all())
        << is << "\nis not\n"
        << expected;
  }
  static void add_to(NormalEquations& to, const Vector6d& J, const Vector6d& K, double r,
                     double w) {
    to.H += w * J * J.transpose();
    to.g += w * r * J;
    to.cross += 0.5 * w * (J * K.transpose() + K * J.transpose());
    to.error += w * r * r;
    to.weight += w;
    ++to.count;
  }
};

// ---- depth

Vector3d normal_at(const DepthLevel& level, int x, int y) {
  return {level.normal[0](x, y), level.normal[1](x, y), level.normal[2](x, y)};
}

Vector3d point_of(const DepthLevel& level, double x, double y) {
  const Pinhole& c = level.camera;
  const double z = level.depth(static_cast<int>(x), static_cast<int>(y));
  return {(x - c.cx) / c.fx * z, (y - c.cy) / c.fy * z, z};
}

DepthLevel random_level(Random& random, int width, int height) {
  DepthLevel level;
  level.resize({random.float_in(25, 35), random.float_in(25, 35), random.float_in(15, 22),
                random.float_in(10, 16)},
               width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      level.depth(x, y) = random.chance(0.1)    ? kNan
                          : random.chance(0.05) ? 0.0F
                                                : random.float_in(1.0, 1.5);
      const Vector3d n =
          Vector3d(random.in(-1, 1), random.in(-1, 1), random.in(-2, -0.2)).normalized();
      const bool known = !random.chance(0.1);
      for (int i = 0; i < 3; ++i) {
        level.normal[static_cast<std::size_t>(i)](x, y) = known ? static_cast<float>(n[i]) : kNan;
      }
    }
  }
  return level;
}

// A frame and a model of another size, and how they are compared. Pixels for which rounding could
// decide whether they count, and with what, have no depth.
struct IcpCase {
  DepthLevel frame, model;
  IcpJob job;

  explicit IcpCase(unsigned seed) {
    Random random(seed);
    frame = random_level(random, 37, 23);
    model = random_level(random, 41, 29);
    job.frame = DepthView::of(frame);
    job.model = DepthView::of(model);
    set_motion(random_motion(random, 0.1, 0.1), job.R, job.t);
    job.gate_m = 0.2F;
    job.least_cosine = 0.6F;
    job.constant_m = 0.02F;
    job.quadratic_per_m = 0.01F;
    for (int y = 0; y < frame.height(); ++y) {
      for (int x = 0; x < frame.width(); ++x) {
        if (!is_sure(x, y)) frame.depth(x, y) = kNan;
      }
    }
  }
  // In the model's axes.
  [[nodiscard]] Vector3d point(int x, int y) const {
    return motion_of(job.R, job.t) * point_of(frame, x, y);
  }
  [[nodiscard]] Eigen::Vector2d pixel(const Vector3d& q) const {
    const Pinhole& c = model.camera;
    return {q.x() / q.z() * c.fx + c.cx, q.y() / q.z() * c.fy + c.cy};
  }

 private:
  [[nodiscard]] bool is_sure(int x, int y) const {
    const Vector3d q = point(x, y);
    if (!(q.z() > 0.1)) return false;
    const Eigen::Vector2d at = pixel(q);
    for (const double coordinate : at) {
      if (std::abs(coordinate - std::floor(coordinate) - 0.5) < 1e-3) return false;
    }
    const int u = static_cast<int>(std::lround(at.x())), v = static_cast<int>(std::lround(at.y()));
    if (u < 0 || v < 0 || u >= model.width() || v >= model.height()) return true;
    const double apart = (q - point_of(model, u, v)).norm();
    const double cosine =
        (motion_of(job.R, job.t).linear() * normal_at(frame, x, y)).dot(normal_at(model, u, v));
    return !(std::abs(apart - job.gate_m) < 1e-4) && !(std::abs(cosine - job.least_cosine) < 1e-4);
  }
};

TEST(AlignKernel, RowsAreTheSumsOfTheirPixels) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    const IcpCase c(seed);
    for (const auto& range : {std::pair(0, c.frame.height()), std::pair(3, 4)}) {
      const int first = range.first, last = range.second;
      PlainSums expected;
      int none = 0;
      for (int y = first; y < last; ++y) {
        for (int x = 0; x < c.frame.width(); ++x) {
          const Residual one = icp_residual(c.job, x, y);
          expected.add(one);
          if (!(one.weight > 0.0F)) ++none;
        }
      }
      if (first == 0) {
        ASSERT_GT(expected.sums.count, 50);
        ASSERT_GT(none, 50);
      }
      testing::on_every_target([&] {
        for (const bool with_cross : {true, false}) {
          NormalEquations sums;
          icp_rows(c.job, first, last, with_cross, sums);
          expected.expect_equal(sums, with_cross);
        }
      });
    }
  }
}

// r and its slopes from their definition in double precision, the pixel of the model held fast.
TEST(AlignKernel, DepthJacobianOfEachPixelIsItsSlope) {
  const IcpCase c(4);
  int checked = 0;
  for (int y = 0; y < c.frame.height(); ++y) {
    for (int x = 0; x < c.frame.width(); ++x) {
      const Residual one = icp_residual(c.job, x, y);
      if (!(one.weight > 0.0F)) continue;
      ++checked;
      const Vector3d q = c.point(x, y);
      const Eigen::Vector2d at = c.pixel(q);
      const int u = static_cast<int>(std::lround(at.x()));
      const int v = static_cast<int>(std::lround(at.y()));
      const Vector3d p = point_of(c.model, u, v), n = normal_at(c.model, u, v);
      const Vector3d own = motion_of(c.job.R, c.job.t).linear() * normal_at(c.frame, x, y);
      ASSERT_NEAR(one.r, n.dot(q - p), 1e-5);
      const double sigma =
          c.job.constant_m + c.job.quadratic_per_m * std::pow(c.frame.depth(x, y), 2);
      const double huber = std::min(1.0, c.job.huber * sigma / std::abs(n.dot(q - p)));
      ASSERT_NEAR(one.weight * sigma * sigma, huber, 1e-3);
      for (int k = 0; k < 6; ++k) {
        constexpr double kStep = 1e-5;
        const Vector6d step = kStep * Vector6d::Unit(k);
        const Vector3d change = (se3_exp(step) * q - se3_exp(-step) * q) / (2.0 * kStep);
        ASSERT_NEAR(one.J[k], n.dot(change), 1e-5) << "direction " << k;
        ASSERT_NEAR(one.K[k], own.dot(change), 1e-5) << "direction " << k;
      }
    }
  }
  EXPECT_GT(checked, 50);
}

// ---- intensity

struct PhotoCase {
  Image<float> image{31, 27}, gx{31, 27}, gy{31, 27};
  PhotoPoints points;
  PhotoJob job;

  PhotoCase() {
    job.image = image;
    job.image_gx = gx;
    job.image_gy = gy;
    job.camera = {28.0F, 30.0F, 14.6F, 13.2F};
    set_motion(Isometry3d::Identity(), job.R, job.t);
  }
  PhotoCase(const PhotoCase&) = delete;
  PhotoCase& operator=(const PhotoCase&) = delete;
  void add(const Vector3d& P, float intensity, float slope_x, float slope_y) {
    points.x.push_back(static_cast<float>(P.x()));
    points.y.push_back(static_cast<float>(P.y()));
    points.z.push_back(static_cast<float>(P.z()));
    points.intensity.push_back(intensity);
    points.gx.push_back(slope_x);
    points.gy.push_back(slope_y);
    job.points = PhotoPointsView::of(points);
  }
};

// Points of which some fall outside, some are behind the camera, and none near a border.
void fill(PhotoCase& c, unsigned seed, int count) {
  Random random(seed);
  for (int y = 0; y < c.image.height; ++y) {
    for (int x = 0; x < c.image.width; ++x) {
      c.image(x, y) = random.float_in(0.0, 255.0);
      c.gx(x, y) = random.float_in(-20.0, 20.0);
      c.gy(x, y) = random.float_in(-20.0, 20.0);
    }
  }
  const Isometry3d T = random_motion(random, 0.1, 0.1);
  set_motion(T, c.job.R, c.job.t);
  c.job.gain = random.float_in(0.8, 1.2);
  c.job.offset = random.float_in(-10.0, 10.0);
  c.job.sigma = 30.0F;
  while (c.points.size() < count) {
    Vector3d P(random.in(-1.0, 1.0), random.in(-1.0, 1.0), random.in(1.0, 2.0));
    if (random.chance(0.1)) P = -P;
    const Vector3d q = T * P;
    const double u = q.x() / q.z() * c.job.camera.fx + c.job.camera.cx;
    const double v = q.y() / q.z() * c.job.camera.fy + c.job.camera.cy;
    const auto at_border = [](double at, int size) {
      return std::abs(at) < 1e-3 || std::abs(at - size + 1) < 1e-3;
    };
    if (at_border(u, c.image.width) || at_border(v, c.image.height)) continue;
    c.add(P, random.float_in(0.0, 255.0), random.float_in(-20.0, 20.0),
          random.float_in(-20.0, 20.0));
  }
}

TEST(AlignKernel, PhotoSumsAreThoseOfTheirPoints) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    PhotoCase c;
    fill(c, seed, 501);
    for (const auto& range : {std::pair(0, 501), std::pair(3, 498), std::pair(7, 20)}) {
      const int first = range.first, last = range.second;
      PlainSums expected;
      PhotoSums more;
      for (int i = first; i < last; ++i) {
        const Residual one = photo_residual(c.job, i);
        expected.add(one);
        if (!(one.weight > 0.0F)) continue;
        const double key = c.job.points.intensity[i], w = one.weight;
        const double here = (one.r + key - c.job.offset) / c.job.gain;
        more.key += w * key;
        more.here += w * here;
        more.key_here += w * key * here;
        more.here_here += w * here * here;
        more.absolute += std::abs(one.r);
      }
      if (last - first > 100) {
        ASSERT_GT(expected.sums.count, 150);
        ASSERT_LT(expected.sums.count, 400);
      }
      testing::on_every_target([&] {
        for (const bool with_cross : {true, false}) {
          PhotoSums sums;
          photo_points(c.job, first, last, with_cross, sums);
          expected.expect_equal(sums.equations, with_cross);
          EXPECT_NEAR(sums.key, more.key, 1e-5 * more.key);
          EXPECT_NEAR(sums.here, more.here, 1e-5 * more.here);
          EXPECT_NEAR(sums.key_here, more.key_here, 1e-5 * more.key_here);
          EXPECT_NEAR(sums.here_here, more.here_here, 1e-5 * more.here_here);
          EXPECT_NEAR(sums.absolute, more.absolute, 1e-5 * more.absolute);
        }
      });
    }
  }
}

// On a ramp the keyframe's slope is that of the image everywhere, so that J is exact.
TEST(AlignKernel, IntensityJacobianOfEachPointIsItsSlope) {
  constexpr float kSlopeX = 1.75F, kSlopeY = -1.25F;  // a step of these is exact
  PhotoCase c;
  for (int y = 0; y < c.image.height; ++y) {
    for (int x = 0; x < c.image.width; ++x) {
      c.image(x, y) = 40.0F + kSlopeX * static_cast<float>(x) + kSlopeY * static_cast<float>(y);
      c.gx(x, y) = kSlopeX;
      c.gy(x, y) = kSlopeY;
    }
  }
  Random random(5);
  int checked = 0;
  for (int i = 0; i < 200; ++i) {
    const double z = random.in(1.0, 2.0);
    const Vector3d P(z * random.in(-0.45, 0.45), z * random.in(-0.4, 0.4), z);
    const auto residual = [&](const Vector3d& at) {
      c.points.clear();
      c.add(at, 40.0F, kSlopeX, kSlopeY);
      return photo_residual(c.job, 0);
    };
    const Residual one = residual(P);
    const double u = P.x() / z * c.job.camera.fx + c.job.camera.cx;
    const double v = P.y() / z * c.job.camera.fy + c.job.camera.cy;
    ASSERT_GT(one.weight, 0.0F);
    ASSERT_NEAR(one.r, kSlopeX * u + kSlopeY * v, 1e-4);
    ++checked;
    double largest = 0.0;
    for (const float slope : one.J) largest = std::max(largest, std::abs(double{slope}));
    for (int k = 0; k < 6; ++k) {
      constexpr double kStep = 3e-3;
      const Vector6d step = kStep * Vector6d::Unit(k);
      const Residual plus = residual(se3_exp(step) * P), minus = residual(se3_exp(-step) * P);
      ASSERT_TRUE(plus.weight > 0.0F && minus.weight > 0.0F);
      const double slope = (double{plus.r} - minus.r) / (2.0 * kStep);
      ASSERT_NEAR(one.J[k], slope, 1e-3 * largest) << "direction " << k;
      ASSERT_NEAR(one.K[k], one.J[k], 1e-5 * largest) << "the image's slope is the keyframe's";
    }
  }
  EXPECT_EQ(checked, 200);
}

TEST(AlignKernel, WhatDoesNotMeetCountsNothing) {
  PhotoCase c;
  fill(c, 1, 1);
  set_motion(Isometry3d::Identity(), c.job.R, c.job.t);
  const auto weight_at = [&](double x, double y, double z) {
    c.points.clear();
    c.add({x, y, z}, 0.0F, 1.0F, 1.0F);
    const Residual one = photo_residual(c.job, 0);
    if (one.weight == 0.0F) {
      EXPECT_EQ(one.r, 0.0F);
      for (int k = 0; k < 6; ++k) EXPECT_EQ(one.J[k], 0.0F);
    }
    return one.weight;
  };
  EXPECT_GT(weight_at(0, 0, 1), 0.0F);
  EXPECT_EQ(weight_at(0, 0, -1), 0.0F) << "behind";
  EXPECT_EQ(weight_at(0, 0, kNan), 0.0F);
  EXPECT_EQ(weight_at(1, 0, 1), 0.0F) << "outside";
  EXPECT_EQ(weight_at(0, -1, 1), 0.0F);
}

}  // namespace
}  // namespace tread
