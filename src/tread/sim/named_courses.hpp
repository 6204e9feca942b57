// The courses that come with the project: those of worlds/, built into the library.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tread/sim/course.hpp"

namespace tread {

[[nodiscard]] std::vector<std::string> course_names();
// The file as it is in worlds/; empty if there is none of that name.
[[nodiscard]] std::optional<std::string_view> named_course_text(std::string_view name);

// A file, or one of those names.
[[nodiscard]] Result<Course> find_course(const std::string& file_or_name,
                                        std::optional<std::uint64_t> seed = {});

}  // namespace tread
