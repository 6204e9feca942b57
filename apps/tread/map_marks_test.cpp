#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "pictures.hpp"

namespace tread {
namespace {

constexpr Rgb kGround{98, 105, 117};

// 20 x 10 m of unknown ground, 10 pixels a metre, corner at (-5, 3).
MapPicture blank() {
  return {Image<Rgb>(200, 100, kGround), {-5.0, 3.0}, 10.0};
}

Rgb at(const MapPicture& map, double x, double y) {
  const Eigen::Vector2d pixel = map.pixel_of({x, y});
  return map.image(static_cast<int>(std::lround(pixel.x())),
                   static_cast<int>(std::lround(pixel.y())));
}

int count(const Image<Rgb>& image, Rgb colour) {
  int found = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) found += image(x, y) == colour ? 1 : 0;
  }
  return found;
}

TEST(MapMarks, PathsLieWhereTheyShould) {
  MapPicture map = blank();
  draw_path(map, std::vector<Eigen::Vector2d>{{0.0, 5.0}, {8.0, 5.0}, {8.0, 11.0}}, kPathColour);
  EXPECT_EQ(at(map, 4.0, 5.0), kPathColour);
  EXPECT_EQ(at(map, 8.0, 9.0), kPathColour);
  EXPECT_EQ(at(map, 4.0, 8.0), kGround);
  EXPECT_EQ(at(map, -3.0, 5.0), kGround);
}

TEST(MapMarks, StartGoalAndWaypointsHaveTheirColours) {
  MapPicture map = blank();
  draw_start(map, {0.0, 8.0});
  draw_goal(map, {10.0, 8.0});
  draw_waypoints(map, std::vector<Eigen::Vector2d>{{5.0, 8.0}});
  EXPECT_EQ(at(map, 0.0, 8.0), kStartColour);
  EXPECT_EQ(at(map, 10.0, 8.0), kGoalColour);
  EXPECT_EQ(at(map, 5.0, 8.0), kWaypointColour);
  EXPECT_EQ(at(map, 2.5, 8.0), kGround);
}

TEST(MapMarks, AGoalBeyondTheMapIsAnArrowOnTheWayToIt) {
  for (const Eigen::Vector2d& goal :
       {Eigen::Vector2d(60.0, 8.0), {-60.0, 8.0}, {0.0, 60.0}, {0.0, -60.0}, {1e7, 1e7}}) {
    MapPicture map = blank();
    draw_goal(map, goal, Eigen::Vector2d(0.0, 8.0));
    EXPECT_GT(count(map.image, kGoalColour), 30) << goal.transpose();
  }
  MapPicture map = blank();
  draw_goal(map, {60.0, 8.0}, Eigen::Vector2d(0.0, 8.0));
  EXPECT_EQ(at(map, 14.3, 8.0), kGoalColour);
  // Without a place to come from, and with one outside: from the middle.
  MapPicture middle = blank(), outside = blank();
  draw_goal(middle, {5.0, 60.0});
  EXPECT_EQ(at(middle, 5.0, 12.3), kGoalColour);
  draw_goal(outside, {5.0, 60.0}, Eigen::Vector2d(-400.0, 8.0));
  EXPECT_EQ(outside.image, middle.image);
}

TEST(MapMarks, TheWedgeOfATrajectoryOpensInTheDirectionOfView) {
  Trajectory trajectory(3);
  for (std::size_t i = 0; i < 3; ++i) {
    trajectory[i].stamp_ns = static_cast<std::int64_t>(i);
    trajectory[i].pose.linear() =
        rotation_from_yaw_pitch_roll(std::numbers::pi / 2.0, 0.2, 0.0) * R_body_optical();
    trajectory[i].pose.translation() = Eigen::Vector3d(2.0 * static_cast<double>(i), 7.0, 1.5);
  }
  MapPicture map = blank();
  draw_trajectory(map, trajectory);
  EXPECT_EQ(at(map, 2.0, 7.0), kTrajectoryColour);
  EXPECT_EQ(at(map, 4.0, 7.0), kTrajectoryColour);
  int above = 0, below = 0;  // of the line of travel: it looks along +y, which is up
  const int line = static_cast<int>(map.pixel_of({0.0, 7.0}).y());
  for (int y = 0; y < map.image.height; ++y) {
    for (int x = 0; x < map.image.width; ++x) {
      if (!(map.image(x, y) == kTrajectoryColour) || std::abs(y - line) < 10) continue;
      ++(y < line ? above : below);
    }
  }
  EXPECT_GT(above, 40);
  EXPECT_EQ(below, 0);
  // A camera that looks straight down has no direction on the map.
  Trajectory down(1);
  down[0].pose.translation() = Eigen::Vector3d(4.0, 7.0, 1.0);
  MapPicture only_place = blank();
  draw_trajectory(only_place, down);
  EXPECT_EQ(at(only_place, 4.0, 7.0), kTrajectoryColour);
  EXPECT_LT(count(only_place.image, kTrajectoryColour), 100);
  MapPicture untouched = blank();
  draw_trajectory(untouched, {});
  EXPECT_EQ(untouched.image, blank().image);
}

TEST(MapMarks, TheScaleBarHasARoundLength) {
  MapPicture map = blank();  // 20 m wide: at most 6 m
  draw_scale_bar(map);
  int longest = 0;
  for (int y = 0; y < map.image.height; ++y) {
    int run = 0;
    for (int x = 0; x < map.image.width; ++x) {
      run = map.image(x, y) == Rgb{255, 255, 255} ? run + 1 : 0;
      longest = std::max(longest, run);
    }
  }
  EXPECT_EQ(longest, 50);
  MapPicture nothing{Image<Rgb>(), {0.0, 0.0}, 10.0};
  draw_scale_bar(nothing);
  EXPECT_TRUE(nothing.image.empty());
}

TEST(ColourBar, StandsBesideThePictureInItsScale) {
  const Image<Rgb> picture(120, 300, kGround);
  ColourScale scale;
  scale.label = "cost";
  scale.palette = Palette::kCost;
  scale.high = 20.0F;
  scale.lethal_from = 50.0F;
  const Image<Rgb> out = with_colour_bar(picture, scale);
  EXPECT_GT(out.width, 200);
  EXPECT_EQ(out.height, 300);
  EXPECT_EQ(out(60, 150), kGround);
  // Down the bar the colours run from high to low.
  const int x = 120 + 14 + 5;
  EXPECT_EQ(out(x, 41), palette_colour(Palette::kCost, 1.0));
  int last = 41;
  while (last + 1 < out.height && !(out(x, last + 1) == Rgb{255, 255, 255})) ++last;
  EXPECT_EQ(out(x, last), palette_colour(Palette::kCost, 0.0));
  EXPECT_GT(last, 200);
  const Rgb middle = out(x, (41 + last) / 2), expected = palette_colour(Palette::kCost, 0.5);
  EXPECT_NEAR(middle.r, expected.r, 8);
  EXPECT_NEAR(middle.b, expected.b, 8);
}

TEST(ColourBar, ShortPicturesGetRoomForIt) {
  const Image<Rgb> out = with_colour_bar(Image<Rgb>(30, 10, kGround), {});
  EXPECT_GE(out.height, 160);
  EXPECT_EQ(out(5, 5), kGround);
  EXPECT_EQ(out(5, 50), (Rgb{255, 255, 255}));
}

}  // namespace
}  // namespace tread
