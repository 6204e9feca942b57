#include "tread/io/image_file.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "file_mutations.hpp"
#include "sample_images.hpp"
#include "test_data.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;
using testing::make_png;
using testing::put_file;
using testing::ScratchFolder;

Image<Rgb> random_colour(int width, int height) {
  std::mt19937 random(7);
  Image<Rgb> image(width, height);
  const auto byte = [&] { return static_cast<std::uint8_t>(random()); };
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) image(x, y) = {byte(), byte(), byte()};
  }
  return image;
}

TEST(ImageFile, PngRoundTripsAreExact) {
  const ScratchFolder folder;
  std::mt19937 random(5);
  Image<std::uint8_t> grey(67, 41);
  Image<std::uint16_t> deep(67, 41);
  for (int y = 0; y < grey.height; ++y) {
    for (int x = 0; x < grey.width; ++x) {
      grey(x, y) = static_cast<std::uint8_t>(random());
      deep(x, y) = static_cast<std::uint16_t>(random());
    }
  }
  const Image<Rgb> colour = random_colour(67, 41);
  ASSERT_TRUE(write_png(folder / "grey.png", grey));
  ASSERT_TRUE(write_png(folder / "deep.png", deep));
  ASSERT_TRUE(write_png(folder / "colour.png", colour));
  EXPECT_EQ(read_grey(folder / "grey.png").value(), grey);
  EXPECT_EQ(read_png16(folder / "deep.png").value(), deep);
  EXPECT_EQ(read_colour(folder / "colour.png").value(), colour);
  EXPECT_FALSE(has_colour(folder / "grey.png").value());
  EXPECT_FALSE(has_colour(folder / "deep.png").value());
  EXPECT_TRUE(has_colour(folder / "colour.png").value());
  EXPECT_EQ(read_image_size(folder / "deep.png").value(), (ImageSize{67, 41}));
  EXPECT_EQ(encode_png(colour).value(), testing::get_file(folder / "colour.png"));
}

TEST(ImageFile, ChannelsComeInTheOrderRedGreenBlue) {
  const ScratchFolder folder;
  // Bytes of a PNG pixel are red, green, blue.
  put_file(folder / "a.png", make_png(2, 1, 8, 2, {'\xff', 0, 0, 1, 2, 3}));
  const auto image = read_colour(folder / "a.png");
  ASSERT_TRUE(image) << image.error().message();
  EXPECT_EQ((*image)(0, 0), (Rgb{255, 0, 0}));
  EXPECT_EQ((*image)(1, 0), (Rgb{1, 2, 3}));
}

TEST(ImageFile, GreyOfColourIsBt601AndDeepGreyIsDividedBy256) {
  const ScratchFolder folder;
  put_file(folder / "c.png",
           make_png(4, 1, 8, 2, {'\xff', 0, 0, 0, '\xff', 0, 0, 0, '\xff', 100, 100, 100}));
  const auto grey = read_grey(folder / "c.png");
  ASSERT_TRUE(grey) << grey.error().message();
  EXPECT_EQ((*grey)(0, 0), 76);   // 0.299 * 255 = 76.2
  EXPECT_EQ((*grey)(1, 0), 150);  // 0.587 * 255 = 149.7
  EXPECT_EQ((*grey)(2, 0), 29);   // 0.114 * 255 = 29.1
  EXPECT_EQ((*grey)(3, 0), 100);
  put_file(folder / "d.png", make_png(2, 1, 16, 0, {'\x12', '\xff', '\xff', '\x00'}));
  const auto deep = read_grey(folder / "d.png");
  ASSERT_TRUE(deep) << deep.error().message();
  EXPECT_EQ((*deep)(0, 0), 0x12);
  EXPECT_EQ((*deep)(1, 0), 0xff);
  EXPECT_EQ(read_png16(folder / "d.png").value()(0, 0), 0x12ff);
  put_file(folder / "e.png", make_png(1, 1, 16, 2, {'\x12', '\xff', '\x34', 0, '\x56', 7}));
  EXPECT_EQ(read_colour(folder / "e.png").value()(0, 0), (Rgb{0x12, 0x34, 0x56}));
}

TEST(ImageFile, UnusualPngKindsAreRead) {
  const ScratchFolder folder;
  put_file(folder / "bits.png", make_png(3, 1, 1, 0, {'\xa0'}));  // 1 0 1
  const auto bits = read_grey(folder / "bits.png");
  ASSERT_TRUE(bits) << bits.error().message();
  EXPECT_EQ((*bits)(0, 0), 255);
  EXPECT_EQ((*bits)(1, 0), 0);
  EXPECT_EQ((*bits)(2, 0), 255);
  put_file(folder / "palette.png", make_png(2, 1, 8, 3, {1, 0}, {9, 8, 7, 10, 20, 30}));
  const auto palette = read_colour(folder / "palette.png");
  ASSERT_TRUE(palette) << palette.error().message();
  EXPECT_EQ((*palette)(0, 0), (Rgb{10, 20, 30}));
  EXPECT_EQ((*palette)(1, 0), (Rgb{9, 8, 7}));
  put_file(folder / "alpha.png", make_png(2, 1, 8, 6, {1, 2, 3, 0, 4, 5, 6, '\xff'}));
  const auto alpha = read_colour(folder / "alpha.png");
  ASSERT_TRUE(alpha) << alpha.error().message();
  EXPECT_EQ((*alpha)(0, 0), (Rgb{1, 2, 3})) << "the colour of a transparent pixel stays";
  EXPECT_EQ((*alpha)(1, 0), (Rgb{4, 5, 6}));
  put_file(folder / "grey_alpha.png", make_png(2, 1, 8, 4, {7, 0, 8, '\xff'}));
  const auto both = read_grey_and_colour(folder / "grey_alpha.png");
  ASSERT_TRUE(both) << both.error().message();
  EXPECT_EQ(both->grey(0, 0), 7);
  EXPECT_EQ(both->grey(1, 0), 8);
  EXPECT_TRUE(both->colour.empty());
}

TEST(ImageFile, GreyFilesGiveThreeEqualChannels) {
  const ScratchFolder folder;
  put_file(folder / "g.png", make_png(2, 1, 8, 0, {5, 9}));
  const auto colour = read_colour(folder / "g.png");
  ASSERT_TRUE(colour) << colour.error().message();
  EXPECT_EQ((*colour)(0, 0), (Rgb{5, 5, 5}));
  const auto both = read_grey_and_colour(folder / "g.png");
  ASSERT_TRUE(both);
  EXPECT_TRUE(both->colour.empty());
}

TEST(ImageFile, GreyAndColourAreWhatTheirReadersGive) {
  const ScratchFolder folder;
  ASSERT_TRUE(write_png(folder / "c.png", random_colour(33, 9)));
  const auto both = read_grey_and_colour(folder / "c.png");
  ASSERT_TRUE(both);
  EXPECT_EQ(both->grey, read_grey(folder / "c.png").value());
  EXPECT_EQ(both->colour, read_colour(folder / "c.png").value());
}

TEST(ImageFile, JpegAndPnmAreRead) {
  const ScratchFolder folder;
  put_file(folder / "g.jpg", testing::as_string(testing::kGreyJpeg));
  const auto grey = read_grey(folder / "g.jpg");
  ASSERT_TRUE(grey) << grey.error().message();
  for (int y = 0; y < 16; ++y) {
    for (int x = 0; x < 24; ++x) EXPECT_NEAR((*grey)(x, y), 8 * x + 2 * y, 6) << x << ' ' << y;
  }
  put_file(folder / "c.jpg", testing::as_string(testing::kColourJpeg));
  const auto colour = read_colour(folder / "c.jpg");
  ASSERT_TRUE(colour) << colour.error().message();
  EXPECT_NEAR((*colour)(8, 8).r, 200, 4);
  EXPECT_NEAR((*colour)(8, 8).g, 60, 4);
  EXPECT_NEAR((*colour)(8, 8).b, 20, 4);
  put_file(folder / "g.pgm", "P5\n# made by hand\n3 2\n255\nabcdef");
  EXPECT_EQ(read_grey(folder / "g.pgm").value()(2, 1), 'f');
  put_file(folder / "d.pgm", std::string("P5 2 1 65535\n\x12\x34\xff\x01", 17));
  EXPECT_EQ(read_grey(folder / "d.pgm").value()(0, 0), 0x12);
  EXPECT_EQ(read_grey(folder / "d.pgm").value()(1, 0), 0xff);
  put_file(folder / "c.ppm", "P6 1 1 255\nabc");
  EXPECT_EQ(read_colour(folder / "c.ppm").value()(0, 0), (Rgb{'a', 'b', 'c'}));
  put_file(folder / "t.pgm", "P2 2 2 255\n1 2\n30 255\n");
  EXPECT_EQ(read_grey(folder / "t.pgm").value()(0, 1), 30);
}

TEST(ImageFile, ViewsWithAStrideAreWritten) {
  const ScratchFolder folder;
  Image<std::uint8_t> image(100, 10);
  for (int y = 0; y < 10; ++y) {
    for (int x = 0; x < 100; ++x) image(x, y) = static_cast<std::uint8_t>(x + y);
  }
  const ImageView<const std::uint8_t> part{image.row(2) + 5, 3, 4, image.stride};
  ASSERT_TRUE(write_png(folder / "p.png", part));
  const auto read = read_grey(folder / "p.png");
  ASSERT_TRUE(read);
  ASSERT_EQ(read->width, 3);
  ASSERT_EQ(read->height, 4);
  EXPECT_EQ((*read)(2, 3), 7 + 5);
}

TEST(ImageFile, RefusalsNameTheFile) {
  const ScratchFolder folder;
  const auto missing = read_grey(folder / "none.png");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound);
  EXPECT_EQ(missing.error().where, (folder / "none.png").string());
  put_file(folder / "g.gif", "GIF89a....");
  EXPECT_EQ(read_colour(folder / "g.gif").error().code, ErrorCode::kUnsupported);
  EXPECT_FALSE(has_colour(folder / "none.png"));
  EXPECT_FALSE(read_image_size(folder / "none.png"));
  EXPECT_FALSE(read_grey_and_colour(folder / "none.png"));
  put_file(folder / "g.png", make_png(2, 1, 8, 0, {5, 9}));
  EXPECT_EQ(read_png16(folder / "g.png").error().code, ErrorCode::kBadFormat);
  put_file(folder / "ga.png", make_png(1, 1, 16, 4, {5, 9, 0, 0}));
  EXPECT_FALSE(read_png16(folder / "ga.png")) << "a second channel would be lost";
  EXPECT_FALSE(read_png16(folder / "none.png"));
  EXPECT_EQ(write_png(folder / "e.png", Image<std::uint8_t>()).error().code,
            ErrorCode::kBadArgument);
  EXPECT_FALSE(write_png(folder / "e.png", Image<Rgb>()));
  EXPECT_FALSE(encode_png(Image<Rgb>()));
  const Status nowhere = write_png(folder / "no" / "e.png", Image<std::uint16_t>(2, 2));
  ASSERT_FALSE(nowhere);
  EXPECT_EQ(nowhere.error().code, ErrorCode::kWriteFailed);
  // Sound outside, damaged inside: its pixels are too few.
  const std::string short_data = testing::kPngStart + testing::png_header(20, 20, 8, 0) +
                                 testing::png_chunk("IDAT", testing::stored_zlib("xx")) +
                                 testing::png_chunk("IEND", "");
  put_file(folder / "s.png", short_data);
  const auto inside = read_grey(folder / "s.png");
  EXPECT_TRUE(inside || inside.error().code == ErrorCode::kUnreadable);
}

TEST(ImageFile, EveryShorterFileIsRefused) {
  const ScratchFolder folder;
  const auto read = [](const fs::path& path) { return read_grey(path).has_value(); };
  for (const std::string& valid :
       {make_png(5, 3, 8, 2, std::string(45, 'x')), testing::as_string(testing::kGreyJpeg),
        testing::as_string(testing::kColourJpeg), std::string("P5 3 2 255\nabcdef")}) {
    put_file(folder / "i", valid);
    ASSERT_TRUE(read_grey(folder / "i"));
    EXPECT_EQ(testing::shorter_files_taken(valid, folder / "i", read), 0);
  }
}

TEST(ImageFile, DamagedFilesAreCleanlyReadOrRefused) {
  const ScratchFolder folder;
  const auto read = [](const fs::path& path) {
    const auto both = read_grey_and_colour(path);
    EXPECT_TRUE(both || !both.error().where.empty());
    return both.has_value();
  };
  ::testing::internal::CaptureStderr();
  EXPECT_GT(testing::damaged_files_refused(make_png(5, 3, 8, 2, std::string(45, 'x')), folder / "i",
                                           read),
            1900);
  EXPECT_GT(testing::damaged_files_refused("P6 3 2 255\nabcdefghijklmnopqr", folder / "i", read),
            500);
  EXPECT_GT(testing::damaged_files_refused("P2 3 2 255\n10 20 30 40 50 60\n", folder / "i", read),
            200);
  EXPECT_GT(
      testing::damaged_files_refused(testing::as_string(testing::kColourJpeg), folder / "i", read),
      500);
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
}

// Checksums and structure are right, the compressed data are not.
TEST(ImageFile, WhatOnlyTheDecoderNoticesIsNamedAndNotPrinted) {
  const ScratchFolder folder;
  const std::string sound = make_png(5, 3, 8, 2, std::string(45, 'x'));
  const std::string header = sound.substr(0, 33);
  const std::string end = testing::png_chunk("IEND", "");
  const std::string profile = testing::png_chunk("iCCP", std::string("a\0\0nonsense", 11));
  const std::string jpeg = testing::as_string(testing::kGreyJpeg);
  const std::size_t middle = jpeg.size() - 20;  // of the coded pixels, which are 33 bytes
  const std::pair<std::string, std::string> broken[] = {
      {"nonsense.png", header + testing::png_chunk("IDAT", "\x78\x01nonsense") + end},
      {"short.png", header + testing::png_chunk("IDAT", testing::stored_zlib("x")) + end},
      {"restart.jpg", jpeg.substr(0, middle) + "\xff\xd3" + jpeg.substr(middle)},
      {"short.jpg", jpeg.substr(0, middle) + "\xff\xd9"}};
  ::testing::internal::CaptureStderr();
  for (const auto& [name, bytes] : broken) {
    put_file(folder / name, bytes);
    const auto image = read_grey(folder / name);
    ASSERT_FALSE(image) << name;
    EXPECT_EQ(image.error().where, (folder / name).string());
    EXPECT_EQ(image.error().code, ErrorCode::kUnreadable) << name;
    EXPECT_NE(image.error().what.find("("), std::string::npos) << image.error().message();
  }
  // A profile that cannot be used, and bytes between segments as some cameras write them, harm no
  // pixel.
  put_file(folder / "p.png", header + profile + sound.substr(33));
  EXPECT_TRUE(read_colour(folder / "p.png"));
  put_file(folder / "e.jpg", jpeg.substr(0, jpeg.size() - 2) + std::string(3, '\0') + "\xff\xd9");
  EXPECT_TRUE(read_colour(folder / "e.jpg"));
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
}

TEST(ImageFile, InterlacedPngIsRead) {
  const ScratchFolder folder;
  // Adam7 of 2x1 pixels: pass 1 holds the left one, pass 6 the right one.
  const std::string ihdr("\0\0\0\x02\0\0\0\x01\x08\0\0\0\x01", 13);
  const std::string rows("\0\x11\0\x99", 4);
  put_file(folder / "i.png", std::string("\x89PNG\r\n\x1a\n") + testing::png_chunk("IHDR", ihdr) +
                                 testing::png_chunk("IDAT", testing::stored_zlib(rows)) +
                                 testing::png_chunk("IEND", ""));
  const auto image = read_grey(folder / "i.png");
  ASSERT_TRUE(image) << image.error().message();
  EXPECT_EQ((*image)(0, 0), 0x11);
  EXPECT_EQ((*image)(1, 0), 0x99);
}

TEST(ReadGrey, DeepImagesOfFewerBitsAndMosaics) {
  const ScratchFolder folder;
  Image<std::uint16_t> deep(4, 2);
  Image<std::uint8_t> mosaic(4, 2);
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < 4; ++x) {
      deep(x, y) = static_cast<std::uint16_t>(16 * (10 * x + y) + 9);  // 12 bits
      mosaic(x, y) = static_cast<std::uint8_t>(x % 2 == y % 2 ? (y == 0 ? 200 : 40) : 80);
    }
  }
  ASSERT_TRUE(write_png(folder / "deep.png", deep.view()));
  ASSERT_TRUE(write_png(folder / "mosaic.png", mosaic.view()));
  const auto grey = read_grey(folder / "deep.png", {12, false});
  ASSERT_TRUE(grey);
  EXPECT_EQ((*grey)(3, 1), 31);
  EXPECT_EQ((*read_grey(folder / "deep.png"))(3, 1), 1);
  const auto smooth = read_grey(folder / "mosaic.png", {16, true});
  ASSERT_TRUE(smooth);
  EXPECT_EQ((*smooth)(2, 1), 100);
  ASSERT_TRUE(write_png(folder / "colour.png", Image<Rgb>(3, 3, Rgb{1, 2, 3}).view()));
  const auto coloured = read_grey(folder / "colour.png", {16, true});
  ASSERT_FALSE(coloured);
  EXPECT_NE(coloured.error().message().find("no raw mosaic"), std::string::npos);
  EXPECT_FALSE(read_grey(folder / "deep.png", {7, false}));
}

TEST(ReadDepthImage, GivesMetresAndNanWhereItIsUnknown) {
  const ScratchFolder folder;
  const fs::path path = folder / "depth.png";
  const std::string rows("\x00\x00\x03\xe8\xff\xfe\xff\xff", 8);  // 0, 1000, 65534, 65535
  put_file(path, make_png(2, 2, 16, 0, rows));
  const auto millimetres = read_depth_image(path, 1000.0, true);
  ASSERT_TRUE(millimetres) << millimetres.error().message();
  EXPECT_TRUE(std::isnan((*millimetres)(0, 0)));
  EXPECT_EQ((*millimetres)(1, 0), 1.0F);
  EXPECT_EQ((*millimetres)(0, 1), 65.534F);
  EXPECT_TRUE(std::isnan((*millimetres)(1, 1)));
  const auto tum = read_depth_image(path, 5000.0, false);
  ASSERT_TRUE(tum) << tum.error().message();
  EXPECT_TRUE(std::isnan((*tum)(0, 0)));
  EXPECT_EQ((*tum)(1, 0), 0.2F);
  EXPECT_EQ((*tum)(1, 1), 13.107F);
  for (const double units : {0.0, -1000.0, 1e-30, 1e300, std::nan("")}) {
    const auto refused = read_depth_image(path, units, true);
    ASSERT_FALSE(refused) << units;
    EXPECT_EQ(refused.error().code, ErrorCode::kBadArgument);
  }
  put_file(path, make_png(2, 2, 8, 0, "abcd"));
  EXPECT_EQ(read_depth_image(path, 1000.0, true).error().code, ErrorCode::kBadFormat);
}

}  // namespace
}  // namespace tread
