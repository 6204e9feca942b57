#include "tread/io/rgbd_camera.hpp"

#include <gtest/gtest.h>

#include "file_mutations.hpp"
#include "test_data.hpp"
#include "tread/io/rig_file.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;
using testing::put_file;
using testing::ScratchFolder;

Result<RgbdCamera> read_text(const std::string& text) {
  const ScratchFolder folder;
  put_file(folder / "camera", text);
  return read_rgbd_camera(folder / "camera");
}

TEST(RgbdCamera, EveryFormGivesTheSameCamera) {
  for (const char* text : {
           "500 501 320.5 240.25",
           "# fx fy cx cy\n500 501\r\n320.5 240.25\n",
           "5.0e+002\t0\t320.5\t\n0\t5.01e+002\t240.25\n0 0 1\n",
           "fx: 500\nfy: 501\ncx: 320.5\ncy: 240.25\n",
           "camera_matrix: {rows: 3, cols: 3, data: [500, 0, 320.5, 0, 501, 240.25, 0, 0, 1]}\n",
           "K: [500, 0, 320.5, 0, 501, 240.25, 0, 0, 1]\nD: [0, 0, 0, 0, 0]\n",
       }) {
    const auto camera = read_text(text);
    ASSERT_TRUE(camera) << text << camera.error().message();
    EXPECT_EQ(camera->pinhole.fx, 500.0) << text;
    EXPECT_EQ(camera->pinhole.fy, 501.0) << text;
    EXPECT_EQ(camera->pinhole.cx, 320.5) << text;
    EXPECT_EQ(camera->pinhole.cy, 240.25) << text;
    EXPECT_EQ(camera->pinhole.skew, 0.0) << text;
    EXPECT_EQ(camera->size, ImageSize{}) << text;
  }
}

TEST(RgbdCamera, YamlMayNameTheSize) {
  const auto plain = read_text("fx: 5\nfy: 5\ncx: 2\ncy: 1\nwidth: 4\nheight: 3\n");
  ASSERT_TRUE(plain) << plain.error().message();
  EXPECT_EQ(plain->size, (ImageSize{4, 3}));
  const auto ros = read_text(
      "image_width: 4\nimage_height: 3\ncamera_name: depth\n"
      "camera_matrix: {rows: 3, cols: 3, data: [5, 0, 2, 0, 5, 1, 0, 0, 1]}\n"
      "distortion_model: plumb_bob\n"
      "distortion_coefficients: {rows: 1, cols: 5, data: [0, 0, 0, 0, 0]}\n");
  ASSERT_TRUE(ros) << ros.error().message();
  EXPECT_EQ(ros->size, (ImageSize{4, 3}));
}

TEST(RgbdCamera, ARigGivesItsLeftCamera) {
  const ScratchFolder folder;
  StereoRig rig;
  rig.name = "mine";
  rig.size = {4, 3};
  rig.left = PinholeCamera{5, 6, 2, 1, 0};
  rig.right = PinholeCamera{7, 7, 2, 1, 0};
  rig.T_left_right.translation().x() = 0.1;
  ASSERT_TRUE(write_rig(folder / "rig.yaml", rig));
  const auto camera = read_rgbd_camera(folder / "rig.yaml");
  ASSERT_TRUE(camera) << camera.error().message();
  EXPECT_EQ(camera->pinhole.fx, 5.0);
  EXPECT_EQ(camera->pinhole.fy, 6.0);
  EXPECT_EQ(camera->size, (ImageSize{4, 3}));
  BrownCamera brown;
  brown.pinhole = PinholeCamera{5, 6, 2, 1, 0};
  brown.K[0] = -0.1;
  rig.left = brown;
  ASSERT_TRUE(write_rig(folder / "rig.yaml", rig));
  EXPECT_EQ(read_rgbd_camera(folder / "rig.yaml").error().code, ErrorCode::kUnsupported);
}

TEST(RgbdCamera, RefusalsSayWhereAndWhatToDo) {
  struct Case {
    const char* text;
    const char* named;  // in the message
  };
  for (const Case& c : {
           Case{"", "empty"},
           {"# nothing\n", "empty"},
           {"500 500 320", "3 numbers instead of 4 or 9"},
           {"500 500 320 240 0", "5 numbers"},
           {"500 0 320\n0 500 24o\n0 0 1", "camera:2: '24o' is not a number"},
           {"500 0 320\n0 500 240\n0 0 2", "not the matrix"},
           {"500 9 320\n9 500 240\n0 0 1", "not the matrix"},
           {"0 500 320 240", "focal length is 0"},
           {"500 -500 320 240", "focal length is negative"},
           {"500 nan 320 240", "not a finite number"},
           {"hello", "camera"},
           {"fx: 500\nfy: 500\ncx: 320\n", "'cy' is missing"},
           {"fx: 500\nfy: 500\ncx: 320\ncy: 240\nwidht: 4\n", "widht"},
           {"fx: 500\nfy: 500\ncx: 320\ncy: 240\nwidth: 4\n", "both width and height"},
           {"fx: 500\nfy: 500\ncx: 320\ncy: 240\nwidth: 0\nheight: 3\n", "0 is not a size"},
           {"K: [500, 0, 320, 0, 500, 240, 0, 0, 1]\nD: [0.1, 0, 0, 0, 0]\n", "distortion"},
           {"K: [500, 0, 320]\n", "K"},
       }) {
    const auto camera = read_text(c.text);
    ASSERT_FALSE(camera) << c.text;
    EXPECT_NE(camera.error().message().find(c.named), std::string::npos)
        << camera.error().message();
    EXPECT_FALSE(camera.error().remedy.empty()) << c.text;
  }
}

TEST(RgbdCamera, DamagedFilesAreCleanlyReadOrRefused) {
  const ScratchFolder folder;
  const auto reads = [](const fs::path& path) {
    const auto camera = read_rgbd_camera(path);
    EXPECT_TRUE(!camera || (camera->pinhole.fx > 0.0 && camera->size.width >= 0));
    return camera.has_value();
  };
  EXPECT_GT(testing::damaged_files_refused("585 0 320\n0 585 240\n0 0 1\n", folder / "c", reads),
            300);
  EXPECT_GT(testing::damaged_files_refused("fx: 5\nfy: 5\ncx: 2\ncy: 1\nwidth: 4\nheight: 3\n",
                                           folder / "c", reads),
            300);
}

}  // namespace
}  // namespace tread
