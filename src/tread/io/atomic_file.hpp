// Writing files so that an interrupted save never destroys what was there: everything is written
// beside its place under a temporary name, and only when all of it is complete is it renamed.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "tread/core/result.hpp"

namespace tread {

// Writes the whole file or leaves the old one as it was. The folder must exist.
[[nodiscard]] Status write_file(const std::filesystem::path& path, std::string_view bytes);

// The whole file as bytes, read in pieces: never allocates more than is there. At most max_bytes.
[[nodiscard]] Result<std::string> read_file(const std::filesystem::path& path,
                                            std::size_t max_bytes = std::size_t{1} << 31);

// Several files of one folder that belong together: all become the new ones or none does.
//   FileSet set(folder);
//   path p = set.add("height.tif");   // write to p
//   set.commit();                     // now folder/height.tif is the new one
// commit() first writes a journal of the renames, so that a process that dies between two renames
// leaves a folder that the next FileSet or finish_interrupted() brings to the complete new state;
// one that dies before leaves the old state.
class FileSet {
 public:
  explicit FileSet(std::filesystem::path folder) : folder_(std::move(folder)) {}
  ~FileSet();  // removes what was not committed
  FileSet(const FileSet&) = delete;
  FileSet& operator=(const FileSet&) = delete;

  // The temporary path to write `name` (a plain file name) to.
  [[nodiscard]] std::filesystem::path add(const std::string& name);
  [[nodiscard]] Status commit();
  // Completes the renames that an interrupted commit had decided on. Does nothing if there are
  // none.
  [[nodiscard]] static Status finish_interrupted(const std::filesystem::path& folder);

 private:
  std::filesystem::path folder_;
  std::vector<std::string> names_;
};

}  // namespace tread
