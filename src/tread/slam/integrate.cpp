#include "tread/slam/integrate.hpp"

#include <limits>

#include "tread/core/parallel.hpp"
#include "tread/slam/integrate_kernel.hpp"

namespace tread {
namespace {

IntegrateFrame kernel_frame(const FusionFrame& frame, const DepthNoise& noise,
                            const IntegrateOptions& options, double voxel_m) {
  IntegrateFrame k;
  k.depth = frame.depth;
  k.rgb = frame.rgb;
  k.grey = frame.grey;
  k.camera = frame.camera;
  const Isometry3d T = frame.T_world_camera.inverse();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) k.R[3 * i + j] = static_cast<float>(T.linear()(i, j) * voxel_m);
    k.t[i] = static_cast<float>(T.translation()[i]);
  }
  k.voxel_m = static_cast<float>(voxel_m);
  k.constant_m = static_cast<float>(noise.constant_m);
  k.quadratic_per_m = static_cast<float>(noise.quadratic_per_m);
  k.truncation_m = static_cast<float>(options.truncation_voxels * voxel_m);
  k.reference_m = static_cast<float>(options.reference_m);
  k.full_weight = static_cast<float>(options.full_weight);
  k.most_weight = static_cast<float>(options.most_weight);
  k.along_ray = options.along_ray;
  return k;
}

const BlockPlace kNowhere = BlockPlace::Constant(std::numeric_limits<int>::max());

}  // namespace

OptionSet describe(IntegrateOptions& options) {
  OptionSet set;
  set.add("truncation_voxels", options.truncation_voxels,
          "how far from the surface distances are kept, at least", 2.0, 30.0);
  set.add("farthest_m", options.farthest_m, "depths beyond are not taken in, m", 0.1, 200.0);
  set.add("reference_m", options.reference_m,
          "up to here a measurement has its full weight, beyond it falls with z^2, m", 0.01,
          1000.0);
  set.add("full_weight", options.full_weight, "of a measurement", 1, 64);
  set.add("most_weight", options.most_weight, "that a voxel can gather", 1, 255);
  set.add("along_ray", options.along_ray, "distances along the ray, else along the optical axis");
  set.add("carve_every", options.carve_every,
          "frames between two looks at a block that is in view off the surface", 1, 1000);
  set.add("colour_every", options.colour_every, "frames between two looks at the colour of a block",
          1, 1000);
  return set;
}

// Along the ray of every fourth pixel, each way: blocks of 8 voxels are not missed by that.
void Integrator::touch_surface(const FusionFrame& frame, const DepthNoise& noise,
                               const IntegrateOptions& options, VoxelVolume& volume) {
  constexpr int kSkip = 4;
  const double voxel_m = volume.options().voxel_m;
  const double fx = frame.camera.fx, fy = frame.camera.fy, cx = frame.camera.cx,
               cy = frame.camera.cy;
  const Eigen::Matrix3d R = frame.T_world_camera.linear();
  const Eigen::Vector3d t = frame.T_world_camera.translation();
  touched_.clear();
  BlockPlace before = BlockPlace::Constant(std::numeric_limits<int>::max());
  for (int y = kSkip / 2; y < frame.depth.height; y += kSkip) {
    const float* row = frame.depth.row(y);
    for (int x = kSkip / 2; x < frame.depth.width; x += kSkip) {
      const double d = row[x];
      if (!(d > 0.0 && d <= options.farthest_m)) continue;
      const double mu =
          std::min(std::max(options.truncation_voxels * voxel_m, 3.0 * noise.sigma_m(d)),
                   kLargestDistance * voxel_m);
      const Eigen::Vector3d ray = R * Eigen::Vector3d((x - cx) / fx, (y - cy) / fy, 1.0);
      const int steps = static_cast<int>(std::ceil(2.0 * mu / (kBlockSide / 2 * voxel_m)));
      for (int i = 0; i <= steps; ++i) {
        const BlockPlace place = volume.block_of(t + ray * (d - mu + 2.0 * mu * i / steps));
        if (place == before) continue;
        before = place;
        const int block = volume.touch(place);
        if (block < 0) continue;
        if (static_cast<std::size_t>(block) >= touched_at_.size()) {
          touched_at_.resize(static_cast<std::size_t>(block) + 1024, -1);
        }
        std::int64_t& at = touched_at_[static_cast<std::size_t>(block)];
        if (at == frames_) continue;
        at = frames_;
        touched_.push_back(block);
      }
    }
  }
}

int Integrator::integrate(const FusionFrame& frame, const DepthNoise& noise,
                          const IntegrateOptions& options, VoxelVolume& volume,
                          const Context& context) {
  const ScopedTimer timer(context, "slam/integrate");
  ++frames_;
  touch_surface(frame, noise, options, volume);
  // Blocks in view off the surface: in turn.
  const Isometry3d T_camera_world = frame.T_world_camera.inverse();
  const double block_m = volume.options().voxel_m * kBlockSide;
  const double reach = 0.87 * block_m;  // from the middle of a block to its corner
  touched_at_.resize(std::max(touched_at_.size(), static_cast<std::size_t>(volume.size())), -1);
  for (int block = static_cast<int>(frames_ % options.carve_every); block < volume.size();
       block += options.carve_every) {
    if (!volume.exists(block) || touched_at_[static_cast<std::size_t>(block)] == frames_) continue;
    const Eigen::Vector3d p =
        T_camera_world *
        ((volume.place(block).cast<double>() + Eigen::Vector3d::Constant(0.5)) * block_m);
    if (p.z() < reach || p.z() > options.farthest_m) continue;
    const double u = frame.camera.fx * p.x() / p.z() + frame.camera.cx;
    const double v = frame.camera.fy * p.y() / p.z() + frame.camera.cy;
    const double margin = frame.camera.fx * reach / p.z();
    if (u < -margin || v < -margin || u > frame.depth.width + margin ||
        v > frame.depth.height + margin) {
      continue;
    }
    touched_.push_back(block);
  }
  const IntegrateFrame kernel = kernel_frame(frame, noise, options, volume.options().voxel_m);
  const VolumeView& view = volume.view();
  const bool coloured = !frame.rgb.empty() || !frame.grey.empty();
  // A block that has no colour yet does not wait for its turn; it may be gone by then.
  if (coloured) painted_.resize(touched_at_.size(), kNowhere);
  parallel_chunks(context, 0, static_cast<int>(touched_.size()), 64, [&](int first, int last) {
    for (int i = first; i < last; ++i) {
      const int block = touched_[static_cast<std::size_t>(i)];
      const BlockPlace at = volume.place(block) * kBlockSide;
      const std::size_t voxel = VolumeView::voxel_of(block, 0, 0, 0);
      bool paint = false;
      if (coloured) {
        BlockPlace& painted = painted_[static_cast<std::size_t>(block)];
        paint = (block + frames_) % options.colour_every == 0 || painted != volume.place(block);
        painted = volume.place(block);
      }
      integrate_block(kernel, at.x(), at.y(), at.z(), view.distance + voxel, view.weight + voxel,
                      paint ? view.colour + voxel : nullptr);
    }
  });
  return static_cast<int>(touched_.size());
}

}  // namespace tread
