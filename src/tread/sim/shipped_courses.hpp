// Internal to sim: the texts of worlds/, which the build writes into a source file.
#pragma once

#include <span>
#include <string_view>

namespace tread::internal {

struct ShippedCourse {
  std::string_view name;
  std::string_view text;
};
[[nodiscard]] std::span<const ShippedCourse> shipped_courses();

}  // namespace tread::internal
