#include "tread/slam/align.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "instruction_sets.hpp"
#include "rendered_scene.hpp"

namespace tread {
namespace {

AlignFrame prepare(const bench::RenderedFrame& frame, const bench::Sensor& sensor) {
  AlignFrame out;
  out.depth[0].resize(sensor.camera, sensor.width, sensor.height);
  out.depth[0].depth = frame.depth;
  NormalFinder().build_pyramid({1e-4, 0.0}, out.depth);
  build_grey_pyramid(frame.grey, false, out.grey);
  return out;
}

PhotoKeyframe keyframe_of(const AlignFrame& frame, const Isometry3d& T) {
  PhotoKeyframe key;
  for (std::size_t i = 0; i < 3; ++i) {
    choose_photo_points(frame.grey[i], frame.depth[i], 2.0, 20'000 >> (2 * i), key.points[i]);
    key.camera[i] = frame.depth[i].camera;
  }
  key.T_world_camera = T;
  return key;
}

void set_motion(const Isometry3d& T, float* R, float* t) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) R[3 * i + j] = static_cast<float>(T.linear()(i, j));
    t[i] = static_cast<float>(T.translation()[i]);
  }
}

struct Pair {
  bench::Sensor sensor;
  Isometry3d T_first, T_second;
  AlignFrame first, second;

  explicit Pair(const bench::Scene& scene, const Vector6d& motion,
                const Isometry3d& from = bench::camera_at({0, 0, 1}, 30, 15, 0))
      : T_first(from), T_second(from * se3_exp(motion)) {
    first = prepare(bench::render(scene, sensor, T_first, 1), sensor);
    second = prepare(bench::render(scene, sensor, T_second, 2), sensor);
  }
};

const Vector6d kMotion = (Vector6d() << 0.01, -0.01, 0.02, 0.01, -0.01, 0.015).finished();

// The gradient of half the error is g, by finite differences of the sums themselves: this holds the
// Jacobian of every residual. Gates and weights are wide open, so that nothing jumps.
TEST(AlignKernel, DepthJacobianIsTheSlopeOfTheError) {
  const Pair pair(bench::room_corner(), kMotion);
  const Isometry3d T = Isometry3d::Identity();
  IcpJob job;
  job.frame = DepthView::of(pair.second.depth[2]);
  job.model = DepthView::of(pair.first.depth[2]);
  job.gate_m = 0.2F;
  job.least_cosine = 0.5F;
  job.constant_m = 0.01F;
  job.huber = 1e6F;
  set_motion(T, job.R, job.t);
  NormalEquations at;
  icp_rows(job, 0, job.frame.depth.height, false, at);
  ASSERT_GT(at.count, 3000);
  // Moving a point of the frame changes which pixel of the model it meets; so compare with the
  // change that J itself predicts, pixel by pixel, on those that meet the same one: steps far below
  // a pixel.
  for (int k = 0; k < 6; ++k) {
    constexpr double kStep = 1e-5;
    NormalEquations sides[2];
    for (int side = 0; side < 2; ++side) {
      Vector6d twist = Vector6d::Zero();
      twist(k) = side == 0 ? -kStep : kStep;
      set_motion(se3_exp(twist), job.R, job.t);
      icp_rows(job, 0, job.frame.depth.height, false, sides[side]);
    }
    const double slope = (sides[1].error - sides[0].error) / (2.0 * kStep) / 2.0;
    EXPECT_NEAR(slope, at.g(k), 0.05 * at.g.cwiseAbs().maxCoeff() + 30.0) << "direction " << k;
  }
}

TEST(AlignKernel, IntensityJacobianIsTheSlopeOfTheError) {
  const Pair pair(bench::room_corner(), Vector6d::Zero());
  const PhotoKeyframe key = keyframe_of(pair.first, pair.T_first);
  PhotoJob job;
  job.points = PhotoPointsView::of(key.points[1]);
  job.image = pair.second.grey[1].intensity;
  job.image_gx = pair.second.grey[1].gx;
  job.image_gy = pair.second.grey[1].gy;
  job.camera = key.camera[1];
  job.sigma = 1.0F;
  job.huber = 1e6F;
  // The keyframe's own gradient stands for that of the image: equal at no motion, so the sums of
  // squares around it have the curvature H.
  for (int k = 0; k < 6; ++k) {
    constexpr double kStep = 2e-4;
    PhotoSums sides[2], at;
    for (int side = 0; side < 2; ++side) {
      Vector6d twist = Vector6d::Zero();
      twist(k) = side == 0 ? -kStep : kStep;
      set_motion(se3_exp(twist), job.R, job.t);
      photo_points(job, 0, job.points.size, false, sides[side]);
    }
    set_motion(Isometry3d::Identity(), job.R, job.t);
    photo_points(job, 0, job.points.size, false, at);
    ASSERT_GT(at.equations.count, 2000);
    const double curvature = (sides[1].equations.g(k) - sides[0].equations.g(k)) / (2.0 * kStep);
    EXPECT_NEAR(curvature / at.equations.H(k, k), 1.0, 0.25) << "direction " << k;
  }
}

TEST(AlignKernel, EveryInstructionSetSumsTheSame) {
  const Pair pair(bench::room_corner(), kMotion);
  const PhotoKeyframe key = keyframe_of(pair.first, pair.T_first);
  IcpJob icp;
  icp.frame = DepthView::of(pair.second.depth[1]);
  icp.model = DepthView::of(pair.first.depth[1]);
  icp.constant_m = 0.003F;
  set_motion(se3_exp(kMotion), icp.R, icp.t);
  PhotoJob photo;
  photo.points = PhotoPointsView::of(key.points[1]);
  photo.image = pair.second.grey[1].intensity;
  photo.image_gx = pair.second.grey[1].gx;
  photo.image_gy = pair.second.grey[1].gy;
  photo.camera = key.camera[1];
  set_motion(se3_exp(kMotion).inverse(), photo.R, photo.t);
  std::vector<NormalEquations> icp_sums, photo_sums;
  testing::on_every_target([&] {
    icp_sums.emplace_back();
    icp_rows(icp, 0, icp.frame.depth.height, true, icp_sums.back());
    PhotoSums sums;
    photo_points(photo, 0, photo.points.size, true, sums);
    photo_sums.push_back(sums.equations);
  });
  for (const auto* all : {&icp_sums, &photo_sums}) {
    ASSERT_GT(all->front().count, 2000);
    for (const NormalEquations& other : *all) {
      EXPECT_NEAR(static_cast<double>(other.count), static_cast<double>(all->front().count), 3.0);
      EXPECT_LT((other.H - all->front().H).norm(), 2e-3 * all->front().H.norm());
      EXPECT_LT((other.cross - all->front().cross).norm(), 2e-3 * all->front().cross.norm());
      EXPECT_LT((other.g - all->front().g).norm(), 1e-2 * all->front().g.norm());
    }
  }
}

PosePrior weak_prior(const Isometry3d& T) {
  PosePrior prior;
  prior.T_world_camera = T;
  prior.information.setIdentity();
  return prior;
}

TEST(Align, FindsAKnownMotionByDepthAndByIntensity) {
  const Pair pair(bench::room_corner(), kMotion);
  const PhotoKeyframe key = keyframe_of(pair.first, pair.T_first);
  for (const int with : {1, 2, 3}) {
    const Alignment found =
        align(pair.second, (with & 1) != 0 ? &pair.first.depth : nullptr, pair.T_first,
              (with & 2) != 0 ? &key : nullptr, weak_prior(pair.T_first), {0.001, 0.0}, {});
    const Isometry3d error = pair.T_second.inverse() * found.T_world_camera;
    // Intensity alone is compared at the pixels of a keyframe, with its slopes: no finer.
    const double tolerance = with == 2 ? 3.0 : 1.0;
    EXPECT_LT(error.translation().norm(), 0.0015 * tolerance) << with;
    EXPECT_LT(so3_log(error.linear()).norm(), 0.0008 * tolerance) << with;
    EXPECT_TRUE(found.observability.all_known()) << with;
    EXPECT_GT(found.covariance.trace(), 0.0);
  }
}

// A camera whose exposure has changed, brighter and with an offset.
TEST(Align, ExposureMayChange) {
  Pair pair(bench::flat_ground(true), kMotion, bench::walking_camera(0.0));
  const PhotoKeyframe key = keyframe_of(pair.first, pair.T_first);
  for (GreyLevel& level : pair.second.grey) {
    for (int y = 0; y < level.intensity.height; ++y) {
      for (int x = 0; x < level.intensity.width; ++x) {
        level.intensity(x, y) = 0.8F * level.intensity(x, y) + 25.0F;
        level.gx(x, y) *= 0.8F;
        level.gy(x, y) *= 0.8F;
      }
    }
  }
  const Alignment found = align(pair.second, &pair.first.depth, pair.T_first, &key,
                                weak_prior(pair.T_first), {0.001, 0.0}, {});
  EXPECT_LT((pair.T_second.inverse() * found.T_world_camera).translation().norm(), 0.0015);
  EXPECT_NEAR(found.gain, 1.25, 0.06);
}

// A plane without texture: what it does not tell is said, and left as it was thought to be.
TEST(Align, APlainPlaneLeavesThreeDirectionsToThePrior) {
  const Vector6d along = (Vector6d() << 0.02, 0.0, 0.0, 0.0, 0.0, 0.0).finished();
  const Pair pair(bench::flat_ground(false), along, bench::walking_camera(0.0));
  const PhotoKeyframe key = keyframe_of(pair.first, pair.T_first);
  const Alignment still = align(pair.second, &pair.first.depth, pair.T_first, &key,
                                weak_prior(pair.T_first), {0.001, 0.0}, {});
  EXPECT_EQ(still.observability.unknown.cols(), 3);
  const Alignment told = align(pair.second, &pair.first.depth, pair.T_first, &key,
                               weak_prior(pair.T_second), {0.001, 0.0}, {});
  EXPECT_LT((pair.T_second.inverse() * told.T_world_camera).translation().norm(), 0.0005);
}

// Two sensors that disagree are noticed: the image is another camera's, ten pixels aside.
TEST(Align, ImagesThatDoNotFitTheDepthAreNoticed) {
  const Pair pair(bench::room_corner(), kMotion);
  const auto look = [&](int aside) {
    AlignFrame first = pair.first, second = pair.second;
    for (AlignFrame* frame : {&first, &second}) {
      Image<float>& grey = frame->grey[0].intensity;
      const Image<float> was = grey;
      for (int y = 0; y < grey.height; ++y) {
        for (int x = 0; x < grey.width; ++x)
          grey(x, y) = was(std::min(x + aside, grey.width - 1), y);
      }
      Image<std::uint8_t> bytes(grey.width, grey.height);
      for (int y = 0; y < grey.height; ++y) {
        for (int x = 0; x < grey.width; ++x) bytes(x, y) = static_cast<std::uint8_t>(grey(x, y));
      }
      build_grey_pyramid(bytes, false, frame->grey);
    }
    const PhotoKeyframe key = keyframe_of(first, pair.T_first);
    return align(second, &first.depth, pair.T_first, &key, weak_prior(pair.T_first),
                 {0.001, 0.0014}, {})
        .disagreement;
  };
  EXPECT_LT(look(0), 1.0);
  EXPECT_GT(look(12), 2.0 * look(0));
}

TEST(AlignRotation, FindsAFastTurn) {
  const Isometry3d T = bench::camera_at({0, 0, 1}, 30, 15, 0);
  for (const Eigen::Vector3d& turn :
       {Eigen::Vector3d(0.0, 0.1, 0.0), Eigen::Vector3d(-0.08, 0.02, 0.05),
        Eigen::Vector3d(0, 0, 0)}) {
    Vector6d motion;
    motion << Eigen::Vector3d::Zero(), turn;
    const Pair pair(bench::room_corner(), motion, T);
    const Eigen::Matrix3d R =
        align_rotation(pair.first.grey[2], pair.second.grey[2], pair.first.depth[2].camera);
    EXPECT_LT(so3_log(R.transpose() * so3_exp(turn)).norm(), 0.01) << turn.transpose();
  }
}

}  // namespace
}  // namespace tread
