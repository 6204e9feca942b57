// Image files: PNG and JPEG through libpng and libjpeg; PGM, PPM and PFM by our own code.
// Readers refuse a file that is truncated or whose header promises more than the file can hold,
// before anything of that size is allocated. Errors name the file and what to do.
// Pixels come as they are stored: an orientation in a JPEG's EXIF data is not applied, for it would
// turn the image against its calibration.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "tread/core/image.hpp"
#include "tread/core/options.hpp"
#include "tread/core/result.hpp"
#include "tread/geometry/camera.hpp"

namespace tread {

// What a file does not say of itself.
struct ImageReading {
  int bits = 16;       // of 16-bit files: how many the camera fills; 8 to 16
  bool bayer = false;  // grey files are the raw mosaic of a colour sensor
};
[[nodiscard]] OptionSet describe(ImageReading& reading);

// 8-bit grey, see to_grey in core/raw_image.hpp. A palette gives its colours, alpha is left out.
[[nodiscard]] Result<Image<std::uint8_t>> read_grey(const std::filesystem::path& path,
                                                    const ImageReading& reading = {});
// Colour as red, green, blue; a grey file gives three equal channels.
[[nodiscard]] Result<Image<Rgb>> read_colour(const std::filesystem::path& path);
// One channel, 16 bits, exactly as stored; 8-bit files are refused.
[[nodiscard]] Result<Image<std::uint16_t>> read_png16(const std::filesystem::path& path);
// Depth along the optical axis in metres from a PNG as read_png16 takes it: value /
// units_per_metre, above 0. NaN where it is unknown: at 0, and at 65535 too if `full_is_unknown`.
[[nodiscard]] Result<Image<float>> read_depth_image(const std::filesystem::path& path,
                                                    double units_per_metre, bool full_is_unknown);
// Whether it takes these units: above 0, and so that depths are within a float's range.
[[nodiscard]] Status check_depth_units(double units_per_metre, const std::string& where);
// True for files that have colour (three or more channels).
[[nodiscard]] Result<bool> has_colour(const std::filesystem::path& path);
// Width and height without decoding; the file is checked to be complete.
[[nodiscard]] Result<ImageSize> read_image_size(const std::filesystem::path& path);

// Both from one decoding; `colour` is empty for a grey file.
struct GreyAndColour {
  Image<std::uint8_t> grey;
  Image<Rgb> colour;
};
[[nodiscard]] Result<GreyAndColour> read_grey_and_colour(const std::filesystem::path& path,
                                                         const ImageReading& reading = {});

[[nodiscard]] Status write_png(const std::filesystem::path& path,
                               ImageView<const std::uint8_t> image);
[[nodiscard]] Status write_png(const std::filesystem::path& path,
                               ImageView<const std::uint16_t> image);
[[nodiscard]] Status write_png(const std::filesystem::path& path, ImageView<const Rgb> image);
// The bytes of a PNG file.
[[nodiscard]] Result<std::string> encode_png(ImageView<const Rgb> image);
[[nodiscard]] Result<std::string> encode_png(ImageView<const std::uint8_t> image);

// Portable float map, one channel, as Middlebury writes disparity: rows bottom up, infinite where
// unknown. Both byte orders are read, little endian is written. The scale in the header only tells
// the byte order, as with Middlebury.
[[nodiscard]] Result<Image<float>> read_pfm(const std::filesystem::path& path);
[[nodiscard]] Status write_pfm(const std::filesystem::path& path, ImageView<const float> image);

}  // namespace tread
