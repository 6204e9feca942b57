// `tread map` and `tread plan` as a user runs them.
#include <fmt/format.h>

#include <set>

#include "command_test.hpp"
#include "file_mutations.hpp"
#include "tread/io/map_files.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;
using namespace testing;

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
  const std::string map_folder = (out / "m").string();
  expect_refused("plan " + map_folder + " --start nan 0 --goal 3 0", {"--start", "not finite"});
  expect_refused("plan " + map_folder + " --start 1 0 --goal 1e300 0", {"--goal", "1e+300"});
  expect_refused("plan " + map_folder + " --start 1 0 --goal 3 0 -o ''", {"--output", "empty"}, 2);
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

TEST(TreadMap, ADamagedTrajectoryLosesItsLinesAndNotTheDrive) {
  const ScratchFolder scratch;
  const fs::path path = copy_of_drive(scratch);
  const auto poses = read_tum_trajectory(path / "poses.txt").value();
  // Cut off within the last line: what is left of it is no pose.
  const std::string text = testing::get_file(path / "poses.txt");
  ASSERT_TRUE(write_file(path / "poses.txt", text.substr(0, text.rfind(' '))));
  const Ran ran = tread("map " + path.string() + " --json -o " + (scratch / "m").string());
  EXPECT_EQ(ran.status, 1);
  EXPECT_NE(ran.err.find("poses.txt:"), std::string::npos) << ran.err;
  EXPECT_NE(ran.err.find("7 fields instead of 8"), std::string::npos) << ran.err;
  EXPECT_EQ(ran.json()["frames"], poses.size() - 1);
  EXPECT_EQ(ran.json()["frames_failed"], 1);
  EXPECT_TRUE(load_map(scratch / "m"));
  EXPECT_NE(tread("info " + path.string()).out.find("7 fields"), std::string::npos);
}

TEST(TreadMap, AnInterruptKeepsWhatWasMapped) {
  const ScratchFolder scratch;
  const fs::path path = copy_of_drive(scratch);
  // So many frames that they take some ten seconds.
  Trajectory poses = read_tum_trajectory(path / "poses.txt").value();
  for (int i = 4; i < 1500; ++i) {
    const std::string name = fmt::format("{:06}.png", i);
    for (const char* side : {"left", "right"}) {
      fs::create_symlink(path / side / "000003.png", path / side / name);
    }
    poses.push_back(poses.back());
    poses.back().stamp_ns += 100'000'000;
  }
  ASSERT_TRUE(write_tum_trajectory(path / "poses.txt", poses));
  Ran ran;
  // Again if the machine was so slow that nothing was done yet.
  for (int seconds = 1; seconds <= 16 && ran.out.empty(); seconds *= 4) {
    ran =
        testing::run(fmt::format("timeout --preserve-status -s INT {} {} map {} --json -o {}",
                                 seconds, TREAD_PROGRAM, path.string(), (scratch / "m").string()));
  }
  EXPECT_EQ(ran.status, 1) << ran.err;
  EXPECT_NE(ran.err.find("interrupted after"), std::string::npos) << ran.err;
  EXPECT_LT(ran.json()["frames"], 1500);
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
  fs::remove(path / "rig.yaml");
  expect_refused("map " + path.string(), {"rig"});
  expect_refused("map " + drive().string() + " --set cost.windw_m=1", {"cost.window_m"});
  ASSERT_TRUE(write_file(scratch / "o.yaml", "cost:\n  window_m: wide\n"));
  expect_refused("map " + drive().string() + " --config " + (scratch / "o.yaml").string(),
                 {"o.yaml:2", "cost.window_m", "wide"});
}

TEST(TreadMap, WithoutPosesVisualOdometryPlacesTheFrames) {
  const ScratchFolder scratch;
  const fs::path path = copy_of_drive(scratch);
  const std::string with = (scratch / "with").string(), without = (scratch / "without").string();
  ASSERT_EQ(tread("map " + path.string() + " -o " + with).status, 0);
  fs::remove(path / "poses.txt");
  const Ran ran = tread("map " + path.string() + " -o " + without);
  ASSERT_EQ(ran.status, 0) << ran.err;
  EXPECT_NE(ran.out.find("placed by visual odometry"), std::string::npos) << ran.out;
  // Both begin at the same place, so the ends may be compared as they are.
  const auto truth = read_tum_trajectory(fs::path(with) / "trajectory.tum"),
             found = read_tum_trajectory(fs::path(without) / "trajectory.tum");
  ASSERT_TRUE(truth && found);
  ASSERT_EQ(found->size(), truth->size());
  const Isometry3d way = truth->front().pose.inverse() * truth->back().pose;
  const Isometry3d found_way = found->front().pose.inverse() * found->back().pose;
  EXPECT_GT(way.translation().norm(), 0.5);
  EXPECT_LT((way.inverse() * found_way).translation().norm(), 0.05 * way.translation().norm());
}

TEST(TreadMap, NothingMappedIsAFailureWithItsReport) {
  const ScratchFolder scratch;
  const fs::path path = copy_of_drive(scratch);
  const std::string out = (scratch / "m").string();
  ASSERT_EQ(tread("map " + path.string() + " --features -o " + out).status, 0);
  ASSERT_TRUE(fs::exists(scratch / "m/slope.tif"));
  ASSERT_TRUE(write_file(scratch / "m/notes.txt", "mine"));
  const Image<std::uint8_t> grey(320, 240, 100);
  for (const char* side : {"left", "right"}) {
    for (const auto& entry : fs::directory_iterator(path / side)) {
      ASSERT_TRUE(write_png(entry.path(), grey.view()));
    }
  }
  const Ran ran = tread("map " + path.string() + " --json -o " + out);
  EXPECT_EQ(ran.status, 1);
  EXPECT_NE(ran.err.find("no ground was mapped from 4 frames"), std::string::npos) << ran.err;
  EXPECT_EQ(ran.json()["explored_m2"], 0.0);
  EXPECT_EQ(ran.json()["plan"]["status"], "map empty");
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(scratch / "m")) {
    names.insert(entry.path().filename().string());
  }
  // The map of the earlier run is gone: it is not that of this run.
  EXPECT_EQ(names,
            (std::set<std::string>{"notes.txt", "path.csv", "report.html", "trajectory.tum"}));
}

TEST(TreadMap, ManyBadFramesAreCountedAndTheFirstNamed) {
  const ScratchFolder scratch;
  const fs::path path = copy_of_drive(scratch);
  for (int i = 4; i < 12; ++i) {
    const std::string name = fmt::format("{:06}.png", i);
    ASSERT_TRUE(write_file(path / "left" / name, "broken"));
    ASSERT_TRUE(write_file(path / "right" / name, "broken"));
  }
  Trajectory poses = read_tum_trajectory(path / "poses.txt").value();
  while (poses.size() < 12) {
    poses.push_back(poses.back());
    poses.back().stamp_ns += 100'000'000;
  }
  ASSERT_TRUE(write_tum_trajectory(path / "poses.txt", poses));
  const Ran some = tread("map " + path.string());
  EXPECT_EQ(some.status, 1);
  EXPECT_NE(some.err.find("8 of 12 frames could not be used"), std::string::npos) << some.err;
  EXPECT_NE(some.err.find("000004.png"), std::string::npos) << some.err;
  EXPECT_EQ(some.err.find("000011.png"), std::string::npos) << some.err;
  EXPECT_NE(some.err.find("and 3 more"), std::string::npos) << some.err;
  for (int i = 0; i < 4; ++i) {
    ASSERT_TRUE(write_file(path / "right" / fmt::format("{:06}.png", i), "broken"));
  }
  const Ran all = tread("map " + path.string() + " --rig " + (path / "rig.yaml").string());
  EXPECT_EQ(all.status, 1);
  EXPECT_NE(all.err.find("none of 12 frames"), std::string::npos) << all.err;
}

TEST(TreadMap, NamesAllFilesItWrote) {
  const ScratchFolder out;
  const Ran ran = tread("map " + drive().string() + " --features -o " + out.path().string());
  ASSERT_EQ(ran.status, 0) << ran.err;
  for (const auto& entry : fs::directory_iterator(out.path())) {
    EXPECT_NE(ran.out.find(entry.path().filename().string()), std::string::npos)
        << entry.path() << ran.out;
  }
  EXPECT_NE(ran.out.find("traversability.tif"), std::string::npos);
}

}  // namespace
}  // namespace tread
