#include "tread/stereo/stereo_matcher.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "stereo_images.hpp"
#include "tread/stereo/depth.hpp"

namespace tread {
namespace {

using testing::Pair;
using testing::random_image;
using testing::textured_pair;

// Expects an error and gives back where it points.
std::string refused(const Image<std::uint8_t>& left, const Image<std::uint8_t>& right,
                    const StereoOptions& options) {
  StereoMatcher matcher;
  const auto result = matcher.match(left, right, options);
  return result ? "accepted" : result.error().where;
}

TEST(StereoMatcher, RefusesWhatCannotBeMatched) {
  const Image<std::uint8_t> image = random_image(80, 20, 1), other = random_image(81, 20, 1);
  EXPECT_EQ(refused(image, other, {}), "stereo");
  EXPECT_EQ(refused({}, {}, {}), "stereo");
  StereoOptions options;
  options.sad.window_width_px = 4;
  EXPECT_EQ(refused(image, image, options), "sad.window_width_px");
  options = {};
  options.sad.num_disparities = 81;
  EXPECT_EQ(refused(image, image, options), "sad.num_disparities");
  options.sad.num_disparities = 80;
  EXPECT_EQ(refused(image, image, options), "accepted");
  options.sad.num_disparities = 64;
  options.edges.kind = EdgeKind::kNone;
  options.sad.min_texture = 3.0;
  EXPECT_EQ(refused(image, image, options), "sad.min_texture, edges.kind");
  const Image<std::uint8_t> wide = random_image(3000, 2, 1);
  options = {};
  options.sad.min_disparity_px = 900;
  options.sad.num_disparities = 300;
  EXPECT_EQ(refused(wide, wide, options), "sad.min_disparity_px, sad.num_disparities");
  StereoMatcher matcher;
  const ImageView<const std::uint8_t> overlapping{image.row(0), 80, 20, 40};
  EXPECT_FALSE(matcher.match(overlapping, overlapping, {}));
}

TEST(StereoMatcher, TwoPlanesAreFoundAndSmallHolesFilled) {
  const auto truth = [](int x, int) { return x < 100 ? 8.0 : 20.0; };
  const Pair pair = textured_pair(220, 90, 6, truth);
  StereoMatcher matcher;
  StereoOptions options;
  options.sad.num_disparities = 32;
  const auto disparity = matcher.match(pair.left, pair.right, options);
  ASSERT_TRUE(disparity);
  int known = 0, wrong = 0;
  for (int y = 0; y < 90; ++y) {
    for (int x = 40; x < 210; ++x) {
      if ((*disparity)(x, y) == kNoMatch || (x > 90 && x < 110)) continue;
      ++known;
      wrong += std::abs(disparity_px((*disparity)(x, y)) - truth(x, y)) > 0.25 ? 1 : 0;
    }
  }
  EXPECT_GT(known, 90 * 150 * 9 / 10);
  EXPECT_EQ(wrong, 0);
}

TEST(StereoMatcher, BrightnessAndContrastDoNotMatter) {
  const Pair pair = textured_pair(160, 60, 12, [](int, int) { return 10.0; });
  Image<std::uint8_t> darker = pair.right;
  for (int y = 0; y < 60; ++y) {
    for (int x = 0; x < 160; ++x) {
      darker(x, y) = static_cast<std::uint8_t>(20 + pair.right(x, y) * 7 / 10);
    }
  }
  StereoMatcher matcher;
  StereoOptions options;
  options.sad.num_disparities = 24;
  const auto disparity = matcher.match(pair.left, darker, options);
  ASSERT_TRUE(disparity);
  int right_answers = 0;
  for (int y = 5; y < 55; ++y) {
    for (int x = 30; x < 150; ++x) {
      right_answers += (*disparity)(x, y) != kNoMatch &&
                               std::abs(disparity_px((*disparity)(x, y)) - 10.0F) < 0.5F
                           ? 1
                           : 0;
    }
  }
  EXPECT_GT(right_answers, 50 * 120 * 85 / 100);
}

TEST(StereoMatcher, WithoutTextureNothingIsInvented) {
  const Image<std::uint8_t> wall(200, 100, 90);
  StereoMatcher matcher;
  const auto disparity = matcher.match(wall, wall, {});
  ASSERT_TRUE(disparity);
  EXPECT_EQ(disparity_density(*disparity), 0.0);
}

TEST(PaperQ, StereoModeIsAsThePaperRanIt) {
  const StereoOptions options = paper_q_stereo_options();
  EXPECT_EQ(options.sad.min_disparity_px, 10);
  EXPECT_EQ(options.sad.min_disparity_px + options.sad.num_disparities - 1, 74);
  EXPECT_EQ(options.sad.sub_pixel_steps, 4);
  EXPECT_EQ(options.sad.reference, Reference::kRight);
  EXPECT_EQ(options.sad.uniqueness_percent, 0);
  EXPECT_EQ(options.sad.min_texture, 0.0);
  EXPECT_LT(options.sad.left_right_tolerance_px, 0);
  EXPECT_TRUE(options.holes.temporal && options.holes.spatial);

  // A slanted plane over the walker's range, seen by its camera: depths in steps of 1/4 px, inside
  // the gate of 0.8 to 4 m.
  const auto rig = rectified_rig(bumblebee2(640));
  ASSERT_TRUE(rig);
  const auto truth = [](int, int y) { return 12.0 + 50.0 * y / 480.0; };
  const Pair pair = textured_pair(640, 480, 2, truth);
  StereoMatcher matcher;
  const auto disparity = matcher.match(pair.left, pair.right, options);
  ASSERT_TRUE(disparity);
  Image<float> depth;
  depth_image(*disparity, *rig, {}, depth);
  int known = 0, gated = 0;
  double error_px = 0.0;
  for (int y = 20; y < 460; ++y) {
    for (int x = 20; x < 500; ++x) {
      const Disparity d = (*disparity)(x, y);
      if (d == kNoMatch) continue;
      EXPECT_EQ(d % 16, 0);
      ++known;
      error_px += std::abs(disparity_px(d) - truth(x, y));
      const double z = 40.0 / disparity_px(d);
      EXPECT_EQ(!std::isnan(depth(x, y)), z >= 0.8 && z <= 4.0);
      gated += std::isnan(depth(x, y)) ? 1 : 0;
    }
  }
  EXPECT_GT(known, 440 * 480 * 9 / 10);
  EXPECT_GT(gated, 0);  // 50 px and more are nearer than 0.8 m
  EXPECT_LT(error_px / known, 0.25);
}

TEST(Depth, FollowsEquationOneAndTheGate) {
  const auto rig = rectified_rig(bumblebee2(640));
  ASSERT_TRUE(rig);
  Image<Disparity> disparity(4, 1, kNoMatch);
  disparity(0, 0) = 10 * kDisparityScale;  // 4.0 m, on the gate
  disparity(1, 0) = 50 * kDisparityScale;  // 0.8 m, on the gate
  disparity(2, 0) = 9 * kDisparityScale;   // 4.44 m
  Image<float> depth;
  depth_image(disparity, *rig, {}, depth);
  EXPECT_NEAR(depth(0, 0), 4.0, 1e-5);
  EXPECT_NEAR(depth(1, 0), 0.8, 1e-6);
  EXPECT_TRUE(std::isnan(depth(2, 0)));
  EXPECT_TRUE(std::isnan(depth(3, 0)));
  EXPECT_NEAR(depth_sigma_m(*rig, 2.0), 0.025, 1e-6);
}

TEST(Depth, TheNearestMustBeLessThanTheFarthest) {
  EXPECT_TRUE(check_options(DepthOptions{0.8, 4.0}));
  for (const DepthOptions& options : {DepthOptions{4.0, 0.8}, DepthOptions{2.0, 2.0}}) {
    const Status refused = check_options(options);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().where, "min_depth_m, max_depth_m");
  }
}

TEST(Depth, CloudHasOnePointAPixelInLeftAxesForEitherReference) {
  const auto rig = rectified_rig(bumblebee2(640));
  ASSERT_TRUE(rig);
  Image<float> depth(640, 480, std::nanf(""));
  depth(400, 100) = 2.0F;
  Image<Rgb> colour(640, 480);
  colour(400, 100) = {1, 2, 3};
  PointCloud cloud;
  depth_cloud(depth, *rig, Reference::kLeft, colour, cloud);
  ASSERT_EQ(cloud.points.size(), 1U);
  EXPECT_EQ(cloud.colours.at(0), (Rgb{1, 2, 3}));
  EXPECT_NEAR(cloud.points[0].x(), (400 - rig->cx_px) * 2.0 / rig->fx_px, 1e-5);
  EXPECT_NEAR(cloud.points[0].y(), (100 - rig->cy_px) * 2.0 / rig->fy_px, 1e-5);
  // The same pixel of the right image lies a baseline further right.
  const float x_left = cloud.points[0].x();
  depth_cloud(depth, *rig, Reference::kRight, {}, cloud);
  ASSERT_EQ(cloud.points.size(), 1U);
  EXPECT_TRUE(cloud.colours.empty());
  EXPECT_NEAR(cloud.points[0].x() - x_left, rig->baseline_m, 1e-5);
  // Colours of another size are nobody's.
  depth_cloud(depth, *rig, Reference::kLeft, Image<Rgb>(320, 240), cloud);
  EXPECT_EQ(cloud.points.size(), 1U);
  EXPECT_TRUE(cloud.colours.empty());
}

// Whatever the sizes, strides and options: an answer or an error, and nothing read outside the
// images (they end with their last pixel; the sanitizer looks).
// Options, sizes, strides and contents at random; the images have no byte to spare. What is matched
// is the same with two threads, and what has no match has no rating before the filters.
TEST(StereoMatcher, AnySizeAndOptionsGiveAnAnswerOrAnError) {
  std::mt19937 random(11);
  const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  const auto choose = [&](auto... values) {
    const std::array all{values...};
    return all[static_cast<std::size_t>(below(static_cast<int>(all.size())))];
  };
  StereoMatcher matcher, of_two_threads;
  int matched = 0, refused = 0;
  for (int round = 0; round < 600; ++round) {
    const int width = 1 + below(90), height = 1 + below(40);
    const auto image = [&](int w, int h, int stride, unsigned seed) {
      std::mt19937 noise(seed);
      std::vector<std::uint8_t> pixels(static_cast<std::size_t>(stride * (h - 1) + w));
      for (auto& pixel : pixels) pixel = static_cast<std::uint8_t>(noise());
      return pixels;
    };
    const int shift = below(4), stride = width + below(4), other_stride = width + below(4);
    const int other_width = below(20) == 0 ? width + 1 : width;
    const auto seed = static_cast<unsigned>(random());
    const auto left = image(width, height, stride, seed);
    auto right = image(other_width, height, other_width + other_stride - width, seed + 1);
    for (int y = 0; y < height && other_width == width; ++y) {
      for (int x = shift; x < width; ++x) {
        right[static_cast<std::size_t>(y * other_stride + x - shift)] =
            left[static_cast<std::size_t>(y * stride + x)];
      }
    }
    StereoOptions o;
    o.method = choose(StereoMethod::kSad, StereoMethod::kSgm);
    o.edges.kind = choose(EdgeKind::kGradient, EdgeKind::kLaplacian, EdgeKind::kNone);
    o.edges.gain = choose(1.0, 3.0);
    o.edges.limit = 1 + below(128);
    o.sad.reference = below(4) == 0 ? Reference::kRight : Reference::kLeft;
    o.sad.window_width_px = 1 + 2 * below(16) + (below(9) == 0 ? 1 : 0);  // even ones are refused
    o.sad.window_height_px = 1 + 2 * below(16);
    o.sad.min_disparity_px = below(12);
    o.sad.num_disparities = below(width + 8);  // none, or more than the image has, is refused
    o.sad.border = choose(Border::kFullWindow, Border::kReplicate);
    o.sad.sub_pixel = choose(SubPixel::kNone, SubPixel::kSymmetricV, SubPixel::kParabola);
    o.sad.strict_sub_pixel = below(2) == 0;
    o.sad.uniqueness_percent = below(100);
    o.sad.min_texture = below(3) == 0 ? 2.0 : 0.0;
    o.sad.left_right_tolerance_px = below(3) - 1;
    o.sgm.paths = choose(SgmPaths::kThree, choose(SgmPaths::kFour, SgmPaths::kEight));
    o.sgm.p2 = below(51);  // 50 is refused
    o.sgm.p1 = below(o.sgm.p2 + 1);
    o.sgm.uniqueness_percent = below(101);
    o.sgm.left_right_tolerance_px = below(3) - 1;
    for (HoleFilterOptions* holes : {&o.holes, &o.sgm.holes}) {
      holes->temporal = below(2) == 0;
      holes->spatial = below(2) == 0;
      holes->median = choose(HoleFilterOptions::Median::kAll, HoleFilterOptions::Median::kKnown);
      holes->update =
          choose(HoleFilterOptions::Update::kBuffered, HoleFilterOptions::Update::kInPlace);
      holes->passes = 1 + below(3);
    }
    o.speckle.enabled = o.sgm.speckle.enabled = below(2) == 0;
    o.temporal.enabled = below(2) == 0;
    o.rate = below(2) == 0;
    if (below(3) == 0) {
      for (HoleFilterOptions* holes : {&o.holes, &o.sgm.holes})
        holes->temporal = holes->spatial = false;
      o.speckle.enabled = o.sgm.speckle.enabled = o.temporal.enabled = false;
    }
    const auto match = [&](StereoMatcher& by, int threads) {
      return by.match(ImageView<const std::uint8_t>{left.data(), width, height, stride},
                      ImageView<const std::uint8_t>{right.data(), other_width, height,
                                                    other_width + other_stride - width},
                      o, {threads, nullptr});
    };
    const auto found = match(matcher, 1);
    const auto again = match(of_two_threads, 2);
    ASSERT_EQ(found.has_value(), again.has_value());
    (found ? matched : refused) += 1;
    if (!found) {
      EXPECT_FALSE(found.error().remedy.empty());
      continue;
    }
    ASSERT_TRUE(found->width == width && found->height == height);
    ASSERT_EQ(matcher.residual().empty(), !o.rate);
    const bool filtered = o.holes.temporal || o.holes.spatial || o.sgm.holes.temporal ||
                          o.sgm.holes.spatial || o.speckle.enabled || o.temporal.enabled;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        ASSERT_EQ((*found)(x, y), (*again)(x, y)) << round;
        if (!o.rate || filtered) continue;
        ASSERT_EQ(matcher.residual()(x, y) == kNoResidual, (*found)(x, y) == kNoMatch) << round;
      }
    }
  }
  EXPECT_GT(matched, 200);
  EXPECT_GT(refused, 60);
}

}  // namespace
}  // namespace tread
