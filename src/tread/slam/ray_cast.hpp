// The surface as a camera would see it now, from the volume: what the next frame is aligned with.
#pragma once

#include "tread/core/timer.hpp"
#include "tread/geometry/pose.hpp"
#include "tread/slam/depth_level.hpp"
#include "tread/slam/voxel_volume.hpp"

namespace tread {

// Fills the depths of `seen` (whose camera and size are given) by casting a ray for each pixel that
// has a seed, the depth it is expected at, no farther from it than band_m. Normals are not filled.
void ray_cast(const VoxelVolume& volume, const Isometry3d& T_world_camera,
              ImageView<const float> seeds, double band_m, DepthLevel& seen,
              const Context& context = {});

}  // namespace tread
