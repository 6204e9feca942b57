#include "tread/core/parallel.hpp"

#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cassert>

namespace tread {

void parallel_chunks(const Context& context, int begin, int end, int grain,
                     const std::function<void(int, int)>& body) {
  assert(grain > 0);
  if (end <= begin) return;
  const int chunks = (end - begin + grain - 1) / grain;
  const auto run_chunk = [&](int chunk) {
    const int first = begin + chunk * grain;
    body(first, std::min(end, first + grain));
  };
  if (context.threads <= 1 || chunks == 1) {
    for (int chunk = 0; chunk < chunks; ++chunk) run_chunk(chunk);
    return;
  }
  // More threads than the machine has would only be refused.
  oneapi::tbb::task_arena arena(
      std::min(context.threads, oneapi::tbb::info::default_concurrency()));
  arena.execute([&] { oneapi::tbb::parallel_for(0, chunks, run_chunk); });
}

}  // namespace tread
