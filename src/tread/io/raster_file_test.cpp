// What is read and written. What is refused: raster_file_errors_test.cpp.
#include "tread/io/raster_file.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "file_mutations.hpp"
#include "test_data.hpp"
#include "tiff_maker.hpp"

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

TEST(GeoTiff, RoundTripIsEqualToTheBit) {
  const ScratchFolder folder;
  for (const auto& [columns, rows] : {std::pair{1, 1}, {67, 41}, {1000, 300}, {1, 70000}}) {
    const Grid<float> grid = random_grid(columns, rows);
    ASSERT_TRUE(write_geotiff(folder / "a.tif", grid));
    const auto read = read_geotiff(folder / "a.tif");
    ASSERT_TRUE(read) << read.error().message();
    EXPECT_TRUE(same_bits(read->values, grid.values)) << columns << " x " << rows;
    EXPECT_EQ(read->geometry.columns, columns);
    EXPECT_EQ(read->geometry.rows, rows);
    EXPECT_EQ(read->geometry.resolution_m, 0.1);
    EXPECT_LT((read->geometry.origin - grid.geometry.origin).norm(), 1e-11);
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 1) << "something was left";
}

TEST(GeoTiff, TheFirstRowOfTheFileIsTheLargestY) {
  const ScratchFolder folder;
  put_file(folder / "a.tif", small_geotiff().make({kSixPixels}));
  const auto read = read_geotiff(folder / "a.tif");
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(read->geometry.origin, Eigen::Vector2d(10.0, 19.0));
  EXPECT_EQ(read->geometry.resolution_m, 0.5);
  EXPECT_EQ((*read)[(Cell{0, 1})], 1.0F);
  EXPECT_EQ((*read)[(Cell{2, 0})], 6.0F);
}

TEST(GeoTiff, TiePointsOfPixelCentresAndOfOtherPixelsAreUnderstood) {
  const ScratchFolder folder;
  TiffMaker maker = small_geotiff();
  maker.set_short(34735, {1, 1, 0, 2, 1024, 0, 1, 32767, 1025, 0, 1, 2});  // pixel is point
  put_file(folder / "a.tif", maker.make({kSixPixels}));
  EXPECT_EQ(read_geotiff(folder / "a.tif").value().geometry.origin, Eigen::Vector2d(9.75, 19.25));
  TiffMaker other = small_geotiff();
  other.set_double(33922, {0, 2, 0, 10, 20, 0});  // the lower left corner
  put_file(folder / "b.tif", other.make({kSixPixels}));
  EXPECT_EQ(read_geotiff(folder / "b.tif").value().geometry.origin, Eigen::Vector2d(10.0, 20.0));
}

TEST(GeoTiff, AnotherNoDataValueBecomesNaN) {
  const ScratchFolder folder;
  for (const char* text : {"5", " 5.0 "}) {
    TiffMaker maker = small_geotiff();
    maker.set_text(42113, text);
    put_file(folder / "a.tif", maker.make({kSixPixels}));
    const auto read = read_geotiff(folder / "a.tif");
    ASSERT_TRUE(read) << read.error().message();
    EXPECT_TRUE(std::isnan((*read)[(Cell{1, 0})]));
    EXPECT_EQ((*read)[(Cell{0, 0})], 4.0F);
  }
  for (const char* text : {"nan", "1e300", "nonsense", ""}) {
    TiffMaker maker = small_geotiff();
    maker.set_text(42113, text);
    put_file(folder / "a.tif", maker.make({kSixPixels}));
    const auto read = read_geotiff(folder / "a.tif");
    ASSERT_TRUE(read) << read.error().message();
    EXPECT_EQ((*read)[(Cell{1, 0})], 5.0F) << text;
  }
}

TEST(GeoTiff, ReadsSeveralStripsAndTiles) {
  const ScratchFolder folder;
  TiffMaker strips = small_geotiff();
  strips.set_long(278, {1});
  put_file(folder / "s.tif", strips.make({kSixPixels.substr(0, 12), kSixPixels.substr(12)}));
  EXPECT_EQ(read_geotiff(folder / "s.tif").value()[(Cell{1, 1})], 2.0F);
  // Two tiles of 16 x 16 side by side, 20 x 3 pixels of them in use.
  TiffMaker tiles(20, 3);
  tiles.drop(278);
  tiles.set_long(322, {16});
  tiles.set_long(323, {16});
  std::vector<std::string> parts;
  for (int tile = 0; tile < 2; ++tile) {
    std::vector<float> values;
    for (int y = 0; y < 16; ++y) {
      for (int x = 0; x < 16; ++x) values.push_back(static_cast<float>(100 * y + 16 * tile + x));
    }
    parts.push_back(packed(values));
  }
  put_file(folder / "t.tif", tiles.make(parts, true));
  const auto read = read_tiff(folder / "t.tif");
  ASSERT_TRUE(read) << read.error().message();
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 20; ++x) EXPECT_EQ((*read)(x, y), static_cast<float>(100 * y + x));
  }
}

TEST(Tiff, ImagesRoundTripFirstRowFirst) {
  const ScratchFolder folder;
  Image<float> image(31, 9);
  for (int y = 0; y < 9; ++y) {
    for (int x = 0; x < 31; ++x)
      image(x, y) = static_cast<float>(x) + 0.001F * static_cast<float>(y);
  }
  image(3, 2) = std::numeric_limits<float>::quiet_NaN();
  ASSERT_TRUE(write_tiff(folder / "d.tif", image));
  const auto read = read_tiff(folder / "d.tif");
  ASSERT_TRUE(read) << read.error().message();
  ASSERT_TRUE(same_size(*read, image));
  for (int y = 0; y < 9; ++y) {
    EXPECT_EQ(std::memcmp(read->row(y), image.row(y), 31 * sizeof(float)), 0) << y;
  }
  EXPECT_EQ(read_geotiff(folder / "d.tif").error().code, ErrorCode::kBadFormat);
}

}  // namespace
}  // namespace tread
