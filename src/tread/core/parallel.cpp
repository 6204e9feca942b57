#include "tread/core/parallel.hpp"

#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cassert>

namespace tread {

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
  oneapi::tbb::task_arena arena(workers);
  arena.execute([&] {
    oneapi::tbb::parallel_for(0, chunks, [&](int chunk) {
      run_chunk(chunk, oneapi::tbb::this_task_arena::current_thread_index());
    });
  });
}

}  // namespace tread
