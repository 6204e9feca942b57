// Float rasters: GeoTIFF for grids on the ground, plain TIFF for depth images. Both float32,
// deflate compressed, NaN for unknown, readable by QGIS and GDAL. Values come back bit by bit.
#pragma once

#include <filesystem>
#include <string>

#include "tread/core/grid.hpp"
#include "tread/core/image.hpp"
#include "tread/core/result.hpp"

namespace tread {

// North up: row 0 of the file is the largest y. Local engineering coordinates in metres
// (no earth reference); pixel size, origin and the no-data value NaN are stored.
[[nodiscard]] Status write_geotiff(const std::filesystem::path& path, const Grid<float>& grid);
// Reads what write_geotiff wrote and any single-band north-up float32 GeoTIFF with square pixels,
// striped or tiled; another no-data value becomes NaN. The origin's y is that of the lower border,
// counted from the upper one that the file stores: exact to rounding.
[[nodiscard]] Result<Grid<float>> read_geotiff(const std::filesystem::path& path);

// An image of floats without georeference, row 0 first.
[[nodiscard]] Status write_tiff(const std::filesystem::path& path, ImageView<const float> image);
[[nodiscard]] Result<Image<float>> read_tiff(const std::filesystem::path& path);

}  // namespace tread
