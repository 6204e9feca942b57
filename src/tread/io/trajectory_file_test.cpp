#include "tread/io/trajectory_file.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "file_mutations.hpp"
#include "test_data.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;
using testing::put_file;
using testing::ScratchFolder;

Trajectory some_trajectory() {
  Trajectory trajectory;
  for (int i = 0; i < 20; ++i) {
    StampedPose pose;
    pose.stamp_ns = 1403636579763555527 + 50000001 * std::int64_t{i};
    Vector6d twist;
    twist << 0.1 * i, -1.0 / (1 + i), 1e-9 * i, 0.3 * i, 0.01, -0.2;
    pose.pose = se3_exp(twist);
    trajectory.push_back(pose);
  }
  return trajectory;
}

TEST(TumTrajectory, RoundTripIsExactInTime) {
  const ScratchFolder folder;
  const Trajectory written = some_trajectory();
  ASSERT_TRUE(write_tum_trajectory(folder / "t.tum", written));
  const auto read = read_tum_trajectory(folder / "t.tum");
  ASSERT_TRUE(read) << read.error().message();
  ASSERT_EQ(read->size(), written.size());
  for (std::size_t i = 0; i < written.size(); ++i) {
    EXPECT_EQ((*read)[i].stamp_ns, written[i].stamp_ns);
    EXPECT_EQ((*read)[i].pose.translation(), written[i].pose.translation());
    EXPECT_LT(((*read)[i].pose.linear() - written[i].pose.linear()).norm(), 1e-14);
  }
}

TEST(TumTrajectory, ReadsWhatOthersWrite) {
  const ScratchFolder folder;
  put_file(folder / "t.tum",
           "# ground truth\r\n"
           "1.305031102175304000e+09 1 2 3 0 0 0 2\r\n"
           "\n"
           "1305031102.2\t-1.5e-3 0 0  0 0 0.70710678 0.70710678");
  const auto read = read_tum_trajectory(folder / "t.tum");
  ASSERT_TRUE(read) << read.error().message();
  ASSERT_EQ(read->size(), 2U);
  EXPECT_EQ((*read)[0].stamp_ns, 1305031102175304000);
  EXPECT_EQ((*read)[0].pose.translation(), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ((*read)[0].pose.linear(), Eigen::Matrix3d::Identity());
  // A quarter turn about z takes x to y.
  EXPECT_LT(((*read)[1].pose.linear() * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY()).norm(),
            1e-12);
  EXPECT_TRUE(is_rigid((*read)[1].pose, 1e-14));
}

TEST(TumTrajectory, BadLinesAreNamedByTheirNumber) {
  const ScratchFolder folder;
  struct Case {
    const char* line;
    const char* what;
  };
  const std::vector<Case> cases = {
      {"2.0 0 0 0 0 0 0 0", "quaternion is zero"},
      {"2.0 0 0 0 0 0 0", "7 fields instead of 8"},
      {"2.0 0 0 0 0 0 0 1 5", "9 fields instead of 8"},
      {"2.0 nan 0 0 0 0 0 1", "'nan' is not a finite number"},
      {"2.0 0 0 0 0 0 inf 1", "'inf' is not a finite number"},
      {"2.0 0 0 1e999 0 0 0 1", "'1e999' is not a finite number"},
      {"2.0 0 0 zero 0 0 0 1", "'zero' is not a finite number"},
      {"now 0 0 0 0 0 0 1", "'now' is not a time"},
      {"nan 0 0 0 0 0 0 1", "'nan' is not a time"},
      {"1.0 0 0 0 0 0 0 1", "not later"},
      {"0.999999999 0 0 0 0 0 0 1", "not later"},
  };
  for (const Case& c : cases) {
    put_file(folder / "t.tum", std::string("# head\n1.0 0 0 0 0 0 0 1\n") + c.line + "\n");
    const auto read = read_tum_trajectory(folder / "t.tum");
    ASSERT_FALSE(read) << c.line;
    EXPECT_EQ(read.error().where, (folder / "t.tum").string() + ":3");
    EXPECT_NE(read.error().what.find(c.what), std::string::npos) << read.error().message();
    EXPECT_FALSE(read.error().remedy.empty());
  }
  put_file(folder / "t.tum", "# nothing\n");
  EXPECT_FALSE(read_tum_trajectory(folder / "t.tum"));
  EXPECT_EQ(read_tum_trajectory(folder / "none").error().code, ErrorCode::kNotFound);
}

TEST(TumTrajectory, ExtremeQuaternionsAreNormalised) {
  const ScratchFolder folder;
  put_file(folder / "t.tum", "1 0 0 0 0 0 3e300 3e300\n2 0 0 0 1e-5 0 0 1e-5\n");
  const auto read = read_tum_trajectory(folder / "t.tum");
  ASSERT_TRUE(read) << read.error().message();
  for (const StampedPose& pose : *read) EXPECT_TRUE(is_rigid(pose.pose, 1e-14));
}

TEST(TumTrajectory, DamagedFilesAreCleanlyReadOrRefused) {
  const ScratchFolder folder;
  ASSERT_TRUE(write_tum_trajectory(folder / "valid", some_trajectory()));
  const std::string valid = testing::get_file(folder / "valid").substr(0, 500);
  const auto read = [](const fs::path& path) {
    const auto trajectory = read_tum_trajectory(path);
    if (!trajectory) return false;
    for (std::size_t i = 0; i < trajectory->size(); ++i) {
      EXPECT_TRUE(is_rigid((*trajectory)[i].pose, 1e-12));
      EXPECT_TRUE(i == 0 || (*trajectory)[i].stamp_ns > (*trajectory)[i - 1].stamp_ns);
    }
    return true;
  };
  testing::shorter_files_taken(valid, folder / "t", read);
  EXPECT_GT(testing::damaged_files_refused(valid, folder / "t", read), 500);
}

TEST(KittiPoses, ReadsMatricesRowByRowAndMakesThemRigid) {
  const ScratchFolder folder;
  put_file(folder / "p.txt",
           "1 0 0 0 0 1 0 0 0 0 1 0\n"
           "9.999995e-01 7.196824e-04 -6.870876e-04 -1.401751e-02 -7.197717e-04 9.999997e-01 "
           "-1.295633e-04 -2.820321e-02 6.869946e-04 1.300585e-04 9.999998e-01 1.198998e+00\n");
  const auto poses = read_kitti_poses(folder / "p.txt");
  ASSERT_TRUE(poses) << poses.error().message();
  ASSERT_EQ(poses->size(), 2U);
  EXPECT_EQ((*poses)[0]->matrix(), Eigen::Matrix4d::Identity());
  EXPECT_EQ((*poses)[1]->translation(), Eigen::Vector3d(-1.401751e-02, -2.820321e-02, 1.198998));
  EXPECT_TRUE(is_rigid(*(*poses)[1], 1e-14));
  EXPECT_NEAR((*poses)[1]->linear()(0, 1), 7.197e-04, 1e-6);
}

TEST(KittiPoses, BadLinesAreNamedByTheirNumber) {
  const ScratchFolder folder;
  const std::string good = "1 0 0 0 0 1 0 0 0 0 1 0\n";
  for (const char* line : {"1 0 0 0 0 1 0 0 0 0 1", "1 0 0 0 0 1 0 0 0 0 1 x",
                           "2 0 0 0 0 2 0 0 0 0 2 0",   // scaled
                           "-1 0 0 0 0 1 0 0 0 0 1 0",  // mirrored
                           "1 0 0 nan 0 1 0 0 0 0 1 0"}) {
    put_file(folder / "p.txt", good + line + "\n");
    const auto poses = read_kitti_poses(folder / "p.txt");
    ASSERT_FALSE(poses) << line;
    EXPECT_EQ(poses.error().where, (folder / "p.txt").string() + ":2");
  }
  put_file(folder / "p.txt", "");
  EXPECT_FALSE(read_kitti_poses(folder / "p.txt"));
  EXPECT_FALSE(read_kitti_poses(folder / "none"));
  const auto read = [](const fs::path& path) { return read_kitti_poses(path).has_value(); };
  testing::shorter_files_taken(good + good, folder / "p.txt", read);
  EXPECT_GT(testing::damaged_files_refused(good + good, folder / "p.txt", read), 1000);
}

TEST(KittiPoses, BadLinesCanBeLeftOutAndAreNamed) {
  const ScratchFolder folder;
  const std::string good = "1 0 0 0 0 1 0 0 0 0 1 0\n";
  put_file(folder / "p.txt", good + "1 0 0 nan 0 1 0 0 0 0 1 0\n" + good + "1 0 0 0 0 1 0 0");
  std::vector<Error> bad;
  const auto poses = read_kitti_poses(folder / "p.txt", &bad);
  ASSERT_TRUE(poses);
  ASSERT_EQ(poses->size(), 4U);
  EXPECT_TRUE((*poses)[0] && !(*poses)[1] && (*poses)[2] && !(*poses)[3]);
  ASSERT_EQ(bad.size(), 2U);
  EXPECT_EQ(bad[0].where, (folder / "p.txt").string() + ":2");
  EXPECT_EQ(bad[1].where, (folder / "p.txt").string() + ":4");
}

TEST(TumTrajectory, BadLinesCanBeLeftOutAndAreNamed) {
  const ScratchFolder folder;
  put_file(folder / "t.tum",
           "1 0 0 0 0 0 0 1\n2 x 0 0 0 0 0 1\n3 0 0 0 0 0 0 1\n2.5 0 0 0 0 0 0 1\n4 0 0 0\n");
  std::vector<Error> bad;
  const auto poses = read_tum_trajectory(folder / "t.tum", &bad);
  ASSERT_TRUE(poses);
  ASSERT_EQ(poses->size(), 2U);
  EXPECT_EQ((*poses)[1].stamp_ns, 3'000'000'000);
  ASSERT_EQ(bad.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    const int line = i == 0 ? 2 : static_cast<int>(i) + 3;
    EXPECT_EQ(bad[i].where, (folder / "t.tum").string() + ":" + std::to_string(line));
  }
}

TEST(Times, AreExactAndMustIncrease) {
  const ScratchFolder folder;
  put_file(folder / "times.txt", "0.000000e+00\n1.036224e-01\n2.072890e-01\n");
  EXPECT_EQ(read_times(folder / "times.txt").value(),
            (std::vector<std::int64_t>{0, 103622400, 207289000}));
  put_file(folder / "times.txt", "0.0\n0.1\n0.1\n");
  const auto equal = read_times(folder / "times.txt");
  ASSERT_FALSE(equal);
  EXPECT_EQ(equal.error().where, (folder / "times.txt").string() + ":3");
  put_file(folder / "times.txt", "0.0 1\n");
  EXPECT_FALSE(read_times(folder / "times.txt"));
  put_file(folder / "times.txt", "");
  EXPECT_FALSE(read_times(folder / "times.txt"));
  EXPECT_FALSE(read_times(folder / "none"));
}

TEST(Times, DamagedFilesAreCleanlyReadOrRefused) {
  const ScratchFolder folder;
  const std::string valid = "0.000000e+00\n1.036224e-01\n2.072890e-01\n3.1\n";
  const auto read = [](const fs::path& path) {
    const auto times = read_times(path);
    EXPECT_TRUE(!times || std::is_sorted(times->begin(), times->end()));
    return times.has_value();
  };
  testing::shorter_files_taken(valid, folder / "t", read);
  EXPECT_GT(testing::damaged_files_refused(valid, folder / "t", read), 500);
}

constexpr const char* kMatrix =
    "  0.0e+000\t -1.0e+000\t  0.0e+000\t  1.5e+000\t\r\n"
    "  1.0e+000\t  0.0e+000\t  0.0e+000\t -2.0e+000\t\r\n"
    "  0.0e+000\t  0.0e+000\t  1.0e+000\t  3.0e+000\t\r\n"
    "  0.0e+000\t  0.0e+000\t  0.0e+000\t  1.0e+000\t\r\n";

TEST(PoseMatrix, ReadsWhat7ScenesWrites) {
  const ScratchFolder folder;
  const fs::path path = folder / "frame-000000.pose.txt";
  put_file(path, kMatrix);
  const auto pose = read_pose_matrix(path);
  ASSERT_TRUE(pose) << pose.error().message();
  EXPECT_EQ(pose->translation(), Eigen::Vector3d(1.5, -2.0, 3.0));
  EXPECT_LT((*pose * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(1.5, -1.0, 3.0)).norm(), 1e-12);
}

TEST(PoseMatrix, WhatIsNoPoseIsRefusedByName) {
  const ScratchFolder folder;
  const fs::path path = folder / "p.txt";
  const std::string last = "0 0 0 1\n";
  for (const std::string& text :
       {std::string(), std::string("1 0 0"), "1 0 0 0 0 1 0 0 0 0 1 nan " + last,
        "-inf 0 0 0 0 1 0 0 0 0 1 0 " + last, "-1.#IND 0 0 0 0 1 0 0 0 0 1 0 " + last,
        "0 0 0 0 0 0 0 0 0 0 0 0 " + last, "2 0 0 0 0 2 0 0 0 0 2 0 " + last,
        "1 0 0 0 0 1 0 0 0 0 -1 0 " + last, "1 0 0 0 0 1 0 0 0 0 1 0 " + last + "5",
        std::string("1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 0")}) {
    put_file(path, text);
    const auto pose = read_pose_matrix(path);
    ASSERT_FALSE(pose) << text;
    EXPECT_EQ(pose.error().where, path.string());
    EXPECT_FALSE(pose.error().remedy.empty());
  }
  EXPECT_EQ(read_pose_matrix(folder / "none.txt").error().code, ErrorCode::kNotFound);
}

TEST(PoseMatrix, DamagedFilesAreCleanlyReadOrRefused) {
  const ScratchFolder folder;
  const int refused =
      testing::damaged_files_refused(kMatrix, folder / "p.txt", [](const fs::path& path) {
        const auto pose = read_pose_matrix(path);
        EXPECT_TRUE(!pose || is_rigid(*pose));
        return pose.has_value();
      });
  EXPECT_GT(refused, 500);
}

}  // namespace
}  // namespace tread
