#include "tread/slam/extract_mesh.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <random>

namespace tread {
namespace {

void fill(VoxelVolume& volume, int blocks,
          const std::function<double(const Eigen::Vector3d&)>& distance) {
  for (int z = -blocks; z < blocks; ++z) {
    for (int y = -blocks; y < blocks; ++y) {
      for (int x = -blocks; x < blocks; ++x) {
        const int index = volume.touch({x, y, z});
        ASSERT_GE(index, 0);
        for (int v = 0; v < kBlockVoxels; ++v) {
          const Eigen::Vector3d p(x * 8 + v % 8, y * 8 + v / 8 % 8, z * 8 + v / 64);
          const std::size_t at = VolumeView::voxel_of(index, 0, 0, 0) + static_cast<std::size_t>(v);
          volume.view().distance[at] = static_cast<std::int16_t>(
              std::clamp(distance(p) * kDistanceUnits, -32000.0, 32000.0));
          volume.view().weight[at] = 10;
          volume.view().colour[at] = {200, 100, 50};
        }
      }
    }
  }
}

// Every edge is of as many triangles one way as the other: no cracks, no holes, one side out.
void expect_watertight(const Mesh& mesh) {
  std::map<std::pair<int, int>, int> edges;
  for (const auto& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) ++edges[{t[i], t[(i + 1) % 3]}];
  }
  for (const auto& [edge, count] : edges) {
    const auto back = edges.find({edge.second, edge.first});
    ASSERT_TRUE(back != edges.end());
    ASSERT_EQ(count, back->second);
  }
}

double volume_inside(const Mesh& mesh) {
  double sum = 0.0;
  for (const auto& t : mesh.triangles) {
    const auto at = [&](std::size_t i) {
      return mesh.vertices[static_cast<std::size_t>(t[i])].cast<double>().eval();
    };
    sum += at(0).dot(at(1).cross(at(2))) / 6.0;
  }
  return sum;
}

TEST(ExtractMesh, ABallIsClosedAndAsLargeAsItIs) {
  VoxelVolume volume({.voxel_m = 0.02, .window_log2 = 4, .memory_mb = 32});
  const double radius = 13.3;  // voxels; across blocks
  fill(volume, 3, [&](const Eigen::Vector3d& p) { return p.norm() - radius; });
  const Mesh mesh = extract_mesh(volume);
  ASSERT_GT(mesh.triangles.size(), 1000U);
  ASSERT_EQ(mesh.vertices.size(), mesh.colours.size());
  expect_watertight(mesh);
  const double r = radius * 0.02;
  EXPECT_NEAR(volume_inside(mesh), 4.0 / 3.0 * std::numbers::pi * r * r * r,
              0.01 * 4.0 / 3.0 * std::numbers::pi * r * r * r)
      << "positive: triangles face outwards";
  for (const Eigen::Vector3f& p : mesh.vertices) ASSERT_NEAR(p.norm(), r, 0.0005);
  for (const Rgb& c : mesh.colours) ASSERT_EQ(c, (Rgb{200, 100, 50}));
}

// Random distances bring up all ways in which a cube can be cut, the ambiguous ones too.
TEST(ExtractMesh, NoCracksWhateverTheCorners) {
  VoxelVolume volume({.voxel_m = 0.02, .window_log2 = 4, .memory_mb = 32});
  std::mt19937 random(3);
  fill(volume, 2, [&](const Eigen::Vector3d& p) {
    if (p.cwiseAbs().maxCoeff() > 13.0) return 1.0;  // closed at the border
    const double d = static_cast<double>(random() % 2000) / 1000.0 - 1.0;
    return d == 0.0 ? 0.5 : d;
  });
  const Mesh mesh = extract_mesh(volume);
  ASSERT_GT(mesh.triangles.size(), 10'000U);
  expect_watertight(mesh);
}

TEST(ExtractMesh, TheSameWhenHalfOfItIsArchived) {
  VoxelVolume volume({.voxel_m = 0.02, .window_log2 = 4, .memory_mb = 32});
  fill(volume, 3, [](const Eigen::Vector3d& p) { return p.norm() - 13.3; });
  const Mesh before = extract_mesh(volume);
  volume.centre_on({1.2, 0.0, 0.0});
  ASSERT_GT(volume.archived(), 10U);
  const Mesh after = extract_mesh(volume);
  EXPECT_EQ(before.triangles, after.triangles);
  EXPECT_EQ(before.vertices, after.vertices);
}

TEST(ExtractMesh, NothingWhereSomethingIsUnknown) {
  VoxelVolume volume({.voxel_m = 0.02, .window_log2 = 4, .memory_mb = 32});
  EXPECT_TRUE(extract_mesh(volume).triangles.empty());
  fill(volume, 1, [](const Eigen::Vector3d& p) { return p.z() - 0.5; });
  const std::size_t all = extract_mesh(volume).triangles.size();
  const int index = volume.find({0, 0, 0});
  volume.view().weight[VolumeView::voxel_of(index, 3, 3, 0)] = 0;
  EXPECT_EQ(extract_mesh(volume).triangles.size(), all - 8) << "four cubes of two triangles";
}

}  // namespace
}  // namespace tread
