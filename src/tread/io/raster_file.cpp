// Sources: TIFF 6.0; Adobe Photoshop TIFF Technical Note 3 (floating-point predictor); OGC GeoTIFF
// 1.1 (ModelPixelScale, ModelTiepoint, GeoKeyDirectory); GDAL's no-data tag 42113.
// Memory while reading grows with the pixels that the file really yields.
#include "tread/io/raster_file.hpp"

#include <fmt/format.h>
#include <geokeys.h>
#include <geotiff.h>
#include <geovalues.h>
#include <tiffio.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "tread/io/atomic_file.hpp"
#include "tread/io/text.hpp"
#include "tread/io/tiff_handle.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

struct Raster {
  int width = 0;
  int height = 0;
  std::vector<float> values;  // row 0 of the file first
};

tl::unexpected<Error> bad_raster(const TiffHandle& file, const std::string& what,
                                 const std::string& remedy) {
  return fail(ErrorCode::kUnsupported, what, file.where(), remedy);
}

// How many bytes of pixels a byte of the file can stand for at most; 0 if it is not known.
std::size_t expansion_of(int compression) {
  switch (compression) {
    case COMPRESSION_NONE:
      return 1;
    case COMPRESSION_PACKBITS:
      return 64;
    case COMPRESSION_DEFLATE:
    case COMPRESSION_ADOBE_DEFLATE:
      return 1032;
    case COMPRESSION_LZW:
      return 4096;  // its longest table entry
    default:
      return 0;
  }
}

int tag_of(const TiffHandle& file, std::uint32_t tag, int otherwise) {
  std::uint16_t value = 0;
  return TIFFGetField(file.get(), tag, &value) != 0 ? value : otherwise;
}

// One band of float32 whose size its bytes can hold.
Status check_pixels(const TiffHandle& file, std::uint32_t width, std::uint32_t height) {
  const int bands = tag_of(file, TIFFTAG_SAMPLESPERPIXEL, 1);
  if (bands != 1) {
    return bad_raster(file, fmt::format("it has {} bands", bands),
                      "Choose one: gdal_translate -b 1 IN OUT");
  }
  const bool is_float =
      tag_of(file, TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_UINT) == SAMPLEFORMAT_IEEEFP;
  const int bits = tag_of(file, TIFFTAG_BITSPERSAMPLE, 1);
  if (!is_float || bits != 32) {
    return bad_raster(file, fmt::format("its values are not float32 (but {} bits)", bits),
                      "Convert it: gdal_translate -ot Float32 IN OUT");
  }
  if (tag_of(file, TIFFTAG_ORIENTATION, ORIENTATION_TOPLEFT) != ORIENTATION_TOPLEFT) {
    return bad_raster(file, "its rows do not begin at the top left", "Turn it with gdalwarp");
  }
  const std::size_t expansion = expansion_of(tag_of(file, TIFFTAG_COMPRESSION, COMPRESSION_NONE));
  if (expansion == 0) {
    return bad_raster(file, "its compression is not read",
                      "Convert it: gdal_translate -co COMPRESS=DEFLATE IN OUT");
  }
  constexpr std::uint32_t kLongestSide = 1U << 24U;
  if (width == 0 || height == 0 || width > kLongestSide || height > kLongestSide ||
      std::uint64_t{width} * height > file.file_bytes() * expansion / sizeof(float)) {
    return fail(ErrorCode::kUnreadable,
                fmt::format("its header promises {}x{} pixels, more than its bytes can hold", width,
                            height),
                file.where(), "Copy or write it again");
  }
  return {};
}

tl::unexpected<Error> not_read(const TiffHandle& file, const std::string& part) {
  return file.error(ErrorCode::kUnreadable, part + " cannot be read",
                    "The file is damaged: copy or write it again");
}

Status read_rows(const TiffHandle& file, Raster& raster) {
  const auto width = static_cast<std::size_t>(raster.width);
  // libtiff decodes whole rows into what it is given.
  if (TIFFScanlineSize64(file.get()) != width * sizeof(float)) return not_read(file, "a row");
  std::vector<float> row(width);
  for (int y = 0; y < raster.height; ++y) {
    if (TIFFReadScanline(file.get(), row.data(), static_cast<std::uint32_t>(y), 0) != 1) {
      return not_read(file, fmt::format("row {}", y));
    }
    raster.values.insert(raster.values.end(), row.begin(), row.end());
  }
  return {};
}

Status read_tiles(const TiffHandle& file, Raster& raster) {
  std::uint32_t tile_width = 0, tile_height = 0;
  TIFFGetField(file.get(), TIFFTAG_TILEWIDTH, &tile_width);
  TIFFGetField(file.get(), TIFFTAG_TILELENGTH, &tile_height);
  constexpr std::uint32_t kLongestSide = 4096;
  const bool usual = tile_width > 0 && tile_height > 0 && tile_width <= kLongestSide &&
                     tile_height <= kLongestSide;
  const std::size_t tile_pixels = std::size_t{tile_width} * tile_height;
  if (!usual || TIFFTileSize64(file.get()) != tile_pixels * sizeof(float)) {
    return bad_raster(file, fmt::format("tiles of {}x{} pixels", tile_width, tile_height),
                      "Convert it: gdal_translate -co TILED=NO IN OUT");
  }
  std::vector<float> tile(tile_pixels);
  const auto width = static_cast<std::uint32_t>(raster.width);
  const auto height = static_cast<std::uint32_t>(raster.height);
  for (std::uint32_t y = 0; y < height; y += tile_height) {
    const std::uint32_t rows = std::min(tile_height, height - y);
    raster.values.resize(std::size_t{y + rows} * width);
    for (std::uint32_t x = 0; x < width; x += tile_width) {
      if (TIFFReadTile(file.get(), tile.data(), x, y, 0, 0) < 0) {
        return not_read(file, fmt::format("the tile at ({}, {})", x, y));
      }
      const std::uint32_t columns = std::min(tile_width, width - x);
      for (std::uint32_t row = 0; row < rows; ++row) {
        std::copy_n(tile.data() + std::size_t{row} * tile_width, columns,
                    raster.values.data() + std::size_t{y + row} * width + x);
      }
    }
  }
  return {};
}

Result<Raster> read_raster(const TiffHandle& file) {
  std::uint32_t width = 0, height = 0;
  TIFFGetField(file.get(), TIFFTAG_IMAGEWIDTH, &width);
  TIFFGetField(file.get(), TIFFTAG_IMAGELENGTH, &height);
  if (const Status pixels = check_pixels(file, width, height); !pixels) return forward(pixels);
  if (file.has_error()) return not_read(file, "its directory");
  Raster raster{static_cast<int>(width), static_cast<int>(height), {}};
  const bool tiled = TIFFIsTiled(file.get()) != 0;
  const Status read = tiled ? read_tiles(file, raster) : read_rows(file, raster);
  if (!read) return forward(read);
  return raster;
}

// The value of a short key of the GeoKeyDirectory: four shorts of head, then four a key (id,
// place, count, value); place 0 says that the value stands there itself.
int geo_key(const TiffHandle& file, int id, int otherwise) {
  const auto keys = file.shorts(kTagGeoKeys);
  for (std::size_t i = 4; i + 3 < keys.size(); i += 4) {
    if (keys[i] == id && keys[i + 1] == 0) return keys[i + 3];
  }
  return otherwise;
}

Result<GridGeometry> geometry_of(const TiffHandle& file, int columns, int rows) {
  const auto scale = file.doubles(kTagPixelScale);
  const auto tie = file.doubles(kTagTiePoints);
  if (!file.doubles(kTagTransformation).empty() || tie.size() > 6) {
    return bad_raster(file, "its rows do not run along x",
                      "Make it north up: gdalwarp -of GTiff IN OUT");
  }
  if (scale.size() < 2 || tie.size() != 6) {
    return fail(ErrorCode::kBadFormat,
                "it has no place on the ground (ModelPixelScale, "
                "ModelTiepoint)",
                file.where(), "Give it one: gdal_translate -a_ullr LEFT TOP RIGHT BOTTOM IN OUT");
  }
  const double side_m = scale[0];
  const bool finite =
      std::all_of(tie.begin(), tie.end(), [](double v) { return std::isfinite(v); });
  if (!finite || !(side_m > 0.0) || !std::isfinite(side_m)) {
    return fail(ErrorCode::kBadValue, "its place on the ground is not finite", file.where(),
                "Write it again");
  }
  if (!(std::abs(scale[1] - side_m) <= 1e-6 * side_m)) {
    return bad_raster(file, fmt::format("its pixels of {} x {} are not square", side_m, scale[1]),
                      "Resample it: gdalwarp -tr SIZE SIZE IN OUT");
  }
  // With pixel-is-point the tie point is the centre of its pixel.
  const bool centres = geo_key(file, GTRasterTypeGeoKey, RasterPixelIsArea) == RasterPixelIsPoint;
  const double corner = centres ? 0.5 : 0.0;
  GridGeometry geometry;
  geometry.resolution_m = side_m;
  geometry.columns = columns;
  geometry.rows = rows;
  geometry.origin.x() = tie[3] - (tie[0] + corner) * side_m;
  geometry.origin.y() = tie[4] + (tie[1] + corner - rows) * side_m;
  if (!geometry.origin.allFinite()) {
    return fail(ErrorCode::kBadValue, "its place on the ground is not finite", file.where(),
                "Write it again");
  }
  return geometry;
}

// The no-data value of the file becomes NaN.
void forget_no_data(const TiffHandle& file, std::vector<float>& values) {
  const std::string text = file.text(kTagNoData);
  const auto no_data = parse_number<double>(trimmed(text));
  if (!no_data || !std::isfinite(*no_data) ||
      std::abs(*no_data) > std::numeric_limits<float>::max()) {
    return;
  }
  std::replace(values.begin(), values.end(), static_cast<float>(*no_data), kUnknown);
}

void set_pixel_tags(TIFF* tiff, int width, int height) {
  constexpr int kStripBytes = 1 << 18;  // small enough for a reader that wants a part
  const int rows_per_strip = std::clamp(kStripBytes / (4 * width), 1, height);
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, width);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, height);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 32);
  TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_IEEEFP);
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 1);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  TIFFSetField(tiff, TIFFTAG_ORIENTATION, ORIENTATION_TOPLEFT);
  TIFFSetField(tiff, TIFFTAG_COMPRESSION, COMPRESSION_ADOBE_DEFLATE);
  TIFFSetField(tiff, TIFFTAG_PREDICTOR, PREDICTOR_FLOATINGPOINT);
  TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, rows_per_strip);
  TIFFSetField(tiff, kTagNoData, "nan");
}

__attribute__((format(printf, 3, 4))) void ignore_message(gtiff* /*keys*/, int /*level*/,
                                                          const char* /*format*/, ...) {}

bool set_place(TIFF* tiff, const GridGeometry& geometry) {
  const double side_m = geometry.resolution_m;
  const std::array<double, 3> scale = {side_m, side_m, 0.0};
  const std::array<double, 6> tie = {
      0.0, 0.0, 0.0, geometry.origin.x(), geometry.origin.y() + side_m * geometry.rows, 0.0};
  TIFFSetField(tiff, kTagPixelScale, 3, scale.data());
  TIFFSetField(tiff, kTagTiePoints, 6, tie.data());
  // A plane of its own, not bound to the earth, in metres.
  GTIF* keys = GTIFNewEx(tiff, ignore_message, nullptr);
  if (keys == nullptr) return false;
  GTIFKeySet(keys, GTModelTypeGeoKey, TYPE_SHORT, 1, KvUserDefined);
  GTIFKeySet(keys, GTRasterTypeGeoKey, TYPE_SHORT, 1, RasterPixelIsArea);
  GTIFKeySet(keys, GTCitationGeoKey, TYPE_ASCII, 0, "local, x forward, y left");
  GTIFKeySet(keys, ProjLinearUnitsGeoKey, TYPE_SHORT, 1, Linear_Meter);
  const bool written = GTIFWriteKeys(keys) != 0;
  GTIFFree(keys);
  return written;
}

// row(y) gives the first pixel of row y of the file.
template <class Row>
Status write_raster(const fs::path& path, int width, int height, const GridGeometry* place,
                    const Row& row) {
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  FileSet set(folder);
  const fs::path temporary = set.add(path.filename().string());
  const auto bytes =
      std::uint64_t{4} * static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
  auto file = TiffHandle::create(temporary, final_path(path).string(), bytes > 4'000'000'000U);
  if (!file) return forward(file);
  set_pixel_tags(file->get(), width, height);
  const auto not_written = [&](const std::string& what) {
    return file->error(ErrorCode::kWriteFailed, what,
                       "Check that the folder is writable and has space");
  };
  if (place != nullptr && !set_place(file->get(), *place)) {
    return not_written("its place on the ground cannot be written");
  }
  std::vector<float> copy(static_cast<std::size_t>(width));  // libtiff changes what it is given
  for (int y = 0; y < height; ++y) {
    const float* from = row(y);
    std::copy(from, from + width, copy.begin());
    if (TIFFWriteScanline(file->get(), copy.data(), static_cast<std::uint32_t>(y), 0) != 1) {
      return not_written(fmt::format("row {} cannot be written", y));
    }
  }
  if (const Status finished = file->finish_writing(); !finished) return finished;
  return set.commit();
}

Result<Grid<float>> read_grid(const fs::path& path) {
  const auto file = TiffHandle::open(path);
  if (!file) return forward(file);
  auto raster = read_raster(*file);
  if (!raster) return forward(raster);
  const auto geometry = geometry_of(*file, raster->width, raster->height);
  if (!geometry) return forward(geometry);
  forget_no_data(*file, raster->values);
  Grid<float> grid;
  grid.geometry = *geometry;
  grid.values = std::move(raster->values);
  const auto columns = static_cast<std::ptrdiff_t>(geometry->columns);
  for (std::ptrdiff_t low = 0, high = geometry->rows - 1; low < high; ++low, --high) {
    std::swap_ranges(grid.values.begin() + low * columns, grid.values.begin() + (low + 1) * columns,
                     grid.values.begin() + high * columns);
  }
  return grid;
}

Result<Image<float>> read_image(const fs::path& path) {
  const auto file = TiffHandle::open(path);
  if (!file) return forward(file);
  const auto raster = read_raster(*file);
  if (!raster) return forward(raster);
  Image<float> image(raster->width, raster->height);
  for (int y = 0; y < image.height; ++y) {
    const float* from = raster->values.data() + std::ptrdiff_t{y} * image.width;
    std::copy(from, from + image.width, image.row(y));
  }
  return image;
}

constexpr const char* kNeedsMemory = "Give it more memory, or cut the file into smaller ones";

}  // namespace

Status write_geotiff(const fs::path& path, const Grid<float>& grid) {
  const GridGeometry& geometry = grid.geometry;
  if (geometry.columns <= 0 || geometry.rows <= 0 || grid.values.size() != geometry.size()) {
    return fail(ErrorCode::kBadArgument,
                fmt::format("a grid of {}x{} cells with {} values", geometry.columns, geometry.rows,
                            grid.values.size()),
                path.string(), "Give a grid with one value a cell");
  }
  if (!(geometry.resolution_m > 0.0) || !std::isfinite(geometry.resolution_m) ||
      !geometry.origin.allFinite()) {
    return fail(ErrorCode::kBadArgument, "the grid's resolution or origin is not finite",
                path.string(), "Give a resolution above zero and a finite origin");
  }
  return write_raster(path, geometry.columns, geometry.rows, &geometry, [&](int y) {
    return &grid[Cell{0, geometry.rows - 1 - y}];
  });
}

Result<Grid<float>> read_geotiff(const fs::path& path) {
  return with_memory_checked(path.string(), kNeedsMemory, [&] { return read_grid(path); });
}

Status write_tiff(const fs::path& path, ImageView<const float> image) {
  if (image.empty()) {
    return fail(ErrorCode::kBadArgument, "an image without pixels cannot be written", path.string(),
                "Give an image");
  }
  return write_raster(path, image.width, image.height, nullptr,
                      [&](int y) { return image.row(y); });
}

Result<Image<float>> read_tiff(const fs::path& path) {
  return with_memory_checked(path.string(), kNeedsMemory, [&] { return read_image(path); });
}

}  // namespace tread
