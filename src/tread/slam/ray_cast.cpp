#include "tread/slam/ray_cast.hpp"

#include <cassert>

#include "tread/core/parallel.hpp"
#include "tread/slam/ray_cast_kernel.hpp"

namespace tread {

void ray_cast(const VoxelVolume& volume, const Isometry3d& T_world_camera,
              ImageView<const float> seeds, double band_m, DepthLevel& seen,
              const Context& context) {
  assert(same_size(seeds, seen.depth));
  const ScopedTimer timer(context, "slam/ray_cast");
  const VolumeView& view = volume.view();
  const double voxel_m = volume.options().voxel_m;
  const Eigen::Vector3d window(view.origin[0], view.origin[1], view.origin[2]);
  const Eigen::Vector3f origin =
      (T_world_camera.translation() / voxel_m - window * kBlockSide).cast<float>();
  const Eigen::Matrix3f R = (T_world_camera.linear() / voxel_m).cast<float>();
  const auto band = static_cast<float>(band_m);
  const Pinhole& camera = seen.camera;
  parallel_chunks(context, 0, seeds.height, 8, [&](int first, int last) {
    for (int y = first; y < last; ++y) {
      const float yn = (static_cast<float>(y) - camera.cy) / camera.fy;
      const Eigen::Vector3f first_ray = R * Eigen::Vector3f(-camera.cx / camera.fx, yn, 1.0F);
      const Eigen::Vector3f step = R * Eigen::Vector3f(1.0F / camera.fx, 0.0F, 0.0F);
      RayRow rays;
      for (int i = 0; i < 3; ++i) {
        rays.origin[i] = origin[i];
        rays.first[i] = first_ray[i];
        rays.step[i] = step[i];
      }
      cast_row(view, rays, seeds.row(y), seeds.width, band, seen.depth.row(y));
    }
  });
}

}  // namespace tread
