#include "tread/io/mesh_file.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "file_mutations.hpp"
#include "test_data.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;
using testing::put_file;
using testing::ScratchFolder;

PointCloud some_cloud(bool coloured) {
  PointCloud cloud;
  for (int i = 0; i < 7; ++i) {
    const auto v = static_cast<float>(i);
    cloud.points.emplace_back(0.1F * v, -v * v, 1e-20F * v);
    if (coloured) cloud.colours.push_back({static_cast<std::uint8_t>(i * 30), 255, 0});
  }
  return cloud;
}

template <class T>
std::string bytes_of(T value) {
  std::string bytes(sizeof(T), '\0');
  std::memcpy(bytes.data(), &value, sizeof(T));
  return bytes;
}

TEST(Ply, RoundTripIsExact) {
  const ScratchFolder folder;
  for (const bool coloured : {false, true}) {
    const PointCloud cloud = some_cloud(coloured);
    ASSERT_TRUE(write_ply(folder / "a.ply", cloud));
    const auto read = read_ply(folder / "a.ply");
    ASSERT_TRUE(read) << read.error().message();
    EXPECT_EQ(read->points, cloud.points);
    EXPECT_EQ(read->colours, cloud.colours);
  }
  ASSERT_TRUE(write_ply(folder / "empty.ply", PointCloud{}));
  EXPECT_TRUE(read_ply(folder / "empty.ply").value().points.empty());
}

TEST(Ply, AMeshHasItsFacesBehindItsVertices) {
  const ScratchFolder folder;
  Mesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.colours = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}, {10, 11, 12}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}};
  ASSERT_TRUE(write_ply(folder / "a.ply", mesh));
  const std::string bytes = testing::get_file(folder / "a.ply");
  EXPECT_NE(bytes.find("element face 2\nproperty list uchar int vertex_indices\n"),
            std::string::npos);
  EXPECT_TRUE(bytes.ends_with(std::string(1, '\3') + bytes_of(0) + bytes_of(1) + bytes_of(3)));
  const auto points = read_ply(folder / "a.ply");
  ASSERT_TRUE(points) << points.error().message();
  EXPECT_EQ(points->points, mesh.vertices);
  EXPECT_EQ(points->colours, mesh.colours);
  mesh.colours.pop_back();
  EXPECT_EQ(write_ply(folder / "b.ply", mesh).error().code, ErrorCode::kBadArgument);
}

TEST(Ply, TheFileIsWhatTheFormatSays) {
  const ScratchFolder folder;
  PointCloud cloud;
  cloud.points = {{1.0F, 2.0F, -3.0F}};
  cloud.colours = {{7, 8, 9}};
  ASSERT_TRUE(write_ply(folder / "a.ply", cloud));
  EXPECT_EQ(testing::get_file(folder / "a.ply"),
            "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\n"
            "property float y\nproperty float z\nproperty uchar red\nproperty uchar green\n"
            "property uchar blue\nend_header\n" +
                bytes_of(1.0F) + bytes_of(2.0F) + bytes_of(-3.0F) + "\x07\x08\x09");
}

TEST(Ply, ReadsOtherTypesOrdersAndElements) {
  const ScratchFolder folder;
  put_file(folder / "a.ply",
           "ply\r\nformat binary_little_endian 1.0\r\ncomment by hand\r\nobj_info x\r\n"
           "element camera 2\r\nproperty short id\r\nelement nothing 5\r\n"
           "element vertex 2\r\nproperty double z\r\nproperty uint8 blue\r\nproperty int16 x\r\n"
           "property uint y\r\nproperty uchar red\r\nproperty uchar green\r\nproperty char a\r\n"
           "element face 1\r\nproperty list uchar int vertex_indices\r\nend_header\r\n" +
               std::string("idid") + bytes_of(1.5) + "\x03" + bytes_of(std::int16_t{-7}) +
               bytes_of(std::uint32_t{4000000000U}) + "\x01\x02x" + bytes_of(1e300) + "\x06" +
               bytes_of(std::int16_t{8}) + bytes_of(std::uint32_t{9}) + "\x04\x05x" + "face");
  const auto read = read_ply(folder / "a.ply");
  ASSERT_TRUE(read) << read.error().message();
  ASSERT_EQ(read->points.size(), 2U);
  EXPECT_EQ(read->points[0], Eigen::Vector3f(-7.0F, 4e9F, 1.5F));
  EXPECT_EQ(read->points[1], Eigen::Vector3f(8.0F, 9.0F, INFINITY));
  ASSERT_EQ(read->colours.size(), 2U);
  EXPECT_EQ(read->colours[0], (Rgb{1, 2, 3}));
  EXPECT_EQ(read->colours[1], (Rgb{4, 5, 6}));
}

TEST(Ply, EveryBinaryTypeIsRead) {
  const ScratchFolder folder;
  const std::vector<std::pair<std::string, std::string>> types = {
      {"char", bytes_of(std::int8_t{-5})},
      {"uchar", bytes_of(std::uint8_t{250})},
      {"short", bytes_of(std::int16_t{-5})},
      {"ushort", bytes_of(std::uint16_t{65000})},
      {"int32", bytes_of(-5)},
      {"uint32", bytes_of(65000U)},
      {"float32", bytes_of(-5.0F)},
      {"float64", bytes_of(-1e300)}};
  const std::vector<float> expected = {-5.0F, 250.0F,   -5.0F, 65000.0F,
                                       -5.0F, 65000.0F, -5.0F, -INFINITY};
  for (std::size_t i = 0; i < types.size(); ++i) {
    put_file(folder / "a.ply",
             "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty " + types[i].first +
                 " x\nproperty char y\nproperty char z\nend_header\n" + types[i].second + "yz");
    const auto read = read_ply(folder / "a.ply");
    ASSERT_TRUE(read) << read.error().message();
    EXPECT_EQ(read->points[0].x(), expected[i]) << types[i].first;
  }
}

constexpr const char* kAscii =
    "ply\nformat ascii 1.0\nelement other 1\nproperty int n\nelement vertex 2\n"
    "property float x\nproperty float y\nproperty float z\nproperty uchar red\n"
    "property uchar green\nproperty uchar blue\nend_header\n"
    "42\n1 2.5 -3e2 10 20 30\n\n 4\t5 nan 255 0 1 \n";

TEST(Ply, ReadsText) {
  const ScratchFolder folder;
  put_file(folder / "a.ply", kAscii);
  const auto read = read_ply(folder / "a.ply");
  ASSERT_TRUE(read) << read.error().message();
  ASSERT_EQ(read->points.size(), 2U);
  EXPECT_EQ(read->points[0], Eigen::Vector3f(1.0F, 2.5F, -300.0F));
  EXPECT_EQ(read->points[1].y(), 5.0F);
  EXPECT_TRUE(std::isnan(read->points[1].z()));
  EXPECT_EQ(read->colours[1], (Rgb{255, 0, 1}));
}

TEST(Ply, BadFilesAreNamed) {
  const ScratchFolder folder;
  const std::string ascii = "ply\nformat ascii 1.0\n";
  const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
  const std::string binary = "ply\nformat binary_little_endian 1.0\n";
  struct Case {
    std::string bytes;
    ErrorCode code;
    const char* what;
  };
  for (const Case& c : {
           Case{"", ErrorCode::kBadFormat, "header does not end"},
           Case{"plx\n", ErrorCode::kBadFormat, "does not begin with 'ply'"},
           Case{"ply\nend_header\n", ErrorCode::kBadFormat, "names no format"},
           Case{"ply\nformat binary_big_endian 1.0\n", ErrorCode::kUnsupported, "big_endian"},
           Case{ascii + "nonsense here\n", ErrorCode::kBadFormat, "'nonsense here'"},
           Case{ascii + "property float x\n", ErrorCode::kBadFormat, "does not belong"},
           Case{ascii + "element vertex -1\n", ErrorCode::kBadFormat, "'-1'"},
           Case{ascii + "element vertex 1\nproperty half x\n", ErrorCode::kBadFormat, "property"},
           Case{ascii + "end_header\n", ErrorCode::kBadFormat, "no element vertex"},
           Case{ascii + "element vertex 1\nproperty float x\nend_header\n1\n",
                ErrorCode::kBadFormat, "has no y"},
           Case{ascii + "element vertex 1\n" + xyz + "property list uchar int n\nend_header\n",
                ErrorCode::kUnsupported, "list"},
           Case{ascii + "element vertex 1\n" + xyz + "property float red\nend_header\n1 2 3 4\n",
                ErrorCode::kUnsupported, "red is not of type uchar"},
           Case{ascii + "element vertex 1\n" + xyz + "end_header\n1 2\n", ErrorCode::kBadFormat,
                "2 numbers instead of 3"},
           Case{ascii + "element vertex 1\n" + xyz + "end_header\n1 2 x\n", ErrorCode::kBadFormat,
                "cannot be read"},
           Case{ascii + "element vertex 2\n" + xyz + "end_header\n1 2 3\n", ErrorCode::kUnreadable,
                "2 rows"},
           Case{ascii + "element vertex 18446744073709551615\n" + xyz + "end_header\n1 2 3\n",
                ErrorCode::kUnreadable, "rows"},
           Case{binary + "element vertex 1000000000000\n" + xyz + "end_header\nabc",
                ErrorCode::kUnreadable, "rows"},
           Case{binary + "element f 1\nproperty list uchar int i\nelement vertex 0\n" + xyz +
                    "end_header\n",
                ErrorCode::kUnsupported, "before the vertices"},
           Case{binary + "element f 9999999999\nproperty int i\nelement vertex 0\n" + xyz +
                    "end_header\n",
                ErrorCode::kUnreadable, "rows"},
           Case{ascii + std::string((1 << 20) + 10, ' ') + "\n", ErrorCode::kBadFormat,
                "header does not end"},
       }) {
    put_file(folder / "a.ply", c.bytes);
    const auto read = read_ply(folder / "a.ply");
    ASSERT_FALSE(read) << c.bytes;
    EXPECT_EQ(read.error().code, c.code) << read.error().message();
    EXPECT_NE(read.error().what.find(c.what), std::string::npos) << read.error().message();
    EXPECT_TRUE(read.error().where.starts_with((folder / "a.ply").string()));
    EXPECT_FALSE(read.error().remedy.empty());
  }
  EXPECT_EQ(read_ply(folder / "none").error().code, ErrorCode::kNotFound);
  PointCloud uneven = some_cloud(true);
  uneven.colours.pop_back();
  EXPECT_EQ(write_ply(folder / "u.ply", uneven).error().code, ErrorCode::kBadArgument);
}

TEST(Ply, DamagedFilesAreCleanlyReadOrRefused) {
  const ScratchFolder folder;
  ASSERT_TRUE(write_ply(folder / "valid", some_cloud(true)));
  const auto read = [](const fs::path& path) {
    const auto cloud = read_ply(path);
    if (!cloud) return false;
    EXPECT_LE(cloud->points.size(), fs::file_size(path));
    EXPECT_TRUE(cloud->colours.empty() || cloud->colours.size() == cloud->points.size());
    return true;
  };
  for (const std::string& valid : {testing::get_file(folder / "valid"), std::string(kAscii)}) {
    EXPECT_EQ(testing::shorter_files_taken(valid, folder / "a", read), 0);
    EXPECT_GT(testing::damaged_files_refused(valid, folder / "a", read), 500);
  }
}

}  // namespace
}  // namespace tread
