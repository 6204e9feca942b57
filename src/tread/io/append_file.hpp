// Internal to io: a file that grows while it is open, through a buffer. It is not on the disk
// before somebody syncs it; see RecordingFolder.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "tread/core/result.hpp"

namespace tread::internal {

class AppendFile {
 public:
  // Creates it, or empties what is there; messages call it `where`.
  [[nodiscard]] static Result<AppendFile> create(const std::filesystem::path& path,
                                                 std::string where);
  AppendFile(AppendFile&& other) noexcept;
  AppendFile& operator=(AppendFile&&) = delete;
  ~AppendFile();  // without what is still in the buffer: close() writes it

  [[nodiscard]] Status append(std::string_view bytes);
  [[nodiscard]] Status close();

 private:
  AppendFile(int descriptor, std::string where)
      : descriptor_(descriptor), where_(std::move(where)) {}
  [[nodiscard]] Status flush();

  int descriptor_;
  std::string where_;
  std::string buffer_;
};

// The whole of a file.
[[nodiscard]] Status put_whole_file(const std::filesystem::path& path, std::string where,
                                    std::string_view bytes);

}  // namespace tread::internal
