#include "tread/core/parallel.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

namespace tread {
namespace {

TEST(ParallelChunks, CoversTheRangeOnceWithTheSameChunksForAnyThreadCount) {
  for (int threads : {1, 2, 4}) {
    std::vector<std::atomic<int>> visits(1000);
    std::atomic<int> chunks{0};
    Context context;
    context.threads = threads;
    parallel_chunks(context, 7, 907, 64, [&](int first, int last) {
      EXPECT_EQ((first - 7) % 64, 0);
      EXPECT_LE(last - first, 64);
      for (int i = first; i < last; ++i) ++visits[static_cast<std::size_t>(i)];
      ++chunks;
    });
    EXPECT_EQ(chunks, 15);
    for (int i = 0; i < 1000; ++i) {
      EXPECT_EQ(visits[static_cast<std::size_t>(i)], i >= 7 && i < 907 ? 1 : 0) << i;
    }
  }
}

TEST(ParallelChunks, NoTwoChunksShareAWorkerAtOnce) {
  Context context;
  context.threads = 2;
  ASSERT_GE(worker_count(context), 1);
  ASSERT_LE(worker_count(context), 2);
  std::vector<std::atomic<int>> busy(2);
  std::atomic<int> visits{0};
  parallel_chunks(context, 0, 400, 1, [&](int, int, int worker) {
    ASSERT_GE(worker, 0);
    ASSERT_LT(worker, worker_count(context));
    EXPECT_EQ(busy[static_cast<std::size_t>(worker)]++, 0);
    std::this_thread::sleep_for(std::chrono::microseconds(20));
    --busy[static_cast<std::size_t>(worker)];
    ++visits;
  });
  EXPECT_EQ(visits, 400);
}

TEST(ParallelChunks, EmptyRangeDoesNothing) {
  parallel_chunks({}, 5, 5, 1, [](int, int) { FAIL(); });
  parallel_chunks({}, 5, 3, 1, [](int, int) { FAIL(); });
}

TEST(ScopedTimer, AddsUpByPath) {
  Timings timings;
  Context context;
  context.timings = &timings;
  for (int i = 0; i < 3; ++i) {
    const ScopedTimer timer(context, "stereo/match");
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  const auto found = timings.entries().find("stereo/match");
  ASSERT_NE(found, timings.entries().end());
  EXPECT_EQ(found->second.calls, 3);
  EXPECT_GE(found->second.total_ms, 6.0);
  EXPECT_GE(found->second.max_ms, found->second.mean_ms());
  { const ScopedTimer nowhere(Context{}, "x"); }
  EXPECT_EQ(timings.entries().size(), 1U);
}

}  // namespace
}  // namespace tread
