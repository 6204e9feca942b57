#include "tread/stereo/uncertainty.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "stereo_images.hpp"
#include "tread/stereo/stereo_matcher.hpp"

namespace tread {
namespace {

TEST(MatchUncertainty, GrowsWithTheResidual) {
  for (const StereoMethod method : {StereoMethod::kSad, StereoMethod::kSgm}) {
    for (int r = 1; r <= kLargestResidual; ++r) {
      const MatchUncertainty less = match_uncertainty(method, static_cast<std::uint8_t>(r - 1));
      const MatchUncertainty more = match_uncertainty(method, static_cast<std::uint8_t>(r));
      EXPECT_LE(more.confidence, less.confidence);
      EXPECT_GE(more.sigma_px, less.sigma_px);
      EXPECT_GT(more.confidence, 0.4F);
      EXPECT_LE(more.confidence, 1.0F);
      EXPECT_GT(less.sigma_px, 0.1F);
      EXPECT_LT(more.sigma_px, 0.6F);
    }
  }
}

TEST(MatchUncertainty, IsMadeOnlyWhereItIsAskedFor) {
  const testing::Pair pair = testing::textured_pair(120, 40, 1, [](int, int) { return 9.25; });
  StereoMatcher matcher;
  StereoOptions options;
  options.sad.num_disparities = 24;
  for (const StereoMethod method : {StereoMethod::kSad, StereoMethod::kSgm}) {
    options.method = method;
    options.rate = false;
    ASSERT_TRUE(matcher.match(pair.left, pair.right, options));
    EXPECT_TRUE(matcher.residual().empty());
    options.rate = true;
    const auto disparity = matcher.match(pair.left, pair.right, options);
    ASSERT_TRUE(disparity);
    ASSERT_TRUE(same_size(matcher.residual(), *disparity));
  }
}

// Of two halves of one picture the noisier has the larger residuals, and what they promise holds:
// the errors are no larger than twice the standard deviation told.
TEST(MatchUncertainty, FollowsTheNoiseOfTheImages) {
  constexpr int kWidth = 400, kHeight = 120;
  testing::Pair pair =
      testing::textured_pair(kWidth, kHeight, 5, [](int, int y) { return 10.0 + 0.06 * y; });
  std::mt19937 random(8);
  std::normal_distribution<double> noise(0.0, 14.0);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = kWidth / 2; x < kWidth; ++x) {
      for (Image<std::uint8_t>* image : {&pair.left, &pair.right}) {
        (*image)(x, y) =
            static_cast<std::uint8_t>(std::clamp((*image)(x, y) + noise(random), 0.0, 255.0));
      }
    }
  }
  for (const StereoMethod method : {StereoMethod::kSad, StereoMethod::kSgm}) {
    StereoOptions options;
    options.method = method;
    options.rate = true;
    options.sad.num_disparities = 32;
    StereoMatcher matcher;
    const auto disparity = matcher.match(pair.left, pair.right, options);
    ASSERT_TRUE(disparity);
    double told[2] = {}, squared[2] = {}, count[2] = {};
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 40; x < kWidth; ++x) {
        if ((*disparity)(x, y) == kNoMatch || std::abs(x - kWidth / 2) < 20) continue;
        const double error = disparity_px((*disparity)(x, y)) - (10.0 + 0.06 * y);
        if (std::fabs(error) > 1.0) continue;
        const int half = x < kWidth / 2 ? 0 : 1;
        const float sigma = match_uncertainty(method, matcher.residual()(x, y)).sigma_px;
        told[half] += sigma * sigma;
        squared[half] += error * error;
        ++count[half];
      }
    }
    ASSERT_GT(count[1], 2000.0);
    const double told_clean = std::sqrt(told[0] / count[0]);
    const double told_noisy = std::sqrt(told[1] / count[1]);
    EXPECT_GT(told_noisy, 1.2 * told_clean);
    EXPECT_LT(std::sqrt(squared[0] / count[0]), 2.0 * told_clean);
    EXPECT_LT(std::sqrt(squared[1] / count[1]), 2.0 * told_noisy);
    EXPECT_GT(std::sqrt(squared[1] / count[1]), 0.4 * told_noisy);
  }
}

TEST(DepthSigmas, AreEq2WithTheDeviationOfTheDisparity) {
  RectifiedRig rig;
  rig.size = {3, 1};
  rig.fx_px = rig.fy_px = 500.0;
  rig.baseline_m = 0.2;
  Image<float> depth(3, 1, 2.0F);
  depth(1, 0) = std::nanf("");
  depth(2, 0) = 4.0F;
  Image<std::uint8_t> residual(3, 1, 16);
  std::vector<float> sigma_m = {9.0F};
  depth_sigmas(depth, residual, rig, StereoMethod::kSad, sigma_m);
  ASSERT_EQ(sigma_m.size(), 2U);
  const double sigma_px = match_uncertainty(StereoMethod::kSad, 16).sigma_px;
  EXPECT_NEAR(sigma_m[0], depth_sigma_m(rig, 2.0, sigma_px), 1e-6);
  EXPECT_NEAR(sigma_m[1], depth_sigma_m(rig, 4.0, sigma_px), 1e-6);
}

}  // namespace
}  // namespace tread
