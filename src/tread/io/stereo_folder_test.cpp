#include "tread/io/stereo_folder.hpp"

#include <gtest/gtest.h>

#include "file_mutations.hpp"
#include "test_data.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;
using testing::ScratchFolder;

void touch(const fs::path& path) {
  fs::create_directories(path.parent_path());
  testing::put_file(path, "");
}

std::vector<std::string> names_of(const StereoFolder& folder) {
  std::vector<std::string> names;
  for (const auto& frame : folder.frames) names.push_back(frame.name);
  return names;
}

TEST(StereoFolder, EveryLayoutIsFound) {
  struct Case {
    const char* left;
    const char* right;
    StereoFolder::Kind kind;
  };
  for (const Case& c :
       {Case{"image_0/000001.png", "image_1/000001.png", StereoFolder::Kind::kKitti},
        Case{"image_2/000001.png", "image_3/000001.png", StereoFolder::Kind::kKitti},
        Case{"image_l/000001.png", "image_r/000001.png", StereoFolder::Kind::kKitti},
        Case{"left/a.jpg", "right/a.JPEG", StereoFolder::Kind::kLeftRight},
        Case{"image_left/a.pgm", "image_right/a.ppm", StereoFolder::Kind::kLeftRight},
        Case{"cam0/data/1.png", "cam1/data/1.png", StereoFolder::Kind::kLeftRight},
        Case{"mav0/cam0/data/1.png", "mav0/cam1/data/1.png", StereoFolder::Kind::kLeftRight},
        Case{"scene_left.png", "scene_right.png", StereoFolder::Kind::kLeftRight}}) {
    const ScratchFolder scratch;
    touch(scratch / c.left);
    touch(scratch / c.right);
    const auto folder = find_stereo_folder(scratch.path());
    ASSERT_TRUE(folder) << c.left << ": " << folder.error().message();
    EXPECT_EQ(folder->kind, c.kind) << c.left;
    ASSERT_EQ(folder->frames.size(), 1U) << c.left;
    EXPECT_EQ(folder->frames[0].left, scratch / c.left);
    EXPECT_EQ(folder->frames[0].right, scratch / c.right);
  }
}

TEST(StereoFolder, GreyImagesOfKittiComeBeforeColour) {
  const ScratchFolder scratch;
  for (int i = 0; i < 4; ++i) touch(scratch / ("image_" + std::to_string(i) + "/000000.png"));
  EXPECT_EQ(find_stereo_folder(scratch.path()).value().left_folder, "image_0");
}

TEST(StereoFolder, NumbersAreOrderedAsNumbersAndKeepTheirGaps) {
  const ScratchFolder scratch;
  for (const char* name : {"10", "9", "2"}) {
    touch(scratch / "left" / (std::string(name) + ".png"));
    touch(scratch / "right" / (std::string(name) + ".png"));
  }
  const auto folder = find_stereo_folder(scratch.path());
  ASSERT_TRUE(folder);
  EXPECT_EQ(names_of(*folder), (std::vector<std::string>{"2", "9", "10"}));
  EXPECT_EQ(folder->frames[1].number, 9);
  EXPECT_EQ(folder->frames[1].stamp_ns, 900'000'000);
}

TEST(StereoFolder, LongNumbersAreStamps) {
  const ScratchFolder scratch;
  for (const char* name : {"1403636579763555584", "1403636579813555456"}) {
    touch(scratch / "cam0" / "data" / (std::string(name) + ".png"));
    touch(scratch / "cam1" / "data" / (std::string(name) + ".png"));
  }
  const auto folder = find_stereo_folder(scratch.path());
  ASSERT_TRUE(folder);
  EXPECT_EQ(folder->frames[0].stamp_ns, 1403636579763555584);
  EXPECT_EQ(folder->frames[1].stamp_ns, 1403636579813555456);
  EXPECT_EQ(folder->frames[1].number, 1);
}

TEST(StereoFolder, NamesAreOrderedAsNamesAndCounted) {
  const ScratchFolder scratch;
  // Equal as numbers, or not all numbers, or between number and stamp: names.
  for (const auto& names : {std::vector<std::string>{"01", "1"},
                            {"a", "b"},
                            {"5", "b"},
                            {"123456789012", "5"},
                            {"99999999999999999999", "x"}}) {
    fs::remove_all(scratch / "left");
    fs::remove_all(scratch / "right");
    for (const std::string& name : names) {
      touch(scratch / "left" / (name + ".png"));
      touch(scratch / "right" / (name + ".png"));
    }
    const auto folder = find_stereo_folder(scratch.path());
    ASSERT_TRUE(folder);
    EXPECT_EQ(names_of(*folder), names);
    EXPECT_EQ(folder->frames[0].stamp_ns, 0);
    EXPECT_EQ(folder->frames[1].stamp_ns, 100'000'000);
  }
}

TEST(StereoFolder, UnpairedFilesStayAndOthersAreLeftOut) {
  const ScratchFolder scratch;
  for (const char* name : {"left/1.png", "left/2.png", "right/2.png", "right/3.png",
                           "left/notes.txt", "left/.hidden.png", "right/Thumbs.db"}) {
    touch(scratch / name);
  }
  const auto folder = find_stereo_folder(scratch.path());
  ASSERT_TRUE(folder);
  EXPECT_EQ(names_of(*folder), (std::vector<std::string>{"1", "2", "3"}));
  EXPECT_TRUE(folder->frames[0].right.empty());
  EXPECT_TRUE(folder->frames[2].left.empty());
}

TEST(StereoFolder, WhatIsNotUnderstoodIsRefusedWithWhatIs) {
  const ScratchFolder scratch;
  EXPECT_EQ(find_stereo_folder(scratch / "none").error().code, ErrorCode::kNotFound);
  touch(scratch / "file.png");
  const auto file = find_stereo_folder(scratch / "file.png");
  ASSERT_FALSE(file);
  EXPECT_NE(file.error().remedy.find("image_0"), std::string::npos);
  const auto nothing = find_stereo_folder(scratch.path());
  ASSERT_FALSE(nothing);
  EXPECT_EQ(nothing.error().code, ErrorCode::kNotFound);
  EXPECT_NE(nothing.error().remedy.find("NAME_left.png"), std::string::npos);
  fs::create_directories(scratch / "left");
  fs::create_directories(scratch / "right");
  EXPECT_EQ(find_stereo_folder(scratch.path()).error().what, "no images in it");
  touch(scratch / "left/1.png");
  touch(scratch / "left/1.jpg");
  const auto twice = find_stereo_folder(scratch.path());
  ASSERT_FALSE(twice);
  EXPECT_NE(twice.error().what.find("1.jpg"), std::string::npos);
}

}  // namespace
}  // namespace tread
