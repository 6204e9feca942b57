#include "tread/core/result.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace tread {
namespace {

TEST(Result, MessagesSayWhereWhatAndTheRemedy) {
  const Error error{ErrorCode::kBadValue, "it is 3", "file:4", "Write 5"};
  EXPECT_EQ(error.message(), "file:4: it is 3. Write 5.");
  EXPECT_EQ((Error{ErrorCode::kBadValue, "it is 3", "", ""}).message(), "it is 3.");
}

TEST(Result, MemoryThatRunsOutBecomesAnError) {
  const auto ask = [](std::size_t bytes) {
    return with_memory_checked("map", "Make it smaller", [bytes]() -> Result<std::size_t> {
      std::vector<char> memory;
      memory.reserve(bytes);
      return memory.capacity();
    });
  };
  EXPECT_EQ(ask(1000).value(), 1000U);
  const auto uncountable = ask(std::numeric_limits<std::size_t>::max());  // std::length_error
  ASSERT_FALSE(uncountable);
  EXPECT_EQ(uncountable.error().code, ErrorCode::kTooLarge);
  EXPECT_EQ(uncountable.error().message(),
            "map: there is not enough memory for it. Make it smaller.");
  const Status out = with_memory_checked("map", "", []() -> Status { throw std::bad_alloc(); });
  ASSERT_FALSE(out);
  EXPECT_EQ(out.error().code, ErrorCode::kTooLarge);
  // Errors of the body itself stay as they are.
  const Status own = with_memory_checked(
      "map", "", []() -> Status { return fail(ErrorCode::kNotFound, "x", "y", "z"); });
  EXPECT_EQ(own.error().where, "y");
}

}  // namespace
}  // namespace tread
