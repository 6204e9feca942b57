#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "command_test.hpp"
#include "euroc_drive.hpp"
#include "rendered_scene.hpp"
#include "rgbd_images.hpp"
#include "tread/geometry/trajectory_error.hpp"
#include "tread/io/mesh_file.hpp"

namespace tread::testing {
namespace {

// A 16-bit PNG of millimetres.
std::string depth_png_of(ImageView<const float> depth) {
  std::string rows;
  for (int y = 0; y < depth.height; ++y) {
    for (int x = 0; x < depth.width; ++x) {
      const float z = depth(x, y);
      const int mm = z > 0.0F ? static_cast<int>(std::lround(1000.0F * z)) : 0;
      rows += {static_cast<char>(mm >> 8), static_cast<char>(mm & 0xff)};
    }
  }
  return make_png(depth.width, depth.height, 16, 0, rows);
}

using Pose = std::function<Isometry3d(double)>;

// Ten frames of a scene, as 7-Scenes lays them out.
void make_frames(const fs::path& folder, const bench::Scene& scene, const Pose& pose_at_time) {
  bench::Sensor sensor;
  sensor.width = 160;
  sensor.height = 120;
  sensor.camera = {145.0F, 145.0F, 79.5F, 59.5F};
  sensor.noise = DepthNoise{};
  sensor.grey_sigma = 1.0;
  for (int i = 0; i < 10; ++i) {
    const bench::RenderedFrame frame =
        bench::render(scene, sensor, pose_at_time(i / 30.0), static_cast<unsigned>(i));
    const std::string name = fmt::format("frame-{:06d}", i);
    put(folder / (name + ".depth.png"), depth_png_of(frame.depth));
    EXPECT_TRUE(write_png(folder / (name + ".color.png"), frame.grey.view()));
    std::string pose;
    for (int k = 0; k < 16; ++k) {
      pose += fmt::format("{} ", frame.T_world_camera.matrix()(k / 4, k % 4));
    }
    put(folder / (name + ".pose.txt"), pose);
  }
  put(folder / "camera-intrinsics.txt", "145 0 79.5\n0 145 59.5\n0 0 1\n");
}

void make_walk(const fs::path& folder, bool textured) {
  make_frames(folder, bench::flat_ground(textured), bench::walking_camera);
}

TEST(TreadSlam, TracksAWalkAndWritesWhatItFound) {
  const ScratchFolder scratch;
  make_walk(scratch / "walk", true);
  const std::string out = (scratch / "out").string();
  const Ran ran = tread("slam " + (scratch / "walk").string() + " --json -o " + out);
  ASSERT_EQ(ran.status, 0) << ran.out << ran.err;
  const auto json = ran.json();
  EXPECT_EQ(json["frames"], 10);
  EXPECT_EQ(json["tracked"], 9);
  EXPECT_EQ(json["lost"], 0);
  EXPECT_NEAR(json["path_m"].get<double>(), 0.15, 0.03);
  EXPECT_LT(json["absolute_error_m"].get<double>(), 0.003);
  const auto path = read_tum_trajectory(scratch / "out/trajectory.tum");
  ASSERT_TRUE(path) << path.error().message();
  EXPECT_EQ(path->size(), 10U);
  const auto surface = read_ply(scratch / "out/mesh.ply");
  ASSERT_TRUE(surface) << surface.error().message();
  EXPECT_GT(surface->points.size(), 1000U);
  for (const char* name : {"tracking.csv", "picture_path.png", "report.html"}) {
    EXPECT_TRUE(fs::exists(scratch / "out" / name)) << name;
  }
  const std::string page = read_file(scratch / "out/report.html").value_or("");
  EXPECT_NE(page.find("No frame was lost"), std::string::npos);
}

TEST(TreadSlam, SaysWhatItCouldNotTell) {
  const ScratchFolder scratch;
  make_walk(scratch / "walk", false);
  const Ran ran =
      tread("slam " + (scratch / "walk").string() + " --json -o " + (scratch / "out").string());
  ASSERT_EQ(ran.status, 1) << ran.out << ran.err;
  EXPECT_NE(ran.err.find("only 1 of 10 frames could be placed"), std::string::npos) << ran.err;
  EXPECT_EQ(ran.json()["tracked"], 0);
  EXPECT_EQ(ran.json()["unobservable"], 9);
  EXPECT_NE(read_file(scratch / "out/report.html").value_or("").find("Where tracking was weak"),
            std::string::npos);
}

TEST(TreadSlam, BadFramesCostThemselves) {
  const ScratchFolder scratch;
  make_walk(scratch / "walk", true);
  put_file(scratch / "walk/frame-000004.depth.png", "no png");
  const Ran ran = tread("slam " + (scratch / "walk").string() + " --json");
  EXPECT_EQ(ran.status, 1);
  EXPECT_NE(ran.err.find("frame-000004.depth.png"), std::string::npos) << ran.err;
  EXPECT_EQ(ran.json()["frames"], 10);
  EXPECT_EQ(ran.json()["tracked"], 8);
}

// A camera that had to be assumed is said, and is no failure.
TEST(TreadSlam, NoticesAreNoFailure) {
  const ScratchFolder scratch;
  make_walk(scratch / "walk", true);
  put_file(scratch / "walk/frame-000003.pose.txt", "nan");
  const Ran ran = tread("slam " + (scratch / "walk").string());
  EXPECT_EQ(ran.status, 0) << ran.err;
  EXPECT_NE(ran.err.find("note: "), std::string::npos) << ran.err;
}

TEST(TreadInfo, TellsWhatAnRgbdFolderIs) {
  const ScratchFolder scratch;
  make_walk(scratch / "walk", true);
  const Ran ran = tread("info " + (scratch / "walk").string());
  EXPECT_EQ(ran.status, 0) << ran.err;
  EXPECT_NE(ran.out.find("10 frames, with reference poses"), std::string::npos) << ran.out;
  EXPECT_NE(ran.out.find("160x120 px, f 145.0 px"), std::string::npos) << ran.out;
}

TEST(TreadSlam, WrongInputIsRefusedWithARemedy) {
  const ScratchFolder scratch;
  fs::create_directories(scratch / "empty");
  expect_refused("slam " + (scratch / "empty").string(), {"empty"});
  expect_refused("slam " + (scratch / "nowhere").string(), {"nowhere"});
  expect_refused("slam x --set volume.voxel=0.01", {"volume.voxel", "volume.voxel_m"});
  expect_refused("slam x --profile paper", {"paper-q"}, 2);
  EXPECT_NE(tread("slam --print-config").out.find("voxel_m: 0.01"), std::string::npos);
}

TEST(TreadSlam, TheProfileOfThePaperTracksAndSaysWhereItWouldSlide) {
  const ScratchFolder scratch;
  make_frames(scratch / "room", bench::room_corner(), [](double t) {
    return bench::camera_at({0.3 * t, 0.2 * t, 1.0}, 30.0 + 20.0 * t, 15.0, 0.0);
  });
  const Ran room = tread("slam " + (scratch / "room").string() + " --profile paper-q --json");
  ASSERT_EQ(room.status, 0) << room.err;
  EXPECT_EQ(room.json()["tracked"], 9);
  EXPECT_LT(room.json()["absolute_error_m"].get<double>(), 0.005);
  // Flat ground by depth alone, where KinFu slides.
  make_walk(scratch / "walk", true);
  const Ran walk = tread("slam " + (scratch / "walk").string() + " --profile paper-q --json");
  EXPECT_EQ(walk.json()["unobservable"], 9);
}

// Pairs that are not rectified, an IMU with biases at some distance from the cameras.
TEST(TreadSlam, FollowsAnEurocFlightByPairsAndImu) {
  const ScratchFolder scratch;
  const EurocDrive drive;
  drive.write(scratch / "flight", 5.0);
  const std::string out = (scratch / "out").string();
  const Ran ran = tread("slam " + (scratch / "flight").string() + " --json -o " + out);
  ASSERT_EQ(ran.status, 0) << ran.out << ran.err;
  const auto json = ran.json();
  EXPECT_EQ(json["frames"], 100);
  EXPECT_EQ(json["lost"], 0);
  EXPECT_EQ(json["odometry"]["tracked"], 99);
  EXPECT_GT(json["odometry"]["inertial"].get<int>(), 50);
  EXPECT_LT(json["absolute_error_m"].get<double>(), 0.005);
  // The IMU's own path is the body's, which the truth is of.
  const auto body = read_tum_trajectory(scratch / "out/trajectory_imu.tum");
  ASSERT_TRUE(body) << body.error().message();
  Trajectory truth;
  for (int i = 0; i < 100; ++i) {
    truth.push_back({EurocDrive::stamp(i / 20.0), drive.body_at(i / 20.0)});
  }
  const auto error = absolute_trajectory_error(*body, truth);
  ASSERT_TRUE(error);
  EXPECT_LT(error->rmse_m, 0.005);
  EXPECT_LT(error->rmse_rad, 0.01);
  // The world is level by what the accelerometer felt, whose bias is a hundredth of gravity.
  const Eigen::Vector3d up = body->front().pose.linear().transpose().col(2),
                        up_true = truth.front().pose.linear().transpose().col(2);
  EXPECT_LT((up - up_true).norm(), 0.02);

  const Ran without = tread("slam " + (scratch / "flight").string() +
                            " --json --set use_imu=false --set odometry.corners.most=200");
  ASSERT_EQ(without.status, 0) << without.err;
  EXPECT_EQ(without.json()["odometry"]["inertial"], 0);
  EXPECT_LT(without.json()["absolute_error_m"].get<double>(), 0.01);
}

}  // namespace
}  // namespace tread::testing
