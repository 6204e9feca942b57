#include "tread/robot/walker_model.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace tread {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

double across(const JointLimits& limits, int step, int steps) {
  return limits.low_rad + (limits.high_rad - limits.low_rad) * step / steps;
}

// Joints of a grid over the limits whose foot is below the hip: what METHODS calls exact.
template <class Body>
void over_the_workspace(const WalkerModelOptions& options, int leg, const Body& body) {
  constexpr int kSteps = 12;
  int visited = 0;
  for (int a = 0; a <= kSteps; ++a) {
    for (int b = 0; b <= kSteps; ++b) {
      for (int c = 0; c <= kSteps; ++c) {
        const Eigen::Vector3d q(across(joint_limits(options, leg, 0), a, kSteps),
                                across(joint_limits(options, leg, 1), b, kSteps),
                                across(joint_limits(options, leg, 2), c, kSteps));
        if (options.hip_m + options.upper_m * std::cos(q.y()) +
                options.lower_m * std::cos(q.y() + q.z()) <
            0.01) {
          continue;
        }
        body(q);
        ++visited;
      }
    }
  }
  EXPECT_GT(visited, 1000);
}

TEST(WalkerModel, TheHomePoseIsThatOfTheSource) {
  const WalkerModelOptions options;
  for (int leg = 0; leg < kLegs; ++leg) {
    const Eigen::Vector3d foot = foot_position(options, leg, joints_of_leg(home_joints(), leg));
    EXPECT_NEAR(foot.x(), is_front(leg) ? 0.367 : -0.367, 5e-4) << leg_name(leg);
    EXPECT_NEAR(foot.y(), is_left(leg) ? 0.323 : -0.323, 5e-4) << leg_name(leg);
    EXPECT_NEAR(foot.z(), -0.574, 5e-4) << leg_name(leg);
  }
  EXPECT_NEAR(walker_mass_kg(options), 84.8, 0.05);
}

TEST(WalkerModel, InverseUndoesForwardOverTheWorkspace) {
  const WalkerModelOptions options;
  for (int leg = 0; leg < kLegs; ++leg) {
    over_the_workspace(options, leg, [&](const Eigen::Vector3d& q) {
      const LegJoints found = joints_for_foot(options, leg, foot_position(options, leg, q));
      ASSERT_TRUE(found.reached()) << leg_name(leg) << " " << q.transpose();
      ASSERT_LT((found.joints_rad - q).norm(), 1e-9) << leg_name(leg) << " " << q.transpose();
    });
  }
}

TEST(WalkerModel, JacobianIsTheDerivativeOfThePosition) {
  const WalkerModelOptions options;
  constexpr double kStep = 1e-6;
  for (int leg = 0; leg < kLegs; ++leg) {
    over_the_workspace(options, leg, [&](const Eigen::Vector3d& q) {
      Eigen::Matrix3d numeric;
      for (int i = 0; i < 3; ++i) {
        const Eigen::Vector3d d = kStep * Eigen::Vector3d::Unit(i);
        numeric.col(i) = (foot_position(options, leg, q + d) - foot_position(options, leg, q - d)) /
                         (2.0 * kStep);
      }
      ASSERT_LT((numeric - foot_jacobian(options, leg, q)).norm(), 1e-8) << q.transpose();
    });
  }
}

TEST(WalkerModel, LegsReachStraightDownAsFarAsTheSourceSays) {
  const WalkerModelOptions options;
  for (int leg = 0; leg < kLegs; ++leg) {
    const Eigen::Vector3d hip = hip_position(options, leg);
    double nearest = 1.0, farthest = 0.0;
    for (int mm = 100; mm < 1000; ++mm) {
      const double down = 0.001 * mm;
      if (!joints_for_foot(options, leg, hip - down * Eigen::Vector3d::UnitZ()).reached()) continue;
      nearest = std::min(nearest, down);
      farthest = std::max(farthest, down);
    }
    EXPECT_NEAR(nearest, 0.317, 0.0015) << leg_name(leg);
    EXPECT_NEAR(farthest, 0.760, 0.0015) << leg_name(leg);
  }
}

TEST(WalkerModel, KneesOfFrontAndHindLegsPointAtEachOther) {
  const WalkerModelOptions options;
  for (int leg = 0; leg < kLegs; ++leg) {
    const Eigen::Vector3d down = hip_position(options, leg) - Eigen::Vector3d(0.0, 0.0, 0.5);
    const double knee = joints_for_foot(options, leg, down).joints_rad.z();
    EXPECT_EQ(knee < 0.0, is_front(leg)) << leg_name(leg);
    const JointLimits limits = joint_limits(options, leg, 2);
    EXPECT_NEAR(limits.low_rad, (is_front(leg) ? -140.0 : 20.0) * kDegree, 1e-4);
    EXPECT_NEAR(limits.high_rad, (is_front(leg) ? -20.0 : 140.0) * kDegree, 1e-4);
  }
}

TEST(WalkerModel, AFootOutOfReachIsMissedByWhatItIsTooFar) {
  const WalkerModelOptions options;
  const Eigen::Vector3d hip = hip_position(options, 2);
  const Eigen::Vector3d wanted = hip - Eigen::Vector3d(0.0, 0.0, 0.871);
  const LegJoints found = joints_for_foot(options, 2, wanted);
  EXPECT_FALSE(found.reached());
  EXPECT_NEAR(found.missed_m, 0.1, 1e-9);
  EXPECT_NEAR((foot_position(options, 2, found.joints_rad) - wanted).norm(), 0.1, 1e-9);
  EXPECT_FALSE(joints_for_foot(options, 2, hip).reached()) << "in its own hip";
  EXPECT_FALSE(joints_for_foot(options, 2, Eigen::Vector3d::Constant(std::nan(""))).within_limits);
}

// Lagrange: the torques that hold the robot still are the derivative of what it would cost to move
// it, so no small change of the joints that keeps the feet where they are may do work.
TEST(WalkerModel, TorquesOfStandingBearTheWeight) {
  const WalkerModelOptions options;
  const auto joints = home_joints();
  const Eigen::Vector3d up = Eigen::Vector3d(0.1, -0.15, 1.0).normalized();
  const JointCommand command = stand_command(options, joints, up);
  // Move the body by a twist, the feet fixed in the world: dq = -J^-1 (v + w x p).
  for (int i = 0; i < 6; ++i) {
    Vector6d twist = Vector6d::Zero();
    twist(i) = 1e-6;
    const auto moved = [&](double sign) {
      std::array<double, kLegJoints> q = joints;
      for (int leg = 0; leg < kLegs; ++leg) {
        const Isometry3d T_old_new = se3_exp(sign * twist);
        const Eigen::Vector3d p = foot_position(options, leg, joints_of_leg(joints, leg));
        const Eigen::Vector3d there =
            joints_for_foot(options, leg, T_old_new.inverse() * p).joints_rad;
        for (int k = 0; k < 3; ++k) q[static_cast<std::size_t>(3 * leg + k)] = there(k);
      }
      return q;
    };
    const auto ahead = moved(1.0), behind = moved(-1.0);
    double work = 0.0;
    for (std::size_t k = 0; k < kLegJoints; ++k) {
      work += command.torque_nm[k] * (ahead[k] - behind[k]);
    }
    const auto height = [&](const std::array<double, kLegJoints>& q, double sign) {
      return up.dot(se3_exp(sign * twist) * walker_centre_of_mass(options, q));
    };
    const double lifted =
        walker_mass_kg(options) * 9.81 * (height(ahead, 1.0) - height(behind, -1.0));
    EXPECT_NEAR(work, lifted, 1e-9 + 1e-4 * std::abs(lifted)) << i;
  }
}

TEST(WalkerModel, OptionsAreChecked) {
  WalkerModelOptions options;
  EXPECT_TRUE(check_options(options));
  options.kfe = {1.0, 0.5};
  const Status crossed = check_options(options);
  ASSERT_FALSE(crossed);
  EXPECT_NE(crossed.error().message().find("kfe_low_rad"), std::string::npos)
      << crossed.error().message();
  options = {};
  options.trunk_inertia_kg_m2.x() = 100.0;
  EXPECT_FALSE(check_options(options));
  options = {};
  options.lower_kg = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(check_options(options));
  StandOptions stand;
  EXPECT_TRUE(check_options(stand));
  stand.stiffness_nm_per_rad = -1.0;
  EXPECT_FALSE(check_options(stand));
}

}  // namespace
}  // namespace tread
