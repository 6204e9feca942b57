#include "tread/sim/named_courses.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "tread/core/options.hpp"
#include "tread/sim/shipped_courses.hpp"

namespace tread {

std::vector<std::string> course_names() {
  std::vector<std::string> names;
  for (const internal::ShippedCourse& course : internal::shipped_courses()) {
    names.emplace_back(course.name);
  }
  return names;
}

std::optional<std::string_view> named_course_text(std::string_view name) {
  for (const internal::ShippedCourse& course : internal::shipped_courses()) {
    if (name == course.name) return course.text;
  }
  return std::nullopt;
}

Result<Course> find_course(const std::string& file_or_name, std::optional<std::uint64_t> seed) {
  std::error_code ignored;
  // A folder of that name is what an earlier run wrote.
  const bool is_file = std::filesystem::exists(file_or_name, ignored) &&
                       !std::filesystem::is_directory(file_or_name, ignored);
  if (is_file) return read_course(file_or_name, seed);
  if (const auto text = named_course_text(file_or_name)) {
    return parse_course(std::string(*text), file_or_name + ".yaml", seed);
  }
  const std::string near = nearest_name(file_or_name, course_names());
  return fail(ErrorCode::kNotFound, "there is no such course", file_or_name,
              near.empty()
                  ? fmt::format("Give a file, or one of: {}", fmt::join(course_names(), ", "))
                  : fmt::format("Did you mean '{}'?", near));
}

}  // namespace tread
