#include "tread/slam/visual_odometry.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "plane_world.hpp"
#include "tread/geometry/trajectory_error.hpp"
#include "tread/slam/inertial_start.hpp"

namespace tread {
namespace {

constexpr double kRate_hz = 15.0;
const Eigen::Vector3d kGyroBias(0.02, -0.03, 0.01), kAccelBias(0.08, -0.05, 0.1);

std::int64_t stamp_of(int frame) {
  return std::llround(frame / kRate_hz * 1e9);
}

// Pairs along plane_world_pose, made once.
const std::vector<PlaneWorld::Pair>& pairs() {
  static const std::vector<PlaneWorld::Pair> kPairs = [] {
    std::vector<PlaneWorld::Pair> made;
    for (int i = 0; i < 90; ++i) {
      made.push_back(PlaneWorld::room().pair(plane_world_rig(), plane_world_pose(i / kRate_hz), 2.0,
                                             static_cast<std::uint32_t>(i)));
    }
    return made;
  }();
  return kPairs;
}

Imu imu_of_test() {
  Imu imu;
  imu.T_imu_left = Isometry3d::Identity();
  return imu;
}

struct Drive {
  std::vector<OdometryState> states;
  Trajectory trajectory, truth;
  [[nodiscard]] int count(OdometryStatus status) const {
    int n = 0;
    for (const OdometryState& state : states) n += state.status == status ? 1 : 0;
    return n;
  }
  // How far the last pose is from the truth, both seen from the first.
  [[nodiscard]] double end_error_m() const {
    const Isometry3d is = trajectory.front().pose.inverse() * trajectory.back().pose;
    const Isometry3d should = truth.front().pose.inverse() * truth.back().pose;
    return (is.translation() - should.translation()).norm();
  }
  [[nodiscard]] double end_error_rad() const {
    const Isometry3d is = trajectory.front().pose.inverse() * trajectory.back().pose;
    const Isometry3d should = truth.front().pose.inverse() * truth.back().pose;
    return so3_log(is.linear().transpose() * should.linear()).norm();
  }
};

// What is done to a pair before it is seen.
using Change = std::function<void(int, PlaneWorld::Pair&)>;

Drive drive(bool with_imu, int frames, const Change& change = {}, const Context& context = {}) {
  Isometry3d first = Isometry3d::Identity();
  if (with_imu) {
    const auto rest = plane_world_imu(-0.5, 0.0, kGyroBias, kAccelBias);
    first.linear() = level_camera(rest, Isometry3d::Identity()).value();
  }
  VisualOdometry odometry(plane_world_rig(), {}, first,
                          with_imu ? std::optional(imu_of_test()) : std::nullopt);
  Drive run;
  for (int i = 0; i < frames; ++i) {
    PlaneWorld::Pair pair = pairs()[static_cast<std::size_t>(i)];
    if (change) change(i, pair);
    OdometryFrame frame{stamp_of(i), pair.left, pair.right};
    const auto samples = plane_world_imu((i - 1) / kRate_hz, i / kRate_hz, kGyroBias, kAccelBias);
    if (with_imu) frame.imu = samples;
    const auto state = odometry.track(frame, context);
    EXPECT_TRUE(state) << (state ? "" : state.error().message());
    run.states.push_back(*state);
    run.trajectory.push_back({frame.stamp_ns, state->T_world_camera});
    run.truth.push_back({frame.stamp_ns, plane_world_pose(i / kRate_hz)});
  }
  return run;
}

// Both cameras see nothing from `first` to before `last`.
Change covered(int first, int last) {
  return [first, last](int i, PlaneWorld::Pair& pair) {
    if (i < first || i >= last) return;
    pair.left = Image<std::uint8_t>(480, 360, 3);
    pair.right = pair.left;
  };
}

TEST(VisualOdometry, FollowsACameraThroughARoom) {
  const Drive r = drive(false, 90);
  EXPECT_EQ(r.states.front().status, OdometryStatus::kFirst);
  EXPECT_EQ(r.count(OdometryStatus::kTracked), 89);
  EXPECT_LT(r.end_error_m(), 0.006);  // of 2.4 m
  EXPECT_LT(r.end_error_rad(), 0.002);
  const auto e = absolute_trajectory_error(r.trajectory, r.truth);
  ASSERT_TRUE(e);
  EXPECT_LT(e->rmse_m, 0.003);
}

TEST(VisualOdometry, ErrorsOfASingleMotionAreWithinTheirCovariance) {
  const Drive r = drive(false, 90);
  int within = 0, counted = 0;
  for (std::size_t i = 1; i < r.states.size(); ++i) {
    const Isometry3d should = r.truth[i - 1].pose.inverse() * r.truth[i].pose;
    const Eigen::Vector3d e = r.states[i].T_before_now.translation() - should.translation();
    const double sigma = std::sqrt(r.states[i].covariance.topLeftCorner<3, 3>().trace());
    // Both poses of a motion err, and the covariance is that of one.
    within += e.norm() < 3.0 * std::sqrt(2.0) * sigma ? 1 : 0;
    ++counted;
    EXPECT_LT(sigma, 0.02);
  }
  EXPECT_GT(within, counted * 8 / 10);
}

TEST(VisualOdometry, OneAndTwoThreadsAreEqualToTheBit) {
  const Drive one = drive(true, 60), two = drive(true, 60, {}, {2, nullptr});
  for (std::size_t i = 0; i < one.states.size(); ++i) {
    EXPECT_EQ(one.states[i].T_world_camera.matrix(), two.states[i].T_world_camera.matrix()) << i;
  }
}

TEST(VisualOdometry, TheImuKeepsTheWorldLevel) {
  const Drive r = drive(true, 90);
  EXPECT_EQ(r.count(OdometryStatus::kTracked), 89);
  EXPECT_TRUE(r.states.back().inertial);
  EXPECT_FALSE(r.states.front().inertial);
  EXPECT_LT(r.end_error_m(), 0.006);
  // Up is up: roll and pitch against the true world, not against the first pose.
  const Eigen::Vector3d up_is = r.trajectory.back().pose.linear().transpose().col(2),
                        up_should = r.truth.back().pose.linear().transpose().col(2);
  // The first pose is as level as an accelerometer with that bias can say, 0.13 / 9.81.
  EXPECT_LT((up_is - up_should).norm(), 0.016);
}

TEST(VisualOdometry, HeldByTheImuWhileCovered) {
  // A second in motion, from 3 s on.
  const Drive r = drive(true, 90, covered(45, 60));
  EXPECT_EQ(r.count(OdometryStatus::kHeld), 15);
  EXPECT_EQ(r.count(OdometryStatus::kLost), 0);
  for (const OdometryState& state : r.states) EXPECT_FALSE(state.restarted);
  EXPECT_LT(r.end_error_m(), 0.02);
}

TEST(VisualOdometry, LostWhileCoveredAndFoundAgainAtWhatItSawBefore) {
  const Drive r = drive(false, 70, covered(45, 51));
  EXPECT_EQ(r.count(OdometryStatus::kLost), 6);
  for (const OdometryState& state : r.states) EXPECT_FALSE(state.restarted);
  EXPECT_EQ(r.states.back().status, OdometryStatus::kTracked);
  EXPECT_LT(r.end_error_m(), 0.02);
}

TEST(VisualOdometry, StartsAnewWhenLostForLongAndSaysSo) {
  const Drive r = drive(false, 90, covered(30, 60));
  EXPECT_GE(r.count(OdometryStatus::kLost), 30);
  int restarts = 0;
  for (std::size_t i = 0; i < r.states.size(); ++i) {
    restarts += r.states[i].restarted ? 1 : 0;
    if (i >= 30 && i < 60) {
      EXPECT_FALSE(r.states[i].placed()) << i;
    }
  }
  EXPECT_EQ(restarts, 1);
  EXPECT_EQ(r.states.back().status, OdometryStatus::kTracked);
  // From the restart on it is right again, whatever the gap cost.
  const Isometry3d is = r.trajectory[65].pose.inverse() * r.trajectory[89].pose;
  const Isometry3d should = r.truth[65].pose.inverse() * r.truth[89].pose;
  EXPECT_LT((is.translation() - should.translation()).norm(), 0.01);
}

TEST(VisualOdometry, SomethingLargeThatPassesDoesNotPullItAlong) {
  // A third of the picture shows a wall that goes its own way.
  const Drive r = drive(false, 60, [](int i, PlaneWorld::Pair& pair) {
    const auto& other = pairs()[static_cast<std::size_t>(89 - i)];
    for (int y = 100; y < 300; ++y) {
      for (int x = 100 + i; x < 290 + i; ++x) {
        pair.left(x, y) = other.left(x - 40, y);
        pair.right(x - 20, y) = other.right(x - 60, y);
      }
    }
  });
  EXPECT_EQ(r.count(OdometryStatus::kTracked), 59);
  EXPECT_LT(r.end_error_m(), 0.03);
}

TEST(VisualOdometry, ExposureChangesAndCamerasDiffer) {
  const Drive r = drive(false, 60, [](int i, PlaneWorld::Pair& pair) {
    const double exposure = 0.8 + 0.2 * std::sin(0.5 * i);
    for (const bool left : {true, false}) {
      Image<std::uint8_t>& image = left ? pair.left : pair.right;
      for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
          image(x, y) = static_cast<std::uint8_t>(
              left ? exposure * image(x, y) : 10.0 + 0.7 * exposure * image(x, y));
        }
      }
    }
  });
  EXPECT_EQ(r.count(OdometryStatus::kTracked), 59);
  EXPECT_LT(r.end_error_m(), 0.01);
}

TEST(VisualOdometry, AMotionPriorHoldsIt) {
  VisualOdometry odometry(plane_world_rig());
  const auto& view = pairs()[0];
  ASSERT_TRUE(odometry.track({0, view.left, view.right}));
  const Image<std::uint8_t> dark(480, 360, 3);
  MotionPrior motion;
  motion.T_before_now.translation() = Eigen::Vector3d(0.0, 0.0, 0.1);
  motion.covariance = 1e-4 * Matrix6d::Identity();
  const auto held = odometry.track({100'000'000, dark, dark, motion});
  ASSERT_TRUE(held);
  EXPECT_EQ(held->status, OdometryStatus::kHeld);
  EXPECT_NEAR(held->T_world_camera.translation().z(), 0.1, 1e-9);
  EXPECT_EQ(held->covariance, motion.covariance);
}

TEST(VisualOdometry, WaitsUntilThereIsSomethingToSee) {
  VisualOdometry odometry(plane_world_rig());
  const Image<std::uint8_t> grey(480, 360, 128);
  for (int i = 0; i < 3; ++i) {
    const auto state = odometry.track({i, grey, grey});
    ASSERT_TRUE(state);
    EXPECT_EQ(state->status, OdometryStatus::kLost);
  }
  const auto state = odometry.track({10, pairs()[0].left, pairs()[0].right});
  ASSERT_TRUE(state);
  EXPECT_EQ(state->status, OdometryStatus::kFirst);
}

TEST(VisualOdometry, RefusesWhatIsNotInOrder) {
  VisualOdometry odometry(plane_world_rig());
  const auto& view = pairs()[0];
  const Image<std::uint8_t> small(100, 100);
  EXPECT_FALSE(odometry.track({0, small, view.right}));
  EXPECT_FALSE(odometry.track({0, view.left, {}}));
  ASSERT_TRUE(odometry.track({5, view.left, view.right}));
  const auto again = odometry.track({5, view.left, view.right});
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().where, "stamp_ns");
  EXPECT_TRUE(odometry.track({6, view.left, view.right}));
}

TEST(VisualOdometry, SaysWhatItWasMadeWithThatIsNotSound) {
  const auto& view = pairs()[0];
  const auto refused = [&](const RectifiedRig& rig, const OdometryOptions& options = {},
                           const std::optional<Imu>& imu = {}) {
    VisualOdometry odometry(rig, options, Isometry3d::Identity(), imu);
    const auto state = odometry.track({0, view.left, view.right});
    return state ? std::string() : state.error().where;
  };
  RectifiedRig rig = plane_world_rig();
  rig.baseline_m = 0.0;
  EXPECT_EQ(refused(rig), "rig");
  rig = plane_world_rig();
  rig.size = {20, 20};
  EXPECT_EQ(refused(rig), "rig.size");
  OdometryOptions options;
  options.corners.levels = 0;
  EXPECT_EQ(refused(plane_world_rig(), options), "corners.levels");
  Imu imu;
  imu.accel_noise = 0.0;
  EXPECT_EQ(refused(plane_world_rig(), {}, imu), "imu.accel_noise");
  EXPECT_EQ(refused(plane_world_rig()), "");
  VisualOdometry odometry(plane_world_rig());
  MotionPrior motion;
  motion.covariance.setZero();
  EXPECT_FALSE(odometry.track({0, view.left, view.right, motion}));
}

TEST(VisualOdometry, SamplesThatAreMissingOrNonsenseDoNotHurt) {
  VisualOdometry odometry(plane_world_rig(), {}, Isometry3d::Identity(), imu_of_test());
  Trajectory path;
  for (int i = 0; i < 60; ++i) {
    auto samples = plane_world_imu((i - 1) / kRate_hz, i / kRate_hz, kGyroBias, kAccelBias);
    if (i > 20 && i < 30) samples.clear();
    if (i == 40) samples[3].gyro_rad_per_s.setConstant(std::nan(""));
    if (i == 41) std::swap(samples[2], samples[7]);
    const auto& view = pairs()[static_cast<std::size_t>(i)];
    OdometryFrame frame{stamp_of(i), view.left, view.right};
    frame.imu = samples;
    const auto state = odometry.track(frame);
    ASSERT_TRUE(state);
    EXPECT_TRUE(state->placed());
    path.push_back({frame.stamp_ns, state->T_world_camera});
  }
  const Isometry3d is = path.front().pose.inverse() * path.back().pose;
  const Isometry3d should = plane_world_pose(0.0).inverse() * plane_world_pose(59 / kRate_hz);
  EXPECT_LT((is.translation() - should.translation()).norm(), 0.01);
}

TEST(StartInertia, FindsGravitySpeedAndTheBiasOfTheGyroscope) {
  std::vector<WindowFrame> frames;
  for (int i = 0; i < 8; ++i) {
    const double t = 1.0 + 0.3 * i;
    WindowFrame frame;
    frame.id = i;
    frame.T_world_camera = plane_world_pose(t);
    if (i > 0) {
      ImuPreintegration since(imu_of_test(), {});
      since.integrate(plane_world_imu(t - 0.31, t + 0.01, kGyroBias, Eigen::Vector3d::Zero()),
                      std::llround((t - 0.3) * 1e9), std::llround(t * 1e9));
      frame.since = since;
    }
    frames.push_back(frame);
  }
  const auto gravity = start_inertia(frames, Isometry3d::Identity());
  ASSERT_TRUE(gravity);
  EXPECT_LT((*gravity - Eigen::Vector3d(0, 0, -9.81)).norm(), 0.05);
  EXPECT_LT((frames[3].bias.gyro_rad_per_s - kGyroBias).norm(), 1e-3);
  const Eigen::Vector3d speed =
      (plane_world_pose(1.9 + 1e-4).translation() - plane_world_pose(1.9 - 1e-4).translation()) /
      2e-4;
  EXPECT_LT((frames[3].velocity_m_per_s - speed).norm(), 0.01);
  // Too few, a hole, or no gravity.
  std::vector<WindowFrame> few(frames.begin(), frames.begin() + 4);
  EXPECT_FALSE(start_inertia(few, Isometry3d::Identity()));
  auto hole = frames;
  hole[4].since.reset();
  EXPECT_FALSE(start_inertia(hole, Isometry3d::Identity()));
  for (auto& frame : frames) {
    if (frame.since) frame.since = ImuPreintegration(imu_of_test(), {});
  }
  EXPECT_FALSE(start_inertia(frames, Isometry3d::Identity()));
}

TEST(LevelCamera, PutsZUpAndLooksAlongX) {
  const auto rest = plane_world_imu(-0.5, 0.0, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero());
  const auto R = level_camera(rest, Isometry3d::Identity());
  ASSERT_TRUE(R);
  EXPECT_LT((*R - plane_world_pose(0.0).linear()).norm(), 1e-3);
  // A camera that looks straight down has its upper edge ahead.
  std::vector<ImuSample> down = {{0, Eigen::Vector3d::Zero(), Eigen::Vector3d(0, 0, -9.81)}};
  const auto R_down = level_camera(down, Isometry3d::Identity());
  ASSERT_TRUE(R_down);
  EXPECT_LT((*R_down * Eigen::Vector3d::UnitZ() + Eigen::Vector3d::UnitZ()).norm(), 1e-9);
  EXPECT_LT((*R_down * -Eigen::Vector3d::UnitY() - Eigen::Vector3d::UnitX()).norm(), 1e-9);
  EXPECT_FALSE(level_camera({}, Isometry3d::Identity()));
  down[0].accel_m_per_s2.z() = -20.0;
  EXPECT_FALSE(level_camera(down, Isometry3d::Identity()));
}

}  // namespace
}  // namespace tread
