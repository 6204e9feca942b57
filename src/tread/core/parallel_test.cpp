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
