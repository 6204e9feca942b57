// RGB-D images that are described by lists: TUM RGB-D, and seq.txt.
#include <gtest/gtest.h>

#include <cmath>

#include "file_mutations.hpp"
#include "rgbd_images.hpp"
#include "test_data.hpp"
#include "tread/io/image_file.hpp"
#include "tread/io/rgbd_source.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;
using testing::colour_png;
using testing::depth_png;
using testing::mentions;
using testing::put;
using testing::read_all;
using testing::RgbdRead;
using testing::ScratchFolder;

// ---- TUM

// Depth at 0.00, 0.05, 0.10 s after a start, of 1, 2, 3 m; colour 4 ms before, none, 20 ms behind.
void make_tum(const fs::path& folder) {
  put(folder / "camera.yaml", "fx: 5\nfy: 5\ncx: 2\ncy: 1\n");
  put(folder / "depth.txt",
      "# depth maps\n# timestamp filename\n1305031102.160407 depth/1305031102.160407.png\n"
      "1305031102.210407 depth/1305031102.210407.png\n"
      "1305031102.260407123 depth/1305031102.260407.png\n");
  put(folder / "depth" / "1305031102.160407.png", depth_png(5000));
  put(folder / "depth" / "1305031102.210407.png", depth_png(10000));
  put(folder / "depth" / "1305031102.260407.png", depth_png(15000));
  put(folder / "rgb.txt",
      "# color images\n1305031102.140407 rgb/far.png\n1305031102.156407 rgb/first.png\n"
      "1305031102.231 rgb/none.png\n1305031102.280407123 rgb/last.png\n");
  for (const char* name : {"far", "first", "none", "last"}) {
    put(folder / "rgb" / (std::string(name) + ".png"), colour_png(name[0]));
  }
}

TEST(RgbdLists, TumFolderPairsByTime) {
  const ScratchFolder folder;
  make_tum(folder.path());
  EXPECT_TRUE(looks_like_rgbd(folder.path()));
  const auto source = open_rgbd_source(folder.path());
  ASSERT_TRUE(source) << source.error().message();
  EXPECT_EQ((*source)->kind(), "TUM RGB-D folder");
  EXPECT_FALSE((*source)->has_poses());
  EXPECT_TRUE((*source)->problems().empty());
  const RgbdRead read = read_all(**source);
  ASSERT_EQ(read.taken, "xxx");
  EXPECT_EQ(read.frames[0].stamp_ns, 1305031102160407000);
  EXPECT_EQ(read.frames[2].stamp_ns, 1305031102260407123);
  EXPECT_EQ(read.frames[0].name, "1305031102.160407");
  EXPECT_TRUE(std::isnan(read.frames[0].depth(0, 0)));
  EXPECT_EQ(read.frames[0].depth(1, 0), 13.107F) << "65535 is a depth like others";
  EXPECT_EQ(read.frames[1].depth(2, 0), 2.0F);
  EXPECT_EQ(read.frames[0].grey(0, 0), 'f');
  EXPECT_TRUE(read.frames[1].grey.empty()) << "the nearest is 20.593 ms away";
  EXPECT_EQ(read.frames[2].grey(0, 0), 'l') << "20 ms are near enough";
}

TEST(RgbdLists, OneColourImageMayServeTwoDepthImages) {
  const ScratchFolder folder;
  make_tum(folder.path());
  put(folder / "depth.txt",
      "10.03 depth/1305031102.210407.png\n10.00 depth/1305031102.160407.png\n");
  put(folder / "rgb.txt", "-9000000000 rgb/far.png\n10.015 rgb/first.png\n9000000000 rgb/last.png");
  const auto source = open_rgbd_source(folder.path());
  ASSERT_TRUE(source) << source.error().message();
  const RgbdRead read = read_all(**source);
  ASSERT_EQ(read.taken, "xx");
  EXPECT_EQ(read.frames[0].stamp_ns, 10000000000) << "frames are in order of time";
  EXPECT_EQ(read.frames[0].grey(0, 0), 'f');
  EXPECT_EQ(read.frames[1].grey(0, 0), 'f');
}

TEST(RgbdLists, TumAssociationsAreTheFrames) {
  const ScratchFolder folder;
  make_tum(folder.path());
  put(folder / "assoc_rgb.txt",
      "1305031102.280407 rgb/last.png 1305031102.160407 depth/1305031102.160407.png\n"
      "1305031102.210407 depth/1305031102.210407.png 9 rgb/none.png\n"
      "1 a.png 2 b.png\n1 depth/a.png\n");
  const auto source = open_rgbd_source(folder.path());
  ASSERT_TRUE(source) << source.error().message();
  ASSERT_EQ((*source)->problems().size(), 2U);
  EXPECT_TRUE(mentions((*source)->problems()[0], "which of the two images is depth"));
  EXPECT_EQ((*source)->problems()[1].where, (folder / "assoc_rgb.txt").string() + ":4");
  const RgbdRead read = read_all(**source);
  ASSERT_EQ(read.taken, "xx");
  EXPECT_EQ(read.frames[0].stamp_ns, 1305031102160407000) << "the time of depth";
  EXPECT_EQ(read.frames[0].grey(0, 0), 'l') << "as the file says, however far";
  EXPECT_EQ(read.frames[1].grey(0, 0), 'n');
}

TEST(RgbdLists, TumTruthIsReadWhole) {
  const ScratchFolder folder;
  make_tum(folder.path());
  put(folder / "groundtruth.txt",
      "# ground truth\n1305031102.1 0 0 0 0 0 0 1\n1305031102.18 0.8 0 0 0 0 0 1\nbad line\n"
      "1305031102.22 1 0 0 0 0 0 1\n1305031102.4 1 0 0 0 0 0 1\n1305031109 1 0 0 0 0 0 1\n");
  const auto source = open_rgbd_source(folder.path());
  ASSERT_TRUE(source) << source.error().message();
  EXPECT_TRUE((*source)->has_poses());
  EXPECT_EQ((*source)->truth().size(), 5U);
  ASSERT_EQ((*source)->problems().size(), 1U);
  EXPECT_EQ((*source)->problems()[0].where, (folder / "groundtruth.txt").string() + ":4");
  const RgbdRead read = read_all(**source);
  ASSERT_EQ(read.taken, "xxx");
  EXPECT_NEAR(read.frames[0].T_world_camera.value().translation().x(), 0.60407, 1e-9);
  EXPECT_TRUE(read.frames[1].T_world_camera);
  EXPECT_FALSE(read.frames[2].T_world_camera) << "in a gap of 0.18 s";
  put(folder / "groundtruth.txt", "");
  const auto without = open_rgbd_source(folder.path());
  ASSERT_TRUE(without) << "bad poses of the folder do not cost the images";
  EXPECT_FALSE((*without)->has_poses());
  EXPECT_EQ((*without)->problems().size(), 1U);
}

TEST(RgbdLists, BadLinesAndImagesOfTumCostTheirFrames) {
  const ScratchFolder folder;
  make_tum(folder.path());
  put(folder / "depth.txt",
      "1 depth/1305031102.160407.png\nnow depth/1305031102.160407.png\n2\n"
      "3 depth/missing.png\n1 depth/1305031102.210407.png\n4 depth/\x01.png\n"
      "5 depth/1305031102.260407.png\n6 depth/1305031102.260407.png\n");
  put(folder / "rgb.txt", "5 rgb/missing.png\n6\n");
  const auto source = open_rgbd_source(folder.path());
  ASSERT_TRUE(source) << source.error().message();
  std::vector<std::string> where;
  for (const Error& problem : (*source)->problems()) where.push_back(problem.where);
  const std::string depth = (folder / "depth.txt").string();
  EXPECT_EQ(where, (std::vector<std::string>{depth + ":2", depth + ":3", depth + ":6", depth + ":5",
                                             (folder / "rgb.txt").string() + ":2"}));
  const RgbdRead read = read_all(**source);
  ASSERT_EQ(read.taken, "x--x");
  EXPECT_EQ(read.errors[0].where, (folder / "depth/missing.png").string());
  EXPECT_EQ(read.errors[1].where, (folder / "rgb/missing.png").string());
  for (const char* text : {"", "# nothing\n"}) {
    put(folder / "depth.txt", text);
    const auto empty = open_rgbd_source(folder.path());
    ASSERT_FALSE(empty);
    EXPECT_TRUE(mentions(empty.error(), "no depth image is listed"));
  }
  put(folder / "depth.txt", "what is this\n");
  EXPECT_EQ(open_rgbd_source(folder.path()).error().where, depth + ":1");
}

TEST(RgbdLists, TumCamerasAreKnownByTheFoldersName) {
  const ScratchFolder folder;
  make_tum(folder / "tum");
  fs::remove(folder / "tum" / "camera.yaml");
  put(folder / "tum" / "depth.txt", "1 depth/a.png\n");
  ASSERT_TRUE(write_png(folder / "tum/depth/a.png", Image<std::uint16_t>(640, 480, 5000).view()));
  fs::path before = folder / "tum";
  const auto named = [&](const std::string& name) {
    fs::rename(before, folder / name);
    before = folder / name;
    return open_rgbd_source(before / "");
  };
  struct Case {
    const char* name;
    double fx;
  };
  for (const Case& c :
       {Case{"rgbd_dataset_freiburg1_desk", 517.3}, Case{"Freiburg2", 520.9},
        Case{"tum-fr3-office", 535.4}, Case{"fr1_xyz", 517.3}, Case{"fr2desk", 520.9}}) {
    const auto source = named(c.name);
    ASSERT_TRUE(source) << source.error().message();
    EXPECT_EQ((*source)->camera().pinhole.fx, c.fx) << c.name;
    EXPECT_TRUE((*source)->problems().empty()) << c.name;
  }
  for (const char* name : {"office", "afr1", "fr12"}) {
    const auto source = named(name);
    ASSERT_TRUE(source) << source.error().message();
    EXPECT_EQ((*source)->camera().pinhole.fx, 525.0) << name;
    EXPECT_EQ((*source)->camera().pinhole.cx, 319.5) << name;
    ASSERT_EQ((*source)->problems().size(), 1U) << name;
    EXPECT_TRUE(mentions((*source)->problems()[0], "assumed is ROS's default"));
  }
  put(before / "camera-intrinsics.txt", "500 500 320 240");
  const auto own = named("freiburg1");
  ASSERT_TRUE(own) << own.error().message();
  EXPECT_EQ((*own)->camera().pinhole.fx, 500.0) << "a file comes before the name";
}

// ---- seq.txt

constexpr const char* kHead = "K 5 6 2 1 1000 4 3\n";

void make_list(const fs::path& folder, const std::string& lines) {
  put(folder / "seq.txt", kHead + lines);
  put(folder / "d" / "a.depth.png", depth_png(1500));
  put(folder / "d" / "b.png", depth_png(2500));
  put(folder / "c.png", colour_png('c'));
}

TEST(RgbdLists, AListBringsEverything) {
  const ScratchFolder folder;
  make_list(folder.path(),
            "0.5 d/b.png - 1 2 3 0 0 0 2\n0.033333 d/a.depth.png c.png 0 0 0 0 0 0 1\n"
            "0.6 d/b.png c.png\n");
  for (const fs::path& path : {folder.path(), folder / "seq.txt"}) {
    EXPECT_TRUE(looks_like_rgbd(path));
    const auto source = open_rgbd_source(path);
    ASSERT_TRUE(source) << source.error().message();
    EXPECT_EQ((*source)->kind(), "list of RGB-D images");
    EXPECT_EQ((*source)->camera().pinhole.fy, 6.0);
    EXPECT_EQ((*source)->camera().size, (ImageSize{4, 3}));
    EXPECT_EQ((*source)->truth().size(), 2U);
    EXPECT_TRUE((*source)->problems().empty());
    const RgbdRead read = read_all(**source);
    ASSERT_EQ(read.taken, "xxx");
    EXPECT_EQ(read.frames[0].stamp_ns, 33333000);
    EXPECT_EQ(read.frames[0].name, "a");
    EXPECT_EQ(read.frames[0].depth(2, 0), 1.5F);
    EXPECT_TRUE(std::isnan(read.frames[0].depth(1, 0)));
    EXPECT_EQ(read.frames[0].grey(0, 0), 'c');
    EXPECT_TRUE(read.frames[1].grey.empty());
    EXPECT_EQ(read.frames[1].T_world_camera.value().translation(), Eigen::Vector3d(1, 2, 3));
    EXPECT_FALSE(read.frames[2].T_world_camera);
  }
}

TEST(RgbdLists, BadLinesOfAList) {
  const ScratchFolder folder;
  make_list(folder.path(),
            "0 d/b.png - 1 2 3 0 0 0 1\n1 d/b.png - nan 2 3 0 0 0 1\n2 d/b.png - 1 2 3 0 0 0 0\n"
            "3 d/b.png - 1 2\nx d/b.png -\n1 d/b.png -\n4 d/none.png -\n");
  const auto source = open_rgbd_source(folder.path());
  ASSERT_TRUE(source) << source.error().message();
  std::vector<std::string> lines;
  for (const Error& problem : (*source)->problems()) {
    lines.push_back(problem.where.substr(problem.where.rfind(':')));
  }
  EXPECT_EQ(lines, (std::vector<std::string>{":3", ":4", ":5", ":6", ":7"}));
  const RgbdRead read = read_all(**source);
  EXPECT_EQ(read.taken, "xxx-");
  EXPECT_TRUE(read.frames.at(0).T_world_camera);
  EXPECT_FALSE(read.frames.at(1).T_world_camera);
  for (const char* head :
       {"K 5 6 2 1 1000 4", "K 5 6 2 1 0 4 3", "K 5 6 2 1 1e300 4 3", "K 5 6 2 x 1000 4 3",
        "K 0 6 2 1 1000 4 3", "K 5 6 2 1 1000 -4 3", "K 5 6 2 1 1000 4.5 3", "K"}) {
    put(folder / "seq.txt", std::string(head) + "\n0 d/b.png -\n");
    const auto refused = open_rgbd_source(folder.path());
    ASSERT_FALSE(refused) << head;
    EXPECT_FALSE(refused.error().remedy.empty());
  }
  put(folder / "seq.txt", kHead);
  EXPECT_TRUE(mentions(open_rgbd_source(folder.path()).error(), "no depth image is listed"));
}

TEST(RgbdLists, DamagedListsAreCleanlyReadOrRefused) {
  const ScratchFolder folder;
  make_list(folder.path(), "");
  const auto reads = [&](const fs::path&) {
    const auto source = open_rgbd_source(folder.path());
    if (!source) return false;
    const int frames = static_cast<int>(read_all(**source).taken.size());
    EXPECT_EQ(frames, (*source)->frame_count());
    return frames == 2 && (*source)->problems().empty();
  };
  const std::string list =
      std::string(kHead) + "0 d/b.png - 1 2 3 0 0 0 1\n1.5 d/a.depth.png c.png 1 2 3 0 0 0 1\n";
  EXPECT_GT(testing::damaged_files_refused(list, folder / "seq.txt", reads), 300);
  fs::remove(folder / "seq.txt");
  put(folder / "camera.yaml", "fx: 5\nfy: 5\ncx: 2\ncy: 1\n");
  const std::string depths = "1.5 d/a.depth.png\n2.5 d/b.png\n";
  put(folder / "rgb.txt", "2.5 c.png\n");
  EXPECT_GT(testing::damaged_files_refused(depths, folder / "depth.txt", reads), 300);
}

}  // namespace
}  // namespace tread
