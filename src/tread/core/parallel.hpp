// Parallel loops whose result does not depend on the number of threads: the range is cut into
// chunks by the grain alone, and each chunk is worked on by one thread.
#pragma once

#include <functional>

#include "tread/core/timer.hpp"

namespace tread {

// Calls body(first, last) for consecutive chunks of [begin, end), at most `grain` long each. The
// chunks run in any order on at most context.threads threads; body must not depend on the order.
void parallel_chunks(const Context& context, int begin, int end, int grain,
                     const std::function<void(int first, int last)>& body);

}  // namespace tread
