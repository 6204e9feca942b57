// Raster files that are refused, damaged or cannot be written.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cmath>
#include <csignal>

#include "file_mutations.hpp"
#include "test_data.hpp"
#include "tiff_maker.hpp"
#include "tread/io/atomic_file.hpp"
#include "tread/io/raster_file.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;
using testing::kSixPixels;
using testing::packed;
using testing::put_file;
using testing::random_grid;
using testing::same_bits;
using testing::ScratchFolder;
using testing::small_geotiff;
using testing::TiffMaker;

TEST(GeoTiff, WhatIsNotReadIsNamedWithARemedy) {
  const ScratchFolder folder;
  struct Case {
    const char* what;
    ErrorCode code;
    std::function<void(TiffMaker&)> change;
  };
  const std::vector<Case> cases = {
      {"3 bands", ErrorCode::kUnsupported,
       [](TiffMaker& m) {
         m.set_short(277, {3});
         m.set_short(258, {32, 32, 32});
         m.set_short(339, {3, 3, 3});
       }},
      {"not float32", ErrorCode::kUnsupported, [](TiffMaker& m) { m.set_short(339, {1}); }},
      {"64 bits", ErrorCode::kUnsupported, [](TiffMaker& m) { m.set_short(258, {64}); }},
      {"top left", ErrorCode::kUnsupported, [](TiffMaker& m) { m.set_short(274, {3}); }},
      {"compression", ErrorCode::kUnsupported, [](TiffMaker& m) { m.set_short(259, {50000}); }},
      {"more than its bytes", ErrorCode::kUnreadable,
       [](TiffMaker& m) { m.set_long(256, {4000000000U}); }},
      {"more than its bytes", ErrorCode::kUnreadable,
       [](TiffMaker& m) {
         m.set_long(256, {100000});
         m.set_long(257, {100000});
       }},
      {"no place", ErrorCode::kBadFormat, [](TiffMaker& m) { m.drop(33550); }},
      {"no place", ErrorCode::kBadFormat, [](TiffMaker& m) { m.drop(33922); }},
      {"no place", ErrorCode::kBadFormat, [](TiffMaker& m) { m.set_text(33922, "here"); }},
      {"do not run along x", ErrorCode::kUnsupported,
       [](TiffMaker& m) { m.set_double(34264, std::vector<double>(16, 0.5)); }},
      {"do not run along x", ErrorCode::kUnsupported,
       [](TiffMaker& m) { m.set_double(33922, std::vector<double>(12, 0.5)); }},
      {"not square", ErrorCode::kUnsupported,
       [](TiffMaker& m) {
         m.set_double(33550, {0.5, 0.6, 0});
       }},
      {"not finite", ErrorCode::kBadValue,
       [](TiffMaker& m) {
         m.set_double(33550, {-1, -1, 0});
       }},
      {"not finite", ErrorCode::kBadValue,
       [](TiffMaker& m) {
         m.set_double(33550, {NAN, 1, 0});
       }},
      {"not finite", ErrorCode::kBadValue,
       [](TiffMaker& m) {
         m.set_double(33922, {0, 0, 0, INFINITY, 0, 0});
       }},
      {"not finite", ErrorCode::kBadValue,
       [](TiffMaker& m) {
         m.set_double(33922, {1e300, 0, 0, 1e300, 0, 0});
         m.set_double(33550, {1e300, 1e300, 0});
       }},
  };
  for (const Case& c : cases) {
    TiffMaker maker = small_geotiff();
    c.change(maker);
    put_file(folder / "a.tif", maker.make({kSixPixels}));
    const auto read = read_geotiff(folder / "a.tif");
    ASSERT_FALSE(read) << c.what;
    EXPECT_EQ(read.error().code, c.code) << read.error().message();
    EXPECT_NE(read.error().what.find(c.what), std::string::npos) << read.error().message();
    EXPECT_EQ(read.error().where, (folder / "a.tif").string());
    EXPECT_FALSE(read.error().remedy.empty());
  }
}

TEST(GeoTiff, LibtiffsMessageIsInTheErrorAndNotOnTheScreen) {
  const ScratchFolder folder;
  ::testing::internal::CaptureStderr();
  put_file(folder / "a.tif", "this is no TIFF file");
  const auto read = read_geotiff(folder / "a.tif");
  ASSERT_FALSE(read);
  EXPECT_NE(read.error().what.find("Not a TIFF"), std::string::npos) << read.error().message();
  // A strip too short for its rows, for which libtiff would take what stands behind it.
  put_file(folder / "b.tif", small_geotiff().make({kSixPixels.substr(0, 10)}) + "more bytes here");
  const auto cut = read_geotiff(folder / "b.tif");
  ASSERT_FALSE(cut);
  EXPECT_NE(cut.error().what.find("StripByteCounts"), std::string::npos) << cut.error().message();
  // Damaged packed data.
  ASSERT_TRUE(write_geotiff(folder / "d.tif", random_grid(50, 50)));
  std::string bytes = testing::get_file(folder / "d.tif");
  for (std::size_t i = 100; i < 200; ++i) bytes[i] = '\xff';
  put_file(folder / "d.tif", bytes);
  const auto damaged = read_geotiff(folder / "d.tif");
  ASSERT_FALSE(damaged);
  EXPECT_EQ(damaged.error().code, ErrorCode::kUnreadable);
  EXPECT_NE(damaged.error().what.find("row "), std::string::npos) << damaged.error().message();
  // Unknown tags make libtiff warn.
  TiffMaker unknown = small_geotiff();
  unknown.set_short(60000, {1, 2, 3});
  put_file(folder / "c.tif", unknown.make({kSixPixels}));
  EXPECT_TRUE(read_geotiff(folder / "c.tif"));
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
}

TEST(GeoTiff, HugeTilesAreRefused) {
  const ScratchFolder folder;
  TiffMaker maker(3, 2);
  maker.drop(278);
  maker.set_long(322, {1U << 20U});
  maker.set_long(323, {1U << 20U});
  put_file(folder / "a.tif", maker.make({kSixPixels}, true));
  const auto read = read_tiff(folder / "a.tif");
  ASSERT_FALSE(read);
  EXPECT_NE(read.error().what.find("tiles"), std::string::npos);
}

TEST(GeoTiff, GridsThatCannotBeWrittenAreRefused) {
  const ScratchFolder folder;
  const auto code = [&](const Grid<float>& grid) {
    const Status status = write_geotiff(folder / "a.tif", grid);
    return status ? ErrorCode::kUnsupported : status.error().code;
  };
  EXPECT_EQ(code(Grid<float>()), ErrorCode::kBadArgument);
  Grid<float> grid = random_grid(3, 2);
  grid.values.pop_back();
  EXPECT_EQ(code(grid), ErrorCode::kBadArgument);
  grid = random_grid(3, 2);
  grid.geometry.resolution_m = 0.0;
  EXPECT_EQ(code(grid), ErrorCode::kBadArgument);
  grid.geometry.resolution_m = 1.0;
  grid.geometry.origin.x() = NAN;
  EXPECT_EQ(code(grid), ErrorCode::kBadArgument);
  EXPECT_FALSE(write_tiff(folder / "a.tif", Image<float>()));
  EXPECT_TRUE(fs::is_empty(folder.path()));
  const Status nowhere = write_geotiff(folder / "no" / "a.tif", random_grid(3, 2));
  ASSERT_FALSE(nowhere);
  EXPECT_EQ(nowhere.error().code, ErrorCode::kWriteFailed);
  EXPECT_EQ(nowhere.error().where, (folder / "no" / "a.tif").string());
  EXPECT_EQ(read_geotiff(folder / "none").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(read_geotiff(folder.path()).error().code, ErrorCode::kUnreadable);
}

TEST(GeoTiff, MessagesNameTheFileOfASetAndNoTemporaryName) {
  FileSet set("/nowhere");
  const Status geotiff = write_geotiff(set.add("height.tif"), Grid<float>({1.0, {0.0, 0.0}, 2, 2}));
  ASSERT_FALSE(geotiff);
  EXPECT_EQ(geotiff.error().message(),
            "/nowhere/height.tif: cannot be created (No such file or directory). Check that the "
            "folder exists, is writable and has space.");
  const Status text = write_file(set.add("path.csv"), "x");
  ASSERT_FALSE(text);
  EXPECT_EQ(text.error().where, "/nowhere/path.csv");
  EXPECT_EQ(final_path("a/.tread-0123456789abcdef-b"), "a/b");
  for (const char* other :
       {"a/.tread-0123456789abcdef-", "a/.tread-0123456789abcdeX-b", "a/b", ""}) {
    EXPECT_EQ(final_path(other), other);
  }
}

TEST(GeoTiff, AFullDiskLeavesTheOldFile) {
  const ScratchFolder folder;
  const Grid<float> old = random_grid(3, 2);
  ASSERT_TRUE(write_geotiff(folder / "a.tif", old));
  auto* const old_handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit limit{};
  getrlimit(RLIMIT_FSIZE, &limit);
  rlimit small = limit;
  small.rlim_cur = 10000;
  setrlimit(RLIMIT_FSIZE, &small);
  const Status status = write_geotiff(folder / "a.tif", random_grid(300, 200));
  setrlimit(RLIMIT_FSIZE, &limit);
  std::signal(SIGXFSZ, old_handler);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, ErrorCode::kWriteFailed);
  EXPECT_EQ(status.error().where, (folder / "a.tif").string());
  const auto read = read_geotiff(folder / "a.tif");
  ASSERT_TRUE(read);
  EXPECT_TRUE(same_bits(read->values, old.values));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 1) << "something was left";
}

TEST(Tiff, DamagedFilesAreCleanlyReadOrRefused) {
  const ScratchFolder folder;
  ASSERT_TRUE(write_geotiff(folder / "valid.tif", random_grid(13, 11)));
  const auto read = [](const fs::path& path) { return read_geotiff(path).has_value(); };
  TiffMaker tiles(5, 5);
  tiles.drop(278);
  tiles.set_long(322, {16});
  tiles.set_long(323, {16});
  tiles.set_double(33550, {0.5, 0.5, 0.0});
  tiles.set_double(33922, {0, 0, 0, 10, 20, 0});
  for (const std::string& valid :
       {testing::get_file(folder / "valid.tif"), small_geotiff().make({kSixPixels}),
        tiles.make({std::string(1024, 'x')}, true)}) {
    put_file(folder / "a.tif", valid);
    ASSERT_TRUE(read(folder / "a.tif"));
    EXPECT_EQ(testing::shorter_files_taken(valid, folder / "a.tif", read), 0);
    EXPECT_GT(testing::damaged_files_refused(valid, folder / "a.tif", read), 300);
  }
}

}  // namespace
}  // namespace tread
