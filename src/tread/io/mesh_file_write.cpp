// Writing PLY. What is read is in mesh_file.cpp.
#include <fmt/format.h>

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "tread/io/atomic_file.hpp"
#include "tread/io/mesh_file.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little,
              "binary PLY is written as it lies in memory");

Status check_colours(std::size_t colours, std::size_t points, const fs::path& path) {
  if (colours == 0 || colours == points) return {};
  return fail(ErrorCode::kBadArgument, fmt::format("{} colours for {} points", colours, points),
              path.string(), "Give one colour a point, or none");
}

std::string vertex_header(std::size_t count, bool coloured) {
  return fmt::format(
      "ply\nformat binary_little_endian 1.0\nelement vertex {}\n"
      "property float x\nproperty float y\nproperty float z\n{}",
      count, coloured ? "property uchar red\nproperty uchar green\nproperty uchar blue\n" : "");
}

void append_vertices(const std::vector<Eigen::Vector3f>& points, const std::vector<Rgb>& colours,
                     std::string& bytes) {
  constexpr std::size_t kPointBytes = 3 * sizeof(float);
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::array<char, kPointBytes> packed{};
    std::memcpy(packed.data(), points[i].data(), kPointBytes);
    bytes.append(packed.data(), packed.size());
    if (colours.empty()) continue;
    for (const std::uint8_t channel : {colours[i].r, colours[i].g, colours[i].b}) {
      bytes += static_cast<char>(channel);
    }
  }
}

}  // namespace

Status write_ply(const fs::path& path, const PointCloud& cloud) {
  if (Status good = check_colours(cloud.colours.size(), cloud.points.size(), path); !good) {
    return good;
  }
  std::string bytes = vertex_header(cloud.points.size(), !cloud.colours.empty()) + "end_header\n";
  bytes.reserve(bytes.size() + cloud.points.size() * 15);
  append_vertices(cloud.points, cloud.colours, bytes);
  return write_file(path, bytes);
}

Status write_ply(const fs::path& path, const Mesh& mesh) {
  if (Status good = check_colours(mesh.colours.size(), mesh.vertices.size(), path); !good) {
    return good;
  }
  std::string bytes =
      vertex_header(mesh.vertices.size(), !mesh.colours.empty()) +
      fmt::format("element face {}\nproperty list uchar int vertex_indices\nend_header\n",
                  mesh.triangles.size());
  bytes.reserve(bytes.size() + mesh.vertices.size() * 15 + mesh.triangles.size() * 13);
  append_vertices(mesh.vertices, mesh.colours, bytes);
  for (const auto& triangle : mesh.triangles) {
    std::array<char, 1 + sizeof(triangle)> packed{3};
    std::memcpy(packed.data() + 1, triangle.data(), sizeof(triangle));
    bytes.append(packed.data(), packed.size());
  }
  return write_file(path, bytes);
}

}  // namespace tread
