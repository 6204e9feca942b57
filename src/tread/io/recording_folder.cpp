#include "tread/io/recording_folder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "tread/io/atomic_file.hpp"
#include "tread/io/text.hpp"

namespace tread::internal {
namespace {

namespace fs = std::filesystem;

constexpr const char* kWork = ".tread-recording";

tl::unexpected<Error> cannot(const char* what, const fs::path& path, const std::error_code& why) {
  return fail(ErrorCode::kWriteFailed, fmt::format("{}: {}", what, why.message()), path.string(),
              "Check that the folder is writable and has space");
}

bool is_there(const fs::path& path) {
  std::error_code ignored;
  return fs::symlink_status(path, ignored).type() != fs::file_type::not_found && !ignored;
}

std::vector<std::string> names_in(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    const std::string name = at->path().filename().string();
    if (!name.starts_with('.')) names.push_back(name);
  }
  std::sort(names.begin(), names.end());
  return names;
}

// cam0, cam1, ... and the other parts of mav0, which are folders.
bool is_sensor(const std::string& name) {
  for (const char* known :
       {"imu0", "gnss0", "wheels0", "legs0", "head0", "bump0", "state_groundtruth_estimate0"}) {
    if (name == known) return true;
  }
  return name.starts_with("cam") && parse_number<unsigned>(name.substr(3)).has_value();
}

bool is_truth(const std::string& name) {
  return name.ends_with(".tum") || name.ends_with(".tif") || name.starts_with("depth");
}

// What would go with an older recording must be of it.
// Pictures of a course, and the page of them, may be there before its recording.
bool is_picture(const std::string& name) {
  return name == "report.html" || name == "picture_above.png" || name == "picture_eye.png";
}

Status check_replaceable(const fs::path& folder) {
  const auto names = names_in(folder);
  if (std::all_of(names.begin(), names.end(), is_picture)) return {};
  if (!is_there(folder / kRecordingMark)) {
    return fail(
        ErrorCode::kWriteFailed,
        fmt::format("there is something in it ({}), but no {}", names.front(), kRecordingMark),
        folder.string(), "Give an empty folder, a new one, or one with a recording");
  }
  for (const auto& [part, known] : {std::pair("mav0", &is_sensor), std::pair("truth", &is_truth)}) {
    for (const std::string& name : names_in(folder / part)) {
      if (known(name)) continue;
      return fail(ErrorCode::kWriteFailed,
                  "this is no part of a recording, and would be lost with the old one",
                  (folder / part / name).string(), "Move it away, or give another folder");
    }
  }
  return {};
}

std::error_code sync_path(const fs::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  int failed = descriptor < 0 || ::fsync(descriptor) != 0 ? errno : 0;
  if (failed == EINVAL) failed = 0;  // some file systems cannot do this for folders
  if (descriptor >= 0) ::close(descriptor);
  return {failed, std::generic_category()};
}

Status sync_tree(const fs::path& root) {
  std::error_code error;
  fs::recursive_directory_iterator at(root, error);
  for (const fs::recursive_directory_iterator end; !error && at != end; at.increment(error)) {
    if (const auto failed = sync_path(at->path()))
      return cannot("cannot write", at->path(), failed);
  }
  if (error) return cannot("cannot be listed", root, error);
  (void)sync_path(root);
  return {};
}

Status move(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::rename(from, to, error);
  if (error) return cannot("cannot be replaced", to, error);
  return {};
}

// The moves of publish(), from the beginning or from wherever they were interrupted.
Status carry_out(const fs::path& folder, const std::vector<std::string>& made,
                 const std::function<void()>& step) {
  const fs::path work = folder / kWork;
  for (const std::string& name : recording_entries()) {
    const bool is_new = std::find(made.begin(), made.end(), name) != made.end();
    if (is_new && !is_there(work / "new" / name)) continue;  // this one was moved before
    step();
    if (is_there(folder / name)) {
      if (Status done = move(folder / name, work / "old" / name); !done) return done;
    }
    step();
    if (!is_new) continue;
    if (Status done = move(work / "new" / name, folder / name); !done) return done;
  }
  (void)sync_path(folder);
  step();
  // While "complete" is there, everybody knows what the rest is.
  std::error_code error;
  for (const char* part : {"new", "old", "complete", ""}) {
    fs::remove_all(work / part, error);
    if (error) return cannot("cannot be removed", work / part, error);
  }
  return {};
}

// Of a work folder that nobody holds.
Status finish_work(const fs::path& folder) {
  const fs::path mark = folder / kWork / "complete";
  if (!is_there(mark)) return {};
  const auto text = read_file(mark, std::size_t{1} << 16);
  if (!text) return forward(text);
  std::vector<std::string> made;
  for (const TextLine& line : lines_with_content(*text)) made.emplace_back(line.text);
  return carry_out(folder, made, [] {});
}

// The work folder's descriptor with its lock, or -1 if somebody else has it.
int lock_work(const fs::path& work) {
  const int descriptor = ::open(work.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return -1;
  // A file system without locks still has everything but the protection from a second process.
  if (::flock(descriptor, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return descriptor;
  ::close(descriptor);
  return -1;
}

}  // namespace

const std::vector<std::string>& recording_entries() {
  static const std::vector<std::string> kEntries = {"mav0", "truth", "rig.yaml", "poses.txt",
                                                    kRecordingMark};
  return kEntries;
}

Result<std::unique_ptr<RecordingFolder>> RecordingFolder::open(const fs::path& given) {
  const fs::path folder = given.empty() ? fs::path(".") : given;
  std::error_code error;
  fs::create_directories(folder, error);
  if (error && !fs::is_directory(folder)) return cannot("cannot make this folder", folder, error);
  if (const Status done = finish_interrupted(folder); !done) return forward(done);
  if (const Status free = check_replaceable(folder); !free) return forward(free);
  const fs::path work = folder / kWork;
  fs::create_directory(work, error);
  if (error) return cannot("cannot write", folder, error);
  const int lock = lock_work(work);
  if (lock < 0) {
    return fail(ErrorCode::kWriteFailed, "another process records into it", folder.string(),
                "Wait for it, or give another folder");
  }
  for (const char* part : {"new", "old"}) {  // of a process that died
    fs::remove_all(work / part, error);
    if (!error) fs::create_directory(work / part, error);
    if (!error) continue;
    ::close(lock);
    return cannot("cannot write", folder, error);
  }
  return std::unique_ptr<RecordingFolder>(new RecordingFolder(folder, lock));
}

RecordingFolder::RecordingFolder(fs::path folder, int lock)
    : folder_(std::move(folder)), lock_(lock) {}

RecordingFolder::~RecordingFolder() {
  // From the mark on the new recording counts: what is left to do is for who looks next.
  std::error_code ignored;
  if (!decided_) fs::remove_all(folder_ / kWork, ignored);
  ::close(lock_);
}

fs::path RecordingFolder::staged(const std::string& name) const {
  return folder_ / kWork / "new" / name;
}

std::string RecordingFolder::where(const std::string& name) const {
  return (folder_ / name).string();
}

Error RecordingFolder::renamed(Error error) const {
  const std::string made = staged("").string(), place = where("");
  if (error.where.starts_with(made)) error.where.replace(0, made.size(), place);
  return error;
}

Status RecordingFolder::make_folder(const std::string& name) const {
  std::error_code error;
  fs::create_directories(staged(name), error);
  if (error) return cannot("cannot write", where(name), error);
  return {};
}

Status RecordingFolder::publish() {
  return publish_in_steps([] {});
}

Status RecordingFolder::publish_in_steps(const std::function<void()>& step) {
  step();
  if (Status synced = sync_tree(staged("")); !synced) {
    return tl::unexpected<Error>(renamed(synced.error()));
  }
  if (Status free = check_replaceable(folder_); !free) return free;
  const std::vector<std::string> made = names_in(staged(""));
  step();
  const std::string list = fmt::format("{}\n", fmt::join(made, "\n"));
  if (Status done = write_file(folder_ / kWork / "complete", list); !done) return done;
  decided_ = true;
  return carry_out(folder_, made, step);
}

Status RecordingFolder::finish_interrupted(const fs::path& folder) {
  const fs::path work = folder / kWork;
  if (!is_there(work / "complete")) return {};
  const int lock = lock_work(work);
  if (lock < 0) return {};  // who holds it is about to
  Status done = finish_work(folder);
  ::close(lock);
  return done;
}

}  // namespace tread::internal
