#include "tread/io/raster_file.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <bit>
#include <cmath>
#include <csignal>
#include <cstring>
#include <map>
#include <random>

#include "file_mutations.hpp"
#include "test_data.hpp"
#include "tread/io/atomic_file.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;
using testing::put_file;
using testing::ScratchFolder;

constexpr int kShort = 3, kLong = 4, kDouble = 12, kAscii = 2;

template <class T>
std::string packed(const std::vector<T>& values) {
  std::string bytes(values.size() * sizeof(T), '\0');
  if (!bytes.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

// A little-endian TIFF written from the specification, without libtiff: one strip or tile after
// another right behind the head, then the directory.
class TiffMaker {
 public:
  TiffMaker(std::uint32_t width, std::uint32_t height) {
    set_long(256, {width});
    set_long(257, {height});
    set_short(258, {32});     // bits
    set_short(259, {1});      // not compressed
    set_short(262, {1});      // black is zero
    set_short(277, {1});      // bands
    set_short(339, {3});      // floating point
    set_long(278, {height});  // rows a strip
  }
  void set_short(int tag, const std::vector<std::uint16_t>& v) {
    tags_[tag] = {kShort, v.size(), packed(v)};
  }
  void set_long(int tag, const std::vector<std::uint32_t>& v) {
    tags_[tag] = {kLong, v.size(), packed(v)};
  }
  void set_double(int tag, const std::vector<double>& v) {
    tags_[tag] = {kDouble, v.size(), packed(v)};
  }
  void set_text(int tag, const std::string& text) {
    tags_[tag] = {kAscii, text.size() + 1, text + '\0'};
  }
  void drop(int tag) { tags_.erase(tag); }
  // The pixels, by strips (tags 273, 279) or by tiles (324, 325).
  std::string make(const std::vector<std::string>& parts, bool tiled = false) {
    std::vector<std::uint32_t> places, sizes;
    std::string body;
    for (const std::string& part : parts) {
      places.push_back(static_cast<std::uint32_t>(8 + body.size()));
      sizes.push_back(static_cast<std::uint32_t>(part.size()));
      body += part;
    }
    set_long(tiled ? 324 : 273, places);
    set_long(tiled ? 325 : 279, sizes);
    if (body.size() % 2 != 0) body += '\0';
    const std::size_t directory = 8 + body.size();
    const std::size_t values_at = directory + 2 + 12 * tags_.size() + 4;
    std::string entries, values;
    for (const auto& [tag, field] : tags_) {
      entries += packed<std::uint16_t>(
          {static_cast<std::uint16_t>(tag), static_cast<std::uint16_t>(field.type)});
      entries += packed<std::uint32_t>({static_cast<std::uint32_t>(field.count)});
      if (field.bytes.size() <= 4) {
        entries += field.bytes + std::string(4 - field.bytes.size(), '\0');
      } else {
        entries += packed<std::uint32_t>({static_cast<std::uint32_t>(values_at + values.size())});
        values += field.bytes + std::string(field.bytes.size() % 2, '\0');
      }
    }
    return std::string("II*\0", 4) +
           packed<std::uint32_t>({static_cast<std::uint32_t>(directory)}) + body +
           packed<std::uint16_t>({static_cast<std::uint16_t>(tags_.size())}) + entries +
           std::string(4, '\0') + values;
  }

 private:
  struct Field {
    int type;
    std::size_t count;
    std::string bytes;
  };
  std::map<int, Field> tags_;
};

// 3 x 2 pixels: 1 2 3 above 4 5 6, at pixel size 0.5, upper left corner (10, 20).
TiffMaker small_geotiff() {
  TiffMaker maker(3, 2);
  maker.set_double(33550, {0.5, 0.5, 0.0});
  maker.set_double(33922, {0, 0, 0, 10, 20, 0});
  return maker;
}
const std::string kSixPixels = packed<float>({1, 2, 3, 4, 5, 6});

Grid<float> random_grid(int columns, int rows) {
  GridGeometry geometry;
  geometry.resolution_m = 0.1;
  geometry.origin = {-3.05, 12.5};
  geometry.columns = columns;
  geometry.rows = rows;
  Grid<float> grid(geometry);
  std::mt19937 random(3);
  for (float& value : grid.values) {
    // Every pattern of bits, among them infinite and NaN ones with payloads.
    value = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
  }
  grid.values[0] = std::numeric_limits<float>::quiet_NaN();
  return grid;
}

bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

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
