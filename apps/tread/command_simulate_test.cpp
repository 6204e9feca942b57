#include <fmt/format.h>
#include <gtest/gtest.h>

#include "command_test.hpp"
#include "file_mutations.hpp"
#include "rgbd_images.hpp"
#include "tread/io/raster_file.hpp"
#include "tread/io/recording_files.hpp"

namespace tread::testing {
namespace {

// A pallet on gravel, and what makes a run small.
constexpr const char* kCourse =
    "tread_course: 1\n"
    "size_m: [8, 6]\n"
    "origin_m: [-3, -3]\n"
    "ground: {surface: gravel}\n"
    "route_m: [[1, 0], [2, 0]]\n"
    "objects:\n"
    "  - pallet: {at_m: [3, 2]}\n";
constexpr const char* kSmall =
    " --set robot.head.width_px=320 --set robot.head.height_px=240 --set robot.head.focal_px=250"
    " --set robot.heads=1 --set drive.rest_s=0.3";

std::string out(const ScratchFolder& scratch) {
  return (scratch / "out").string();
}
std::string course(const ScratchFolder& scratch) {
  put(scratch / "made.yaml", kCourse);
  return (scratch / "made.yaml").string();
}

TEST(TreadSimulate, WritesADataSetThatTheOtherCommandsRead) {
  const ScratchFolder scratch;
  const Ran ran = tread("simulate " + course(scratch) + kSmall + " --json -o " + out(scratch));
  ASSERT_EQ(ran.status, 0) << ran.err;
  EXPECT_EQ(ran.json().at("end"), "Arrived.");
  EXPECT_NEAR(ran.json().at("way_m").get<double>(), 1.8, 0.2);
  for (const char* name : {"report.html", "picture_above.png", "picture_eye.png", "recording.yaml",
                           "truth/body.tum", "truth/left.tum", "truth/height.tif"}) {
    EXPECT_TRUE(fs::exists(scratch.path() / "out" / name)) << name;
  }
  const auto height = read_geotiff(scratch.path() / "out/truth/height.tif");
  ASSERT_TRUE(height);
  EXPECT_NEAR(((*height)[height->geometry.cell_at({3.0, 2.0})]), 0.15, 1e-5);
  const auto wheels = read_wheels(scratch.path() / "out/mav0/wheels0/data.csv");
  ASSERT_TRUE(wheels) << wheels.error().message();
  EXPECT_GT(wheels->size(), 100U);
  const Ran info = tread("info " + out(scratch));
  EXPECT_EQ(info.status, 0) << info.err;
  EXPECT_NE(info.out.find("with poses, with samples of an IMU"), std::string::npos) << info.out;
  // Along gravel the way that the cameras see is the true one.
  const Ran slam = tread("slam " + out(scratch) + " --json");
  ASSERT_EQ(slam.status, 0) << slam.err << slam.out;
  EXPECT_LT(slam.json().at("absolute_error_m").get<double>(), 0.01) << slam.out;
  const Ran map = tread("map " + out(scratch) + " --json");
  EXPECT_EQ(map.status, 0) << map.err;
}

TEST(TreadSimulate, OneSeedIsOneRecordingForAnyThreads) {
  const ScratchFolder scratch;
  const std::string file = course(scratch);
  const auto imu_of = [&](const std::string& more, const char* name) {
    const std::string folder = (scratch / name).string();
    const Ran ran =
        tread("simulate " + file + kSmall + " --duration 0.5 " + more + " -o " + folder);
    EXPECT_EQ(ran.status, 0) << ran.err;
    return get_file(fs::path(folder) / "mav0/imu0/data.csv") +
           get_file(fs::path(folder) / "mav0/cam0/data/1600000000300000000.png");
  };
  const std::string once = imu_of("--threads 1", "a");
  EXPECT_GT(once.size(), 10000U);
  EXPECT_TRUE(once == imu_of("--threads 2", "b"));
  EXPECT_FALSE(once == imu_of("--seed 2", "c"));
}

TEST(TreadSimulate, TheRobotsThatComeAlongAreSound) {
  const ScratchFolder scratch;
  const std::string file = course(scratch);
  for (const char* robot : {"skid_rover", "fisheye_walker"}) {
    const std::string settings = fmt::format("{}/robots/{}.yaml", TREAD_SOURCE_DIR, robot);
    const Ran ran = tread(fmt::format(
        "simulate {} --config {} --set robot.head.width_px=160 --set robot.head.height_px=120 "
        "--duration 0.4 -o {}",
        file, settings, (scratch / robot).string()));
    EXPECT_EQ(ran.status, 0) << ran.err;
    const auto rig = read_rig((scratch / robot).string());
    ASSERT_TRUE(rig) << rig.error().message();
    EXPECT_FALSE(rig->rectified);
  }
}

TEST(TreadSimulate, TheWalkerIsCarriedWithItsGait) {
  const ScratchFolder scratch;
  const Ran ran = tread("simulate " + course(scratch) + kSmall +
                        " --robot walker --duration 2 --json -o " + out(scratch));
  ASSERT_EQ(ran.status, 0) << ran.err;
  EXPECT_NE(ran.json().at("end").get<std::string>().find("Carried"), std::string::npos);
  EXPECT_GT(ran.json().at("samples").at("head").get<int>(), 100);
}

// The rover drives off the edge of the world: what it saw until then is a recording.
TEST(TreadSimulate, WhatWasSimulatedBeforeAnErrorIsKept) {
  const ScratchFolder scratch;
  put(scratch / "edge.yaml",
      "tread_course: 1\nsize_m: [4, 4]\nroute_m: [[1.9, 0]]\n"
      "start: {at_m: [0.5, 0]}\nground: {relief: [{ramp: {from_m: [1, 0], to_m: [2, 0], width_m: "
      "9, "
      "rise_m: -2}}]}\n");
  const Ran ran = tread("simulate " + (scratch / "edge.yaml").string() + kSmall +
                        " --duration 12 -o " + out(scratch));
  EXPECT_EQ(ran.status, 1) << ran.out;
  EXPECT_NE(ran.err.find("edge"), std::string::npos) << ran.err;
  EXPECT_TRUE(fs::exists(scratch.path() / "out" / "recording.yaml"));
  EXPECT_TRUE(fs::exists(scratch.path() / "out" / "report.html"));
}

TEST(TreadSimulate, PreviewDrawsACourseOfTheProgram) {
  const ScratchFolder scratch;
  const Ran ran = tread("simulate stairs --preview -o " + out(scratch));
  ASSERT_EQ(ran.status, 0) << ran.err;
  const auto above = read_colour(scratch.path() / "out/picture_above.png");
  ASSERT_TRUE(above);
  EXPECT_EQ(above->width, 1100);
}

TEST(TreadSimulate, RefusesWhatCannotBe) {
  const ScratchFolder scratch;
  expect_refused("simulate meadw", {"meadw", "'meadow'"});
  put(scratch / "bad.yaml",
      "tread_course: 1\nsize_m: [5, 5]\nobjects:\n  - palet: {at_m: [1, 1]}\n");
  expect_refused("simulate " + (scratch / "bad.yaml").string(), {"bad.yaml:4", "'pallet'"});
  expect_refused("simulate flat --duration -1", {"--duration"});
  expect_refused("simulate flat --set robot.head.focal_px=0", {"robot.head.focal_px"});
  put(scratch / "settings.yaml", "robot:\n  head: {focal_px: 0}\n");
  expect_refused("simulate flat --config " + (scratch / "settings.yaml").string(),
                 {"settings.yaml:2", "focal_px"});
  put(scratch / "rock.yaml",
      "tread_course: 1\nsize_m: [8, 8]\nobjects:\n  - rock: {at_m: [-0.3, 0], size_m: 0.8}\n");
  expect_refused("simulate " + (scratch / "rock.yaml").string(), {"objects[0].rock (line 4)"});
  put(scratch / "full" / "mine.txt", "not a recording");
  expect_refused("simulate flat --duration 0.1 -o " + (scratch / "full").string(), {"full"});
  expect_refused("slam sim:nowhere", {"nowhere"});
  expect_refused("simulate flat --seed -1", {"--seed"});
  expect_refused("simulate flat --preview", {"--preview"});
  expect_refused("simulate flat --robot walker --set robot.head_tilt_rad=1.4", {"head_tilt_rad"});
  expect_refused("simulate flat --robot tank", {"rover"}, 2);
}

}  // namespace
}  // namespace tread::testing
