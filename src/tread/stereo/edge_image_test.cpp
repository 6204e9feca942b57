#include "tread/stereo/edge_image.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "stereo_images.hpp"

namespace tread {
namespace {

using testing::random_image;

// The Laplacian of Gaussian written as its definition says, in double.
Image<std::uint8_t> laplacian_oracle(const Image<std::uint8_t>& image, int mask, double gain) {
  const int r = mask / 2;
  const double sigma = mask / 6.0;
  const auto g = [sigma](int i) { return std::exp(-i * i / (2 * sigma * sigma)); };
  double g2_sum = 0.0;
  for (int i = -r; i <= r; ++i) g2_sum += (i * i / (sigma * sigma) - 1.0) * g(i);
  const auto g2 = [&](int i) {
    return (i * i / (sigma * sigma) - 1.0) * g(i) - (i == 0 ? g2_sum : 0.0);
  };
  double positive = 0.0;
  for (int j = -r; j <= r; ++j) {
    for (int i = -r; i <= r; ++i) positive += std::max(0.0, g2(i) * g(j) + g(i) * g2(j));
  }
  Image<std::uint8_t> edges(image.width, image.height);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      double sum = 0.0;
      for (int j = -r; j <= r; ++j) {
        for (int i = -r; i <= r; ++i) {
          sum -= (g2(i) * g(j) + g(i) * g2(j)) * image(std::clamp(x + i, 0, image.width - 1),
                                                       std::clamp(y + j, 0, image.height - 1));
        }
      }
      edges(x, y) = static_cast<std::uint8_t>(
          std::clamp(std::floor(128.0 + gain * sum / positive), 0.0, 255.0));
    }
  }
  return edges;
}

TEST(EdgeImage, ConstantImageIsFlatWhateverItsBrightness) {
  for (EdgeKind kind : {EdgeKind::kGradient, EdgeKind::kLaplacian}) {
    for (int mask : {3, 5, 7, 9, 11}) {
      for (int value : {0, 1, 128, 255}) {
        const Image<std::uint8_t> image(13, 9, static_cast<std::uint8_t>(value));
        Image<std::uint8_t> edges;
        edge_image(image, {kind, 16.0, 128, mask}, edges);
        EXPECT_TRUE(edges == Image<std::uint8_t>(13, 9, 128)) << mask << " " << value;
      }
    }
  }
}

TEST(EdgeImage, LaplacianIsItsDefinitionToOneGreyLevel) {
  const Image<std::uint8_t> image = random_image(41, 33, 3);
  for (int mask : {3, 5, 7, 9, 11}) {
    Image<std::uint8_t> edges;
    edge_image(image, {EdgeKind::kLaplacian, 1.0, 128, mask}, edges);
    const Image<std::uint8_t> expected = laplacian_oracle(image, mask, 1.0);
    int worst = 0;
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        worst = std::max(worst, std::abs(int{edges(x, y)} - int{expected(x, y)}));
      }
    }
    EXPECT_LE(worst, 2) << mask;  // the mask is rounded to 1/1024
  }
}

TEST(EdgeImage, GradientOfARampIsEightTimesItsSlope) {
  Image<std::uint8_t> ramp(20, 6);
  for (int y = 0; y < 6; ++y) {
    for (int x = 0; x < 20; ++x) ramp(x, y) = static_cast<std::uint8_t>(2 * x + 50 * (y % 2));
  }
  Image<std::uint8_t> edges;
  edge_image(ramp, {EdgeKind::kGradient, 1.0, 100, 7}, edges);
  for (int y = 0; y < 6; ++y) {
    for (int x = 1; x < 19; ++x) EXPECT_EQ(edges(x, y), 128 + 16);
  }
  edge_image(ramp, {EdgeKind::kGradient, 1.0, 10, 7}, edges);
  EXPECT_EQ(edges(10, 3), 138);  // cut off
  edge_image(ramp, {EdgeKind::kGradient, 0.5, 100, 7}, edges);
  EXPECT_EQ(edges(10, 3), 136);
}

TEST(EdgeImage, ValuesStayWithinTheLimitAndTheStatedDifference) {
  const Image<std::uint8_t> image = random_image(64, 48, 5);
  for (EdgeKind kind : {EdgeKind::kGradient, EdgeKind::kLaplacian, EdgeKind::kNone}) {
    for (int limit : {1, 15, 127, 128}) {
      const EdgeOptions options{kind, 64.0, limit, 5};
      Image<std::uint8_t> edges;
      edge_image(image, options, edges);
      int low = 255, high = 0;
      for (int y = 0; y < edges.height; ++y) {
        for (int x = 0; x < edges.width; ++x) {
          low = std::min<int>(low, edges(x, y));
          high = std::max<int>(high, edges(x, y));
        }
      }
      EXPECT_LE(high - low, largest_edge_difference(options));
      if (kind != EdgeKind::kNone) {
        EXPECT_GE(low, 128 - limit);
        EXPECT_LE(high, 128 + limit);
      } else {
        EXPECT_TRUE(edges == image);
      }
    }
  }
}

TEST(EdgeImage, SameForAnyThreadCountAndAnyStride) {
  const Image<std::uint8_t> image = random_image(301, 203, 11);
  for (EdgeKind kind : {EdgeKind::kGradient, EdgeKind::kLaplacian}) {
    Image<std::uint8_t> one, two;
    const ImageView<const std::uint8_t> inner{image.row(1) + 3, 290, 200, image.stride};
    Context context;
    edge_image(inner, {kind}, one, context);
    context.threads = 2;
    edge_image(inner, {kind}, two, context);
    EXPECT_TRUE(one == two);
  }
}

TEST(EdgeImage, TinyImages) {
  for (int width : {1, 2, 3}) {
    for (int height : {1, 2}) {
      Image<std::uint8_t> edges;
      edge_image(random_image(width, height, 1), {EdgeKind::kLaplacian, 1.0, 128, 11}, edges);
      EXPECT_EQ(edges.width, width);
      edge_image(random_image(width, height, 1), {}, edges);
      EXPECT_EQ(edges.height, height);
    }
  }
}

}  // namespace
}  // namespace tread
