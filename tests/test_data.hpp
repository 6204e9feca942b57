// Where tests find data: real data outside the repository, and scratch folders.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <optional>
#include <string>

namespace tread::testing {

// The path of a file or folder of the development data: $TREAD_DATA, else ../shared/data beside
// the source tree. Empty if it is not there.
[[nodiscard]] std::optional<std::filesystem::path> find_data(const std::string& relative_path);

// A fresh empty folder of this test, removed at the end.
class ScratchFolder {
 public:
  ScratchFolder();
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::filesystem::path operator/(const std::string& name) const {
    return path_ / name;
  }

 private:
  std::filesystem::path path_;
};

}  // namespace tread::testing

// Skips the test by name where the development data are not there.
#define TREAD_NEEDS_DATA(variable, relative_path)                                          \
  const auto variable##_found = ::tread::testing::find_data(relative_path);                \
  if (!variable##_found) GTEST_SKIP() << "needs " << (relative_path) << " in $TREAD_DATA"; \
  const std::filesystem::path& variable = *variable##_found
