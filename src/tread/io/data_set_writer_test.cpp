// What is written is read back by this project's own readers.
#include "tread/io/data_set_writer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "file_mutations.hpp"
#include "recording_samples.hpp"
#include "test_data.hpp"
#include "tread/io/imu_file.hpp"
#include "tread/io/raster_file.hpp"
#include "tread/io/recording_files.hpp"
#include "tread/io/trajectory_file.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;
using namespace testing::recording;
using Eigen::Vector3d;
using testing::get_file;
using testing::ScratchFolder;

TEST(DataSetWriter, ImagesRigAndImuComeBackBitByBit) {
  const ScratchFolder scratch;
  const RecordingSetup recording = setup();
  DataSetWriter writer = open(scratch / "new" / "run", recording);
  for (int i = 0; i < 3; ++i) {
    EXPECT_DONE(writer.add(0, frame(i)));
    EXPECT_DONE(writer.add(1, frame(10 * i)));
  }
  for (int i = 0; i < 41; ++i) EXPECT_DONE(writer.add(imu(i)));
  const fs::path folder = scratch / "new" / "run";
  EXPECT_FALSE(fs::exists(folder / "mav0")) << "nothing is there before the end";
  EXPECT_DONE(writer.finish());
  EXPECT_FALSE(fs::exists(folder / ".tread-recording"));

  const auto source = open_stereo_source(folder);
  ASSERT_TRUE(source) << source.error().message();
  EXPECT_TRUE((*source)->problems().empty());
  const StereoRig& back = (*source)->rig();
  const StereoRig& front = recording.heads[0];
  EXPECT_EQ(back.name, "front");
  EXPECT_EQ(back.T_left_right.matrix(), front.T_left_right.matrix());
  ASSERT_TRUE(back.mount);
  EXPECT_EQ(back.mount->T_body_left.matrix(), front.mount->T_body_left.matrix());
  ASSERT_TRUE(back.imu);
  EXPECT_EQ(back.imu->T_imu_left.matrix(), front.imu->T_imu_left.matrix());
  EXPECT_EQ(back.imu->gyro_walk, front.imu->gyro_walk);
  const auto frames = frames_of(folder);
  ASSERT_EQ(frames.size(), 3U);
  for (int i = 0; i < 3; ++i) {
    const StereoFrame expected = frame(i);
    EXPECT_EQ(frames[static_cast<std::size_t>(i)].stamp_ns, expected.stamp_ns);
    EXPECT_EQ(frames[static_cast<std::size_t>(i)].left, expected.left);
    EXPECT_EQ(frames[static_cast<std::size_t>(i)].right, expected.right);
  }
  ASSERT_EQ(frames[1].imu.size(), 20U);
  EXPECT_EQ(frames[1].imu[0].stamp_ns, imu(1).stamp_ns);
  EXPECT_EQ(frames[1].imu[0].gyro_rad_per_s, imu(1).gyro_rad_per_s);
  EXPECT_EQ(frames[1].imu[0].accel_m_per_s2, imu(1).accel_m_per_s2);
  EXPECT_TRUE(fs::exists(folder / "mav0/cam3/data" / "1700000002123456789.png"));
  EXPECT_EQ(get_file(folder / "mav0/cam2/data.csv"),
            "#timestamp [ns],filename\n1700000000123456789,1700000000123456789.png\n"
            "1700000001123456789,1700000001123456789.png\n"
            "1700000002123456789,1700000002123456789.png\n");
}

// As a program sees it that knows only EuRoC.
TEST(DataSetWriter, TheFolderMav0IsEurocAlone) {
  const ScratchFolder scratch;
  const RecordingSetup recording = setup();
  DataSetWriter writer = open(scratch.path(), recording);
  for (int i = 0; i < 3; ++i) EXPECT_DONE(writer.add(0, frame(i)));
  for (int i = -4; i < 10; ++i) EXPECT_DONE(writer.add(truth(i)));
  EXPECT_DONE(writer.add(imu(0)));
  EXPECT_DONE(writer.finish());
  for (const fs::path& folder : {scratch.path(), scratch / "mav0"}) {
    const auto source = open_stereo_source(folder);
    ASSERT_TRUE(source) << source.error().message();
    const StereoRig& back = (*source)->rig();
    EXPECT_EQ(back.mount.has_value(), folder == scratch.path());
    const StereoRig& front = recording.heads[0];
    const auto& left = std::get<BrownCamera>(back.left);
    EXPECT_EQ(left.parameters(), brown().parameters());
    EXPECT_EQ(std::get<KannalaBrandtCamera>(back.right).parameters(),
              std::get<KannalaBrandtCamera>(front.right).parameters());
    EXPECT_EQ(back.size, kSize);
    expect_equal(back.T_left_right, front.T_left_right, 1e-14);
    expect_equal(back.imu->T_imu_left, front.imu->T_imu_left, 1e-14);
    EXPECT_EQ(back.imu->accel_noise, front.imu->accel_noise);
    const auto frames = frames_of(folder);
    ASSERT_EQ(frames.size(), 3U);
    for (int i = 0; i < 3; ++i) {
      const auto& T = frames[static_cast<std::size_t>(i)].T_world_left;
      ASSERT_TRUE(T);
      expect_equal(*T, truth(2 * i).T_world_body * front.mount->T_body_left, 1e-12);
    }
  }
  const auto body = read_tum_trajectory(scratch / "truth/body.tum");
  ASSERT_TRUE(body);
  ASSERT_EQ(body->size(), 14U);
  EXPECT_EQ((*body)[3].stamp_ns, truth(-1).stamp_ns);
  expect_equal((*body)[3].pose, truth(-1).T_world_body, 1e-14);
  const std::string text = get_file(scratch / "mav0/state_groundtruth_estimate0/data.csv");
  const std::string line = text.substr(text.find('\n') + 1, text.find('\n', 800) - text.find('\n'));
  EXPECT_EQ(
      std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(text.find('\n')), ','),
      16);
  EXPECT_NE(line.find(",0.001,0.002,0.003,0.1,0.2,0.3"), std::string::npos) << line;
}

TEST(DataSetWriter, ColourStampsNearZeroAndFramesOutOfOrder) {
  const ScratchFolder scratch;
  DataSetWriter writer = open(scratch.path());
  std::vector<StereoFrame> sent;
  for (const int i : {2, 0, 1, 0}) {
    StereoFrame colour = frame(i, true);
    colour.stamp_ns = i * kFrame_ns;
    colour.T_world_left = pose(i, 0.0);
    EXPECT_DONE(writer.add(0, colour));
    sent.push_back(std::move(colour));
  }
  EXPECT_DONE(writer.finish());
  const auto frames = frames_of(scratch.path());
  ASSERT_EQ(frames.size(), 3U) << "the second of a stamp is left out";
  EXPECT_EQ(frames[0].stamp_ns, 0);
  EXPECT_EQ(frames[2].stamp_ns, 2 * kFrame_ns);
  EXPECT_EQ(frames[2].left_colour, sent[0].left_colour);
  EXPECT_EQ(frames[2].right, sent[0].right);
  const auto left = read_tum_trajectory(scratch / "truth/left.tum");
  ASSERT_TRUE(left) << left.error().message();
  ASSERT_EQ(left->size(), 3U);
  expect_equal((*left)[1].pose, pose(1, 0.0), 1e-14);
  EXPECT_EQ(read_recording_info(scratch.path())->samples,
            (std::vector<std::pair<std::string, std::int64_t>>{
                {"cam0", 3}, {"cam1", 3}, {"cam2", 0}, {"cam3", 0}, {"imu0", 0}}));
}

TEST(DataSetWriter, OfAHeadThatTurnsThePosesComeFromTheFrames) {
  const ScratchFolder scratch;
  RecordingSetup recording = setup();
  recording.head_turns = true;
  DataSetWriter writer = open(scratch.path(), recording);
  for (int i = 0; i < 3; ++i) {
    StereoFrame turned = frame(i);
    turned.T_world_left = pose(i, 0.5 * i);
    EXPECT_DONE(writer.add(0, turned));
    EXPECT_DONE(writer.add(truth(2 * i)));
    EXPECT_DONE(writer.add(imu(20 * i)));
    EXPECT_DONE(writer.add(HeadState{turned.stamp_ns, 0.5 * i, 0.2}));
  }
  EXPECT_DONE(writer.finish());
  const auto source = open_stereo_source(scratch.path());
  ASSERT_TRUE(source) << source.error().message();
  EXPECT_FALSE((*source)->has_imu()) << "it does not move with the cameras";
  const auto frames = frames_of(scratch.path());
  ASSERT_EQ(frames.size(), 3U);
  expect_equal(*frames[2].T_world_left, pose(2, 1.0), 1e-14);
  EXPECT_EQ(read_imu(scratch / "mav0/imu0/data.csv")->size(), 3U);
  EXPECT_EQ(read_head(scratch / "mav0/head0/data.csv")->at(2).pan_rad, 1.0);
}

TEST(DataSetWriter, TheOtherSensorsComeBack) {
  const ScratchFolder scratch;
  DataSetWriter writer = open(scratch.path());
  LegSample legs;
  legs.stamp_ns = kFirst_ns + 3;
  for (std::size_t i = 0; i < kLegJoints; ++i) {
    const double v = static_cast<double>(i) + 1.0;
    legs.position_rad[i] = 1.0 / v;
    legs.velocity_rad_per_s[i] = -2.0 / v;
    legs.torque_nm[i] = 100.0 / v;
  }
  for (std::size_t i = 0; i < kLegs; ++i) {
    legs.foot_force_n[i] = Vector3d(1.0 / 3.0, -7.0, 100.0 + static_cast<double>(i));
  }
  EXPECT_DONE(writer.add(GnssFix{kFirst_ns, {1e3 / 3.0, -2.0, 0.1}, 3.0, 4.5}));
  EXPECT_DONE(writer.add(GnssFix{kFirst_ns + 1, {0, 0, 0}, 0, 0}));
  EXPECT_DONE(writer.add(WheelSample{kFirst_ns, 1.0 / 7.0, -2.0, 3.5, -4.25}));
  EXPECT_DONE(writer.add(legs));
  EXPECT_DONE(writer.add(BumpEvent{kFirst_ns, true}));
  EXPECT_DONE(writer.add(BumpEvent{kFirst_ns + 5, false}));
  Image<float> depth(kSize.width, kSize.height, 1.5F);
  depth(2, 1) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_DONE(writer.add_depth(0, kFirst_ns, depth));
  EXPECT_DONE(writer.add_depth(1, 7, depth));
  Grid<float> height;
  height.geometry.resolution_m = 0.1;
  height.geometry.origin = {-3.0, 2.0};
  height.geometry.columns = 3;
  height.geometry.rows = 2;
  height.values = {0.0F, 1.0F, 2.0F, 3.0F, 4.0F, 5.0F};
  EXPECT_DONE(writer.add_raster("height", height));
  EXPECT_DONE(writer.finish());

  const fs::path mav = scratch / "mav0";
  const auto gnss = read_gnss(mav / "gnss0/data.csv");
  ASSERT_TRUE(gnss) << gnss.error().message();
  ASSERT_EQ(gnss->size(), 2U);
  EXPECT_EQ((*gnss)[0].stamp_ns, kFirst_ns);
  EXPECT_EQ((*gnss)[0].position_m, Vector3d(1e3 / 3.0, -2.0, 0.1));
  EXPECT_EQ((*gnss)[0].sigma_up_m, 4.5);
  EXPECT_NE(get_file(mav / "gnss0/sensor.yaml").find("[1, 0, 0, 0.1, 0, 1, 0, 0, 0, 0, 1, 1.1"),
            std::string::npos);
  const auto wheels = read_wheels(mav / "wheels0/data.csv");
  ASSERT_TRUE(wheels) << wheels.error().message();
  EXPECT_EQ((*wheels)[0].left_rad, 1.0 / 7.0);
  EXPECT_EQ((*wheels)[0].right_current_a, -4.25);
  const auto back = read_legs(mav / "legs0/data.csv");
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_EQ((*back)[0].stamp_ns, legs.stamp_ns);
  EXPECT_EQ((*back)[0].position_rad, legs.position_rad);
  EXPECT_EQ((*back)[0].velocity_rad_per_s, legs.velocity_rad_per_s);
  EXPECT_EQ((*back)[0].torque_nm, legs.torque_nm);
  EXPECT_EQ((*back)[0].foot_force_n, legs.foot_force_n);
  const auto bumps = read_bumps(mav / "bump0/data.csv");
  ASSERT_TRUE(bumps) << bumps.error().message();
  ASSERT_EQ(bumps->size(), 2U);
  EXPECT_TRUE((*bumps)[0].pressed);
  EXPECT_FALSE((*bumps)[1].pressed);
  const auto tiff = read_tiff(scratch / "truth/depth/1700000000123456789.tif");
  ASSERT_TRUE(tiff) << tiff.error().message();
  EXPECT_EQ((*tiff)(0, 0), 1.5F);
  EXPECT_TRUE(std::isnan((*tiff)(2, 1)));
  EXPECT_TRUE(fs::exists(scratch / "truth/depth1/0000000000000000007.tif"));
  const auto grid = read_geotiff(scratch / "truth/height.tif");
  ASSERT_TRUE(grid) << grid.error().message();
  EXPECT_EQ(grid->values, height.values);
  const auto info = read_recording_info(scratch.path());
  ASSERT_TRUE(info) << info.error().message();
  EXPECT_EQ(info->description, setup().description);
  EXPECT_EQ(info->heads, 2);
}

}  // namespace
}  // namespace tread
