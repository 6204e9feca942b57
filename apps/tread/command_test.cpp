// The program as a user runs it: help, usage, and `tread depth`.
#include "command_test.hpp"

#include <cmath>
#include <new>
#include <stdexcept>

#include "command.hpp"
#include "tread/io/mesh_file.hpp"
#include "tread/io/raster_file.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;
using namespace testing;

TEST(TreadHelp, EveryCommandShowsAnExample) {
  EXPECT_EQ(tread("--help").status, 0);
  EXPECT_EQ(tread("--version").status, 0);
  for (const char* command : {"depth", "map", "plan", "info"}) {
    const Ran ran = tread(std::string(command) + " --help");
    EXPECT_EQ(ran.status, 0);
    EXPECT_NE(ran.out.find("Example"), std::string::npos) << command;
  }
}

TEST(TreadHelp, WrongUsageEndsWith2AndSaysWhatToDo) {
  expect_refused("", {"no command", "depth, slam, map, plan, simulate, info", "--help"}, 2);
  expect_refused("frob", {"'frob'", "depth, slam, map, plan, simulate, info"}, 2);
  expect_refused("mpa drive", {"Did you mean 'map'?"}, 2);
  expect_refused("depth", {"LEFT is required", "tread depth --help"}, 2);
  expect_refused("depth a b --treads 2", {"--treads", "Did you mean --threads?"}, 2);
  expect_refused("depth a b --threads 0", {"--threads", "1 to 256"}, 2);
  expect_refused("depth a b -o", {"--output"}, 2);
  expect_refused("map drive --rig ''", {"--rig", "empty"}, 2);
  expect_refused("map drive --start 1", {"--start", "2"}, 2);
  expect_refused("plan m --start 0 0 --goal east 1", {"--goal", "east"}, 2);
}

TEST(PrintException, TellsWhatItMeansAndNotWhereALibraryThrew) {
  const auto said = [](const std::exception& error) {
    ::testing::internal::CaptureStderr();
    EXPECT_EQ(print_exception(error), 1);
    return ::testing::internal::GetCapturedStderr();
  };
  const std::runtime_error no_memory(
      "OpenCV(4.6.0) ./alloc.cpp:73: error: (-4:Insufficient memory) Failed to allocate 9 bytes in "
      "function 'OutOfMemoryError'\n");
  EXPECT_TRUE(said(no_memory).starts_with("tread: out of memory. "));
  EXPECT_EQ(said(std::bad_alloc()), said(no_memory));
  const std::string other = said(std::runtime_error(
      "OpenCV(4.6.0) ./a.cpp:7: error: (-215:Assertion failed) n > 0 in function 'f'\n"));
  EXPECT_NE(other.find("(-215:Assertion failed) n > 0. Please report"), std::string::npos) << other;
  EXPECT_EQ(other.find("a.cpp"), std::string::npos) << other;
}

TEST(TreadDepth, WritesWhatItSays) {
  const ScratchFolder out;
  const Ran ran = tread("depth " + pair_arguments() + " --rig " + (drive() / "rig.yaml").string() +
                        " --json -o " + (out / "d").string());
  ASSERT_EQ(ran.status, 0) << ran.err;
  const auto json = ran.json();
  EXPECT_GT(json["density"], 0.5);
  EXPECT_EQ(json["size_px"][0], 320);
  for (const auto& file : json["files"]) {
    EXPECT_TRUE(fs::exists(file.get<std::string>())) << file;
  }
  const auto disparity = read_pfm(out / "d/disparity.pfm");
  const auto depth = read_tiff(out / "d/depth.tif");
  const auto cloud = read_ply(out / "d/cloud.ply");
  ASSERT_TRUE(disparity && depth && cloud);
  EXPECT_EQ(cloud->points.size(), json["points"]);
  // b f = 50 m px: unknown in one is unknown in the other.
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) {
      ASSERT_EQ(std::isinf((*disparity)(x, y)), std::isnan((*depth)(x, y)));
      if (std::isinf((*disparity)(x, y)) || (*disparity)(x, y) == 0.0F) continue;
      ASSERT_NEAR((*depth)(x, y), 50.0 / (*disparity)(x, y), 1e-3);
    }
  }
}

TEST(TreadDepth, RatesItsMatchesIfAsked) {
  const ScratchFolder out;
  const std::string folder = (out / "d").string();
  ASSERT_EQ(tread("depth " + pair_arguments() + " --set stereo.rate=true -o " + folder).status, 0);
  EXPECT_TRUE(fs::exists(out / "d/confidence.tif"));
  EXPECT_TRUE(fs::exists(out / "d/sigma.tif"));
  ASSERT_EQ(tread("depth " + pair_arguments() + " -o " + folder).status, 0);
  EXPECT_FALSE(fs::exists(out / "d/confidence.tif"));  // of the run before
}

TEST(TreadDepth, ShrunkImagesKeepTheirDepths) {
  const ScratchFolder out;
  const Ran ran = tread("depth " + pair_arguments() + " --rig " + (drive() / "rig.yaml").string() +
                        " --set shrink=2 -o " + out.path().string());
  ASSERT_EQ(ran.status, 0) << ran.err;
  const auto small = read_pfm(out / "disparity.pfm");
  const auto depth = read_tiff(out / "depth.tif");
  ASSERT_TRUE(small && depth);
  EXPECT_EQ(small->width, 160);
  int known = 0;
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 160; ++x) {
      if (std::isnan((*depth)(x, y)) || (*small)(x, y) == 0.0F) continue;
      ++known;
      ASSERT_NEAR((*depth)(x, y), 25.0 / (*small)(x, y), 1e-3);
    }
  }
  EXPECT_GT(known, 4000);
}

TEST(TreadDepth, WithoutRigGivesDisparityOnlyAndSaysSo) {
  const Ran ran = tread("depth " + pair_arguments());
  EXPECT_EQ(ran.status, 0);
  EXPECT_NE(ran.out.find("no rig given"), std::string::npos);
}

TEST(TreadDepth, WrongInputsAreNamed) {
  const ScratchFolder scratch;
  const std::string left = (drive() / "left/000001.png").string();
  expect_refused("depth nowhere.png " + left, {"nowhere.png"});
  ASSERT_TRUE(write_file(scratch / "text.png", "not an image"));
  expect_refused("depth " + left + " " + (scratch / "text.png").string(), {"text.png"});
  ASSERT_TRUE(write_png(scratch / "small.png", Image<std::uint8_t>(10, 10).view()));
  expect_refused("depth " + left + " " + (scratch / "small.png").string(),
                 {"small.png", "10x10", "320x240"});
  expect_refused("depth " + pair_arguments() + " --rig bumblebee2-640",
                 {"bumblebee2-640", "640x480", "320x240"});
  expect_refused("depth " + pair_arguments() + " --rig nowhere.yaml", {"nowhere.yaml"});
  expect_refused("depth " + pair_arguments() + " --set stereo.sad.windw_width_px=5",
                 {"stereo.sad.window_width_px"});
  expect_refused("depth " + pair_arguments() + " --set stereo.sad.window_width_px=4",
                 {"stereo.sad.window_width_px", "odd"});
  expect_refused("depth " + pair_arguments() + " --set nonsense", {"name=value"});
  expect_refused("depth " + pair_arguments() + " --set =3", {"no name", "name=value"});
  expect_refused("depth " + pair_arguments() + " --num-disparities 400", {"320"});
  expect_refused("depth " + pair_arguments() + " -o " + left + "/x", {left});
}

// Two grey images: nothing to match.
std::string grey_pair(const ScratchFolder& folder) {
  EXPECT_TRUE(write_png(folder / "l.png", Image<std::uint8_t>(320, 240, 100).view()));
  EXPECT_TRUE(write_png(folder / "r.png", Image<std::uint8_t>(320, 240, 101).view()));
  return (folder / "l.png").string() + " " + (folder / "r.png").string();
}

TEST(TreadDepth, NothingMatchedIsAFailureWithItsPictures) {
  const ScratchFolder scratch;
  const std::string rig = " --rig " + (drive() / "rig.yaml").string();
  const std::string out = (scratch / "d").string();
  const Ran ran = tread("depth " + grey_pair(scratch) + rig + " --json -o " + out);
  EXPECT_EQ(ran.status, 1);
  for (const char* word : {"l.png", "no pixel was matched", "0 to 63 px", "texture"}) {
    EXPECT_NE(ran.err.find(word), std::string::npos) << ran.err;
  }
  const auto json = ran.json();
  EXPECT_EQ(json["density"], 0.0);
  EXPECT_FALSE(json.contains("disparity_px"));  // there are no numbers to tell
  EXPECT_FALSE(json.contains("depth_m"));
  EXPECT_EQ(json["problems"].size(), 1U);
  EXPECT_EQ(json["files"].size(), 3U);
  for (const char* name : {"disparity.pfm", "disparity.png", "report.html"}) {
    EXPECT_TRUE(fs::exists(scratch / "d" / name)) << name;
  }
  EXPECT_FALSE(fs::exists(scratch / "d/depth.tif"));
}

TEST(TreadDepth, TheSamePictureTwiceIsSaid) {
  const std::string left = (drive() / "left/000001.png").string();
  expect_refused("depth " + left + " " + left, {"left/000001.png", "are the same"});
}

TEST(TreadDepth, NoDepthWithinTheGateIsAFailure) {
  const ScratchFolder scratch;
  const Ran ran = tread("depth " + pair_arguments() + " --rig " + (drive() / "rig.yaml").string() +
                        " --set depth.min_depth_m=900 -o " + (scratch / "d").string());
  EXPECT_EQ(ran.status, 1);
  EXPECT_NE(ran.err.find("900 to 10000 m"), std::string::npos) << ran.err;
  EXPECT_EQ(ran.out.find(" points;"), std::string::npos) << ran.out;
  EXPECT_TRUE(fs::exists(scratch / "d/disparity.png"));
}

TEST(TreadDepth, FilesOfAnEarlierRunGoAndOtherFilesStay) {
  const ScratchFolder out;
  const std::string run = "depth " + pair_arguments() + " -o " + out.path().string();
  // The user's own, in a folder that no run has written to.
  ASSERT_TRUE(write_file(out / "depth.tif", "mine"));
  ASSERT_EQ(tread(run).status, 0);
  EXPECT_EQ(read_file(out / "depth.tif").value(), "mine");
  ASSERT_EQ(tread(run + " --rig " + (drive() / "rig.yaml").string()).status, 0);
  EXPECT_TRUE(read_tiff(out / "depth.tif"));
  ASSERT_TRUE(write_file(out / "notes.txt", "mine"));
  ASSERT_EQ(tread(run).status, 0);
  EXPECT_FALSE(fs::exists(out / "depth.tif"));
  EXPECT_FALSE(fs::exists(out / "cloud.ply"));
  EXPECT_TRUE(fs::exists(out / "notes.txt"));
  EXPECT_EQ(std::distance(fs::directory_iterator(out.path()), {}), 4);  // and nothing temporary
}

TEST(TreadDepth, TheOutputFolderIsCheckedBeforeTheWork) {
  const ScratchFolder scratch;
  expect_refused("depth " + pair_arguments() + " -o ''", {"--output", "empty"}, 2);
  ASSERT_TRUE(write_file(scratch / "file", ""));
  const Ran ran = tread("depth " + pair_arguments() + " -o " + (scratch / "file").string());
  EXPECT_EQ(ran.status, 1);
  EXPECT_EQ(ran.out, "");  // nothing was computed
  EXPECT_NE(ran.err.find("cannot make this folder"), std::string::npos) << ran.err;
  if (fs::exists("/proc/self")) {  // a folder that nobody can write to, not even root
    expect_refused("depth " + pair_arguments() + " -o /proc/self", {"/proc/self", "cannot write"});
    expect_refused("map " + drive().string() + " -o /proc/self", {"/proc/self", "cannot write"});
  }
  expect_refused("map " + drive().string() + " -o ''", {"--output", "empty"}, 2);
}

}  // namespace
}  // namespace tread
