#include "tread/plan/bucket_queue.hpp"

#include <gtest/gtest.h>

#include <random>

namespace tread {
namespace {

std::vector<double> drain(BucketQueue& queue) {
  std::vector<double> estimates;
  while (!queue.empty()) estimates.push_back(queue.pop().estimate);
  return estimates;
}

TEST(BucketQueue, ComesInOrderOfBucketsAndLastFirstWithin) {
  BucketQueue queue(10.0, 1.0, 20.0);
  for (const double estimate : {12.1, 10.5, 12.7, 29.0, 10.2, 12.3}) queue.push({estimate, 0, 0});
  EXPECT_EQ(drain(queue), (std::vector<double>{10.2, 10.5, 12.3, 12.7, 12.1, 29.0}));
}

TEST(BucketQueue, OrderedItComesInExactOrder) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> step(0.0, 20.0);
  BucketQueue queue(0.0, 3.0, 20.0);
  for (int i = 0; i < 50; ++i) queue.push({step(random), 0, 0});
  queue.order();
  double last = 0.0;
  for (int i = 0; i < 2000; ++i) {  // as a search does: take one, push some that are no better
    const double taken = queue.pop().estimate;
    EXPECT_GE(taken, last);
    last = taken;
    queue.push({taken + step(random), 0, 0});
  }
  EXPECT_EQ(drain(queue).size(), 50U);
}

TEST(BucketQueue, EqualEstimatesComeByPlaceOnceOrdered) {
  BucketQueue queue(0.0, 1.0, 1.0);
  queue.push({0.5, 3, 1});
  queue.push({0.5, 1, 2});
  queue.push({0.5, 2, 1});
  queue.order();
  EXPECT_EQ(queue.pop().x, 2);
  EXPECT_EQ(queue.pop().x, 3);
  EXPECT_EQ(queue.pop().x, 1);
}

TEST(BucketQueue, LosesNothingThatLiesOutOfItsBounds) {
  BucketQueue queue(100.0, 1.0, 4.0);
  for (const double estimate : {101.0, 5.0, 1e300, 1e9, 100.5}) queue.push({estimate, 0, 0});
  EXPECT_EQ(drain(queue).size(), 5U);
  // Far more buckets asked for than there may be: wider ones.
  EXPECT_GT(BucketQueue(0.0, 1e-9, 1e9).width(), 1e5);
}

}  // namespace
}  // namespace tread
