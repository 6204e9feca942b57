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
// Regular files only: a pipe or a device might never end.
[[nodiscard]] Result<std::string> read_file(const std::filesystem::path& path,
                                            std::size_t max_bytes = std::size_t{1} << 31);

// True for a name that stays in its folder: not empty, ".", "..", no '/', no control bytes.
[[nodiscard]] bool is_plain_file_name(std::string_view name);

// What the temporary path of a FileSet stands for, as messages shall name it; other paths are given
// back as they are.
[[nodiscard]] std::filesystem::path final_path(const std::filesystem::path& path);

// Several files of one folder that belong together: all become the new ones or none does.
//   FileSet set(folder);
//   path p = set.add("height.tif");   // write to p
//   set.commit();                     // now folder/height.tif is the new one
// commit() first writes a journal of the renames, so that a process that dies between two renames
// leaves a folder that the next FileSet or finish_interrupted() brings to the complete new state;
// one that dies before leaves the old state. Two processes that commit in one folder wait for each
// other. Temporary files that a dead process left behind are removed a day later by commit().
class FileSet {
 public:
  explicit FileSet(std::filesystem::path folder);
  ~FileSet();  // removes what was not committed
  FileSet(const FileSet&) = delete;
  FileSet& operator=(const FileSet&) = delete;

  // The temporary path to write `name` to. A name that is not a plain file name makes commit()
  // fail.
  [[nodiscard]] std::filesystem::path add(const std::string& name);
  [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }
  // The names added, in their order.
  [[nodiscard]] const std::vector<std::string>& names() const { return added_; }
  // `name` shall be gone when the set is committed; it need not be there.
  void remove(const std::string& name);
  // All files added must have been written by now. Afterwards the set is empty.
  [[nodiscard]] Status commit();
  // Completes the renames that an interrupted commit had decided on. Does nothing if there are
  // none. A journal that names anything outside the folder is refused.
  [[nodiscard]] static Status finish_interrupted(const std::filesystem::path& folder);

 private:
  friend struct FileSetTestAccess;
  // `step` is called before each change of the folder, so that a test can stop there.
  [[nodiscard]] Status commit_in_steps(const std::function<void()>& step);
  [[nodiscard]] Status sync_added() const;

  std::filesystem::path folder_;
  std::string token_;  // part of the temporary names, different for every set
  std::vector<std::string> added_;
  std::vector<std::string> removed_;
};

}  // namespace tread
