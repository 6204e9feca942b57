#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>

#include "file_mutations.hpp"
#include "test_data.hpp"
#include "tread/io/image_file.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;
using testing::put_file;
using testing::ScratchFolder;

// 1.0F is 3f800000, 2.0F is 40000000.
const std::string kOneTwoBig("\x3f\x80\x00\x00\x40\x00\x00\x00", 8);
const std::string kOneTwoLittle("\x00\x00\x80\x3f\x00\x00\x00\x40", 8);

TEST(Pfm, RoundTripIsExactAlsoForSpecialValues) {
  const ScratchFolder folder;
  Image<float> image(19, 7, 1.5F);
  image(0, 0) = std::numeric_limits<float>::infinity();
  image(1, 0) = -0.0F;
  image(2, 0) = std::bit_cast<float>(0x7fc12345U);  // a NaN with a payload
  image(3, 6) = std::numeric_limits<float>::denorm_min();
  ASSERT_TRUE(write_pfm(folder / "a.pfm", image));
  const auto read = read_pfm(folder / "a.pfm");
  ASSERT_TRUE(read) << read.error().message();
  ASSERT_TRUE(same_size(*read, image));
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      EXPECT_EQ(std::bit_cast<std::uint32_t>((*read)(x, y)),
                std::bit_cast<std::uint32_t>(image(x, y)));
    }
  }
}

TEST(Pfm, RowsAreBottomUpInBothByteOrders) {
  const ScratchFolder folder;
  for (const std::string& bytes :
       {"Pf\n1 2\n1.0\n" + kOneTwoBig, "Pf\n1 2\n-1\n" + kOneTwoLittle,
        "Pf 1 2 -0.004 " + kOneTwoLittle, "Pf\r\n1 2\r\n-1.0\r\n" + kOneTwoLittle}) {
    put_file(folder / "a.pfm", bytes);
    const auto read = read_pfm(folder / "a.pfm");
    ASSERT_TRUE(read) << read.error().message();
    EXPECT_EQ((*read)(0, 1), 1.0F) << "the first pixel of the file is the lowest row";
    EXPECT_EQ((*read)(0, 0), 2.0F);
  }
  Image<float> image(1, 2);
  image(0, 1) = 1.0F;
  image(0, 0) = 2.0F;
  ASSERT_TRUE(write_pfm(folder / "b.pfm", image));
  EXPECT_EQ(testing::get_file(folder / "b.pfm"), "Pf\n1 2\n-1\n" + kOneTwoLittle);
}

TEST(Pfm, APixelThatBeginsWithALineFeedIsNotTakenForTheHeader) {
  const ScratchFolder folder;
  const std::string pixel("\x0a\x00\x80\x3f", 4);
  put_file(folder / "a.pfm", "Pf\n1 1\n-1\r" + pixel);
  const auto read = read_pfm(folder / "a.pfm");
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(std::bit_cast<std::uint32_t>((*read)(0, 0)), 0x3f80000aU);
}

TEST(Pfm, BadFilesAreNamedWithARemedy) {
  const ScratchFolder folder;
  struct Case {
    std::string bytes;
    ErrorCode code;
  };
  for (const Case& c : {Case{"PF\n1 2\n-1\n" + kOneTwoLittle, ErrorCode::kUnsupported},
                        Case{"P5\n1 2\n-1\n" + kOneTwoLittle, ErrorCode::kBadFormat},
                        Case{" Pf\n1 2\n-1\n" + kOneTwoLittle, ErrorCode::kBadFormat},
                        Case{"Pf\n0 2\n-1\n", ErrorCode::kBadFormat},
                        Case{"Pf\n-1 -2\n-1\n" + kOneTwoLittle, ErrorCode::kBadFormat},
                        Case{"Pf\nx 2\n-1\n" + kOneTwoLittle, ErrorCode::kBadFormat},
                        Case{"Pf\n1 2\n0\n" + kOneTwoLittle, ErrorCode::kBadFormat},
                        Case{"Pf\n1 2\nnan\n" + kOneTwoLittle, ErrorCode::kBadFormat},
                        Case{"Pf\n1 2\n-1\n" + kOneTwoLittle + "x", ErrorCode::kBadFormat},
                        Case{"Pf\n1 3\n-1\n" + kOneTwoLittle, ErrorCode::kUnreadable},
                        Case{"Pf\n2147483647 2147483647\n-1\nx", ErrorCode::kUnreadable},
                        Case{"", ErrorCode::kBadFormat}}) {
    put_file(folder / "a.pfm", c.bytes);
    const auto read = read_pfm(folder / "a.pfm");
    ASSERT_FALSE(read) << c.bytes;
    EXPECT_EQ(read.error().code, c.code) << read.error().message();
    EXPECT_EQ(read.error().where, (folder / "a.pfm").string());
    EXPECT_FALSE(read.error().remedy.empty());
  }
  EXPECT_EQ(read_pfm(folder / "none").error().code, ErrorCode::kNotFound);
  EXPECT_FALSE(write_pfm(folder / "e.pfm", Image<float>()));
}

TEST(Pfm, DamagedFilesAreCleanlyReadOrRefused) {
  const ScratchFolder folder;
  ASSERT_TRUE(write_pfm(folder / "valid", Image<float>(5, 4, 2.5F)));
  const std::string valid = testing::get_file(folder / "valid");
  const auto read = [](const fs::path& path) { return read_pfm(path).has_value(); };
  EXPECT_EQ(testing::shorter_files_taken(valid, folder / "a", read), 0);
  EXPECT_GT(testing::damaged_files_refused(valid, folder / "a", read), 500);
}

TEST(Pfm, ReadsTheGroundTruthOfMotorcycle) {
  TREAD_NEEDS_DATA(path, "stereo/Motorcycle/disp_gt.pfm");
  const auto truth = read_pfm(path);
  ASSERT_TRUE(truth) << truth.error().message();
  EXPECT_EQ(truth->width, 741);
  EXPECT_EQ(truth->height, 500);
  int finite = 0;
  float low = INFINITY, high = -INFINITY;
  double upper = 0.0, lower = 0.0;
  for (int y = 0; y < truth->height; ++y) {
    for (int x = 0; x < truth->width; ++x) {
      const float d = (*truth)(x, y);
      if (!std::isfinite(d)) continue;
      ++finite;
      low = std::min(low, d);
      high = std::max(high, d);
      (y < 250 ? upper : lower) += d;
    }
  }
  EXPECT_NEAR(finite / (741.0 * 500.0), 0.927, 0.0005);
  EXPECT_NEAR(low, 7.2, 0.05);
  EXPECT_NEAR(high, 59.9, 0.05);
  EXPECT_GT(lower, upper) << "the ground is nearer than the wall: rows would be upside down";
}

}  // namespace
}  // namespace tread
