#include "tread/io/rgbd_source.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "rgbd_images.hpp"
#include "sample_images.hpp"
#include "test_data.hpp"
#include "tread/io/image_file.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;
using testing::colour_png;
using testing::depth_png;
using testing::make_png;
using testing::mentions;
using testing::put;
using testing::read_all;
using testing::RgbdRead;
using testing::ScratchFolder;

// The pose of a camera x metres along the x axis.
std::string pose_text(double x) {
  return "1 0 0 " + std::to_string(x) + "\r\n0 1 0 0\r\n0 0 1 0\r\n0 0 0 1\r\n";
}

std::string frame_name(int number) {
  const std::string digits = std::to_string(number);
  return "frame-" + std::string(6 - digits.size(), '0') + digits;
}

// Frames first, first + 1 ... of 7-Scenes, with a camera; depth is number + 1 metres.
void make_frames(const fs::path& folder, int count, int first = 0) {
  put(folder / "camera-intrinsics.txt", "5 0 2\n0 5 1\n0 0 1\n");
  for (int i = first; i < first + count; ++i) {
    put(folder / (frame_name(i) + ".depth.png"), depth_png(1000 * (i + 1)));
    put(folder / (frame_name(i) + ".color.png"), colour_png(static_cast<char>(i)));
    put(folder / (frame_name(i) + ".pose.txt"), pose_text(i));
  }
}

TEST(RgbdSource, SevenScenesFolderGivesItsFrames) {
  const ScratchFolder folder;
  make_frames(folder.path(), 3);
  const auto source = open_rgbd_source(folder.path());
  ASSERT_TRUE(source) << source.error().message();
  EXPECT_EQ((*source)->kind(), "7-Scenes or 3DMatch folder");
  EXPECT_EQ((*source)->frame_count(), 3);
  EXPECT_EQ((*source)->camera().pinhole.fx, 5.0);
  EXPECT_EQ((*source)->camera().size, (ImageSize{4, 3}));
  EXPECT_TRUE((*source)->has_poses());
  EXPECT_TRUE((*source)->problems().empty());
  const RgbdRead read = read_all(**source);
  ASSERT_EQ(read.taken, "xxx");
  for (int i = 0; i < 3; ++i) {
    const RgbdFrame& frame = read.frames[static_cast<std::size_t>(i)];
    EXPECT_EQ(frame.name, frame_name(i));
    EXPECT_TRUE(std::isnan(frame.depth(0, 0))) << "0 is unknown";
    EXPECT_TRUE(std::isnan(frame.depth(1, 0))) << "65535 is unknown";
    EXPECT_EQ(frame.depth(2, 0), static_cast<float>(i + 1));
    EXPECT_EQ(frame.depth(3, 2), static_cast<float>(i + 1));
    EXPECT_EQ(frame.grey(1, 1), i);
    EXPECT_EQ(frame.rgb(1, 1).g, i);
    ASSERT_TRUE(frame.T_world_camera);
    EXPECT_EQ(frame.T_world_camera->translation(), Eigen::Vector3d(i, 0, 0));
    EXPECT_EQ((*source)->truth().at(static_cast<std::size_t>(i)).stamp_ns, frame.stamp_ns);
  }
  EXPECT_FALSE((*source)->next().value()) << "the end stays the end";
}

TEST(RgbdSource, NumbersAre30HzExactly) {
  const ScratchFolder folder;
  make_frames(folder.path(), 4);
  for (const int number : {30, 150, 999999}) make_frames(folder.path(), 1, number);
  const auto source = open_rgbd_source(folder.path());
  ASSERT_TRUE(source) << source.error().message();
  std::vector<std::int64_t> stamps;
  for (const RgbdFrame& frame : read_all(**source).frames) stamps.push_back(frame.stamp_ns);
  EXPECT_EQ(stamps, (std::vector<std::int64_t>{0, 33333333, 66666667, 100000000, 1000000000,
                                               5000000000, 33333300000000}));
}

TEST(RgbdSource, ColourAndPoseAreOptionalAndJpegIsRead) {
  const ScratchFolder folder;
  put(folder / "camera-intrinsics.txt", "20 20 8 8");
  for (int i = 0; i < 3; ++i) {
    put(folder / (frame_name(i) + ".depth.png"), depth_png(2000, 16, 16));
  }
  put(folder / "frame-000001.color.jpg", testing::as_string(testing::kColourJpeg));
  put(folder / "frame-000002.color.png", make_png(16, 16, 8, 0, std::string(256, 'x')));
  const auto source = open_rgbd_source(folder.path());
  ASSERT_TRUE(source) << source.error().message();
  EXPECT_FALSE((*source)->has_poses());
  const RgbdRead read = read_all(**source);
  ASSERT_EQ(read.taken, "xxx");
  EXPECT_TRUE(read.frames[0].grey.empty());
  EXPECT_TRUE(read.frames[0].rgb.empty());
  EXPECT_FALSE(read.frames[0].T_world_camera);
  EXPECT_NEAR(read.frames[1].rgb(8, 8).r, 200, 5);
  EXPECT_EQ(read.frames[2].grey(8, 8), 'x');
  EXPECT_TRUE(read.frames[2].rgb.empty()) << "a grey image has no colour";
}

TEST(RgbdSource, ASceneGivesTheCameraOfItsSequences) {
  const ScratchFolder folder;
  make_frames(folder / "seq-01", 2);
  fs::rename(folder / "seq-01" / "camera-intrinsics.txt", folder / "camera-intrinsics.txt");
  for (const fs::path& path : {folder / "seq-01", folder / "seq-01" / "", folder.path()}) {
    EXPECT_TRUE(looks_like_rgbd(path));
    const auto source = open_rgbd_source(path);
    ASSERT_TRUE(source) << source.error().message();
    EXPECT_EQ((*source)->frame_count(), 2) << path;
    EXPECT_EQ((*source)->camera().pinhole.fx, 5.0) << path;
  }
  make_frames(folder / "seq-02", 2);
  const auto several = open_rgbd_source(folder.path());
  ASSERT_FALSE(several);
  EXPECT_TRUE(mentions(several.error(), "seq-01, seq-02")) << several.error().message();
}

TEST(RgbdSource, BadPosesCostOnlyThemselves) {
  const ScratchFolder folder;
  make_frames(folder.path(), 5);
  put(folder / "frame-000001.pose.txt", "1 0 0 nan 0 1 0 0 0 0 1 0 0 0 0 1");
  put(folder / "frame-000002.pose.txt", "-inf 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1");
  put(folder / "frame-000003.pose.txt", "2 0 0 0 0 2 0 0 0 0 2 0 0 0 0 1");
  const auto source = open_rgbd_source(folder.path());
  ASSERT_TRUE(source) << source.error().message();
  EXPECT_EQ((*source)->truth().size(), 2U);
  ASSERT_EQ((*source)->problems().size(), 3U);
  EXPECT_EQ((*source)->problems()[0].where, (folder / "frame-000001.pose.txt").string());
  EXPECT_TRUE(mentions((*source)->problems()[2], "not a rotation"));
  const RgbdRead read = read_all(**source);
  ASSERT_EQ(read.taken, "xxxxx");
  EXPECT_TRUE(read.frames[0].T_world_camera);
  for (const std::size_t i : {1U, 2U, 3U}) EXPECT_FALSE(read.frames[i].T_world_camera) << i;
  EXPECT_TRUE(read.frames[4].T_world_camera);
}

TEST(RgbdSource, BadImagesCostTheirFrames) {
  const ScratchFolder folder;
  make_frames(folder.path(), 8);
  const std::string whole = depth_png(1000);
  put(folder / "frame-000000.depth.png", depth_png(1000, 5, 3));
  put(folder / "frame-000001.depth.png", whole.substr(0, whole.size() / 2));
  put(folder / "frame-000002.depth.png", "no picture");
  fs::remove(folder / "frame-000003.depth.png");
  put(folder / "frame-000004.color.png", "no picture");
  put(folder / "frame-000005.depth.png", make_png(4, 3, 8, 0, std::string(12, 'x')));
  const auto source = open_rgbd_source(folder.path());
  ASSERT_TRUE(source) << source.error().message();
  EXPECT_EQ((*source)->frame_count(), 8);
  EXPECT_EQ((*source)->camera().size, (ImageSize{4, 3}));
  const RgbdRead read = read_all(**source);
  ASSERT_EQ(read.taken, "------xx");
  EXPECT_TRUE(mentions(read.errors[0], "5x3 pixels, but the camera has 4x3"));
  EXPECT_EQ(read.errors[1].code, ErrorCode::kUnreadable);
  EXPECT_TRUE(mentions(read.errors[3], "no depth image of this name"));
  const std::array<const char*, 6> named = {"0.depth.png", "1.depth.png", "2.depth.png",
                                            "3.color.png", "4.color.png", "5.depth.png"};
  for (std::size_t i = 0; i < named.size(); ++i) {
    EXPECT_EQ(read.errors[i].where, (folder / "frame-00000").string() + named[i]);
    EXPECT_FALSE(read.errors[i].remedy.empty());
  }
}

TEST(RgbdSource, ColourOfAnotherSizeIsLeftOutAndCountedOnce) {
  const ScratchFolder folder;
  make_frames(folder.path(), 4);
  for (const int i : {1, 2, 3}) {
    put(folder / (frame_name(i) + ".color.png"), colour_png(7, 8, 6));
  }
  const auto source = open_rgbd_source(folder.path());
  ASSERT_TRUE(source) << source.error().message();
  const RgbdRead read = read_all(**source);
  ASSERT_EQ(read.taken, "xxxx");
  EXPECT_FALSE(read.frames[0].grey.empty());
  EXPECT_TRUE(read.frames[2].grey.empty());
  EXPECT_TRUE(read.frames[2].rgb.empty());
  ASSERT_EQ((*source)->problems().size(), 1U);
  const Error& problem = (*source)->problems()[0];
  EXPECT_TRUE(mentions(problem, "8x6 pixels, but the depth image has 4x3")) << problem.message();
  EXPECT_TRUE(mentions(problem, "(and 2 more like it)")) << problem.message();
  EXPECT_EQ(problem.where, (folder / "frame-000001.color.png").string());
}

TEST(RgbdSource, OfTwoNamesWithOneNumberOneIsUsed) {
  const ScratchFolder folder;
  make_frames(folder.path(), 2);
  put(folder / "frame-1.depth.png", depth_png(9000));
  put(folder / "frame-.depth.png", "");
  put(folder / "frame-1234567890123456789012.depth.png", "");
  const auto source = open_rgbd_source(folder.path());
  ASSERT_TRUE(source) << source.error().message();
  EXPECT_EQ(read_all(**source).taken, "xx");
  ASSERT_EQ((*source)->problems().size(), 1U);
  EXPECT_EQ((*source)->problems()[0].where, (folder / "frame-1.depth.png").string());
}

TEST(RgbdSource, OptionsComeBeforeTheFolder) {
  const ScratchFolder folder;
  make_frames(folder / "in", 3);
  put(folder / "mine.txt", "7 7 2 1");
  put(folder / "path.tum", "0 9 0 0 0 0 0 1\n0.05 9 0 0 0 0 0 1\nwrong\n");
  const auto source =
      open_rgbd_source(folder / "in", {folder / "mine.txt", 500.0, folder / "path.tum"});
  ASSERT_TRUE(source) << source.error().message();
  EXPECT_EQ((*source)->camera().pinhole.fx, 7.0);
  EXPECT_EQ((*source)->truth().size(), 2U);
  ASSERT_EQ((*source)->problems().size(), 1U);
  EXPECT_EQ((*source)->problems()[0].where, (folder / "path.tum").string() + ":3");
  const RgbdRead read = read_all(**source);
  ASSERT_EQ(read.taken, "xxx");
  EXPECT_EQ(read.frames[0].depth(2, 0), 2.0F) << "1000 units at 500 per metre";
  EXPECT_EQ(read.frames[1].T_world_camera.value().translation().x(), 9.0);
  EXPECT_FALSE(read.frames[2].T_world_camera) << "0.067 s is behind the trajectory";

  const auto where_of = [&](const RgbdOptions& options) {
    const auto refused = open_rgbd_source(folder / "in", options);
    EXPECT_FALSE(refused);
    return refused ? std::string() : refused.error().where;
  };
  EXPECT_EQ(where_of({folder / "none.txt", 0.0, {}}), (folder / "none.txt").string());
  EXPECT_EQ(where_of({{}, 0.0, folder / "none.txt"}), (folder / "none.txt").string());
  put(folder / "path.tum", "wrong\n");
  EXPECT_EQ(where_of({{}, 0.0, folder / "path.tum"}), (folder / "path.tum").string() + ":1");
  EXPECT_EQ(where_of({{}, -1.0, {}}), (folder / "in").string());
  EXPECT_EQ(where_of({{}, std::nan(""), {}}), (folder / "in").string());
}

TEST(RgbdSource, WithoutACameraThatOf7ScenesIsAssumedForItsSizeOnly) {
  const ScratchFolder folder;
  put(folder / "frame-000000.depth.png", depth_png(1000));
  const auto other = open_rgbd_source(folder.path());
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().code, ErrorCode::kNotFound);
  EXPECT_TRUE(mentions(other.error(), "no camera is known for 4x3")) << other.error().message();
  EXPECT_TRUE(mentions(other.error(), "camera-intrinsics.txt"));
  ASSERT_TRUE(
      write_png(folder / "frame-000000.depth.png", Image<std::uint16_t>(640, 480, 1000).view()));
  const auto source = open_rgbd_source(folder.path());
  ASSERT_TRUE(source) << source.error().message();
  EXPECT_EQ((*source)->camera().pinhole.fx, 585.0);
  EXPECT_EQ((*source)->camera().pinhole.cy, 240.0);
  ASSERT_EQ((*source)->problems().size(), 1U);
  EXPECT_TRUE(mentions((*source)->problems()[0], "assumed is that of 7-Scenes"));
  put(folder / "camera.yaml", "fx: 5\n");
  EXPECT_FALSE(open_rgbd_source(folder.path())) << "a bad file is not passed over";
}

// ---- what is none of them

TEST(RgbdSource, WhatIsNoRgbdFolderIsToldWhatIs) {
  const ScratchFolder folder;
  const auto none = open_rgbd_source(folder.path());
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, ErrorCode::kNotFound);
  EXPECT_EQ(none.error().message(),
            folder.path().string() +
                ": no RGB-D images are found in it. Give a folder with frame-NNNNNN.depth.png "
                "(7-Scenes, 3DMatch), or with depth.txt (TUM RGB-D), or with a seq.txt that begins "
                "with 'K fx fy cx cy depth_scale width height'.");
  EXPECT_EQ(open_rgbd_source(folder / "no").error().what, "no such folder");
  put(folder / "some.txt", "Kalibr\n");
  EXPECT_EQ(open_rgbd_source(folder / "some.txt").error().code, ErrorCode::kUnsupported);
  put(folder / "seq.txt", "1 2 3\n");
  EXPECT_EQ(open_rgbd_source(folder.path()).error().code, ErrorCode::kNotFound);
  put(folder / "image_0" / "000000.png", "");
  for (const fs::path& path : {folder.path(), folder / "no", folder / "some.txt"}) {
    EXPECT_FALSE(looks_like_rgbd(path)) << path;
  }
}

TEST(RgbdSource, ReadsARealSequence) {
  TREAD_NEEDS_DATA(path, "rgbd_seq/3dmatch_tsdf_fusion50");
  const auto source = open_rgbd_source(path);
  ASSERT_TRUE(source) << source.error().message();
  EXPECT_EQ((*source)->kind(), "7-Scenes or 3DMatch folder");
  EXPECT_EQ((*source)->frame_count(), 25);
  EXPECT_EQ((*source)->camera().size, (ImageSize{640, 480}));
  EXPECT_EQ((*source)->camera().pinhole.fx, 585.0);
  EXPECT_EQ((*source)->camera().pinhole.fy, 585.0);
  EXPECT_EQ((*source)->camera().pinhole.cx, 320.0);
  EXPECT_EQ((*source)->camera().pinhole.cy, 240.0);
  const RgbdRead frames = read_all(**source);
  const auto list = open_rgbd_source(path / "seq.txt");
  ASSERT_TRUE(list) << list.error().message();
  const RgbdRead listed = read_all(**list);
  EXPECT_TRUE((*source)->problems().empty());
  EXPECT_TRUE((*list)->problems().empty());
  ASSERT_EQ(frames.taken, std::string(25, 'x'));
  ASSERT_EQ(listed.taken, std::string(25, 'x'));
  EXPECT_EQ(frames.frames[0].name, "frame-000150");
  EXPECT_EQ(frames.frames[0].stamp_ns, 5'000'000'000);
  for (std::size_t i = 0; i < 25; ++i) {
    const RgbdFrame& frame = frames.frames[i];
    const RgbdFrame& other = listed.frames[i];
    EXPECT_EQ(frame.name, other.name);
    EXPECT_EQ(frame.grey, other.grey);
    // The list has its times and poses to six and seven digits.
    EXPECT_NEAR(static_cast<double>(frame.stamp_ns - other.stamp_ns - 5'000'000'000), 0.0, 500.0);
    ASSERT_TRUE(frame.T_world_camera && other.T_world_camera);
    EXPECT_TRUE(frame.T_world_camera->isApprox(*other.T_world_camera, 1e-5));
    int known = 0;
    for (int y = 0; y < 480; ++y) {
      for (int x = 0; x < 640; ++x) {
        if (std::isnan(frame.depth(x, y))) continue;
        ++known;
        EXPECT_TRUE(frame.depth(x, y) > 0.3F && frame.depth(x, y) < 10.0F) << "of a Kinect";
      }
    }
    EXPECT_GT(known, 640 * 480 / 2);
  }
}

}  // namespace
}  // namespace tread
