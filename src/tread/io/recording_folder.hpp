// Internal to io: a folder whose recording is replaced as a whole. The new one is made in
//   FOLDER/.tread-recording/new/
// on the same disk, also where FOLDER is a mount. publish() writes everything to the disk, then
// FOLDER/.tread-recording/complete with the names of the new entries (the point from which the new
// recording counts), and then moves each old entry to .tread-recording/old/ and the new one to its
// place. Each step may be done twice, so whoever finds a folder that is complete finishes it.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tread/core/result.hpp"

namespace tread::internal {

// What a recording may consist of, directly in its folder: files and folders.
[[nodiscard]] const std::vector<std::string>& recording_entries();
// The one that every recording has, by which it is known.
inline constexpr const char* kRecordingMark = "recording.yaml";

class RecordingFolder {
 public:
  // Makes the folder if need be. Refuses one that holds something but no recording, one whose
  // recording holds what no recording does, which would be lost, and one that another process
  // records into. What a dead process left there is finished or removed.
  [[nodiscard]] static Result<std::unique_ptr<RecordingFolder>> open(
      const std::filesystem::path& folder);
  ~RecordingFolder();  // removes what was not published
  RecordingFolder(const RecordingFolder&) = delete;
  RecordingFolder& operator=(const RecordingFolder&) = delete;

  // Where to write the file of this name, and how messages shall call it.
  [[nodiscard]] std::filesystem::path staged(const std::string& name) const;
  [[nodiscard]] std::string where(const std::string& name) const;
  // An error of a file there, with the name that it will have.
  [[nodiscard]] Error renamed(Error error) const;
  [[nodiscard]] Status make_folder(const std::string& name) const;
  // All files must be closed.
  [[nodiscard]] Status publish();

  // Finishes what an interrupted publish() had decided on; nothing to do in most folders.
  [[nodiscard]] static Status finish_interrupted(const std::filesystem::path& folder);

 private:
  friend struct RecordingFolderTestAccess;
  RecordingFolder(std::filesystem::path folder, int lock);
  // `step` is called before each change, so that a test can stop there.
  [[nodiscard]] Status publish_in_steps(const std::function<void()>& step);

  std::filesystem::path folder_;
  int lock_;  // descriptor, held while this lives
  bool decided_ = false;
};

}  // namespace tread::internal
