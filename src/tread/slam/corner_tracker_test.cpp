#include "tread/slam/corner_tracker.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "plane_world.hpp"
#include "tread/slam/corner_patch.hpp"

namespace tread {
namespace {

// A smooth picture of waves of many directions, moved and turned, brighter or darker.
Image<std::uint8_t> waves(const Eigen::Vector2d& centre, const Eigen::Matrix2d& A, double gain,
                          double offset) {
  Image<std::uint8_t> image(120, 100);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const Eigen::Vector2d p = A.inverse() * (Eigen::Vector2d(x, y) - centre);
      double value = 0.0;
      for (int k = 0; k < 9; ++k) {
        const double angle = 0.7 * k, wave = 0.15 + 0.05 * k;
        value += std::sin(wave * (p.x() * std::cos(angle) + p.y() * std::sin(angle)) + 1.3 * k);
      }
      image(x, y) =
          static_cast<std::uint8_t>(std::clamp(gain * (128.0 + 22.0 * value) + offset, 0.0, 255.0));
    }
  }
  return image;
}

TEST(CornerPatch, FindsItsPlaceUnderAWarpAndAnotherExposure) {
  const Eigen::Vector2d there(60.0, 50.0);
  const auto before = waves(there, Eigen::Matrix2d::Identity(), 1.0, 0.0);
  const auto patch = CornerPatch::take(before, there);
  ASSERT_TRUE(patch);
  Eigen::Matrix2d A;
  A << 1.15, 0.12, -0.1, 0.93;
  const Eigen::Vector2d now(63.37, 48.81);
  const auto after = waves(now, A, 0.7, 30.0);
  CornerPatch::Warp warp{now + Eigen::Vector2d(0.9, -0.8), Eigen::Matrix2d::Identity()};
  const auto correlation = patch->align(after, warp);
  ASSERT_TRUE(correlation);
  EXPECT_GT(*correlation, 0.99);
  EXPECT_LT((warp.place - now).norm(), 0.03);
  EXPECT_LT((warp.A - A).norm(), 0.02);
}

TEST(CornerPatch, SaysSoWhenItIsNotThere) {
  const Eigen::Vector2d there(60.0, 50.0);
  const auto before = waves(there, Eigen::Matrix2d::Identity(), 1.0, 0.0);
  const auto patch = CornerPatch::take(before, there);
  ASSERT_TRUE(patch);
  CornerPatch::Warp warp{{30.0, 75.0}, Eigen::Matrix2d::Identity()};
  const auto elsewhere = patch->align(before, warp);
  EXPECT_TRUE(!elsewhere || *elsewhere < 0.8 || (warp.place - there).norm() < 0.1);
  warp = {there, Eigen::Matrix2d::Identity()};
  EXPECT_FALSE(patch->align(Image<std::uint8_t>(120, 100, 90), warp));
}

TEST(CornerPatch, NeedsRoomAndSomethingToSee) {
  const auto image = waves({60, 50}, Eigen::Matrix2d::Identity(), 1.0, 0.0);
  EXPECT_FALSE(CornerPatch::take(image, {5.0, 50.0}));
  EXPECT_FALSE(CornerPatch::take(image, {60.0, 95.0}));
  EXPECT_FALSE(CornerPatch::take(image, {-1e9, std::nan("")}));
  EXPECT_FALSE(CornerPatch::take(Image<std::uint8_t>(120, 100, 90), {60.0, 50.0}));
  const auto patch = CornerPatch::take(image, {60.0, 50.0});
  ASSERT_TRUE(patch);
  CornerPatch::Warp outside{{3.0, 3.0}, Eigen::Matrix2d::Identity()};
  EXPECT_FALSE(patch->align(image, outside));
  CornerPatch::Warp huge{{60.0, 50.0}, 20.0 * Eigen::Matrix2d::Identity()};
  EXPECT_FALSE(patch->align(image, huge));
}

TEST(CornerTracker, CornersAreApartAndNotMoreThanAskedFor) {
  const RectifiedRig rig = plane_world_rig();
  const auto view = PlaneWorld::room().pair(rig, plane_world_pose(0.0), 1.0, 1);
  CornerOptions options;
  options.most = 150;
  CornerTracker tracker(options);
  tracker.see(view.left, view.right, {});
  const auto corners = tracker.detect({}, {});
  EXPECT_GT(corners.size(), 120U);
  EXPECT_LE(corners.size(), 150U);
  double least = 1e9;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      least = std::min(least, (corners[i] - corners[k]).norm());
    }
  }
  EXPECT_GT(least, 15.0);
  // Those there are count.
  const auto more = tracker.detect(corners, {});
  EXPECT_LE(more.size() + corners.size(), 150U);
  tracker.see(Image<std::uint8_t>(480, 360, 77), Image<std::uint8_t>(480, 360, 77), {});
  EXPECT_TRUE(tracker.detect({}, {}).empty());
}

TEST(CornerTracker, FollowsCornersAndFindsThemInTheRightImage) {
  const RectifiedRig rig = plane_world_rig();
  const PlaneWorld world = PlaneWorld::room();
  const Isometry3d T_a = plane_world_pose(2.0), T_b = plane_world_pose(2.1);
  const auto a = world.pair(rig, T_a, 1.0, 1), b = world.pair(rig, T_b, 1.0, 2);
  CornerTracker tracker(CornerOptions{});
  tracker.see(a.left, a.right, {});
  const auto corners = tracker.detect({}, {});
  std::vector<StereoSight> sights;
  for (const auto& p : corners) sights.push_back({p.x(), p.y()});
  tracker.find_right(sights, 1.0, 200.0, {});
  tracker.keep();
  tracker.see(b.left, b.right, {});
  std::vector<Eigen::Vector2d> to = corners;
  std::vector<std::uint8_t> found;
  tracker.follow(corners, to, found, {});
  int followed = 0, good = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (found[i] == 0 || !sights[i].has_right()) continue;
    ++followed;
    const Eigen::Vector3d p = T_a * point_of(rig, sights[i]);
    const Eigen::Vector3d expected = stereo_projection(rig, T_b.inverse() * p);
    good += (expected.head<2>() - to[i]).norm() < 0.7 ? 1 : 0;
  }
  EXPECT_GT(followed, 150);
  EXPECT_GT(good, followed * 9 / 10);
}

TEST(CornerTracker, DoesNotGuessWhereThePatternRepeats) {
  // Bars every 16 pixels: each could be any other.
  Image<std::uint8_t> bars(480, 360);
  for (int y = 0; y < 360; ++y) {
    for (int x = 0; x < 480; ++x) {
      bars(x, y) = static_cast<std::uint8_t>(((x / 8) + (y / 8)) % 2 == 0 ? 40 : 200);
    }
  }
  CornerTracker tracker(CornerOptions{});
  tracker.see(bars, bars, {});
  std::vector<StereoSight> sights;
  for (const auto& p : tracker.detect({}, {})) {
    // Nearer to the border there is only one place it could be.
    if (p.x() > 50.0) sights.push_back({p.x(), p.y()});
  }
  ASSERT_GT(sights.size(), 50U);
  tracker.find_right(sights, 1.0, 200.0, {});
  for (const StereoSight& sight : sights) EXPECT_FALSE(sight.has_right());
}

}  // namespace
}  // namespace tread
