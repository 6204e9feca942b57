#include "tread/slam/keyframe_store.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <random>

namespace tread {
namespace {

constexpr std::size_t kMiB = 1U << 20U;

// A wavy surface with noise, a step and holes.
Image<float> some_depth(const DepthNoise& noise, unsigned seed, int width = 160, int height = 120) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  Image<float> depth(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      double z = x > width / 2 ? 1.2 : 3.0 + 0.5 * std::sin(0.05 * x + 0.08 * y);
      z += noise.sigma_m(z) * normal(random);
      depth(x, y) =
          (x + 3 * y) % 17 == 0 ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(z);
    }
  }
  return depth;
}

// Largest error in standard deviations; infinite where known and unknown pixels are not the same.
double largest_error(const Image<float>& a, const Image<float>& b, const DepthNoise& noise) {
  double largest = 0.0;
  for (int y = 0; y < a.height; ++y) {
    for (int x = 0; x < a.width; ++x) {
      const float p = a(x, y), q = b(x, y);
      if (std::isnan(p) != std::isnan(q)) return std::numeric_limits<double>::infinity();
      if (!std::isnan(p)) {
        largest = std::max(largest, std::abs(static_cast<double>(p) - q) / noise.sigma_m(p));
      }
    }
  }
  return largest;
}

TEST(KeyframeStore, GivesDepthsBackToAnEighthOfTheirNoise) {
  for (const DepthNoise& noise :
       {DepthNoise{}, DepthNoise{0.0005, 0.007}, DepthNoise{0.002, 0.0}}) {
    KeyframeStore store(noise, 5.0, 4 * kMiB, 0);
    const Image<float> depth = some_depth(noise, 3);
    ASSERT_TRUE(store.put(5, depth, {}, {}));
    StoredKeyframe back;
    ASSERT_TRUE(store.get(5, back));
    ASSERT_TRUE(same_size(back.depth, depth));
    EXPECT_LE(largest_error(depth, back.depth, noise), 0.127);
    EXPECT_GT(largest_error(depth, back.depth, noise), 0.05) << "they are rounded";
    EXPECT_TRUE(back.grey.empty());
    EXPECT_TRUE(back.rgb.empty());
    // Noise of four steps: hardly more than a byte a pixel.
    EXPECT_LT(store.memory_bytes(), 160U * 120U * 3U / 2U);
    // What was rounded once stays as it is.
    ASSERT_TRUE(store.put(6, back.depth, {}, {}));
    StoredKeyframe again;
    ASSERT_TRUE(store.get(6, again));
    EXPECT_EQ(largest_error(back.depth, again.depth, noise), 0.0);
  }
}

// A range of more than 65535 steps has coarser ones.
TEST(KeyframeStore, ALongRangeIsKeptToAPartOfItself) {
  const DepthNoise noise{1e-6, 0.0};
  KeyframeStore store(noise, 200.0, kMiB, 0);
  Image<float> depth(4, 1);
  depth(0, 0) = 0.004F;
  depth(1, 0) = 50.0F;
  depth(2, 0) = 200.0F;
  depth(3, 0) = 201.0F;
  ASSERT_TRUE(store.put(0, depth, {}, {}));
  StoredKeyframe back;
  ASSERT_TRUE(store.get(0, back));
  for (int x = 0; x < 3; ++x) EXPECT_NEAR(back.depth(x, 0), depth(x, 0), 200.0 / 65534.0);
  EXPECT_TRUE(std::isnan(back.depth(3, 0))) << "beyond the range";
}

TEST(KeyframeStore, KeepsWhatThePlaceLooksLike) {
  const DepthNoise noise;
  KeyframeStore store(noise, 5.0, kMiB, 0);
  Image<float> depth(64, 48, 1.5F);
  Image<Rgb> rgb(64, 48);
  Image<std::uint8_t> grey(64, 48);
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) {
      rgb(x, y) = {static_cast<std::uint8_t>(3 * x), static_cast<std::uint8_t>(4 * y), 40};
      grey(x, y) = static_cast<std::uint8_t>(2 * x + y);
    }
  }
  ASSERT_TRUE(store.put(1, depth, rgb, {}));
  ASSERT_TRUE(store.put(2, depth, {}, grey));
  StoredKeyframe coloured, plain;
  ASSERT_TRUE(store.get(1, coloured));
  ASSERT_TRUE(store.get(2, plain));
  ASSERT_TRUE(same_size(coloured.rgb, depth));
  ASSERT_TRUE(same_size(plain.grey, depth));
  EXPECT_TRUE(coloured.grey.empty());
  double error = 0.0;
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) {
      error = std::max<double>({error, std::abs(coloured.rgb(x, y).r - rgb(x, y).r) / 2.0,
                                std::abs(coloured.rgb(x, y).g - rgb(x, y).g) / 2.0,
                                std::abs(coloured.rgb(x, y).b - rgb(x, y).b) / 2.0,
                                static_cast<double>(std::abs(plain.grey(x, y) - grey(x, y)))});
    }
  }
  EXPECT_LT(error, 6.0);
  // A picture of another size is no picture of this.
  ASSERT_TRUE(store.put(3, depth, {}, Image<std::uint8_t>(10, 10)));
  ASSERT_TRUE(store.get(3, plain));
  EXPECT_TRUE(plain.grey.empty());
}

TEST(KeyframeStore, NeverPassesItsCapsAndUsesWhatIsGivenBack) {
  const DepthNoise noise;
  const std::size_t memory = 20 * KeyframeStore::kPageBytes, file = 30 * KeyframeStore::kPageBytes;
  KeyframeStore store(noise, 5.0, memory, file);
  std::int64_t id = 0;
  while (store.put(id, some_depth(noise, static_cast<unsigned>(id)), {}, {})) {
    ++id;
    ASSERT_LE(store.memory_bytes(), memory);
    ASSERT_LE(store.file_bytes(), file);
    ASSERT_LT(id, 1000);
  }
  // 50 pages, some three for each.
  EXPECT_GE(id, 14);
  EXPECT_GT(store.file_bytes(), 0U);
  EXPECT_EQ(store.size(), static_cast<std::size_t>(id));
  StoredKeyframe back;
  EXPECT_FALSE(store.get(id, back)) << "there was no room";
  for (int round = 0; round < 3; ++round) {
    for (std::int64_t i = 0; i < id; i += 2) store.remove(i + 1000 * round);
    for (std::int64_t i = 0; i < id; i += 2) {
      ASSERT_TRUE(store.put(i + 1000 * (round + 1),
                            some_depth(noise, static_cast<unsigned>(i + round)), {}, {}));
    }
    EXPECT_LE(store.memory_bytes(), memory);
    EXPECT_LE(store.file_bytes(), file);
  }
  // All are whole, those in memory and those in the file.
  for (std::int64_t i = 0; i < id; ++i) {
    const bool even = i % 2 == 0;
    ASSERT_TRUE(store.get(even ? i + 3000 : i, back)) << i;
    const auto seed = static_cast<unsigned>(even ? i + 2 : i);
    EXPECT_LE(largest_error(some_depth(noise, seed), back.depth, noise), 0.127) << i;
  }
  store.clear();
  EXPECT_EQ(store.size(), 0U);
  EXPECT_EQ(store.memory_bytes() + store.file_bytes(), 0U);
  EXPECT_TRUE(store.put(0, some_depth(noise, 0), {}, {}));
}

TEST(KeyframeStore, WhatCannotBeKeptIsRefused) {
  KeyframeStore store({}, 5.0, kMiB, 0);
  EXPECT_FALSE(store.put(1, {}, {}, {}));
  ASSERT_TRUE(store.put(1, Image<float>(8, 8, 1.0F), {}, {}));
  EXPECT_FALSE(store.put(1, Image<float>(8, 8, 2.0F), {}, {})) << "the id is taken";
  StoredKeyframe back;
  ASSERT_TRUE(store.get(1, back));
  EXPECT_NEAR(back.depth(3, 3), 1.0F, 0.001F);
  store.remove(17);
  EXPECT_FALSE(store.get(17, back));
  KeyframeStore none({}, 5.0, 0, 0);
  EXPECT_FALSE(none.put(1, Image<float>(8, 8, 1.0F), {}, {}));
  // Not a number, infinity, behind the camera.
  Image<float> odd(3, 1);
  odd(0, 0) = std::numeric_limits<float>::quiet_NaN();
  odd(1, 0) = std::numeric_limits<float>::infinity();
  odd(2, 0) = -1.0F;
  ASSERT_TRUE(store.put(2, odd, {}, {}));
  ASSERT_TRUE(store.get(2, back));
  for (int x = 0; x < 3; ++x) EXPECT_TRUE(std::isnan(back.depth(x, 0))) << x;
}

}  // namespace
}  // namespace tread
