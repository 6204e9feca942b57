// Many errors as a few: what a person reads when each frame of a drive goes wrong in the same way.
#pragma once

#include <cstddef>
#include <vector>

#include "tread/core/result.hpp"

namespace tread {

// One error for each kind, in the order in which the kinds first came, at most `most` of them. The
// first of a kind stands for it, with the number of the others: "... (and 28 more like it)". Errors
// are of one kind if code and remedy are equal and their texts differ in numbers only. What is
// beyond `most` is counted in one last entry.
[[nodiscard]] std::vector<Error> distinct_problems(const std::vector<Error>& problems,
                                                   std::size_t most = 10);

}  // namespace tread
