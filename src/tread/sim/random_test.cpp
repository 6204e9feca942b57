#include "tread/sim/random.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <vector>

namespace tread {
namespace {

TEST(Random, TheIntegersAreThoseOfSplitMix64) {
  Random random(1234567);  // the values that its reference implementation gives
  for (const std::uint64_t expected :
       {6457827717110365317ULL, 3203168211198807973ULL, 9817491932198370423ULL,
        4593380528125082431ULL, 16408922859458223821ULL}) {
    EXPECT_EQ(random.bits64(), expected);
  }
  Random high(1234567);
  EXPECT_EQ(high.bits(), 6457827717110365317ULL >> 32);
  Random part(1234567);
  EXPECT_EQ(part.uniform(), std::ldexp(static_cast<double>(6457827717110365317ULL >> 11), -53));
}

TEST(Random, StreamsDependOnTheirNamesAndNotOnWhatWasDrawn) {
  Random root(7);
  Random before = root.stream("imu");
  for (int i = 0; i < 5; ++i) (void)root.normal();
  Random after = root.stream("imu");
  Random drawn = root.stream("imu");
  (void)drawn.normal();
  Random below = drawn.stream("gyro"), same = before.stream("gyro");
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(before.bits64(), after.bits64());
    EXPECT_EQ(below.bits64(), same.bits64());
  }
}

TEST(Random, NoTwoStreamsAreAlike) {
  std::set<std::uint64_t> first;
  std::size_t streams = 0;
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    Random root(seed);
    for (std::uint64_t number = 0; number < 50; ++number, ++streams) {
      first.insert(root.stream(number).bits64());
    }
    for (const char* name : {"", "a", "b", "ab", "ba", "imu", "imu2", "gnss"}) {
      first.insert(root.stream(name).bits64());
      ++streams;
    }
    for (int i = 0; i < 20; ++i, ++streams) first.insert(root.bits64());
  }
  EXPECT_EQ(first.size(), streams);
}

// Pearson's correlation over `count` numbers, which is 1 / sqrt(count) for independent ones.
double correlation(Random a, Random b, int count) {
  double ab = 0.0, aa = 0.0, bb = 0.0;
  for (int i = 0; i < count; ++i) {
    const double x = a.uniform() - 0.5, y = b.uniform() - 0.5;
    ab += x * y;
    aa += x * x;
    bb += y * y;
  }
  return ab / std::sqrt(aa * bb);
}

TEST(Random, StreamsAreIndependent) {
  constexpr int kCount = 100'000;
  constexpr double kFourSigma = 4.0 / 316.0;
  const Random root(11);
  EXPECT_LT(std::abs(correlation(root.stream(1), root.stream(2), kCount)), kFourSigma);
  EXPECT_LT(std::abs(correlation(root, root.stream(0), kCount)), kFourSigma);
  EXPECT_LT(std::abs(correlation(Random(0), Random(1), kCount)), kFourSigma);
  Random ahead = root;
  (void)ahead.bits64();
  EXPECT_LT(std::abs(correlation(root, ahead, kCount)), kFourSigma) << "a number and the next";
  EXPECT_NEAR(correlation(root, root, kCount), 1.0, 1e-12) << "the check sees what is not";
}

TEST(Random, UniformNumbersFillTheirRangeEvenly) {
  Random random(3);
  constexpr int kCount = 200'000, kBins = 64;
  std::array<int, kBins> bins{};
  for (int i = 0; i < kCount; ++i) {
    const double x = random.uniform();
    ASSERT_GE(x, 0.0);
    ASSERT_LT(x, 1.0);
    ++bins[static_cast<std::size_t>(x * kBins)];
  }
  double chi2 = 0.0;
  for (const int n : bins) chi2 += std::pow(n - kCount / kBins, 2) / (kCount / kBins);
  EXPECT_NEAR(chi2, kBins - 1, 4.0 * std::sqrt(2.0 * (kBins - 1)));
  for (int i = 0; i < 1000; ++i) {
    const double x = random.uniform(-2.0, 3.0);
    ASSERT_TRUE(x >= -2.0 && x < 3.0);
  }
}

TEST(Random, NormalNumbersHaveTheMomentsAndTails) {
  Random random(5);
  constexpr int kCount = 400'000;
  std::vector<double> x(kCount);
  for (double& value : x) value = random.normal();
  const auto moment = [&](int power) {
    double sum = 0.0;
    for (const double value : x) sum += std::pow(value, power);
    return sum / kCount;
  };
  const double sigma = 1.0 / std::sqrt(kCount);  // of the mean; then of the others in its terms
  EXPECT_NEAR(moment(1), 0.0, 4.0 * sigma);
  EXPECT_NEAR(moment(2), 1.0, 4.0 * sigma * std::sqrt(2.0));
  EXPECT_NEAR(moment(3), 0.0, 4.0 * sigma * std::sqrt(15.0));
  EXPECT_NEAR(moment(4), 3.0, 4.0 * sigma * std::sqrt(96.0));
  const auto beyond = std::count_if(x.begin(), x.end(), [](double v) { return v > 2.0; });
  EXPECT_NEAR(static_cast<double>(beyond) / kCount, 0.022750, 4.0 * 0.149 * sigma);
  double next = 0.0;
  for (std::size_t i = 1; i < x.size(); ++i) next += x[i - 1] * x[i];
  EXPECT_NEAR(next / kCount, 0.0, 4.0 * sigma) << "the two of a pair are independent too";
}

TEST(Random, WaitingTimesHaveMeanOneAndNoMemory) {
  Random random(9);
  constexpr int kCount = 200'000;
  double sum = 0.0, squares = 0.0;
  for (int i = 0; i < kCount; ++i) {
    const double x = random.exponential();
    ASSERT_GE(x, 0.0);
    sum += x;
    squares += x * x;
  }
  EXPECT_NEAR(sum / kCount, 1.0, 4.0 / std::sqrt(kCount));
  EXPECT_NEAR(squares / kCount, 2.0, 4.0 * std::sqrt(20.0 / kCount));
}

}  // namespace
}  // namespace tread
