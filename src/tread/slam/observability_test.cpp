#include "tread/slam/observability.hpp"

#include <gtest/gtest.h>

namespace tread {
namespace {

// Points of a plane z = depth seen from the origin: sums of [n, q x n]^T [n, q x n].
Matrix6d plane_information(double depth_m, const Eigen::Vector3d& n, double per_point) {
  Matrix6d sum = Matrix6d::Zero();
  for (int y = -50; y <= 50; ++y) {
    for (int x = -50; x <= 50; ++x) {
      const Eigen::Vector3d q(0.01 * x * depth_m, 0.01 * y * depth_m, depth_m);
      Vector6d J;
      J << n, q.cross(n);
      sum += per_point * J * J.transpose();
    }
  }
  return sum;
}

TEST(Observability, APlaneTellsThreeDirectionsOfSix) {
  const double sigma = 0.003;
  const Matrix6d information =
      plane_information(1.2, -Eigen::Vector3d::UnitZ(), 1 / (sigma * sigma));
  const Observability found = find_observability(information, 1.2, {});
  ASSERT_EQ(found.unknown.cols(), 3);
  EXPECT_FALSE(found.all_known());
  // Ways along the plane and the turn about its normal are unknown; the rest is not.
  const auto unknown_part = [&](const Vector6d& v) {
    return (found.unknown.transpose() * v.normalized()).norm();
  };
  EXPECT_NEAR(unknown_part((Vector6d() << 1, 0, 0, 0, 0, 0).finished()), 1.0, 0.3);
  EXPECT_NEAR(unknown_part((Vector6d() << 0, 0, 0, 0, 0, 1).finished()), 1.0, 1e-6);
  EXPECT_NEAR(unknown_part((Vector6d() << 0, 0, 1, 0, 0, 0).finished()), 0.0, 1e-6);
}

TEST(Observability, ThreePlanesTellAll) {
  const double w = 1.0 / (0.003 * 0.003);
  Matrix6d sum = Matrix6d::Zero();
  for (const Eigen::Vector3d& n : {Eigen::Vector3d(0, 0, -1), Eigen::Vector3d(-0.8, 0, -0.6),
                                   Eigen::Vector3d(0, -0.8, -0.6)}) {
    sum += plane_information(1.2, n, w);
  }
  const Observability found = find_observability(sum, 1.2, {});
  EXPECT_TRUE(found.all_known());
  EXPECT_LT(found.worst_m, 0.002);
}

TEST(Observability, NothingTellsNothing) {
  const Observability found = find_observability(Matrix6d::Zero(), 1.0, {});
  EXPECT_EQ(found.unknown.cols(), 6);
  EXPECT_TRUE(std::isinf(found.worst_m));
  const Observability noise = find_observability(-Matrix6d::Identity(), 1.0, {});
  EXPECT_EQ(noise.unknown.cols(), 6);
}

}  // namespace
}  // namespace tread
