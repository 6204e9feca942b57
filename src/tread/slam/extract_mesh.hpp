// The surface in a volume as triangles: marching cubes (Lorensen and Cline 1987) over all blocks,
// at hand and archived.
#pragma once

#include "tread/geometry/mesh.hpp"
#include "tread/slam/voxel_volume.hpp"

namespace tread {

struct MeshOptions {
  int least_weight = 2;  // voxels that were seen less are not trusted
  [[nodiscard]] bool operator==(const MeshOptions&) const = default;
};
[[nodiscard]] OptionSet describe(MeshOptions& options);

// In world axes, coloured. Cubes with a corner that is not known have no surface. Vertices are
// shared, across blocks too: where all is known the mesh has no cracks. Block by block, so that
// besides the mesh only the vertices on block borders are kept.
[[nodiscard]] Mesh extract_mesh(const VoxelVolume& volume, const MeshOptions& options = {});

}  // namespace tread
