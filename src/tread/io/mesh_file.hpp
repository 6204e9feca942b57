// Point clouds and meshes as binary little-endian PLY, which CloudCompare, MeshLab and Open3D read.
#pragma once

#include <filesystem>

#include "tread/core/result.hpp"
#include "tread/geometry/cloud.hpp"
#include "tread/geometry/mesh.hpp"

namespace tread {

[[nodiscard]] Status write_ply(const std::filesystem::path& path, const PointCloud& cloud);
[[nodiscard]] Status write_ply(const std::filesystem::path& path, const Mesh& mesh);
// Reads x, y, z and, if there, red, green, blue of element "vertex"; ASCII and binary little
// endian. Points after a truncation are refused with the file, not invented.
[[nodiscard]] Result<PointCloud> read_ply(const std::filesystem::path& path);

}  // namespace tread
