// `tread info` as a user runs it.
#include <cmath>

#include "command_test.hpp"
#include "tread/io/data_set_writer.hpp"
#include "tread/io/map_files.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;
using namespace testing;

TEST(TreadInfo, KnowsEveryKind) {
  const ScratchFolder out;
  ASSERT_EQ(tread("map " + drive().string() + " -o " + (out / "m").string()).status, 0);
  ASSERT_EQ(tread("depth " + pair_arguments() + " --rig " + (drive() / "rig.yaml").string() +
                  " -o " + (out / "d").string())
                .status,
            0);
  ASSERT_TRUE(write_file(out / "kitti.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 1 0 1 0 0 0 0 1 0\n"));
  ASSERT_TRUE(write_file(out / "times.txt", "0\n0.1\n0.2\n"));
  ASSERT_TRUE(write_file(out / "i.PPM", "P6 1 1 255\nabc"));
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
      {(out / "m/path.csv").string(), "path"},
      {(out / "m/nav2_map.yaml").string(), "Nav2"},
      {(out / "m/nav2_cost.yaml").string(), "Nav2"},
      {(out / "m/report.html").string(), "web page"},
      {(drive() / "poses.txt").string(), "trajectory (TUM)"},
      {(out / "kitti.txt").string(), "trajectory (KITTI"},
      {(out / "times.txt").string(), "times"},
      {(out / "i.PPM").string(), "image"},
      {(out / "d").string(), "results of 'tread depth'"},
      {TREAD_SOURCE_DIR "/examples/demo.yaml", "options"},
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
  ASSERT_TRUE(write_file(out / "what.txt", "some words\n"));
  expect_refused("info " + (out / "what.txt").string(), {"what.txt", "no file that tread knows"});
  ASSERT_TRUE(write_file(out / "p.csv", "x_m,y_m\n1,2\n3;4\n"));
  expect_refused("info " + (out / "p.csv").string(), {"p.csv:3", "3;4"});
}

TEST(TreadInfo, TellsOfTheImuOfADrive) {
  const ScratchFolder scratch;
  const fs::path folder = copy_of_drive(scratch);
  EXPECT_EQ(tread("info --json " + folder.string()).json()["imu"], false);
  EXPECT_EQ(tread("info " + folder.string()).out.find("IMU"), std::string::npos);
  StereoRig rig = small_rig();
  rig.imu.emplace().rate_hz = 250.0;
  rig.imu->gyro_noise = 1.7e-4;
  ASSERT_TRUE(write_rig(folder / "rig.yaml", rig));
  const Ran calibrated = tread("info " + folder.string());
  EXPECT_NE(calibrated.out.find("IMU: 250 Hz, noise 0.00017 rad/s"), std::string::npos)
      << calibrated.out;
  EXPECT_EQ(calibrated.out.find("with samples of an IMU"), std::string::npos) << calibrated.out;
  fs::create_directory(folder / "imu0");
  ASSERT_TRUE(write_file(folder / "imu0/data.csv", "#\n0,0,0,0,0,0,9.8\n4000000,0,0,0,0,0,9.8\n"));
  const Ran ran = tread("info " + folder.string());
  EXPECT_NE(ran.out.find("with poses, with samples of an IMU"), std::string::npos) << ran.out;
  const auto json = tread("info --json " + folder.string()).json();
  EXPECT_EQ(json["imu"], true);
  EXPECT_EQ(json["rig"]["imu"]["rate_hz"], 250.0);
  EXPECT_EQ(json["rig"]["imu"]["gyro_noise"], 1.7e-4);
  EXPECT_EQ(tread("info --json " + (folder / "rig.yaml").string()).json()["rig"]["imu"]["rate_hz"],
            250.0);
}

TEST(TreadInfo, TellsOfAllSensorsOfARecording) {
  const ScratchFolder scratch;
  RecordingSetup setup;
  setup.description = "a kerb, seed 4";
  setup.heads = {small_rig()};
  const StereoRig& rig = setup.heads.front();
  auto writer = DataSetWriter::create(scratch / "run", setup);
  ASSERT_TRUE(writer) << writer.error().message();
  for (int i = 0; i < 2; ++i) {
    StereoFrame frame = render_frame(rig, rig.mount->T_body_left, block_and_kerb, 8.0);
    frame.stamp_ns = 100'000'000LL * i;
    ASSERT_TRUE(writer->add(0, frame));
    ASSERT_TRUE(writer->add(WheelSample{frame.stamp_ns, 0.5, 0.5, 1.0, 1.0}));
  }
  ASSERT_TRUE(writer->add(BumpEvent{7, true}));
  ASSERT_TRUE(writer->finish());
  const Ran ran = tread("info " + (scratch / "run").string());
  EXPECT_EQ(ran.status, 0) << ran.err;
  EXPECT_NE(
      ran.out.find("recording: a kerb, seed 4\n  samples: bump0 1, cam0 2, cam1 2, wheels0 2"),
      std::string::npos)
      << ran.out;
  EXPECT_NE(ran.out.find("mounted"), std::string::npos) << ran.out;
  const auto json = tread("info --json " + (scratch / "run").string()).json();
  EXPECT_EQ(json["frames"], 2);
  EXPECT_EQ(json["recording"]["samples"]["wheels0"], 2);
  ASSERT_TRUE(write_file(scratch / "run/recording.yaml", "tread_recording: 9\n"));
  expect_refused("info " + (scratch / "run").string(), {"recording.yaml:1", "version 9"});
}

TEST(TreadInfo, TellsUnitsWhereThereAreAnyAndNoRangeWhereNothingIsKnown) {
  const ScratchFolder out;
  MapLayers map;
  const GridGeometry geometry{0.5, {0.0, 0.0}, 2, 2};
  map.layers.push_back({"height", "m", "", Grid<float>(geometry, 1.5F)});
  map.layers.push_back({"slope", "1", "", Grid<float>(geometry, 0.25F)});
  map.layers.push_back({"step", "1", "", Grid<float>(geometry, std::nanf(""))});
  ASSERT_TRUE(save_map(map, out / "m"));
  const Ran ran = tread("info " + (out / "m").string());
  EXPECT_NE(ran.out.find("1.5 to 1.5 m\n"), std::string::npos) << ran.out;
  EXPECT_NE(ran.out.find("0.25 to 0.25\n"), std::string::npos) << ran.out;
  EXPECT_NE(ran.out.find("nothing known\n"), std::string::npos) << ran.out;
}

}  // namespace
}  // namespace tread
