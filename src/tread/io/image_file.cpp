// Files are checked (image_header) before any pixel is decoded (image_codecs, pnm). OpenCV encodes
// PNG.
#include "tread/io/image_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <new>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "tread/core/raw_image.hpp"
#include "tread/io/atomic_file.hpp"
#include "tread/io/image_codecs.hpp"
#include "tread/io/image_header.hpp"
#include "tread/io/pnm.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLargestFile = std::size_t{1} << 30;

// Memory is what users run out of; OpenCV's own words, with places in its sources, tell them
// nothing.
bool is_out_of_memory(const std::exception& error) {
  return dynamic_cast<const std::bad_alloc*>(&error) != nullptr ||
         std::string_view(error.what()).find("Insufficient memory") != std::string_view::npos;
}

tl::unexpected<Error> not_decoded(const std::exception& error, const std::string& where) {
  if (is_out_of_memory(error)) {
    return fail(ErrorCode::kUnsupported, "out of memory for this picture", where,
                "Close other programs, or take smaller images");
  }
  return fail(ErrorCode::kUnreadable, "the picture cannot be decoded", where,
              "Copy or record it again");
}

// One or three channels (blue, green, red) of 8 or 16 bits.
Result<cv::Mat> decode(const std::string& bytes, const ImageHeader& header,
                       const std::string& where) {
  try {
    cv::Mat image(header.height, header.width,
                  CV_MAKETYPE(header.bits == 16 ? CV_16U : CV_8U, header.colour ? 3 : 1));
    const PixelRows rows{image.data, image.step};
    const Status decoded = header.format == ImageFormat::kPng
                               ? decode_png(bytes, header, where, rows)
                               : decode_jpeg(bytes, header, where, rows);
    if (!decoded) return forward(decoded);
    return image;
  } catch (const std::exception& error) {
    return not_decoded(error, where);
  }
}

// The same from a PGM or PPM.
Result<cv::Mat> decode_netpbm(const std::string& bytes, const std::string& where) {
  const auto header = parse_pnm_header(bytes, where);
  if (!header) return forward(header);
  const auto values = decode_pnm(bytes, *header, where);
  if (!values) return forward(values);
  const int channels = header->colour ? 3 : 1;
  try {
    cv::Mat deep(header->height, header->width, CV_16UC(channels));
    std::size_t i = 0;
    for (int y = 0; y < deep.rows; ++y) {
      std::uint16_t* row = deep.ptr<std::uint16_t>(y);
      for (int x = 0; x < deep.cols; ++x, row += channels) {
        for (int c = channels - 1; c >= 0; --c) row[c] = (*values)[i++];
      }
    }
    if (header->bits == 16) return deep;
    cv::Mat shallow;
    deep.convertTo(shallow, CV_8U);
    return shallow;
  } catch (const std::exception& error) {
    return not_decoded(error, where);
  }
}

struct Decoded {
  ImageHeader header;
  cv::Mat image;
};

Result<Decoded> read_image(const fs::path& path) {
  const auto bytes = read_file(path, kLargestFile);
  if (!bytes) return forward(bytes);
  const auto header = parse_image_header(*bytes, path.string());
  if (!header) return forward(header);
  auto image = header->format == ImageFormat::kPnm ? decode_netpbm(*bytes, path.string())
                                                   : decode(*bytes, *header, path.string());
  if (!image) return forward(image);
  return Decoded{*header, std::move(*image)};
}

// Calls each(x, y, r, g, b) with 8-bit values.
template <class Sample, class Each>
void for_each_pixel_of(const cv::Mat& image, const Each& each) {
  constexpr int kShift = 8 * (static_cast<int>(sizeof(Sample)) - 1);
  const int channels = image.channels();
  for (int y = 0; y < image.rows; ++y) {
    const Sample* pixel = image.ptr<Sample>(y);
    for (int x = 0; x < image.cols; ++x, pixel += channels) {
      const auto sample = [&](int i) {
        return static_cast<std::uint8_t>(pixel[channels == 1 ? 0 : i] >> kShift);
      };
      each(x, y, Rgb{sample(2), sample(1), sample(0)});
    }
  }
}

template <class Each>
void for_each_pixel(const cv::Mat& image, const Each& each) {
  if (image.depth() == CV_8U) {
    for_each_pixel_of<std::uint8_t>(image, each);
  } else {
    for_each_pixel_of<std::uint16_t>(image, each);
  }
}

Result<Image<std::uint8_t>> grey_of(const cv::Mat& image, const ImageReading& reading,
                                    const fs::path& path) {
  RawImage raw{image.data, image.cols, image.rows, static_cast<std::ptrdiff_t>(image.step[0])};
  raw.bits = reading.bits;
  const bool deep = image.depth() == CV_16U, coloured = image.channels() == 3;
  if (coloured && reading.bayer) {
    return fail(ErrorCode::kBadFormat, "it has colours and is no raw mosaic", path.string(),
                "Set images.bayer to false");
  }
  cv::Mat shallow;
  if (coloured && deep) {
    image.convertTo(shallow, CV_8U, std::ldexp(1.0, 8 - reading.bits), -0.498);  // rounds down
    raw.data = shallow.data;
    raw.row_bytes = static_cast<std::ptrdiff_t>(shallow.step[0]);
  }
  if (coloured) {
    raw.format = PixelFormat::kBgr8;
  } else if (reading.bayer) {
    raw.format = deep ? PixelFormat::kBayer16 : PixelFormat::kBayer8;
  } else {
    raw.format = deep ? PixelFormat::kGrey16 : PixelFormat::kGrey8;
  }
  Image<std::uint8_t> grey;
  if (Status ok = to_grey(raw, grey); !ok) return forward(ok);
  return grey;
}

Image<Rgb> to_colour(const cv::Mat& image) {
  Image<Rgb> colour(image.cols, image.rows);
  for_each_pixel(image, [&](int x, int y, const Rgb& c) { colour(x, y) = c; });
  return colour;
}

Result<ImageHeader> read_header(const fs::path& path) {
  const auto bytes = read_file(path, kLargestFile);
  if (!bytes) return forward(bytes);
  return parse_image_header(*bytes, path.string());
}

Result<std::string> encode(const cv::Mat& image, const std::string& where) {
  try {
    std::vector<unsigned char> bytes;
    if (cv::imencode(".png", image, bytes)) return std::string(bytes.begin(), bytes.end());
  } catch (const std::exception& error) {
    return fail(
        ErrorCode::kWriteFailed,
        fmt::format("cannot encode as PNG{}", is_out_of_memory(error) ? " (out of memory)" : ""),
        where, "Check the size of the image");
  }
  return fail(ErrorCode::kWriteFailed, "cannot encode as PNG", where,
              "Check the size of the image");
}

tl::unexpected<Error> no_pixels(const std::string& where) {
  return fail(ErrorCode::kBadArgument, "an image without pixels cannot be written", where,
              "Give an image");
}

template <class T>
Result<std::string> encode_grey(ImageView<const T> image, int type, const std::string& where) {
  if (image.empty()) return no_pixels(where);
  const cv::Mat wrapped(image.height, image.width, type, const_cast<T*>(image.data),
                        static_cast<std::size_t>(image.stride) * sizeof(T));
  return encode(wrapped, where);
}

Result<std::string> encode_colour(ImageView<const Rgb> image, const std::string& where) {
  if (image.empty()) return no_pixels(where);
  cv::Mat swapped(image.height, image.width, CV_8UC3);
  for (int y = 0; y < image.height; ++y) {
    std::uint8_t* out = swapped.ptr<std::uint8_t>(y);
    for (int x = 0; x < image.width; ++x, out += 3) {
      const Rgb& c = image(x, y);
      out[0] = c.b;
      out[1] = c.g;
      out[2] = c.r;
    }
  }
  return encode(swapped, where);
}

}  // namespace

OptionSet describe(ImageReading& reading) {
  OptionSet set;
  set.add("bits", reading.bits, "of 16-bit images: how many the camera fills", 8, 16);
  set.add("bayer", reading.bayer, "grey images are the raw Bayer mosaic of a colour sensor");
  return set;
}

Result<Image<std::uint8_t>> read_grey(const fs::path& path, const ImageReading& reading) {
  const auto decoded = read_image(path);
  if (!decoded) return forward(decoded);
  return grey_of(decoded->image, reading, path);
}

Result<Image<Rgb>> read_colour(const fs::path& path) {
  const auto decoded = read_image(path);
  if (!decoded) return forward(decoded);
  return to_colour(decoded->image);
}

Result<GreyAndColour> read_grey_and_colour(const fs::path& path, const ImageReading& reading) {
  const auto decoded = read_image(path);
  if (!decoded) return forward(decoded);
  auto grey = grey_of(decoded->image, reading, path);
  if (!grey) return forward(grey);
  GreyAndColour both;
  both.grey = std::move(*grey);
  if (decoded->header.colour) both.colour = to_colour(decoded->image);
  return both;
}

Result<Image<std::uint16_t>> read_png16(const fs::path& path) {
  const auto decoded = read_image(path);
  if (!decoded) return forward(decoded);
  const ImageHeader& header = decoded->header;
  const bool matches = header.format == ImageFormat::kPng && header.bits == 16 && !header.colour &&
                       !header.alpha && decoded->image.type() == CV_16UC1;
  if (!matches) {
    return fail(ErrorCode::kBadFormat, "this is not a PNG of one channel with 16 bits",
                path.string(), "Give a 16-bit grey PNG");
  }
  Image<std::uint16_t> image(header.width, header.height);
  for (int y = 0; y < image.height; ++y) {
    const std::uint16_t* from = decoded->image.ptr<std::uint16_t>(y);
    std::copy(from, from + image.width, image.row(y));
  }
  return image;
}

Status check_depth_units(double units_per_metre, const std::string& where) {
  constexpr double kFewest = 1e-3, kMost = 1e9;  // far from where a float would end
  if (units_per_metre >= kFewest && units_per_metre <= kMost) return {};
  return fail(ErrorCode::kBadArgument,
              fmt::format("{} units of depth per metre are not between {} and {}", units_per_metre,
                          kFewest, kMost),
              where, "Give 1000 if the depth images are in millimetres");
}

Result<Image<float>> read_depth_image(const fs::path& path, double units_per_metre,
                                      bool full_is_unknown) {
  const Status units = check_depth_units(units_per_metre, path.string());
  if (!units) return forward(units);
  const auto stored = read_png16(path);
  if (!stored) return forward(stored);
  constexpr std::uint16_t kFull = 65535;
  Image<float> depth(stored->width, stored->height);
  for (int y = 0; y < depth.height; ++y) {
    std::transform(stored->row(y), stored->row(y) + depth.width, depth.row(y),
                   [&](std::uint16_t value) {
                     const bool unknown = value == 0 || (full_is_unknown && value == kFull);
                     return unknown ? std::numeric_limits<float>::quiet_NaN()
                                    : static_cast<float>(value / units_per_metre);
                   });
  }
  return depth;
}

Result<bool> has_colour(const fs::path& path) {
  const auto header = read_header(path);
  if (!header) return forward(header);
  return header->colour;
}

Result<ImageSize> read_image_size(const fs::path& path) {
  const auto header = read_header(path);
  if (!header) return forward(header);
  return ImageSize{header->width, header->height};
}

Status write_png(const fs::path& path, ImageView<const std::uint8_t> image) {
  const auto bytes = encode_grey(image, CV_8UC1, path.string());
  if (!bytes) return forward(bytes);
  return write_file(path, *bytes);
}

Status write_png(const fs::path& path, ImageView<const std::uint16_t> image) {
  const auto bytes = encode_grey(image, CV_16UC1, path.string());
  if (!bytes) return forward(bytes);
  return write_file(path, *bytes);
}

Status write_png(const fs::path& path, ImageView<const Rgb> image) {
  const auto bytes = encode_colour(image, path.string());
  if (!bytes) return forward(bytes);
  return write_file(path, *bytes);
}

Result<std::string> encode_png(ImageView<const Rgb> image) {
  return encode_colour(image, "PNG");
}

Result<std::string> encode_png(ImageView<const std::uint8_t> image) {
  return encode_grey(image, CV_8UC1, "PNG");
}

}  // namespace tread
