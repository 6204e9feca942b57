#include "cloud_picture.hpp"

#include <gtest/gtest.h>

#include "pictures.hpp"

namespace tread {
namespace {

constexpr Rgb kRed{255, 0, 0}, kGreen{0, 255, 0}, kBlue{0, 0, 255};

// Mean place of a colour; NaN if it is not there.
Eigen::Vector2d place_of(const Image<Rgb>& picture, Rgb colour) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  int count = 0;
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      if (picture(x, y) != colour) continue;
      sum += Eigen::Vector2d(x, y);
      ++count;
    }
  }
  return sum / count;
}

void add_ball(PointCloud& cloud, const Eigen::Vector3f& centre, Rgb colour) {
  for (int i = 0; i < 27; ++i) {
    cloud.points.push_back(centre + 0.05F * Eigen::Vector3f(static_cast<float>(i % 3),
                                                            static_cast<float>(i / 3 % 3),
                                                            static_cast<float>(i / 9)));
    cloud.colours.push_back(colour);
  }
}

TEST(DrawCloud, UpIsUpLeftIsLeftAndFarIsHigherThanNear) {
  PointCloud cloud;
  add_ball(cloud, {1.0F, 0.0F, 0.0F}, kRed);
  add_ball(cloud, {1.0F, 0.0F, 1.0F}, kGreen);
  add_ball(cloud, {1.0F, 1.0F, 0.0F}, kBlue);
  const Image<Rgb> picture = draw_cloud(cloud, Isometry3d::Identity(), 300, 200);
  ASSERT_EQ(picture.width, 300);
  ASSERT_EQ(picture.height, 200);
  EXPECT_LT(place_of(picture, kGreen).y(), place_of(picture, kRed).y() - 20.0);
  EXPECT_LT(place_of(picture, kBlue).x(), place_of(picture, kRed).x() - 20.0);
  PointCloud row;
  add_ball(row, {1.0F, 0.0F, 0.0F}, kRed);
  add_ball(row, {3.0F, 0.0F, 0.0F}, kGreen);
  const Image<Rgb> beside = draw_cloud(row, Isometry3d::Identity(), 300, 200);
  EXPECT_LT(place_of(beside, kGreen).y(), place_of(beside, kRed).y() - 20.0);
}

TEST(DrawCloud, NearPointsHideFarOnes) {
  // Along the way the eye looks: what is behind has the same place in the picture.
  const double c = std::cos(0.6);
  const Eigen::Vector3d away(c * std::cos(0.45), c * std::sin(0.45), -std::sin(0.6));
  PointCloud cloud;
  for (const bool far_first : {true, false}) {
    cloud = {};
    const Eigen::Vector3f shift = away.cast<float>();
    add_ball(cloud, far_first ? Eigen::Vector3f(shift) : Eigen::Vector3f::Zero(),
             far_first ? kGreen : kRed);
    add_ball(cloud, far_first ? Eigen::Vector3f::Zero() : Eigen::Vector3f(shift),
             far_first ? kRed : kGreen);
    const Image<Rgb> picture = draw_cloud(cloud, Isometry3d::Identity(), 60, 60);
    EXPECT_FALSE(place_of(picture, kRed).hasNaN());
    EXPECT_TRUE(place_of(picture, kGreen).hasNaN());
  }
}

TEST(DrawCloud, WithoutPointsThereIsNoPictureAndWithoutColoursHeightsAreShown) {
  EXPECT_TRUE(draw_cloud({}, Isometry3d::Identity(), 60, 60).empty());
  PointCloud cloud;
  add_ball(cloud, {1.0F, 0.0F, 0.0F}, kRed);
  add_ball(cloud, {1.0F, 0.0F, 1.0F}, kRed);
  cloud.colours.clear();
  const Image<Rgb> picture = draw_cloud(cloud, Isometry3d::Identity(), 60, 60);
  int colours = 0;
  for (int x = 0; x < 60; ++x) {
    for (int y = 0; y < 60; ++y) colours += picture(x, y) != kUnknownColour ? 1 : 0;
  }
  EXPECT_GT(colours, 54);
}

}  // namespace
}  // namespace tread
