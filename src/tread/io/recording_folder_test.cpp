// How a recording replaces an older one, and what happens if it is interrupted.
#include "tread/io/recording_folder.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <map>

#include "file_mutations.hpp"
#include "test_data.hpp"
#include "tread/io/source.hpp"

namespace tread::internal {

struct RecordingFolderTestAccess {
  static Status publish_in_steps(RecordingFolder& folder, const std::function<void()>& step) {
    return folder.publish_in_steps(step);
  }
};

namespace {

namespace fs = std::filesystem;
using testing::get_file;
using testing::put_file;
using testing::ScratchFolder;
using Contents = std::map<std::string, std::string>;

// All files by their path in the folder.
Contents contents(const fs::path& folder) {
  Contents files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    files[fs::relative(entry.path(), folder).string()] = get_file(entry.path());
  }
  return files;
}

const Contents kOld = {{"mav0/cam0/data.csv", "old"}, {"mav0/gnss0/data.csv", "old"},
                       {"poses.txt", "old"},          {"recording.yaml", "old"},
                       {"rig.yaml", "old"},           {"truth/body.tum", "old"}};
const Contents kNew = {{"mav0/cam0/data.csv", "new"},
                       {"mav0/imu0/data.csv", "new"},
                       {"recording.yaml", "new"},
                       {"rig.yaml", "new"},
                       {"truth/height.tif", "new"}};

void write(const fs::path& folder, const Contents& files) {
  for (const auto& [name, text] : files) {
    fs::create_directories((folder / name).parent_path());
    put_file(folder / name, text);
  }
}

std::unique_ptr<RecordingFolder> open(const fs::path& folder) {
  auto opened = RecordingFolder::open(folder);
  EXPECT_TRUE(opened) << opened.error().message();
  return opened ? std::move(*opened) : nullptr;
}

TEST(RecordingFolder, ReplacesAllOfTheOldOneAndNothingElse) {
  const ScratchFolder scratch;
  write(scratch.path(), kOld);
  put_file(scratch / "notes.txt", "mine");
  auto folder = open(scratch.path());
  write(folder->staged(""), kNew);
  Contents expected = kOld;
  expected["notes.txt"] = "mine";
  for (const auto& [name, text] : expected) EXPECT_EQ(get_file(scratch / name), text);
  ASSERT_TRUE(folder->publish());
  expected = kNew;
  expected["notes.txt"] = "mine";
  EXPECT_EQ(contents(scratch.path()), expected);
  folder.reset();
  EXPECT_EQ(contents(scratch.path()), expected);
  EXPECT_FALSE(fs::exists(scratch / ".tread-recording"));
}

TEST(RecordingFolder, OneThatIsNotPublishedLeavesNothing) {
  const ScratchFolder scratch;
  write(scratch.path(), kOld);
  {
    const auto folder = open(scratch.path());
    write(folder->staged(""), kNew);
  }
  EXPECT_EQ(contents(scratch.path()), kOld);
}

TEST(RecordingFolder, RefusesWhatIsNoRecordingOrHoldsMore) {
  const ScratchFolder scratch;
  put_file(scratch / "thesis.tex", "dear");
  const auto foreign = RecordingFolder::open(scratch.path());
  ASSERT_FALSE(foreign);
  EXPECT_NE(foreign.error().message().find("thesis.tex"), std::string::npos);
  const ScratchFolder mixed;
  write(mixed.path(), kOld);
  put_file(mixed / "mav0/leica0", "dear");
  const auto more = RecordingFolder::open(mixed.path());
  ASSERT_FALSE(more);
  EXPECT_EQ(more.error().where, (mixed / "mav0/leica0").string());
  fs::remove(mixed / "mav0/leica0");
  put_file(mixed / "truth/measured.csv", "dear");
  EXPECT_FALSE(RecordingFolder::open(mixed.path()));
  EXPECT_EQ(get_file(mixed / "truth/measured.csv"), "dear");
  const ScratchFolder file;
  put_file(file / "a", "x");
  EXPECT_FALSE(RecordingFolder::open(file / "a")) << "not a folder";
}

TEST(RecordingFolder, WhatIsPutThereMeanwhileIsNotLost) {
  const ScratchFolder scratch;
  write(scratch.path(), kOld);
  const auto folder = open(scratch.path());
  write(folder->staged(""), kNew);
  put_file(scratch / "mav0/leica0", "dear");
  EXPECT_FALSE(folder->publish());
  EXPECT_EQ(get_file(scratch / "mav0/leica0"), "dear");
  EXPECT_EQ(get_file(scratch / "rig.yaml"), "old");
}

TEST(RecordingFolder, TwoCannotRecordAtOnce) {
  const ScratchFolder scratch;
  auto first = open(scratch.path());
  const auto second = RecordingFolder::open(scratch.path());
  ASSERT_FALSE(second);
  EXPECT_NE(second.error().message().find("another process"), std::string::npos);
  first.reset();
  EXPECT_TRUE(RecordingFolder::open(scratch.path()));
}

struct Stopped {};

// A process that dies before its n-th change leaves the old recording or, after the mark, one that
// the next who looks makes new.
TEST(RecordingFolder, InterruptedAnywhereItIsTheOldOneOrTheNewOne) {
  int steps = 0;
  {
    const ScratchFolder scratch;
    write(scratch.path(), kOld);
    const auto folder = open(scratch.path());
    write(folder->staged(""), kNew);
    ASSERT_TRUE(RecordingFolderTestAccess::publish_in_steps(*folder, [&] { ++steps; }));
  }
  ASSERT_GT(steps, 10);
  for (int last = 1; last <= steps; ++last) {
    const ScratchFolder scratch;
    write(scratch.path(), kOld);
    {
      const auto folder = open(scratch.path());
      write(folder->staged(""), kNew);
      int step = 0;
      EXPECT_THROW((void)RecordingFolderTestAccess::publish_in_steps(*folder,
                                                                     [&] {
                                                                       if (++step == last)
                                                                         throw Stopped();
                                                                     }),
                   Stopped);
    }
    ASSERT_TRUE(RecordingFolder::finish_interrupted(scratch.path()));
    EXPECT_EQ(contents(scratch.path()), last <= 2 ? kOld : kNew) << last;
    ASSERT_TRUE(RecordingFolder::finish_interrupted(scratch.path()));
  }
}

TEST(RecordingFolder, ReadersFinishAnInterruptedOne) {
  const ScratchFolder scratch;
  write(scratch.path(), kOld);
  write(scratch / ".tread-recording/new", kNew);
  fs::create_directories(scratch / ".tread-recording/old");
  put_file(scratch / ".tread-recording/complete", "mav0\nrecording.yaml\nrig.yaml\ntruth\n");
  EXPECT_FALSE(open_stereo_source(scratch.path())) << "there are no images in it";
  EXPECT_EQ(contents(scratch.path()), kNew);
}

TEST(RecordingFolder, LeftoversOfADeadProcessAreRemoved) {
  const ScratchFolder scratch;
  write(scratch.path(), kOld);
  write(scratch / ".tread-recording/new", {{"mav0/cam0/data.csv", "half"}});
  ASSERT_TRUE(RecordingFolder::finish_interrupted(scratch.path()));
  EXPECT_EQ(get_file(scratch / "mav0/cam0/data.csv"), "old") << "it was not complete";
  const auto folder = open(scratch.path());
  EXPECT_TRUE(fs::is_empty(folder->staged("")));
}

TEST(RecordingFolder, AFolderThatMayNotBeWrittenIsNamed) {
  if (geteuid() == 0) GTEST_SKIP() << "root may write anywhere";
  const ScratchFolder scratch;
  fs::permissions(scratch.path(), fs::perms{0500});
  const auto folder = RecordingFolder::open(scratch / "run");
  fs::permissions(scratch.path(), fs::perms{0700});
  ASSERT_FALSE(folder);
  EXPECT_EQ(folder.error().where, (scratch / "run").string());
}

TEST(RecordingFolder, ErrorsNameTheFilesAsTheyWillBe) {
  const ScratchFolder scratch;
  const auto folder = open(scratch.path());
  const Error error =
      folder->renamed({ErrorCode::kWriteFailed, "full", folder->staged("mav0/x.png").string(), ""});
  EXPECT_EQ(error.where, (scratch / "mav0/x.png").string());
}

}  // namespace
}  // namespace tread::internal
