// Images of another size than the others: the odd one is blamed, not the rest.
#include <gtest/gtest.h>

#include <algorithm>

#include "file_mutations.hpp"
#include "sample_images.hpp"
#include "test_data.hpp"
#include "tread/io/rig_file.hpp"
#include "tread/io/source.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;
using testing::make_png;
using testing::put_file;
using testing::ScratchFolder;

std::string png(int width, int height) {
  return make_png(
      width, height, 8, 0,
      std::string(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 'x'));
}

void put(const fs::path& path, const std::string& bytes) {
  fs::create_directories(path.parent_path());
  put_file(path, bytes);
}

std::string name_of(int frame) {
  return "0000" + std::string(frame < 10 ? "0" : "") + std::to_string(frame) + ".png";
}

// A KITTI sequence of 4 x 3 pixels; its calibration names no size.
void make_kitti(const fs::path& folder, int frames) {
  put(folder / "calib.txt", "P0: 10 0 2 0 0 10 1 0 0 0 1 0\nP1: 10 0 2 -5 0 10 1 0 0 0 1 0\n");
  for (int i = 0; i < frames; ++i) {
    for (const char* side : {"image_0", "image_1"}) put(folder / side / name_of(i), png(4, 3));
  }
}

struct Outcome {
  ImageSize size;
  std::string taken;  // one letter a frame: x, or - for refused
  std::vector<Error> errors;
};

Outcome read(const fs::path& folder) {
  const auto source = open_stereo_source(folder);
  EXPECT_TRUE(source) << source.error().message();
  if (!source) return {};
  Outcome outcome{(*source)->rig().size, "", {}};
  for (;;) {
    const auto next = (*source)->next();
    if (next && !*next) return outcome;
    outcome.taken += next ? 'x' : '-';
    if (!next) outcome.errors.push_back(next.error());
  }
}

TEST(SourceSize, AnOddFirstImageIsTheOneBlamed) {
  for (const char* side : {"image_0", "image_1"}) {
    const ScratchFolder folder;
    make_kitti(folder.path(), 4);
    put(folder / side / name_of(0), png(5, 3));
    const Outcome outcome = read(folder.path());
    EXPECT_EQ(outcome.size, (ImageSize{4, 3}));
    ASSERT_EQ(outcome.taken, "-xxx") << side;
    EXPECT_EQ(outcome.errors[0].where, (folder / side / name_of(0)).string());
    EXPECT_NE(outcome.errors[0].what.find("5x3 pixels, but the rig has 4x3"), std::string::npos);
  }
}

TEST(SourceSize, AWholeOddFirstFrameIsOutvotedByTwoMore) {
  const ScratchFolder folder;
  make_kitti(folder.path(), 3);
  for (const char* side : {"image_0", "image_1"}) put(folder / side / name_of(0), png(8, 8));
  EXPECT_EQ(read(folder.path()).taken, "-xx");
}

TEST(SourceSize, ADriveThatBeginsWithSeveralOddFramesIsJudgedByTheRest) {
  const ScratchFolder folder;
  make_kitti(folder.path(), 40);
  for (int i = 0; i < 12; ++i) {
    for (const char* side : {"image_0", "image_1"}) put(folder / side / name_of(i), png(8, 8));
  }
  EXPECT_EQ(read(folder.path()).taken, std::string(12, '-') + std::string(28, 'x'));
}

TEST(SourceSize, TheCalibrationsOwnSizeComesFirst) {
  const ScratchFolder folder;
  make_kitti(folder.path(), 3);
  for (int i = 1; i < 3; ++i) {
    for (const char* side : {"image_0", "image_1"}) put(folder / side / name_of(i), png(5, 3));
  }
  EXPECT_EQ(read(folder.path()).taken, "-xx") << "without one the most";
  StereoRig rig;
  rig.name = "mine";
  rig.size = {4, 3};
  rig.left = rig.right = PinholeCamera{10, 10, 2, 1, 0};
  rig.T_left_right.translation().x() = 0.2;
  rig.rectified = true;
  fs::remove(folder / "calib.txt");
  ASSERT_TRUE(write_rig(folder / "rig.yaml", rig));
  EXPECT_EQ(read(folder.path()).taken, "x--");
}

TEST(SourceSize, ImagesThatCannotBeReadHaveNoVote) {
  const ScratchFolder folder;
  make_kitti(folder.path(), 30);
  for (int i = 0; i < 30; ++i) {
    if (i == 17) continue;
    for (const char* side : {"image_0", "image_1"}) put(folder / side / name_of(i), "no picture");
  }
  const Outcome outcome = read(folder.path());
  EXPECT_EQ(outcome.size, (ImageSize{4, 3}));
  EXPECT_EQ(std::count(outcome.taken.begin(), outcome.taken.end(), 'x'), 1);
}

}  // namespace
}  // namespace tread
