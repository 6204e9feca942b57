#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "tread/sim/hash_noise_kernel.hpp"

namespace tread {
namespace {

// Places that follow no lattice.
float place(std::uint32_t i) {
  return 300.0F * signed_unit(hash_mix(i));
}

struct Moments {
  double mean = 0.0, sigma = 0.0, least = 1e9, most = -1e9;
};
template <class Value>
Moments moments(const Value& value) {
  constexpr std::uint32_t kCount = 40000;
  double sum = 0.0, squares = 0.0;
  Moments result;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    const auto x = static_cast<double>(value(place(3 * i), place(3 * i + 1), place(3 * i + 2)));
    sum += x;
    squares += x * x;
    result.least = std::min(result.least, x);
    result.most = std::max(result.most, x);
  }
  result.mean = sum / kCount;
  result.sigma = std::sqrt(squares / kCount - result.mean * result.mean);
  return result;
}

// Flipping any bit of what is hashed flips each bit of the hash half of the times.
TEST(HashNoise, EveryBitOfThePlaceChangesHalfTheBitsOfTheHash) {
  for (int bit = 0; bit < 12; ++bit) {
    for (const bool along_y : {false, true}) {
      double flipped = 0.0;
      constexpr int kTimes = 4000;
      for (int i = 0; i < kTimes; ++i) {
        const auto h = hash_mix(static_cast<std::uint32_t>(i));
        const auto x = static_cast<std::int32_t>(h & 0xFFFU),
                   y = static_cast<std::int32_t>(h >> 20);
        const std::int32_t dx = along_y ? 0 : 1 << bit, dy = along_y ? 1 << bit : 0;
        flipped += std::popcount(hash_lattice(x, y, 9U) ^ hash_lattice(x ^ dx, y ^ dy, 9U));
      }
      EXPECT_NEAR(flipped / kTimes, 16.0, 0.25) << bit;
    }
  }
}

TEST(HashNoise, HashesFillTheirRangeEvenly) {
  std::array<int, 64> bins{};
  for (int y = 0; y < 256; ++y) {
    for (int x = 0; x < 256; ++x) {
      const float u = unit(hash_lattice(x, y, 1U));
      ASSERT_GE(u, 0.0F);
      ASSERT_LT(u, 1.0F);
      ++bins[static_cast<std::size_t>(64.0F * u)];
    }
  }
  double chi2 = 0.0;
  for (const int count : bins) chi2 += (count - 1024.0) * (count - 1024.0) / 1024.0;
  // 63 degrees of freedom: 99.99 % below 115, and not too even either.
  EXPECT_LT(chi2, 115.0);
  EXPECT_GT(chi2, 30.0);
}

TEST(HashNoise, FloorIsThatOfTheLibrary) {
  for (const float x : {-2.5F, -1.0F, -0.999F, -0.0F, 0.0F, 0.3F, 1.0F, 7.99F}) {
    EXPECT_EQ(static_cast<float>(lattice_floor(x)), std::floor(x)) << x;
  }
  for (const float x : {-9.0F, -0.2F, 0.0F, 0.25F, 1.0F, 1.4F, 900.0F}) {
    EXPECT_NEAR(clamped(x), std::clamp(x, 0.0F, 1.0F), 1e-4F) << x;
    EXPECT_NEAR(larger_of(x, 0.3F), std::max(x, 0.3F), 1e-4F) << x;
  }
}

TEST(HashNoise, HasTheSpreadThatItsDocumentationSays) {
  const Moments value2 = moments([](float x, float y, float) { return value_noise(x, y, 3U); });
  const Moments value3 =
      moments([](float x, float y, float z) { return value_noise(x, y, z, 3U); });
  const Moments slope2 = moments([](float x, float y, float) { return gradient_noise(x, y, 3U); });
  const Moments slope3 =
      moments([](float x, float y, float z) { return gradient_noise(x, y, z, 3U); });
  for (const Moments& m : {value2, value3, slope2, slope3}) EXPECT_NEAR(m.mean, 0.0, 0.01);
  EXPECT_NEAR(value2.sigma, 0.455, 0.01);
  EXPECT_NEAR(value3.sigma, 0.40, 0.01);
  EXPECT_NEAR(slope2.sigma, 0.175, 0.01);
  EXPECT_NEAR(slope3.sigma, 0.19, 0.01);
  EXPECT_GE(std::min(value2.least, value3.least), -1.0);
  EXPECT_LE(std::max(value2.most, value3.most), 1.0);
  EXPECT_GE(std::min(slope2.least, slope3.least), -1.5);
  EXPECT_LE(std::max(slope2.most, slope3.most), 1.5);
}

TEST(HashNoise, IsSmoothAcrossTheLattice) {
  for (std::uint32_t i = 0; i < 2000; ++i) {
    const float x = std::round(place(i)), y = place(i + 7777U), z = place(i + 99999U);
    constexpr float kStep = 1e-3F;
    EXPECT_NEAR(value_noise(x - kStep, y, 5U), value_noise(x + kStep, y, 5U), 1e-4F);
    EXPECT_NEAR(gradient_noise(x, y, 5U), gradient_noise(x + kStep, y, 5U), 4e-3F);
    EXPECT_NEAR(gradient_noise(x, y, z, 5U), gradient_noise(x + kStep, y, z, 5U), 4e-3F);
    // The slope, too.
    const float before = gradient_noise(x, y, 5U) - gradient_noise(x - kStep, y, 5U),
                after = gradient_noise(x + kStep, y, 5U) - gradient_noise(x, y, 5U);
    EXPECT_NEAR(before, after, 1e-4F);
  }
}

// Another seed, another picture.
TEST(HashNoise, SeedsAreUnrelated) {
  double product = 0.0;
  constexpr std::uint32_t kCount = 20000;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    const float x = place(2 * i), y = place(2 * i + 1);
    product += static_cast<double>(gradient_noise(x, y, 1U) * gradient_noise(x, y, 2U));
  }
  EXPECT_LT(std::abs(product / kCount), 0.03 * 0.175 * 0.175);
}

TEST(HashNoise, FbmIsTheSumOfItsOctaves) {
  const float x = 3.7F, y = -2.2F;
  const float sum = gradient_noise(x, y, 4U) +
                    0.5F * gradient_noise(2.0F * x, 2.0F * y, 4U + kHashStepZ) +
                    0.25F * gradient_noise(4.0F * x, 4.0F * y, 4U + 2U * kHashStepZ);
  EXPECT_NEAR(fbm(x, y, 3, 0.5F, 4U), sum, 1e-6F);
}

// The nearest stone, against a search of a wider neighbourhood.
TEST(HashNoise, CellularFindsTheNearestStone) {
  int same = 0;
  constexpr std::uint32_t kCount = 3000;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    const float x = place(2 * i), y = place(2 * i + 1);
    const Cellular found = cellular(x, y, 6U);
    EXPECT_NEAR(found.nearest, found.dx * found.dx + found.dy * found.dy, 1e-5F);
    EXPECT_GE(found.second, found.nearest);
    float nearest = 1e9F;
    for (std::int32_t v = -3; v <= 3; ++v) {
      for (std::int32_t u = -3; u <= 3; ++u) {
        const std::int32_t sx = lattice_floor(x) + u, sy = lattice_floor(y) + v;
        const std::uint32_t h = hash_lattice(sx, sy, 6U);
        const float dx = x - static_cast<float>(sx) - static_cast<float>(h & 0xFFFFU) / 65536.0F;
        const float dy = y - static_cast<float>(sy) - static_cast<float>(h >> 16) / 65536.0F;
        nearest = std::min(nearest, dx * dx + dy * dy);
      }
    }
    same += std::abs(nearest - found.nearest) < 1e-3F ? 1 : 0;
  }
  // Hardly ever is the nearest two squares away.
  EXPECT_GT(same, static_cast<int>(kCount) * 99 / 100);
}

}  // namespace
}  // namespace tread
