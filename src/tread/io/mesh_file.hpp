// Point clouds as binary little-endian PLY, which CloudCompare, MeshLab and Open3D read.
#pragma once

#include <filesystem>

#include "tread/core/result.hpp"
#include "tread/geometry/cloud.hpp"

namespace tread {

[[nodiscard]] Status write_ply(const std::filesystem::path& path, const PointCloud& cloud);
// Reads x, y, z and, if there, red, green, blue of element "vertex"; ASCII and binary little
// endian. Points after a truncation are refused with the file, not invented.
[[nodiscard]] Result<PointCloud> read_ply(const std::filesystem::path& path);

}  // namespace tread
