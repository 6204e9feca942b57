#include "tread/io/image_header.hpp"

#include <gtest/gtest.h>

#include "sample_images.hpp"

namespace tread {
namespace {

using testing::as_string;
using testing::big_endian;
using testing::kColourJpeg;
using testing::kGreyJpeg;
using testing::kPngStart;
using testing::make_png;
using testing::png_chunk;
using testing::png_header;

ErrorCode code_of(const std::string& bytes) {
  const auto header = parse_image_header(bytes, "x");
  EXPECT_FALSE(header);
  if (header) return ErrorCode::kBadArgument;
  EXPECT_EQ(header.error().where, "x");
  EXPECT_FALSE(header.error().remedy.empty());
  return header.error().code;
}

TEST(ImageHeader, TellsEveryKindOfPng) {
  struct Case {
    int bits, type;
    std::size_t row_bytes;
    bool colour, alpha;
  };
  for (const Case& c :
       {Case{1, 0, 1, false, false}, Case{8, 0, 3, false, false}, Case{16, 0, 6, false, false},
        Case{8, 2, 9, true, false}, Case{4, 3, 2, true, false}, Case{8, 4, 6, false, true},
        Case{16, 6, 24, true, true}}) {
    const auto header =
        parse_image_header(make_png(3, 2, c.bits, c.type, std::string(2 * c.row_bytes, 'x')), "x");
    ASSERT_TRUE(header) << header.error().message();
    EXPECT_EQ(header->format, ImageFormat::kPng);
    EXPECT_EQ(header->width, 3);
    EXPECT_EQ(header->height, 2);
    EXPECT_EQ(header->bits, c.bits < 8 ? 8 : c.bits);
    EXPECT_EQ(header->colour, c.colour);
    EXPECT_EQ(header->alpha, c.alpha);
  }
}

TEST(ImageHeader, TellsJpegAndPnm) {
  const auto grey = parse_image_header(as_string(kGreyJpeg), "x");
  ASSERT_TRUE(grey) << grey.error().message();
  EXPECT_EQ(grey->format, ImageFormat::kJpeg);
  EXPECT_EQ(grey->width, 24);
  EXPECT_EQ(grey->height, 16);
  EXPECT_FALSE(grey->colour);
  const auto colour = parse_image_header(as_string(kColourJpeg), "x");
  ASSERT_TRUE(colour) << colour.error().message();
  EXPECT_TRUE(colour->colour);
  const auto pgm =
      parse_image_header("P5\n# by hand\n3 2 # size\n65535\n" + std::string(12, 'x'), "x");
  ASSERT_TRUE(pgm) << pgm.error().message();
  EXPECT_EQ(pgm->format, ImageFormat::kPnm);
  EXPECT_EQ(pgm->width, 3);
  EXPECT_EQ(pgm->height, 2);
  EXPECT_EQ(pgm->bits, 16);
  const auto text = parse_image_header("P3 1 1 255 1 2 3", "x");
  ASSERT_TRUE(text) << text.error().message();
  EXPECT_TRUE(text->colour);
}

TEST(ImageHeader, EveryShorterFileIsRefusedAsCutOff) {
  for (const std::string& valid : {make_png(3, 2, 8, 0, "abcdef"), as_string(kGreyJpeg),
                                   as_string(kColourJpeg), std::string("P5 3 2 255\nabcdef")}) {
    ASSERT_TRUE(parse_image_header(valid, "x"));
    for (std::size_t size = 0; size < valid.size(); ++size) {
      const auto header = parse_image_header(std::string_view(valid).substr(0, size), "x");
      ASSERT_FALSE(header) << size;
      EXPECT_TRUE(size <= 2 || header.error().code == ErrorCode::kUnreadable) << size;
    }
  }
}

TEST(ImageHeader, BytesBehindTheEndDoNotMatter) {
  EXPECT_TRUE(parse_image_header(as_string(kGreyJpeg) + std::string(100, '\0'), "x"));
  EXPECT_TRUE(parse_image_header(make_png(3, 2, 8, 0, "abcdef") + "padding", "x"));
}

TEST(ImageHeader, MorePixelsThanTheBytesCanHoldAreRefused) {
  const std::string end = png_chunk("IDAT", "tiny") + png_chunk("IEND", "");
  EXPECT_EQ(code_of(kPngStart + png_header(8000, 8000, 8, 0) + end), ErrorCode::kUnreadable);
  EXPECT_EQ(code_of(kPngStart + png_header(60000, 60000, 8, 0) + end), ErrorCode::kUnsupported);
  EXPECT_EQ(code_of(kPngStart + png_header(INT32_MAX, 1, 8, 0) + end), ErrorCode::kUnsupported);
  // Four bytes can stand for 4128 at most.
  EXPECT_TRUE(parse_image_header(kPngStart + png_header(4128, 1, 8, 0) + end, "x"));
  EXPECT_EQ(code_of(kPngStart + png_header(4129, 1, 8, 0) + end), ErrorCode::kUnreadable);
  EXPECT_TRUE(parse_image_header(kPngStart + png_header(2064, 1, 16, 0) + end, "x"));
  EXPECT_EQ(code_of(kPngStart + png_header(2065, 1, 16, 0) + end), ErrorCode::kUnreadable);
  std::string jpeg = as_string(kGreyJpeg);
  const std::size_t frame = jpeg.find("\xff\xc0");
  jpeg.replace(frame + 5, 4, "\x20\x00\x20\x00", 4);
  EXPECT_EQ(code_of(jpeg), ErrorCode::kUnreadable);
  EXPECT_EQ(code_of("P5 3 3 255\nabcdefgh"), ErrorCode::kUnreadable);
  EXPECT_EQ(code_of("P5 2 2 65535\nabcdefg"), ErrorCode::kUnreadable);
  EXPECT_EQ(code_of("P6 2 2 255\nabcdefghijk"), ErrorCode::kUnreadable);
  EXPECT_EQ(code_of("P2 3 1 255\n1 2"), ErrorCode::kUnreadable);
  EXPECT_EQ(code_of("P5 99999 99999 255\nabc"), ErrorCode::kUnsupported);
}

TEST(ImageHeader, DamagedPngIsNamed) {
  std::string wrong_sum = make_png(3, 2, 8, 0, "abcdef");
  wrong_sum[wrong_sum.find("IDAT") + 8] ^= 1;
  const auto damaged = parse_image_header(wrong_sum, "x");
  ASSERT_FALSE(damaged);
  EXPECT_NE(damaged.error().what.find("checksum of chunk 'IDAT'"), std::string::npos);
  const std::string end = png_chunk("IDAT", std::string(100, 'x')) + png_chunk("IEND", "");
  EXPECT_EQ(code_of(kPngStart + end), ErrorCode::kUnreadable);  // no header
  EXPECT_EQ(code_of(kPngStart + png_chunk("IHDR", "short") + end), ErrorCode::kUnreadable);
  EXPECT_EQ(code_of(kPngStart + png_header(0, 5, 8, 0) + end), ErrorCode::kUnreadable);
  EXPECT_EQ(code_of(kPngStart + png_header(-1, 5, 8, 0) + end), ErrorCode::kUnreadable);
  EXPECT_EQ(code_of(kPngStart + png_header(5, 5, 8, 1) + end), ErrorCode::kUnreadable);
  EXPECT_EQ(code_of(kPngStart + png_header(5, 5, 3, 0) + end), ErrorCode::kUnreadable);
  EXPECT_EQ(code_of(kPngStart + png_header(5, 5, 16, 3) + end), ErrorCode::kUnreadable);
}

TEST(ImageHeader, DamagedOrUnusualJpegIsNamed) {
  const std::string valid = as_string(kGreyJpeg);
  const std::size_t frame = valid.find("\xff\xc0");
  const auto with = [&](std::size_t at, char byte) {
    std::string jpeg = valid;
    jpeg[at] = byte;
    return jpeg;
  };
  EXPECT_EQ(code_of(with(frame + 1, '\xc9')), ErrorCode::kUnsupported);  // arithmetic
  EXPECT_EQ(code_of(with(frame + 4, 12)), ErrorCode::kUnsupported);      // 12 bits
  EXPECT_EQ(code_of(with(frame + 9, 4)), ErrorCode::kUnsupported);       // CMYK
  EXPECT_EQ(code_of(with(frame + 6, 0)), ErrorCode::kUnreadable);        // no rows
  EXPECT_EQ(code_of(std::string("\xff\xd8\xff\xd9", 4)), ErrorCode::kUnreadable);
  EXPECT_EQ(code_of(std::string("\xff\xd8\xff\xdb\0\1\xff\xd9", 8)), ErrorCode::kUnreadable);
  EXPECT_EQ(code_of(std::string("\xff\xd8\xff\xc0\0\4\1\1\xff\xd9", 10)), ErrorCode::kUnreadable);
  std::string two_frames = valid;
  two_frames.insert(frame, valid.substr(frame, 13));
  EXPECT_EQ(code_of(two_frames), ErrorCode::kUnreadable);
}

TEST(ImageHeader, OtherFilesAreRefusedWithWhatIsRead) {
  for (const char* bytes :
       {"GIF89a", "BM......", "II*\0....", "P4 8 1\nx", "P7\n", "hello world"}) {
    const auto header = parse_image_header(bytes, "x");
    ASSERT_FALSE(header);
    EXPECT_EQ(header.error().code, ErrorCode::kUnsupported);
    EXPECT_NE(header.error().remedy.find("PNG, JPEG or PGM"), std::string::npos);
  }
  EXPECT_EQ(code_of("P5 3 2 4095\nabcdefghijkl"), ErrorCode::kUnsupported);
  EXPECT_EQ(code_of("P5 3 -2 255\nabcdef"), ErrorCode::kUnreadable);
  EXPECT_EQ(code_of("P5 0 2 255\nabcdef"), ErrorCode::kUnreadable);
  EXPECT_EQ(code_of("P5 3"), ErrorCode::kUnreadable);
}

}  // namespace
}  // namespace tread
