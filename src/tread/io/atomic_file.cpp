// A rename within a folder is atomic, several are not: hence the journal, a text file
//   tread journal 1
//   token 0123456789abcdef
//   rename height.tif        (from .tread-0123456789abcdef-height.tif)
//   remove slope.tif
//   end
// written (itself by a rename) after all new files are on the disk, and removed after all its steps
// are done. Each step may be done twice without harm, so whoever finds a journal carries it out
// from the beginning.
#include "tread/io/atomic_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <random>
#include <system_error>

#include "tread/io/text.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;

constexpr const char* kJournalName = ".tread-journal";
constexpr const char* kTemporaryPrefix = ".tread-";
constexpr std::size_t kTokenLength = 16;

std::string reason(int error_number) {
  return std::error_code(error_number, std::generic_category()).message();
}

tl::unexpected<Error> cannot_write(const fs::path& path, int error_number) {
  return fail(ErrorCode::kWriteFailed, fmt::format("cannot write: {}", reason(error_number)),
              path.string(), "Check that the folder exists, is writable and has space");
}

class FileDescriptor {
 public:
  explicit FileDescriptor(int descriptor) : descriptor_(descriptor) {}
  ~FileDescriptor() { close(); }
  FileDescriptor(const FileDescriptor&) = delete;
  FileDescriptor& operator=(const FileDescriptor&) = delete;
  [[nodiscard]] int get() const { return descriptor_; }
  [[nodiscard]] bool is_open() const { return descriptor_ >= 0; }
  // False if the system only now says that the data could not be written.
  bool close() {
    const int closing = descriptor_;
    descriptor_ = -1;
    return closing < 0 || ::close(closing) == 0;
  }

 private:
  int descriptor_;
};

bool write_all(int descriptor, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t count = ::write(descriptor, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(count));
  }
  return true;
}

// Makes renames in the folder last. Some file systems cannot do this for folders; then there is
// nothing more to be done.
void sync_folder(const fs::path& folder) {
  const FileDescriptor opened(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (opened.is_open()) ::fsync(opened.get());
}

fs::path folder_of(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

std::string make_token() {
  std::random_device random;
  return fmt::format("{:08x}{:08x}", static_cast<std::uint32_t>(random()),
                     static_cast<std::uint32_t>(random()));
}

bool is_token(std::string_view text) {
  return text.size() == kTokenLength &&
         text.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

fs::path temporary_path(const fs::path& folder, const std::string& token, const std::string& name) {
  return folder / (kTemporaryPrefix + token + "-" + name);
}

// A file that is replaced keeps its permissions; a new one gets what the process's umask leaves.
mode_t permissions_for(const fs::path& path) {
  struct stat old {};
  return ::stat(path.c_str(), &old) == 0 ? old.st_mode & 0777U : 0666U;
}

// A rename onto a device or a pipe would replace it.
Status check_replaceable(const fs::path& path) {
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  if (!fs::exists(status) || fs::is_regular_file(status)) return {};
  return fail(ErrorCode::kWriteFailed,
              fs::is_directory(status) ? "this is a folder" : "this is not a regular file",
              path.string(), "Give another name");
}

// Held while the files of a folder are renamed.
class FolderLock {
 public:
  explicit FolderLock(const fs::path& folder)
      : folder_(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
    // A file system without locks still has everything but the protection from a second process.
    while (folder_.is_open() && ::flock(folder_.get(), LOCK_EX) != 0 && errno == EINTR) {
    }
  }

 private:
  FileDescriptor folder_;  // closing it gives the lock back
};

struct Journal {
  std::string token;
  std::vector<std::string> renamed;
  std::vector<std::string> removed;
};

std::string journal_text(const Journal& journal) {
  std::string text = fmt::format("tread journal 1\ntoken {}\n", journal.token);
  for (const std::string& name : journal.renamed) text += fmt::format("rename {}\n", name);
  for (const std::string& name : journal.removed) text += fmt::format("remove {}\n", name);
  return text + "end\n";
}

tl::unexpected<Error> bad_journal(const fs::path& path, int line, const std::string& what) {
  return fail(ErrorCode::kBadFormat, what, line_place(path.string(), line),
              "Delete this file; the folder may hold files of two saves, so save again");
}

// The rest of a line behind its first word.
std::optional<std::string> after_word(std::string_view line, std::string_view word) {
  if (!line.starts_with(word)) return std::nullopt;
  return std::string(line.substr(word.size()));
}

Result<Journal> parse_journal(std::string_view text, const fs::path& path) {
  Journal journal;
  int number = 0;
  bool ended = false;
  while (!text.empty() && !ended) {
    ++number;
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    const auto renamed = after_word(line, "rename ");
    const auto removed = after_word(line, "remove ");
    if (number == 1) {
      if (line != "tread journal 1") return bad_journal(path, number, "not a journal of tread");
    } else if (number == 2) {
      const auto token = after_word(line, "token ");
      if (!token || !is_token(*token)) return bad_journal(path, number, "no valid token");
      journal.token = *token;
    } else if (renamed && is_plain_file_name(*renamed)) {
      journal.renamed.push_back(*renamed);
    } else if (removed && is_plain_file_name(*removed)) {
      journal.removed.push_back(*removed);
    } else if (line == "end") {
      ended = true;
    } else {
      return bad_journal(path, number, in_quotes(line) + " is not a step within this folder");
    }
  }
  if (!ended) return bad_journal(path, number, "the journal is not complete");
  return journal;
}

Status carry_out(const fs::path& folder, const Journal& journal,
                 const std::function<void()>& step) {
  for (const std::string& name : journal.renamed) {
    step();
    const fs::path from = temporary_path(folder, journal.token, name);
    // Not there: this step was already done.
    if (::rename(from.c_str(), (folder / name).c_str()) != 0 && errno != ENOENT) {
      return cannot_write(folder / name, errno);
    }
  }
  for (const std::string& name : journal.removed) {
    step();
    if (::unlink((folder / name).c_str()) != 0 && errno != ENOENT) {
      return cannot_write(folder / name, errno);
    }
  }
  sync_folder(folder);
  step();
  if (::unlink((folder / kJournalName).c_str()) != 0 && errno != ENOENT) {
    return cannot_write(folder / kJournalName, errno);
  }
  sync_folder(folder);
  return {};
}

// finish_interrupted() for those who hold the lock.
Status finish_locked(const fs::path& folder) {
  const fs::path path = folder / kJournalName;
  std::error_code ignored;
  if (!fs::exists(path, ignored)) return {};
  constexpr std::size_t kLargestJournal = std::size_t{1} << 20;
  const auto text = read_file(path, kLargestJournal);
  if (!text) return forward(text);
  const auto journal = parse_journal(*text, path);
  if (!journal) return forward(journal);
  return carry_out(folder, *journal, [] {});
}

void remove_forgotten(const fs::path& folder) {
  const auto yesterday = fs::file_time_type::clock::now() - std::chrono::hours(24);
  std::error_code error;
  std::vector<fs::path> forgotten;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    const std::string name = at->path().filename().string();
    const std::size_t prefix = std::string_view(kTemporaryPrefix).size();
    if (!name.starts_with(kTemporaryPrefix) || name.size() <= prefix + kTokenLength) continue;
    if (!is_token(std::string_view(name).substr(prefix, kTokenLength))) continue;
    std::error_code unknown;
    if (at->is_regular_file(unknown) && at->last_write_time(unknown) < yesterday && !unknown) {
      forgotten.push_back(at->path());
    }
  }
  for (const fs::path& path : forgotten) fs::remove(path, error);
}

}  // namespace

bool is_plain_file_name(std::string_view name) {
  if (name.empty() || name == "." || name == ".." || name.size() > 200) return false;
  return std::none_of(name.begin(), name.end(), [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte < 0x20 || byte == 0x7f || c == '/';
  });
}

fs::path final_path(const fs::path& path) {
  const std::string name = path.filename().string();
  const std::size_t prefix = std::string_view(kTemporaryPrefix).size();
  const bool temporary = name.starts_with(kTemporaryPrefix) &&
                         name.size() > prefix + kTokenLength + 1 &&
                         is_token(std::string_view(name).substr(prefix, kTokenLength)) &&
                         name[prefix + kTokenLength] == '-';
  return temporary ? path.parent_path() / name.substr(prefix + kTokenLength + 1) : path;
}

Status write_file(const fs::path& path, std::string_view bytes) {
  if (const Status replaceable = check_replaceable(path); !replaceable) return replaceable;
  std::error_code ignored;
  // A link stays a link: what it points to is replaced.
  const fs::path target =
      fs::is_symlink(path, ignored) ? fs::weakly_canonical(path, ignored) : path;
  const fs::path temporary =
      temporary_path(folder_of(target), make_token(), target.filename().string());
  FileDescriptor file(
      ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, permissions_for(target)));
  if (!file.is_open()) return cannot_write(final_path(path), errno);
  const bool written = write_all(file.get(), bytes) && ::fsync(file.get()) == 0 && file.close() &&
                       ::rename(temporary.c_str(), target.c_str()) == 0;
  if (!written) {
    const int why = errno;
    ::unlink(temporary.c_str());
    return cannot_write(final_path(path), why);
  }
  sync_folder(folder_of(target));
  return {};
}

Result<std::string> read_file(const fs::path& path, std::size_t max_bytes) {
  // O_NONBLOCK: opening a pipe that nobody writes to would wait for ever.
  const FileDescriptor file(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  if (!file.is_open()) {
    const bool missing = errno == ENOENT || errno == ENOTDIR;
    return fail(missing ? ErrorCode::kNotFound : ErrorCode::kUnreadable,
                missing ? "no such file" : fmt::format("cannot open: {}", reason(errno)),
                path.string(), missing ? "Check the name" : "Check its permissions");
  }
  struct stat status {};
  if (::fstat(file.get(), &status) != 0 || !S_ISREG(status.st_mode)) {
    return fail(ErrorCode::kUnreadable, "this is not a regular file", path.string(),
                "Give the name of a file");
  }
  std::string bytes;
  constexpr std::size_t kPiece = std::size_t{1} << 20;
  const auto size = static_cast<std::size_t>(status.st_size);
  bytes.reserve(std::min(size, max_bytes) + 1);  // what is there, not what somebody promises
  for (;;) {
    const std::size_t before = bytes.size();
    bytes.resize(before +
                 std::min(kPiece, std::max<std::size_t>(size - std::min(size, before), 1)));
    const ssize_t count = ::read(file.get(), bytes.data() + before, bytes.size() - before);
    bytes.resize(before + (count > 0 ? static_cast<std::size_t>(count) : 0));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) {
      return fail(ErrorCode::kUnreadable, fmt::format("cannot read: {}", reason(errno)),
                  path.string(), "Check the disk");
    }
    if (count == 0) return bytes;
    if (bytes.size() > max_bytes) {
      return fail(ErrorCode::kUnsupported, fmt::format("larger than {} bytes", max_bytes),
                  path.string(), "Check that this is the right file");
    }
  }
}

FileSet::FileSet(fs::path folder) : folder_(std::move(folder)), token_(make_token()) {
  if (folder_.empty()) folder_ = ".";
}

FileSet::~FileSet() {
  for (const std::string& name : added_) {
    if (is_plain_file_name(name)) ::unlink(temporary_path(folder_, token_, name).c_str());
  }
}

fs::path FileSet::add(const std::string& name) {
  if (std::find(added_.begin(), added_.end(), name) == added_.end()) added_.push_back(name);
  return temporary_path(folder_, token_, name);
}

void FileSet::remove(const std::string& name) {
  removed_.push_back(name);
}

Status FileSet::commit() {
  return commit_in_steps([] {});
}

// Everything that can fail shall fail before the journal is written.
Status FileSet::sync_added() const {
  for (const auto* names : {&added_, &removed_}) {
    for (const std::string& name : *names) {
      if (is_plain_file_name(name)) continue;
      return fail(ErrorCode::kBadArgument, in_quotes(name) + " is not a plain file name",
                  folder_.string(), "Give a name without '/'");
    }
  }
  for (const std::string& name : added_) {
    const Status replaceable = check_replaceable(folder_ / name);
    if (!replaceable) return replaceable;
    const FileDescriptor file(
        ::open(temporary_path(folder_, token_, name).c_str(), O_RDONLY | O_CLOEXEC));
    if (!file.is_open() || ::fsync(file.get()) != 0) return cannot_write(folder_ / name, errno);
  }
  return {};
}

Status FileSet::commit_in_steps(const std::function<void()>& step) {
  step();
  if (const Status synced = sync_added(); !synced) return synced;
  const FolderLock lock(folder_);
  if (const Status finished = finish_locked(folder_); !finished) return finished;
  remove_forgotten(folder_);
  const Journal journal{token_, added_, removed_};
  // One rename needs no journal: it is atomic.
  const bool needs_journal = added_.size() + removed_.size() > 1;
  if (needs_journal) {
    step();
    const Status written = write_file(folder_ / kJournalName, journal_text(journal));
    if (!written) return written;
  }
  Status done = carry_out(folder_, journal, step);
  // From the journal on the temporary files are its own: where a step failed, the next one who
  // looks completes it.
  if (done || needs_journal) {
    added_.clear();
    removed_.clear();
  }
  return done;
}

Status FileSet::finish_interrupted(const fs::path& folder) {
  std::error_code ignored;
  if (!fs::exists(folder / kJournalName, ignored)) return {};
  const FolderLock lock(folder);
  return finish_locked(folder);
}

}  // namespace tread
