// Parallel loops whose result does not depend on the number of threads: the range is cut into
// chunks by the grain alone, and each chunk is worked on by one thread.
#pragma once

#include <memory>
#include <type_traits>

#include "tread/core/timer.hpp"

namespace tread {
namespace detail {
// The loop itself; `body` is what `call` is handed first.
void run_chunks(const Context& context, int begin, int end, int grain, const void* body,
                void (*call)(const void* body, int first, int last, int worker));
}  // namespace detail

// The most workers that a parallel loop in this context has.
[[nodiscard]] int worker_count(const Context& context);

// Calls body(first, last) or body(first, last, worker) for consecutive chunks of [begin, end), at
// most `grain` long each. The chunks run in any order on at most context.threads threads; body must
// not depend on the order. No two chunks run at once with the same worker, a number in
// [0, worker_count): what a worker needs as memory can be kept by that number. Allocates nothing
// with one thread.
template <class Body>
void parallel_chunks(const Context& context, int begin, int end, int grain, const Body& body) {
  detail::run_chunks(context, begin, end, grain, std::addressof(body),
                     [](const void* b, int first, int last, int worker) {
                       const Body& call = *static_cast<const Body*>(b);
                       if constexpr (std::is_invocable_v<const Body&, int, int, int>) {
                         call(first, last, worker);
                       } else {
                         call(first, last);
                       }
                     });
}

}  // namespace tread
