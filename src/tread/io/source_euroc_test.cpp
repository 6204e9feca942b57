// EuRoC/ASL folders as a source: samples of the IMU and the truth of the body.
#include <gtest/gtest.h>

#include <array>
#include <memory>

#include "file_mutations.hpp"
#include "rig_samples.hpp"
#include "sample_images.hpp"
#include "test_data.hpp"
#include "tread/io/image_file.hpp"
#include "tread/io/rig_file.hpp"
#include "tread/io/source.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using testing::kEurocImu;
using testing::put_file;
using testing::ScratchFolder;

constexpr std::int64_t kFirst_ns = 1'400'000'000'000'000'000;
constexpr std::int64_t kFrame_ns = 50'000'000;  // 20 Hz
constexpr std::int64_t kSample_ns = 5'000'000;  // 200 Hz
constexpr const char* kTruth = "state_groundtruth_estimate0/data.csv";

// Four frames; the left camera 0.2 m ahead (x) of the body, looking along its x.
class EurocFolder : public ::testing::Test {
 protected:
  EurocFolder() {
    for (int i = 0; i < 4; ++i) {
      const std::string image = testing::make_png(4, 3, 8, 0, std::string(12, 'x'));
      put("cam0/data/" + frame_name(i), image);
      put("cam1/data/" + frame_name(i), image);
    }
    // Columns of R: x of the camera is right (-y), y down (-z), z forward (x).
    put("cam0/sensor.yaml", camera_at("0, 0, 1, 0.2, -1, 0, 0, 0, 0, -1, 0, 0"));
    put("cam1/sensor.yaml", camera_at("0, 0, 1, 0.2, -1, 0, 0, -0.1, 0, -1, 0, 0"));
    put("imu0/sensor.yaml", kEurocImu);
    put("imu0/data.csv", imu_data(-400, 40));
  }
  static std::string frame_name(int i) {
    return std::to_string(kFirst_ns + i * kFrame_ns) + ".png";
  }
  static std::string camera_at(const std::string& place) {
    return "sensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n  data: [" + place +
           ", 0, 0, 0, 1]\nrate_hz: 20\nresolution: [4, 3]\ncamera_model: pinhole\n"
           "intrinsics: [10, 10, 2, 1]\ndistortion_model: radial-tangential\n"
           "distortion_coefficients: [-0.1, 0, 0, 0]\n";
  }
  // Samples number first to last around the first frame's time; x of the gyroscope is 1e-3 times
  // the number.
  static std::string imu_data(int first, int last) {
    std::string text = "#timestamp [ns],w_x,w_y,w_z,a_x,a_y,a_z\n";
    for (int i = first; i <= last; ++i) {
      text += std::to_string(kFirst_ns + i * kSample_ns) + "," + std::to_string(1e-3 * i) +
              ",0,0,0,0,9.81\n";
    }
    return text;
  }
  // Along x at 2 m/s from (1, 2, 3), and turned to the left by a quarter.
  static std::string truth(int first, int last) {
    std::string text = "#timestamp, p_x, p_y, p_z, q_w, q_x, q_y, q_z, v_x\n";
    for (int i = first; i <= last; ++i) {
      text += std::to_string(kFirst_ns + i * kSample_ns) + "," + std::to_string(1.0 + 0.01 * i) +
              ",2,3,0.7071067811865476,0,0,0.7071067811865476,2\n";
    }
    return text;
  }
  void put(const std::string& name, const std::string& bytes) const {
    const fs::path path = place() / name;
    fs::create_directories(path.parent_path());
    put_file(path, bytes);
  }
  [[nodiscard]] fs::path place() const { return folder_ / "mav0"; }
  std::unique_ptr<StereoSource> open(const SourceOptions& options = {}) const {
    auto source = open_stereo_source(folder_.path(), options);
    EXPECT_TRUE(source) << source.error().message();
    return source ? std::move(*source) : nullptr;
  }
  ScratchFolder folder_;
};

std::vector<StereoFrame> frames_of(StereoSource& source, int* failed = nullptr) {
  std::vector<StereoFrame> frames;
  for (;;) {
    auto next = source.next();
    if (!next && failed != nullptr) ++*failed;
    if (!next) continue;
    if (!*next) return frames;
    frames.push_back(std::move(**next));
  }
}

// The numbers of the first and last sample of a frame, and how many.
std::array<int, 3> samples_of(const StereoFrame& frame) {
  if (frame.imu.empty()) return {0, 0, 0};
  const auto number = [](const ImuSample& sample) {
    return static_cast<int>((sample.stamp_ns - kFirst_ns) / kSample_ns);
  };
  return {number(frame.imu.front()), number(frame.imu.back()), static_cast<int>(frame.imu.size())};
}

TEST_F(EurocFolder, EachFrameComesWithTheSamplesSinceTheOneBefore) {
  const auto source = open();
  EXPECT_TRUE(source->has_imu());
  EXPECT_FALSE(source->has_poses());
  EXPECT_TRUE(source->problems().empty());
  EXPECT_LT((source->rig().imu->T_imu_left.translation() - Vector3d(0.2, 0, 0)).norm(), 1e-15);
  const auto frames = frames_of(*source);
  ASSERT_EQ(frames.size(), 4U);
  EXPECT_EQ(samples_of(frames[0]), (std::array{-199, 0, 200})) << "one second";
  EXPECT_EQ(samples_of(frames[1]), (std::array{1, 10, 10}));
  EXPECT_EQ(samples_of(frames[2]), (std::array{11, 20, 10}));
  EXPECT_EQ(samples_of(frames[3]), (std::array{21, 30, 10}));
  EXPECT_NEAR(frames[2].imu[0].gyro_rad_per_s.x(), 0.011, 1e-12);
  EXPECT_EQ(frames[2].imu[0].accel_m_per_s2, Vector3d(0, 0, 9.81));
  const auto inner = open_stereo_source(place());
  ASSERT_TRUE(inner) << inner.error().message();
  EXPECT_TRUE((*inner)->has_imu());
}

TEST_F(EurocFolder, AFrameThatCannotBeReadLeavesNoGapInTheSamples) {
  put("cam1/data/" + frame_name(1), "no image");
  fs::remove(place() / "cam0/data" / frame_name(2));
  int failed = 0;
  const auto frames = frames_of(*open(), &failed);
  EXPECT_EQ(failed, 2);
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_EQ(samples_of(frames[0]), (std::array{-199, 0, 200}));
  EXPECT_EQ(samples_of(frames[1]), (std::array{1, 30, 30}));
  put("cam0/data/" + frame_name(0), "no image");
  const auto last = frames_of(*open());
  ASSERT_EQ(last.size(), 1U);
  EXPECT_EQ(samples_of(last[0]), (std::array{-169, 30, 200})) << "now the first that can be read";
}

TEST_F(EurocFolder, SamplesMayBeginLateAndEndEarly) {
  put("imu0/data.csv", imu_data(5, 12));
  const auto frames = frames_of(*open());
  EXPECT_EQ(samples_of(frames[0])[2], 0);
  EXPECT_EQ(samples_of(frames[1]), (std::array{5, 10, 6}));
  EXPECT_EQ(samples_of(frames[2]), (std::array{11, 12, 2}));
  EXPECT_EQ(samples_of(frames[3])[2], 0);
}

TEST_F(EurocFolder, WhatIsWrongWithTheSamplesIsAmongTheProblems) {
  put("imu0/data.csv", imu_data(-10, 40) + "x,y\n");
  const auto one_line = open();
  EXPECT_TRUE(one_line->has_imu());
  ASSERT_EQ(one_line->problems().size(), 1U);
  EXPECT_EQ(one_line->problems()[0].where, (place() / "imu0/data.csv").string() + ":53");
  for (const std::string& text :
       {std::string("x,y\n"), std::string(), imu_data(31, 60), imu_data(-300, -200)}) {
    put("imu0/data.csv", text);
    const auto none = open();
    EXPECT_FALSE(none->has_imu());
    ASSERT_EQ(none->problems().size(), 1U) << text.substr(0, 100);
    EXPECT_TRUE(none->problems()[0].where.starts_with((place() / "imu0/data.csv").string()));
    const auto frames = frames_of(*none);
    EXPECT_EQ(frames.size(), 4U) << "the images are of use without";
    EXPECT_TRUE(frames[0].imu.empty());
  }
  fs::remove(place() / "imu0/data.csv");
  EXPECT_FALSE(open()->has_imu());
  EXPECT_TRUE(open()->problems().empty());
}

TEST_F(EurocFolder, WithoutItsPlaceTheImuIsNotUsed) {
  fs::remove(place() / "imu0/sensor.yaml");
  const auto source = open();
  EXPECT_FALSE(source->rig().imu);
  EXPECT_FALSE(source->has_imu());
  EXPECT_TRUE(frames_of(*source)[1].imu.empty());
}

// The body is turned to the left by a quarter: the camera, 0.2 m ahead of it, looks along y.
void expect_on_path(const StereoFrame& frame, double x) {
  ASSERT_TRUE(frame.T_world_left);
  EXPECT_LT((frame.T_world_left->translation() - Vector3d(x, 2.2, 3)).norm(), 1e-9)
      << frame.T_world_left->translation().transpose();
  EXPECT_LT((frame.T_world_left->linear() * Vector3d::UnitZ() - Vector3d::UnitY()).norm(), 1e-9);
  EXPECT_LT((frame.T_world_left->linear() * Vector3d::UnitY() + Vector3d::UnitZ()).norm(), 1e-9);
}

TEST_F(EurocFolder, TheTruthOfTheBodyBecomesThatOfTheLeftCamera) {
  put(kTruth, truth(9, 60));
  for (const bool with_imu : {true, false}) {
    if (!with_imu) fs::remove_all(place() / "imu0");
    const auto source = open();
    EXPECT_TRUE(source->has_poses());
    EXPECT_TRUE(source->problems().empty());
    const auto frames = frames_of(*source);
    ASSERT_EQ(frames.size(), 4U);
    EXPECT_FALSE(frames[0].T_world_left) << "the truth begins later";
    expect_on_path(frames[1], 1.1);
    expect_on_path(frames[3], 1.3);
  }
}

TEST_F(EurocFolder, TheTruthIsInterpolatedAndItsBadLinesAreTold) {
  put(kTruth, truth(0, 9) + "bad\n" + truth(11, 60));
  const auto source = open();
  ASSERT_EQ(source->problems().size(), 1U);
  EXPECT_EQ(source->problems()[0].where, (place() / kTruth).string() + ":12");
  expect_on_path(frames_of(*source)[1], 1.1);
  put(kTruth, "bad\n");
  const auto bad = open_stereo_source(folder_.path());
  ASSERT_FALSE(bad);
  EXPECT_EQ(bad.error().where, (place() / kTruth).string() + ":1");
}

TEST_F(EurocFolder, AnotherRigPlacesTheCameraInTheBody) {
  put(kTruth, truth(0, 60));
  StereoRig rig = read_rig(folder_.path().string()).value();
  rig.imu->T_imu_left.translation().x() = 0.7;
  const SourceOptions mine{(folder_ / "mine.yaml").string(), "", {}};
  ASSERT_TRUE(write_rig(mine.rig, rig));
  const auto place_of_first = [&] {
    return frames_of(*open(mine))[0].T_world_left->translation().eval();
  };
  EXPECT_LT((place_of_first() - Vector3d(1, 2.7, 3)).norm(), 1e-9);
  // The IMU is 1 m ahead of the body.
  std::string moved = kEurocImu;
  moved.replace(moved.find("[1.0, 0.0, 0.0, 0.0"), 19, "[1.0, 0.0, 0.0, 1.0");
  put("imu0/sensor.yaml", moved);
  EXPECT_LT((place_of_first() - Vector3d(1, 3.7, 3)).norm(), 1e-9);
  fs::remove(place() / "imu0/sensor.yaml");
  EXPECT_LT((place_of_first() - Vector3d(1, 2.7, 3)).norm(), 1e-9);
  // A rig without an IMU: cam0 of the folder.
  rig.imu.reset();
  ASSERT_TRUE(write_rig(mine.rig, rig));
  EXPECT_LT((place_of_first() - Vector3d(1, 2.2, 3)).norm(), 1e-9);
  fs::remove(place() / "cam0/sensor.yaml");
  const auto unplaced = open(mine);
  EXPECT_FALSE(unplaced->has_poses());
  ASSERT_EQ(unplaced->problems().size(), 1U);
  EXPECT_NE(unplaced->problems()[0].remedy.find("imu"), std::string::npos);
  EXPECT_FALSE(frames_of(*unplaced)[0].T_world_left);
}

TEST_F(EurocFolder, PosesOfTheCallerAreTakenAsTheyAre) {
  put(kTruth, truth(0, 60));
  put_file(folder_ / "path.tum", "1400000000.0 7 8 9 0 0 0 1\n1400000000.1 7 8 9 0 0 0 1\n");
  const auto given = open({"", (folder_ / "path.tum").string(), {}});
  const auto frames = frames_of(*given);
  ASSERT_TRUE(frames[1].T_world_left);
  EXPECT_EQ(frames[1].T_world_left->translation(), Vector3d(7, 8, 9));
  EXPECT_TRUE(frames[1].T_world_left->linear().isIdentity());
  EXPECT_FALSE(frames[3].T_world_left) << "behind its end, and the truth is not asked";
  put_file(folder_ / "poses.txt", "1400000000.0 4 5 6 0 0 0 1\n");
  EXPECT_EQ(frames_of(*open())[0].T_world_left->translation(), Vector3d(4, 5, 6));
}

}  // namespace
}  // namespace tread
