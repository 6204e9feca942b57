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
      const float* seed = seeds.row(y);
      float* out = seen.depth.row(y);
      const float yn = (static_cast<float>(y) - camera.cy) / camera.fy;
      for (int x = 0; x < seeds.width; ++x) {
        if (!(seed[x] > 0.0F)) {
          out[x] = std::numeric_limits<float>::quiet_NaN();
          continue;
        }
        const float xn = (static_cast<float>(x) - camera.cx) / camera.fx;
        const Eigen::Vector3f direction = R * Eigen::Vector3f(xn, yn, 1.0F);
        const Ray ray{{origin.x(), origin.y(), origin.z()},
                      {direction.x(), direction.y(), direction.z()}};
        out[x] = cast_ray(view, ray, seed[x], band);
      }
    }
  });
}

}  // namespace tread
