#include "tread/io/atomic_file.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <map>

#include "file_mutations.hpp"
#include "test_data.hpp"

namespace tread {

struct FileSetTestAccess {
  static Status commit(FileSet& set, const std::function<void()>& step) {
    return set.commit_in_steps(step);
  }
};

namespace {

namespace fs = std::filesystem;
using testing::get_file;
using testing::put_file;
using testing::ScratchFolder;

std::map<std::string, std::string> contents(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    files[entry.path().filename().string()] = get_file(entry.path());
  }
  return files;
}

// Files of this process cannot grow beyond `bytes`: what a full disk looks like to a program.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) : old_handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &old_);
    rlimit small = old_;
    small.rlim_cur = bytes;
    setrlimit(RLIMIT_FSIZE, &small);
  }
  ~FullDisk() {
    setrlimit(RLIMIT_FSIZE, &old_);
    std::signal(SIGXFSZ, old_handler_);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

 private:
  rlimit old_{};
  void (*old_handler_)(int);
};

TEST(WriteFile, WritesAndReplacesAndLeavesNothingElse) {
  const ScratchFolder folder;
  ASSERT_TRUE(write_file(folder / "a.txt", "one"));
  ASSERT_TRUE(write_file(folder / "a.txt", std::string("t\0wo", 4)));
  EXPECT_EQ(contents(folder.path()),
            (std::map<std::string, std::string>{{"a.txt", std::string("t\0wo", 4)}}));
}

TEST(WriteFile, KeepsThePermissionsOfTheFileItReplaces) {
  const ScratchFolder folder;
  put_file(folder / "a.txt", "old");
  fs::permissions(folder / "a.txt", fs::perms{0600});
  ASSERT_TRUE(write_file(folder / "a.txt", "new"));
  EXPECT_EQ(fs::status(folder / "a.txt").permissions(), fs::perms{0600});
}

TEST(WriteFile, WritesThroughALink) {
  const ScratchFolder folder;
  put_file(folder / "target", "old");
  fs::create_symlink("target", folder / "link");
  ASSERT_TRUE(write_file(folder / "link", "new"));
  EXPECT_TRUE(fs::is_symlink(folder / "link"));
  EXPECT_EQ(get_file(folder / "target"), "new");
}

TEST(WriteFile, AFullDiskLeavesTheOldFile) {
  const ScratchFolder folder;
  put_file(folder / "a.txt", "old");
  {
    const FullDisk full(1000);
    const Status status = write_file(folder / "a.txt", std::string(5000, 'x'));
    ASSERT_FALSE(status);
    EXPECT_EQ(status.error().code, ErrorCode::kWriteFailed);
    EXPECT_EQ(status.error().where, (folder / "a.txt").string());
    EXPECT_NE(status.error().what.find("File too large"), std::string::npos);
  }
  EXPECT_EQ(contents(folder.path()), (std::map<std::string, std::string>{{"a.txt", "old"}}));
}

TEST(WriteFile, NamesAMissingFolderAndRefusesWhatIsNoFile) {
  const ScratchFolder folder;
  const Status missing = write_file(folder / "none" / "a.txt", "x");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::kWriteFailed);
  EXPECT_NE(missing.error().what.find("No such file or directory"), std::string::npos);
  const Status is_folder = write_file(folder.path(), "x");
  ASSERT_FALSE(is_folder);
  EXPECT_NE(is_folder.error().what.find("folder"), std::string::npos);
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
  const Status is_pipe = write_file(folder / "pipe", "x");
  ASSERT_FALSE(is_pipe);
  EXPECT_TRUE(fs::is_fifo(folder / "pipe")) << "the pipe was replaced";
}

TEST(WriteFile, NamesAFolderThatMayNotBeWrittenTo) {
  if (geteuid() == 0) GTEST_SKIP() << "root may write anywhere";
  const ScratchFolder folder;
  fs::permissions(folder.path(), fs::perms{0500});
  const Status status = write_file(folder / "a.txt", "x");
  fs::permissions(folder.path(), fs::perms{0700});
  ASSERT_FALSE(status);
  EXPECT_NE(status.error().what.find("Permission denied"), std::string::npos);
}

TEST(ReadFile, GivesAllBytesUpToTheLimit) {
  const ScratchFolder folder;
  const std::string bytes((std::size_t{3} << 20) + 17, 'x');
  put_file(folder / "a", bytes);
  EXPECT_EQ(read_file(folder / "a").value(), bytes);
  EXPECT_EQ(read_file(folder / "a", bytes.size()).value(), bytes);
  const auto too_large = read_file(folder / "a", bytes.size() - 1);
  ASSERT_FALSE(too_large);
  EXPECT_EQ(too_large.error().code, ErrorCode::kUnsupported);
  put_file(folder / "empty", "");
  EXPECT_EQ(read_file(folder / "empty").value(), "");
}

TEST(ReadFile, MissingFilesFoldersAndPipesAreNamed) {
  const ScratchFolder folder;
  const auto missing = read_file(folder / "none");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound);
  EXPECT_EQ(missing.error().where, (folder / "none").string());
  EXPECT_FALSE(read_file(folder.path()));
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
  const auto pipe = read_file(folder / "pipe");  // must not wait for a writer
  ASSERT_FALSE(pipe);
  EXPECT_EQ(pipe.error().code, ErrorCode::kUnreadable);
}

TEST(FileNames, PlainOnesStayInTheirFolder) {
  for (const char* name : {"a", "a.tif", ".hidden", "with blank", "a..b"}) {
    EXPECT_TRUE(is_plain_file_name(name)) << name;
  }
  for (const char* name : {"", ".", "..", "a/b", "/a", "../a", "a\nb", "a\x7f"}) {
    EXPECT_FALSE(is_plain_file_name(name)) << name;
  }
  EXPECT_FALSE(is_plain_file_name(std::string_view("a\0b", 3)));
  EXPECT_FALSE(is_plain_file_name(std::string(201, 'a')));
}

TEST(FileSet, CommitReplacesAllAndLeavesNothingElse) {
  const ScratchFolder folder;
  put_file(folder / "a", "old a");
  put_file(folder / "c", "old c");
  put_file(folder / "other", "other");
  FileSet set(folder.path());
  put_file(set.add("a"), "new a");
  put_file(set.add("b"), "new b");
  set.remove("c");
  set.remove("never was");
  EXPECT_EQ(get_file(folder / "a"), "old a");
  ASSERT_TRUE(set.commit());
  EXPECT_EQ(contents(folder.path()), (std::map<std::string, std::string>{
                                         {"a", "new a"}, {"b", "new b"}, {"other", "other"}}));
}

TEST(FileSet, WithoutCommitNothingChanges) {
  const ScratchFolder folder;
  put_file(folder / "a", "old");
  {
    FileSet set(folder.path());
    put_file(set.add("a"), "new");
    (void)set.add("never written");
  }
  EXPECT_EQ(contents(folder.path()), (std::map<std::string, std::string>{{"a", "old"}}));
}

TEST(FileSet, WhatCannotSucceedFailsBeforeAnythingChanges) {
  const ScratchFolder folder;
  put_file(folder / "a", "old");
  fs::create_directory(folder / "taken");
  const auto fails = [&](const std::string& second, bool written) {
    FileSet set(folder.path());
    put_file(set.add("a"), "new");
    const fs::path path = set.add(second);
    if (written) put_file(path, "new");
    const Status status = set.commit();
    return !status && !status.error().where.empty();
  };
  EXPECT_TRUE(fails("missing", false));
  EXPECT_TRUE(fails("taken", true));
  EXPECT_TRUE(fails("../a", false));
  FileSet removing(folder.path());
  removing.remove("../other/file");
  EXPECT_FALSE(removing.commit());
  EXPECT_EQ(get_file(folder / "a"), "old");
  EXPECT_EQ(contents(folder.path()).size(), 2U) << "temporary files were left";
}

// Runs a commit in a child process that dies before the change of the folder with number `dies_at`.
// True if it died, false if it came to its end.
bool commit_dies_at(const fs::path& folder, int dies_at) {
  const pid_t child = fork();
  if (child == 0) {
    FileSet set(folder);
    for (const char* name : {"a", "b", "c"}) put_file(set.add(name), std::string("new ") + name);
    set.remove("d");
    int step = 0;
    const Status status = FileSetTestAccess::commit(set, [&] {
      if (step++ == dies_at) _exit(7);
    });
    _exit(status ? 0 : 1);
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_NE(WEXITSTATUS(status), 1) << "the commit failed";
  return WEXITSTATUS(status) == 7;
}

TEST(FileSet, DyingAnywhereLeavesAllOldOrAllNew) {
  const std::map<std::string, std::string> old_state = {
      {"a", "old a"}, {"b", "old b"}, {"c", "old c"}, {"d", "old d"}};
  const std::map<std::string, std::string> new_state = {
      {"a", "new a"}, {"b", "new b"}, {"c", "new c"}};
  int old_states = 0, new_states = 0, mixed_before = 0;
  bool died = true;
  for (int dies_at = 0; died; ++dies_at) {
    ASSERT_LT(dies_at, 50);
    const ScratchFolder folder;
    for (const auto& [name, bytes] : old_state) put_file(folder / name, bytes);
    died = commit_dies_at(folder.path(), dies_at);
    const bool has_old = get_file(folder / "c") == "old c";
    const bool has_new = get_file(folder / "a") == "new a";
    mixed_before += has_old && has_new ? 1 : 0;
    ASSERT_TRUE(FileSet::finish_interrupted(folder.path()));
    auto state = contents(folder.path());
    std::erase_if(state, [](const auto& file) { return file.first.starts_with(".tread-"); });
    if (state == old_state) {
      ++old_states;
    } else {
      EXPECT_EQ(state, new_state) << "died before step " << dies_at;
      ++new_states;
      EXPECT_EQ(contents(folder.path()), new_state) << "something was left behind";
    }
  }
  // Before the sync and before the journal: old. Before each of three renames, one removal and the
  // end of the journal: new. And once it did not die.
  EXPECT_EQ(old_states, 2);
  EXPECT_EQ(new_states, 6);
  EXPECT_EQ(mixed_before, 2) << "the interruptions did not hit the middle";
}

TEST(FileSet, TheNextCommitCompletesTheInterruptedOneFirst) {
  const ScratchFolder folder;
  ASSERT_TRUE(commit_dies_at(folder.path(), 3));  // behind the first rename
  FileSet set(folder.path());
  put_file(set.add("b"), "newer b");
  ASSERT_TRUE(set.commit());
  EXPECT_EQ(contents(folder.path()),
            (std::map<std::string, std::string>{{"a", "new a"}, {"b", "newer b"}, {"c", "new c"}}));
}

TEST(FileSet, AJournalCannotReachOutsideItsFolder) {
  const ScratchFolder outer;
  fs::create_directory(outer / "map");
  put_file(outer / "victim", "precious");
  const std::string token = "0123456789abcdef";
  put_file(outer / "map" / (".tread-" + token + "-x"), "evil");
  const std::string head = "tread journal 1\ntoken " + token + "\n";
  for (const std::string& text :
       {head + "rename ../victim\nend\n", head + "remove ../victim\nend\n",
        head + "remove /etc/victim\nend\n", head + "rename ..\nend\n", head + "rename \nend\n",
        head + "chmod x\nend\n", head + "rename x\n", std::string("tread journal 2\n"),
        std::string("tread journal 1\ntoken ../../../../../x\nrename victim\nend\n"),
        std::string("")}) {
    put_file(outer / "map" / ".tread-journal", text);
    const Status status = FileSet::finish_interrupted(outer / "map");
    ASSERT_FALSE(status) << text;
    EXPECT_EQ(status.error().code, ErrorCode::kBadFormat) << text;
    EXPECT_FALSE(fs::exists(outer / "map" / "x")) << "a part of a bad journal was carried out";
  }
  EXPECT_EQ(get_file(outer / "victim"), "precious");
  put_file(outer / "map" / ".tread-journal", head + "rename x\nend\n");
  EXPECT_TRUE(FileSet::finish_interrupted(outer / "map"));
  EXPECT_EQ(get_file(outer / "map" / "x"), "evil");
}

TEST(FileSet, DamagedJournalsAreCleanlyRefusedOrCarriedOut) {
  const ScratchFolder folder;
  const std::string valid = "tread journal 1\ntoken 0123456789abcdef\nrename a\nremove bcd\nend\n";
  const auto finish = [&](const fs::path&) {
    return FileSet::finish_interrupted(folder.path()).has_value();
  };
  // The text without its last line end is complete as well.
  EXPECT_EQ(testing::shorter_files_taken(valid, folder / ".tread-journal", finish), 1);
  EXPECT_GT(testing::damaged_files_refused(valid, folder / ".tread-journal", finish), 1000);
}

TEST(FileSet, ForgottenTemporaryFilesGoAfterADayAndFreshOnesStay) {
  const ScratchFolder folder;
  const fs::path forgotten = folder / ".tread-0123456789abcdef-a";
  const fs::path fresh = folder / ".tread-0123456789abcdee-a";
  const fs::path foreign = folder / ".tread-notes-of-somebody-else";
  for (const fs::path& path : {forgotten, fresh, foreign}) put_file(path, "x");
  for (const fs::path& path : {forgotten, foreign}) {
    fs::last_write_time(path, fs::file_time_type::clock::now() - std::chrono::hours(25));
  }
  FileSet set(folder.path());
  put_file(set.add("a"), "new");
  ASSERT_TRUE(set.commit());
  EXPECT_FALSE(fs::exists(forgotten));
  EXPECT_TRUE(fs::exists(fresh));
  EXPECT_TRUE(fs::exists(foreign));
}

TEST(FileSet, AFullDiskInCommitLeavesTheOldState) {
  const ScratchFolder folder;
  put_file(folder / "a", "old a");
  FileSet set(folder.path());
  put_file(set.add("a"), "new a");
  put_file(set.add("b"), "new b");
  {
    const FullDisk full(10);  // the journal does not fit
    const Status status = set.commit();
    ASSERT_FALSE(status);
    EXPECT_EQ(status.error().code, ErrorCode::kWriteFailed);
  }
  ASSERT_TRUE(FileSet::finish_interrupted(folder.path()));
  EXPECT_EQ(get_file(folder / "a"), "old a");
  EXPECT_FALSE(fs::exists(folder / "b"));
}

}  // namespace
}  // namespace tread
