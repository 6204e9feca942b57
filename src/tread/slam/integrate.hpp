// Fusion: a depth image taken at a known pose goes into the volume.
#pragma once

#include <limits>
#include <vector>

#include "tread/core/options.hpp"
#include "tread/core/timer.hpp"
#include "tread/geometry/pose.hpp"
#include "tread/slam/depth_level.hpp"
#include "tread/slam/voxel_volume.hpp"

namespace tread {

struct IntegrateOptions {
  double truncation_voxels = 4.0;  // at least; three sigma of the depth where that is more
  double farthest_m = 5.0;         // depths beyond are not taken in
  double reference_m = 1.0;        // up to here a measurement has its full weight, then 1 / z^2
  int full_weight = 4;
  int most_weight = 255;
  bool along_ray = false;  // distances along the ray, as KinFu, else along the optical axis
  int carve_every = 8;     // a block in view, but not at the surface, is looked at once in so many
                           // frames
  int colour_every = 4;    // and the colour of a block once in so many
  [[nodiscard]] bool operator==(const IntegrateOptions&) const = default;
};
[[nodiscard]] OptionSet describe(IntegrateOptions& options);

struct FusionFrame {
  ImageView<const float> depth;  // metres along the optical axis, NaN where unknown
  ImageView<const Rgb> rgb;      // empty, or of the same size
  ImageView<const std::uint8_t> grey;
  Pinhole camera;
  Isometry3d T_world_camera = Isometry3d::Identity();
};

class Integrator {
 public:
  // Makes the blocks around the measured surface and updates all that the frame says something of.
  // The window of the volume must contain what is to be fused. Returns the blocks updated.
  int integrate(const FusionFrame& frame, const DepthNoise& noise, const IntegrateOptions& options,
                VoxelVolume& volume, const Context& context = {});

 private:
  void touch_surface(const FusionFrame& frame, const DepthNoise& noise,
                     const IntegrateOptions& options, VoxelVolume& volume);

  std::vector<int> touched_;              // blocks at the surface of this frame
  std::vector<std::int64_t> touched_at_;  // frame count, by block
  std::vector<BlockPlace> painted_;       // of each block, where it was when it was given colour
  std::int64_t frames_ = 0;
};

}  // namespace tread
