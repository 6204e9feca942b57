#include "tread/io/source.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "file_mutations.hpp"
#include "sample_images.hpp"
#include "test_data.hpp"
#include "tread/io/image_file.hpp"
#include "tread/io/rig_file.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;
using testing::make_png;
using testing::put_file;
using testing::ScratchFolder;

constexpr const char* kCalibration =
    "P0: 10 0 2 0 0 10 1 0 0 0 1 0\n"
    "P1: 10 0 2 -5 0 10 1 0 0 0 1 0\n"
    "P2: 12 0 2 0.6 0 12 1 0.1 0 0 1 0.003\n"
    "P3: 12 0 2 -4.2 0 12 1 0.2 0 0 1 0.002\n";

// 4 x 3 pixels, all of `value`.
std::string grey_png(char value) {
  return make_png(4, 3, 8, 0, std::string(12, value));
}

void put(const fs::path& path, const std::string& bytes) {
  fs::create_directories(path.parent_path());
  put_file(path, bytes);
}

// A KITTI sequence of `frames` frames; pixels of the left image have the number of the frame.
void make_kitti(const fs::path& folder, int frames) {
  put(folder / "calib.txt", kCalibration);
  for (int i = 0; i < frames; ++i) {
    const std::string name = "00000" + std::to_string(i) + ".png";
    put(folder / "image_0" / name, grey_png(static_cast<char>(i)));
    put(folder / "image_1" / name, grey_png(static_cast<char>(100 + i)));
  }
}

struct Read {
  std::vector<StereoFrame> frames;
  std::vector<Error> errors;
};

Read read_all(StereoSource& source) {
  Read read;
  for (;;) {
    auto next = source.next();
    if (!next) {
      read.errors.push_back(next.error());
    } else if (*next) {
      read.frames.push_back(std::move(**next));
    } else {
      return read;
    }
  }
}

std::vector<std::string> names_of(const Read& read) {
  std::vector<std::string> names;
  for (const StereoFrame& frame : read.frames) names.push_back(frame.name);
  return names;
}

TEST(Source, KittiFolderGivesItsFrames) {
  const ScratchFolder folder;
  make_kitti(folder.path(), 3);
  const auto source = open_stereo_source(folder.path());
  ASSERT_TRUE(source) << source.error().message();
  EXPECT_EQ((*source)->kind(), "KITTI odometry folder");
  EXPECT_EQ((*source)->frame_count(), 3);
  EXPECT_FALSE((*source)->has_poses());
  const StereoRig& rig = (*source)->rig();
  EXPECT_EQ(rig.size, (ImageSize{4, 3}));
  EXPECT_TRUE(rig.rectified);
  EXPECT_NEAR(rig.T_left_right.translation().x(), 0.5, 1e-12);
  ASSERT_TRUE(rig.mount);
  EXPECT_TRUE(rig.mount->assumed);
  EXPECT_EQ(rig.mount->T_body_left.translation().z(), 1.65);
  const Read read = read_all(**source);
  EXPECT_TRUE(read.errors.empty());
  ASSERT_EQ(names_of(read), (std::vector<std::string>{"000000", "000001", "000002"}));
  for (int i = 0; i < 3; ++i) {
    const StereoFrame& frame = read.frames[static_cast<std::size_t>(i)];
    EXPECT_EQ(frame.stamp_ns, i * 100'000'000);
    EXPECT_EQ(frame.left(0, 0), i);
    EXPECT_EQ(frame.right(0, 0), 100 + i);
    EXPECT_TRUE(frame.left_colour.empty());
    EXPECT_FALSE(frame.T_world_left);
  }
  EXPECT_FALSE((*source)->next().value()) << "the end stays the end";
}

TEST(Source, KittiPosesBecomeAWorldWithZUpOnTheGround) {
  const ScratchFolder folder;
  make_kitti(folder.path(), 3);
  // The second pose: 2 m ahead (z), 0.5 m to the right (x), 0.1 m down (y), turned right by 90
  // degrees (about y). The third frame has none.
  put(folder / "poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n0 0 1 0.5 0 1 0 0.1 -1 0 0 2\n");
  const auto source = open_stereo_source(folder.path());
  ASSERT_TRUE(source) << source.error().message();
  EXPECT_TRUE((*source)->has_poses());
  const Read read = read_all(**source);
  ASSERT_EQ(read.frames.size(), 3U);
  ASSERT_TRUE(read.frames[0].T_world_left);
  const Isometry3d& first = *read.frames[0].T_world_left;
  EXPECT_LT((first.translation() - Eigen::Vector3d(0, 0, 1.65)).norm(), 1e-12);
  EXPECT_LT((first.linear() * Eigen::Vector3d::UnitZ() - Eigen::Vector3d::UnitX()).norm(), 1e-12);
  ASSERT_TRUE(read.frames[1].T_world_left);
  const Isometry3d& second = *read.frames[1].T_world_left;
  EXPECT_LT((second.translation() - Eigen::Vector3d(2, -0.5, 1.55)).norm(), 1e-12);
  EXPECT_LT((second.linear() * Eigen::Vector3d::UnitZ() + Eigen::Vector3d::UnitY()).norm(), 1e-12)
      << "it looks to the right, which is -y";
  EXPECT_FALSE(read.frames[2].T_world_left) << "poses.txt has fewer lines than frames";
}

TEST(Source, ColourCamerasOfKittiHaveTheirOwnMatricesAndPlace) {
  const ScratchFolder folder;
  put(folder / "calib.txt", kCalibration);
  // Turned by 90 degrees to the left about camera 0.
  put(folder / "poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n0 0 -1 0 0 1 0 0 1 0 0 0\n");
  for (const char* name : {"000000.png", "000001.png"}) {
    put(folder / "image_2" / name, make_png(4, 3, 8, 2, std::string(36, 'r')));
    put(folder / "image_3" / name, make_png(4, 3, 8, 2, std::string(36, 'r')));
  }
  const auto source = open_stereo_source(folder.path());
  ASSERT_TRUE(source) << source.error().message();
  const PinholeCamera colour = pinhole_of((*source)->rig().left);
  EXPECT_EQ((std::array{colour.fx, colour.fy, colour.cx, colour.cy, colour.skew}),
            (std::array{12.0, 12.0, 2.0, 1.0, 0.0}));
  EXPECT_NEAR((*source)->rig().T_left_right.translation().x(), 0.4, 1e-12);
  const Read read = read_all(**source);
  ASSERT_EQ(read.frames.size(), 2U);
  EXPECT_EQ(read.frames[0].left_colour(1, 1), (Rgb{'r', 'r', 'r'}));
  EXPECT_EQ(read.frames[0].left(1, 1), 'r');
  // Camera 2 is 0.05 m to the left of camera 0, ahead after a turn to the left it is behind it.
  const Eigen::Vector3d moved =
      read.frames[1].T_world_left->translation() - read.frames[0].T_world_left->translation();
  EXPECT_LT((moved - Eigen::Vector3d(-0.05, -0.05, 0)).norm(), 1e-12) << moved.transpose();
  put(folder / "calib.txt", "P0: 10 0 2 0 0 10 1 0 0 0 1 0\nP1: 10 0 2 -5 0 10 1 0 0 0 1 0\n");
  const auto without = open_stereo_source(folder.path());
  ASSERT_FALSE(without);
  EXPECT_NE(without.error().what.find("P2"), std::string::npos);
  put(folder / "calib.txt", "P2: 12 0 2 nan 0 12 1 0.1 0 0 1 0\n");
  EXPECT_EQ(open_stereo_source(folder.path()).error().where,
            (folder / "calib.txt").string() + ":1");
  put(folder / "calib.txt",
      "P2: 12 0 2 0 0 12 1 0 0 0 1 0\nP3: 12 0 2 0 0 12 1 0 0 0 1 0\n");  // no baseline
  EXPECT_FALSE(open_stereo_source(folder.path()));
}

TEST(Source, TimesOfKittiAreExact) {
  const ScratchFolder folder;
  make_kitti(folder.path(), 2);
  put(folder / "times.txt", "0.0\n1.036224e-01\n0.2\n");
  const auto source = open_stereo_source(folder.path());
  ASSERT_TRUE(source) << source.error().message();
  EXPECT_EQ(read_all(**source).frames.at(1).stamp_ns, 103622400);
  put(folder / "times.txt", "0.0\n");
  const auto few = open_stereo_source(folder.path());
  ASSERT_FALSE(few);
  EXPECT_EQ(few.error().where, (folder / "times.txt").string());
}

TEST(Source, PosesBesideTheSequencesAreFound) {
  const ScratchFolder root;
  make_kitti(root / "sequences" / "07", 1);
  put(root / "poses" / "07.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n");
  const auto source = open_stereo_source(root / "sequences" / "07" / "");
  ASSERT_TRUE(source) << source.error().message();
  EXPECT_TRUE((*source)->has_poses());
}

TEST(Source, ABadFrameIsNamedAndTheNextOneFollows) {
  const ScratchFolder folder;
  make_kitti(folder.path(), 7);
  const std::string whole = grey_png(1);
  put(folder / "image_0" / "000001.png", whole.substr(0, whole.size() / 2));
  fs::remove(folder / "image_1" / "000002.png");
  fs::remove(folder / "image_0" / "000003.png");
  put(folder / "image_1" / "000004.png", make_png(4, 4, 8, 0, std::string(16, 'x')));
  put(folder / "image_0" / "000005.png", make_png(5, 3, 8, 0, std::string(15, 'x')));
  const auto source = open_stereo_source(folder.path());
  ASSERT_TRUE(source) << source.error().message();
  EXPECT_EQ((*source)->frame_count(), 7);
  const Read read = read_all(**source);
  EXPECT_EQ(names_of(read), (std::vector<std::string>{"000000", "000006"}));
  EXPECT_EQ(read.frames[1].stamp_ns, 600'000'000);
  ASSERT_EQ(read.errors.size(), 5U);
  EXPECT_EQ(read.errors[0].where, (folder / "image_0" / "000001.png").string());
  EXPECT_EQ(read.errors[0].code, ErrorCode::kUnreadable);
  EXPECT_EQ(read.errors[1].where, (folder / "image_0" / "000002.png").string());
  EXPECT_NE(read.errors[1].what.find("no right image"), std::string::npos);
  EXPECT_EQ(read.errors[2].where, (folder / "image_1" / "000003.png").string());
  EXPECT_NE(read.errors[2].what.find("no left image"), std::string::npos);
  EXPECT_EQ(read.errors[3].where, (folder / "image_1" / "000004.png").string());
  EXPECT_NE(read.errors[3].what.find("4x4 pixels, but the rig has 4x3"), std::string::npos);
  EXPECT_EQ(read.errors[4].where, (folder / "image_0" / "000005.png").string());
}

TEST(Source, ABadFirstFrameDoesNotHideTheOthers) {
  const ScratchFolder folder;
  make_kitti(folder.path(), 2);
  put(folder / "image_0" / "000000.png", "no picture");
  const auto source = open_stereo_source(folder.path());
  ASSERT_TRUE(source) << source.error().message();
  const Read read = read_all(**source);
  EXPECT_EQ(read.errors.size(), 1U);
  EXPECT_EQ(names_of(read), (std::vector<std::string>{"000001"}));
  put(folder / "image_0" / "000001.png", "neither");
  const auto right_only = open_stereo_source(folder.path());
  ASSERT_TRUE(right_only) << "the size is known from the right images";
  EXPECT_EQ(read_all(**right_only).errors.size(), 2U);
  for (const char* name : {"000000.png", "000001.png"}) put(folder / "image_1" / name, "nor these");
  const auto none = open_stereo_source(folder.path());
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().where, (folder / "image_0" / "000000.png").string());
}

StereoRig small_rig() {
  StereoRig rig;
  rig.name = "small";
  rig.size = {4, 3};
  rig.left = PinholeCamera{10, 10, 2, 1, 0};
  rig.right = rig.left;
  rig.T_left_right.translation().x() = 0.2;
  rig.rectified = true;
  return rig;
}

void make_left_right(const fs::path& folder) {
  for (const char* stamp : {"1000000000000000000", "1000000000500000000"}) {
    put(folder / "left" / (std::string(stamp) + ".png"), grey_png(1));
    put(folder / "right" / (std::string(stamp) + ".png"), grey_png(2));
  }
}

TEST(Source, LeftRightFolderTakesItsRigAndPosesByTime) {
  const ScratchFolder folder;
  make_left_right(folder.path());
  ASSERT_TRUE(write_rig(folder / "rig.yaml", small_rig()));
  put(folder / "walk.tum", "1000000000.0 1 2 3 0 0 0 1\n1000000000.4 1 2 3 0 0 0 1\n");
  const auto source = open_stereo_source(folder.path(), {"", (folder / "walk.tum").string()});
  ASSERT_TRUE(source) << source.error().message();
  EXPECT_EQ((*source)->kind(), "folder of left and right images");
  EXPECT_FALSE((*source)->rig().mount);
  EXPECT_TRUE((*source)->has_poses());
  const Read read = read_all(**source);
  ASSERT_EQ(read.frames.size(), 2U);
  EXPECT_EQ(read.frames[0].stamp_ns, 1000000000000000000);
  ASSERT_TRUE(read.frames[0].T_world_left);
  EXPECT_EQ(read.frames[0].T_world_left->translation(), Eigen::Vector3d(1, 2, 3));
  EXPECT_FALSE(read.frames[1].T_world_left) << "0.5 s is behind the trajectory";
}

TEST(Source, KittiPosesOfALeftRightFolderUseItsMountOrNone) {
  const ScratchFolder folder;
  make_left_right(folder.path());
  StereoRig rig = small_rig();
  ASSERT_TRUE(write_rig(folder / "rig.yaml", rig));
  put(folder / "poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 3\n");
  const auto last_place = [&] {
    const auto source = open_stereo_source(folder.path());
    EXPECT_TRUE(source) << source.error().message();
    return read_all(**source).frames.at(1).T_world_left->translation().eval();
  };
  EXPECT_LT((last_place() - Eigen::Vector3d(3, 0, 0)).norm(), 1e-12);
  rig.mount = level_mount(1.0, M_PI / 2, false);  // looks straight down
  ASSERT_TRUE(write_rig(folder / "rig.yaml", rig));
  EXPECT_LT((last_place() - Eigen::Vector3d(0, 0, -2)).norm(), 1e-9);
}

TEST(Source, ARigOfTheCallerComesFirst) {
  const ScratchFolder folder;
  make_kitti(folder / "k", 1);
  StereoRig rig = small_rig();
  rig.mount = level_mount(0.7, 0.0, false);
  ASSERT_TRUE(write_rig(folder / "mine.yaml", rig));
  const auto source = open_stereo_source(folder / "k", {(folder / "mine.yaml").string(), ""});
  ASSERT_TRUE(source) << source.error().message();
  EXPECT_EQ((*source)->rig().name, "small");
  EXPECT_FALSE((*source)->rig().mount->assumed) << "the mount of the rig file was replaced";
  // One whose images have another size: every frame says so.
  const auto other = open_stereo_source(folder / "k", {"bumblebee2-640", ""});
  ASSERT_TRUE(other) << other.error().message();
  const Read read = read_all(**other);
  ASSERT_EQ(read.errors.size(), 1U);
  EXPECT_NE(read.errors[0].what.find("640x480"), std::string::npos);
}

TEST(Source, FilesThatAreMissingOrWrongAreNamed) {
  const ScratchFolder folder;
  const auto nothing = open_stereo_source(folder.path());
  ASSERT_FALSE(nothing);
  EXPECT_NE(nothing.error().remedy.find("image_0"), std::string::npos);
  make_kitti(folder.path(), 1);
  fs::remove(folder / "calib.txt");
  const auto no_calibration = open_stereo_source(folder.path());
  ASSERT_FALSE(no_calibration);
  EXPECT_EQ(no_calibration.error().code, ErrorCode::kNotFound);
  EXPECT_NE(no_calibration.error().what.find("calib.txt"), std::string::npos);
  put(folder / "calib.txt", "P0: 1 2 3\n");
  const auto bad_calibration = open_stereo_source(folder.path());
  ASSERT_FALSE(bad_calibration);
  EXPECT_NE(bad_calibration.error().where.find("calib.txt"), std::string::npos);
  put(folder / "calib.txt", kCalibration);
  for (const char* poses : {"", "1 2 3\n", "1 0 0 0 0 1 0 0 0 0 1 x\n", "1 0 0 0 0 0 0 0\n"}) {
    put(folder / "poses.txt", poses);
    const auto bad_poses = open_stereo_source(folder.path());
    ASSERT_FALSE(bad_poses) << poses;
    EXPECT_TRUE(bad_poses.error().where.starts_with((folder / "poses.txt").string()));
  }
  const auto no_poses = open_stereo_source(folder.path(), {"", (folder / "none.txt").string()});
  ASSERT_FALSE(no_poses);
  EXPECT_EQ(no_poses.error().code, ErrorCode::kNotFound);
  put(folder / "times.txt", "now\n");
  EXPECT_EQ(open_stereo_source(folder.path()).error().where,
            (folder / "times.txt").string() + ":1");
}

TEST(Source, EurocFolderBringsItsCalibration) {
  const ScratchFolder folder;
  const std::string image = make_png(4, 3, 8, 0, std::string(12, 'x'));
  put(folder / "mav0/cam0/data/1403636579763555584.png", image);
  put(folder / "mav0/cam1/data/1403636579763555584.png", image);
  for (const auto& [camera, x] : {std::pair{"cam0", "0.0"}, {"cam1", "0.11"}}) {
    put(folder / "mav0" / camera / "sensor.yaml",
        std::string("sensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n  data: [1, 0, 0, ") + x +
            ", 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\nrate_hz: 20\nresolution: [4, 3]\n"
            "camera_model: pinhole\nintrinsics: [10, 10, 2, 1]\n"
            "distortion_model: radial-tangential\ndistortion_coefficients: [-0.1, 0, 0, 0]\n");
  }
  const auto source = open_stereo_source(folder.path());
  ASSERT_TRUE(source) << source.error().message();
  EXPECT_NEAR((*source)->rig().T_left_right.translation().x(), 0.11, 1e-12);
  EXPECT_EQ(read_all(**source).frames.at(0).stamp_ns, 1403636579763555584);
}

TEST(Source, ReadsARealDrive) {
  TREAD_NEEDS_DATA(path, "stereo_seq/kitti_seq_1");
  const auto source = open_stereo_source(path);
  ASSERT_TRUE(source) << source.error().message();
  EXPECT_EQ((*source)->kind(), "KITTI odometry folder");
  EXPECT_EQ((*source)->frame_count(), 30);
  EXPECT_TRUE((*source)->has_poses());
  EXPECT_EQ((*source)->rig().size, (ImageSize{1226, 370}));
  EXPECT_NEAR((*source)->rig().T_left_right.translation().x(), 0.5372, 1e-4);
  const Read read = read_all(**source);
  EXPECT_TRUE(read.errors.empty());
  ASSERT_EQ(read.frames.size(), 30U);
  Eigen::Vector3d before(-1, 0, 0);
  for (std::size_t i = 0; i < 30; ++i) {
    const StereoFrame& frame = read.frames[i];
    EXPECT_EQ(frame.stamp_ns, static_cast<std::int64_t>(i) * 100'000'000);
    EXPECT_EQ(frame.left.width, 1226);
    EXPECT_EQ(frame.right.height, 370);
    ASSERT_TRUE(frame.T_world_left);
    const Eigen::Vector3d here = frame.T_world_left->translation();
    EXPECT_GT(here.x(), before.x() + 0.5) << "a car at 1.2 m a frame drives along +x";
    before = here;
  }
  EXPECT_LT((read.frames[0].T_world_left->translation() - Eigen::Vector3d(0, 0, 1.65)).norm(),
            1e-9);
  EXPECT_NEAR(read.frames[29].T_world_left->translation().z(), 1.65, 1.5) << "it stays on the road";
}

}  // namespace
}  // namespace tread
