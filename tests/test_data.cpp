#include "test_data.hpp"

#include <unistd.h>

#include <cstdlib>
#include <string>

namespace tread::testing {

namespace fs = std::filesystem;

std::optional<fs::path> find_data(const std::string& relative_path) {
  const char* chosen = std::getenv("TREAD_DATA");
  const fs::path root =
      chosen != nullptr ? fs::path(chosen) : fs::path(TREAD_SOURCE_DIR) / ".." / "shared" / "data";
  std::error_code error;
  fs::path path = root / relative_path;
  if (!fs::exists(path, error)) return std::nullopt;
  return path;
}

ScratchFolder::ScratchFolder() {
  std::string name = (fs::temp_directory_path() / "tread_test_XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) std::abort();
  path_ = name;
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

}  // namespace tread::testing
