#include "tread/core/parallel.hpp"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cassert>

#if defined(__SANITIZE_THREAD__)
#include <sanitizer/tsan_interface.h>
#endif

namespace tread {
namespace {

// libtbb is not instrumented: the thread sanitizer does not see that chunks begin after the call
// and end before its return. Told so, it still sees races of one chunk with another.
void note_done([[maybe_unused]] char& mark) {
#if defined(__SANITIZE_THREAD__)
  __tsan_release(&mark);
#endif
}
void note_seen([[maybe_unused]] char& mark) {
#if defined(__SANITIZE_THREAD__)
  __tsan_acquire(&mark);
#endif
}

}  // namespace

// More threads than the machine has would only be refused.
int worker_count(const Context& context) {
  return std::clamp(context.threads, 1, oneapi::tbb::info::default_concurrency());
}

void detail::run_chunks(const Context& context, int begin, int end, int grain, const void* body,
                        void (*call)(const void* body, int first, int last, int worker)) {
  assert(grain > 0);
  if (end <= begin) return;
  const int chunks = (end - begin + grain - 1) / grain;
  const auto run_chunk = [&](int chunk, int worker) {
    const int first = begin + chunk * grain;
    call(body, first, std::min(end, first + grain), worker);
  };
  const int workers = worker_count(context);
  if (workers <= 1 || chunks == 1) {
    for (int chunk = 0; chunk < chunks; ++chunk) run_chunk(chunk, 0);
    return;
  }
  // As many tasks as workers, each of which takes chunks until there are none: that bounds the
  // threads without an arena of its own, whose threads would have to be woken for every loop.
  char begun = 0, ended = 0;
  note_done(begun);
  std::atomic<int> next{0};
  oneapi::tbb::parallel_for(
      oneapi::tbb::blocked_range<int>(0, std::min(workers, chunks), 1),
      [&](const oneapi::tbb::blocked_range<int>& range) {
        note_seen(begun);
        for (int chunk = next++; chunk < chunks; chunk = next++) run_chunk(chunk, range.begin());
        note_done(ended);
      },
      oneapi::tbb::simple_partitioner());
  note_seen(ended);
}

}  // namespace tread
