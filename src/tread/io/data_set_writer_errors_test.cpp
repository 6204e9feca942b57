// Recordings that cannot be written, and what is left of them.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cmath>
#include <csignal>
#include <functional>
#include <limits>

#include "recording_samples.hpp"
#include "test_data.hpp"
#include "tread/io/data_set_writer.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;
using namespace testing::recording;
using testing::ScratchFolder;

TEST(DataSetWriter, ASetupThatCannotBeIsRefused) {
  const ScratchFolder scratch;
  const auto error_of = [&](const std::function<void(RecordingSetup&)>& change) {
    RecordingSetup recording = setup();
    change(recording);
    const auto writer = DataSetWriter::create(scratch / "run", recording);
    EXPECT_FALSE(writer);
    return writer ? std::string() : writer.error().message();
  };
  const auto expect = [&](const std::string& says, const std::function<void(RecordingSetup&)>& f) {
    const std::string message = error_of(f);
    EXPECT_NE(message.find(says), std::string::npos) << message;
  };
  expect("no head", [](RecordingSetup& r) { r.heads.clear(); });
  expect("heads[1].mount", [](RecordingSetup& r) { r.heads[1].mount.reset(); });
  expect("heads[0].imu.gyro_noise", [](RecordingSetup& r) { r.heads[0].imu->gyro_noise = 0.0; });
  expect("rate", [](RecordingSetup& r) { r.camera_rate_hz = 0.0; });
  expect("rate", [](RecordingSetup& r) { r.gnss_rate_hz = std::nan(""); });
  expect("antenna", [](RecordingSetup& r) { r.p_body_antenna_m.x() = std::nan(""); });
  const auto with_left = [](const CameraModel& camera) {
    return [camera](RecordingSetup& r) { r.heads[1].left = camera; };
  };
  BrownCamera camera = brown();
  camera.lx = 0.01;
  expect("heads[1].left: EuRoC's sensor.yaml has no form for a camera with a lens centre",
         with_left(camera));
  camera = brown();
  camera.K[3] = 1e-3;
  expect("K3", with_left(camera));
  camera = brown();
  camera.P[2] = 1e-3;
  expect("P2", with_left(camera));
  camera = brown();
  camera.D[0] = 1e-3;
  expect("denominator", with_left(camera));
  camera = brown();
  camera.pinhole.skew = 0.1;
  expect("skew", with_left(camera));
  EXPECT_TRUE(!fs::exists(scratch / "run") || fs::is_empty(scratch / "run"));
}

TEST(DataSetWriter, SamplesThatCannotBeAreRefusedAndTheRestGoesOn) {
  const ScratchFolder scratch;
  RecordingSetup recording = setup();
  DataSetWriter writer = open(scratch / "run", recording);
  StereoFrame small = frame(0);
  small.right = Image<std::uint8_t>(3, 3);
  EXPECT_FALSE(writer.add(0, small));
  EXPECT_FALSE(writer.add(2, frame(0)));
  EXPECT_FALSE(writer.add(-1, frame(0)));
  StereoFrame early = frame(0);
  early.stamp_ns = -1;
  EXPECT_FALSE(writer.add(0, early));
  ImuSample bad = imu(0);
  bad.accel_m_per_s2.y() = std::numeric_limits<double>::infinity();
  const Status refused = writer.add(bad);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().where, "imu0");
  EXPECT_FALSE(writer.add(BumpEvent{-5, true}));
  BodyTruth bent = truth(0);
  bent.T_world_body.linear() *= 2.0;
  EXPECT_FALSE(writer.add(bent));
  EXPECT_FALSE(writer.add_raster("../height", {}));
  EXPECT_FALSE(writer.add_raster("height", {}));
  EXPECT_FALSE(writer.add_depth(0, 0, {}));
  EXPECT_DONE(writer.add(0, frame(0)));
  EXPECT_DONE(writer.add(imu(0)));
  EXPECT_DONE(writer.finish());
  EXPECT_EQ(frames_of(scratch / "run").size(), 1U);
  EXPECT_FALSE(writer.add(imu(1))) << "it is finished";
  EXPECT_FALSE(writer.finish());
  recording.heads[0].imu.reset();
  DataSetWriter blind = open(scratch / "blind", recording);
  EXPECT_FALSE(blind.add(imu(0)));
}

TEST(DataSetWriter, AFullDiskIsToldByNameAndTheOldRecordingStays) {
  const ScratchFolder scratch;
  DataSetWriter old = open(scratch.path());
  EXPECT_DONE(old.add(0, frame(0)));
  EXPECT_DONE(old.finish());
  const auto write_until_full = [&] {
    DataSetWriter writer = open(scratch.path());
    Status done;
    for (int i = 0; done && i < 100'000; ++i) done = writer.add(imu(i));
    EXPECT_FALSE(done) << "the table grew beyond the limit";
    if (!done) {
      EXPECT_EQ(done.error().code, ErrorCode::kWriteFailed);
      EXPECT_EQ(done.error().where, (scratch / "mav0/imu0/data.csv").string());
    }
    EXPECT_FALSE(writer.add(0, frame(1))) << "nothing more is taken";
    const Status finished = writer.finish();
    ASSERT_FALSE(finished);
    EXPECT_EQ(finished.error().where, done.error().where);
  };
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  auto* const handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit small = before;
  small.rlim_cur = 200'000;  // bytes a file
  setrlimit(RLIMIT_FSIZE, &small);
  write_until_full();
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(frames_of(scratch.path()).size(), 1U);
  EXPECT_FALSE(fs::exists(scratch / ".tread-recording"));
}

}  // namespace
}  // namespace tread
