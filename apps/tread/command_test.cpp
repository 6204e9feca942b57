// The program as a user runs it: exit status, output, files, messages.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "synthetic_drive.hpp"
#include "test_data.hpp"
#include "tread/io/atomic_file.hpp"
#include "tread/io/image_file.hpp"
#include "tread/io/map_files.hpp"
#include "tread/io/mesh_file.hpp"
#include "tread/io/raster_file.hpp"
#include "tread/io/rig_file.hpp"
#include "tread/io/trajectory_file.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;
using testing::ScratchFolder;

struct Ran {
  int status = -1;
  std::string out;
  std::string err;
  [[nodiscard]] nlohmann::json json() const { return nlohmann::json::parse(out); }
};

Ran tread(const std::string& arguments) {
  const ScratchFolder scratch;
  const std::string err = (scratch / "err").string();
  Ran ran;
  FILE* pipe = popen((std::string(TREAD_PROGRAM) + " " + arguments + " 2>" + err).c_str(), "r");
  EXPECT_NE(pipe, nullptr);
  std::array<char, 4096> buffer{};
  for (std::size_t n = 0; (n = fread(buffer.data(), 1, buffer.size(), pipe)) > 0;) {
    ran.out.append(buffer.data(), n);
  }
  const int ended = pclose(pipe);
  ran.status = WIFEXITED(ended) ? WEXITSTATUS(ended) : -ended;
  ran.err = read_file(err).value_or("");
  return ran;
}

// Expects a failure with exit status 1 whose message holds all of the words.
void expect_refused(const std::string& arguments, const std::vector<std::string>& words) {
  const Ran ran = tread(arguments);
  EXPECT_EQ(ran.status, 1) << arguments << "\n" << ran.out << ran.err;
  EXPECT_TRUE(ran.err.starts_with("tread: ")) << arguments << "\n" << ran.err;
  for (const std::string& word : words) {
    EXPECT_NE(ran.err.find(word), std::string::npos) << arguments << "\n" << ran.err << word;
  }
}

// Four frames towards a block, written once and copied by each test.
const fs::path& drive() {
  static const ScratchFolder folder;
  static const fs::path path = [] {
    fs::create_directories(folder / "left");
    fs::create_directories(folder / "right");
    const StereoRig rig = testing::small_rig();
    Trajectory trajectory;
    for (int i = 0; i < 4; ++i) {
      Isometry3d T_world_body = Isometry3d::Identity();
      T_world_body.translation().x() = 0.3 * i;
      const StereoFrame frame = testing::render_frame(rig, T_world_body * rig.mount->T_body_left,
                                                      testing::block_and_kerb, 8.0);
      const std::string name = "00000" + std::to_string(i) + ".png";
      EXPECT_TRUE(write_png(folder / "left" / name, frame.left.view()));
      EXPECT_TRUE(write_png(folder / "right" / name, frame.right.view()));
      trajectory.push_back({100'000'000LL * i, *frame.T_world_left});
    }
    EXPECT_TRUE(write_rig(folder / "rig.yaml", rig));
    EXPECT_TRUE(write_tum_trajectory(folder / "poses.txt", trajectory));
    return folder.path();
  }();
  return path;
}

fs::path copy_of_drive(const ScratchFolder& scratch) {
  fs::copy(drive(), scratch / "drive", fs::copy_options::recursive);
  return scratch / "drive";
}

std::string pair_arguments() {
  return (drive() / "left/000001.png").string() + " " + (drive() / "right/000001.png").string();
}

TEST(TreadHelp, EveryCommandShowsAnExample) {
  EXPECT_EQ(tread("--help").status, 0);
  EXPECT_EQ(tread("--version").status, 0);
  for (const char* command : {"depth", "map", "plan", "info"}) {
    const Ran ran = tread(std::string(command) + " --help");
    EXPECT_EQ(ran.status, 0);
    EXPECT_NE(ran.out.find("Example"), std::string::npos) << command;
  }
  EXPECT_NE(tread("").status, 0);
  EXPECT_NE(tread("fly").status, 0);
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
  expect_refused("depth " + pair_arguments() + " --num-disparities 400", {"320"});
  expect_refused("depth " + pair_arguments() + " -o " + left + "/x", {left});
}

TEST(TreadMap, MapsADriveAndPlansBeyondIt) {
  const ScratchFolder out;
  const Ran ran =
      tread("map " + drive().string() + " --features --json -o " + (out / "m").string());
  ASSERT_EQ(ran.status, 0) << ran.err;
  const auto json = ran.json();
  EXPECT_EQ(json["frames"], 4);
  EXPECT_EQ(json["plan"]["status"], "found");
  EXPECT_TRUE(json["plan"]["goal_beyond_map"]);
  EXPECT_GT(json["frames_per_second"], 0.0);
  for (const auto& file : json["files"]) {
    EXPECT_TRUE(fs::exists(file.get<std::string>())) << file;
  }
  const auto map = load_map(out / "m");
  ASSERT_TRUE(map) << map.error().message();
  for (const char* layer : {"height", "derivative", "explored", "cost", "slope", "step",
                            "roughness", "traversability"}) {
    EXPECT_NE(map->find(layer), nullptr) << layer;
  }
  EXPECT_TRUE(read_tum_trajectory(out / "m/trajectory.tum"));

  // Plans on the saved map: found, and all kinds of not found, which are answers.
  const std::string base = "plan " + (out / "m").string() + " --json ";
  EXPECT_EQ(tread(base + "--start 1 0 --goal 30 0").json()["status"], "found");
  const Ran blocked = tread(base + "--start 1 0 --goal 3.0 -0.3");
  EXPECT_EQ(blocked.status, 0);
  EXPECT_EQ(blocked.json()["status"], "goal blocked");
  EXPECT_NE(blocked.json()["reason"].get<std::string>().find("nearest free"), std::string::npos);
  const Ran outside = tread(base + "--start 100 0 --goal 3 0");
  EXPECT_EQ(outside.status, 0);
  EXPECT_EQ(outside.json()["status"], "start outside");
  const Ran written =
      tread("plan " + (out / "m").string() + " --start 1 0 --goal 30 0 -o " + (out / "p").string());
  EXPECT_EQ(written.status, 0);
  EXPECT_TRUE(fs::exists(out / "p/path.csv"));
  EXPECT_TRUE(fs::exists(out / "p/plan.png"));
  expect_refused("plan " + (out / "m").string() + " --start nan 0 --goal 3 0", {"not finite"});
  fs::remove(out / "m/cost.tif");
  expect_refused("plan " + (out / "m").string() + " --start 1 0 --goal 3 0", {"cost.tif"});
}

TEST(TreadMap, SameMapWithOneAndTwoThreads) {
  const ScratchFolder out;
  for (const char* threads : {"1", "2"}) {
    ASSERT_EQ(tread("map " + drive().string() + " --threads " + threads + " -o " +
                    (out / threads).string())
                  .status,
              0);
  }
  for (const char* name : {"height.tif", "derivative.tif", "cost.tif", "path.csv"}) {
    EXPECT_EQ(read_file(out / "1" / name).value(), read_file(out / "2" / name).value()) << name;
  }
}

TEST(TreadMap, BadFramesAreNamedAndTheOthersMapped) {
  const ScratchFolder scratch;
  const fs::path path = copy_of_drive(scratch);
  const std::string whole = read_file(path / "left/000001.png").value();
  ASSERT_TRUE(write_file(path / "left/000001.png", whole.substr(0, whole.size() / 2)));
  fs::remove(path / "right/000002.png");
  const Ran ran = tread("map " + path.string() + " --json -o " + (scratch / "m").string());
  EXPECT_EQ(ran.status, 1);
  EXPECT_NE(ran.err.find("left/000001.png"), std::string::npos) << ran.err;
  EXPECT_NE(ran.err.find("000002.png"), std::string::npos) << ran.err;
  const auto json = ran.json();
  EXPECT_EQ(json["frames"], 2);
  EXPECT_EQ(json["frames_failed"], 2);
  EXPECT_EQ(json["problems"].size(), 2U);
  EXPECT_TRUE(load_map(scratch / "m"));
}

TEST(TreadMap, ABrokenPoseLosesOneFrameAndNotTheDrive) {
  const ScratchFolder scratch;
  const fs::path path = copy_of_drive(scratch);
  auto poses = read_tum_trajectory(path / "poses.txt").value();
  poses[2].pose.translation().x() = 1e7;
  ASSERT_TRUE(write_tum_trajectory(path / "poses.txt", poses));
  const Ran ran = tread("map " + path.string() + " --json -o " + (scratch / "m").string());
  EXPECT_EQ(ran.status, 1);
  EXPECT_NE(ran.err.find("frame 000002: its pose is 1e+07 m from"), std::string::npos) << ran.err;
  EXPECT_EQ(ran.json()["frames_failed"], 1);
  EXPECT_TRUE(load_map(scratch / "m"));
}

TEST(TreadMap, WhereNothingCouldBeMappedEveryKindOfProblemIsSaid) {
  const ScratchFolder scratch;
  const fs::path path = copy_of_drive(scratch);
  auto poses = read_tum_trajectory(path / "poses.txt").value();
  poses.resize(1);  // the first frame has a pose and no image, the others have no poses
  ASSERT_TRUE(write_tum_trajectory(path / "poses.txt", poses));
  fs::remove(path / "right/000000.png");
  expect_refused("map " + path.string(),
                 {"there is no right image", "it has no pose (and ", "more like it", "none of "});
}

TEST(TreadMap, WrongInputsAreNamed) {
  const ScratchFolder scratch;
  expect_refused("map " + (scratch / "nowhere").string(), {"nowhere"});
  fs::create_directories(scratch / "empty");
  expect_refused("map " + (scratch / "empty").string(), {"empty"});
  fs::path path = copy_of_drive(scratch);
  fs::remove(path / "poses.txt");
  expect_refused("map " + path.string(), {"pose", "--poses"});
  fs::remove(path / "rig.yaml");
  expect_refused("map " + path.string(), {"rig"});
  expect_refused("map " + drive().string() + " --set cost.windw_m=1", {"cost.window_m"});
  ASSERT_TRUE(write_file(scratch / "o.yaml", "cost:\n  window_m: wide\n"));
  expect_refused("map " + drive().string() + " --config " + (scratch / "o.yaml").string(),
                 {"o.yaml:2", "cost.window_m", "wide"});
}

TEST(TreadInfo, KnowsEveryKind) {
  const ScratchFolder out;
  ASSERT_EQ(tread("map " + drive().string() + " -o " + (out / "m").string()).status, 0);
  ASSERT_EQ(tread("depth " + pair_arguments() + " --rig " + (drive() / "rig.yaml").string() +
                  " -o " + (out / "d").string())
                .status,
            0);
  const std::pair<std::string, std::string> cases[] = {
      {drive().string(), "left and right images"},
      {(out / "m").string(), "map"},
      {(out / "m/map.yaml").string(), "map"},
      {(out / "m/cost.tif").string(), "GeoTIFF grid"},
      {(out / "m/trajectory.tum").string(), "trajectory"},
      {(out / "d/disparity.pfm").string(), "float image (PFM)"},
      {(out / "d/depth.tif").string(), "float image (TIFF)"},
      {(out / "d/cloud.ply").string(), "point cloud"},
      {(out / "d/disparity.png").string(), "image"},
      {(drive() / "rig.yaml").string(), "stereo rig"},
      {"bumblebee2-1024", "stereo rig"}};
  for (const auto& [path, kind] : cases) {
    const Ran ran = tread("info --json " + path);
    ASSERT_EQ(ran.status, 0) << path << ran.err;
    EXPECT_NE(ran.json()["kind"].get<std::string>().find(kind), std::string::npos)
        << path << ran.out;
    EXPECT_EQ(tread("info " + path).status, 0);
  }
  expect_refused("info nowhere", {"nowhere"});
}

}  // namespace
}  // namespace tread
