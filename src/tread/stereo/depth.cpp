#include "tread/stereo/depth.hpp"

#include <cmath>
#include <limits>

#include "tread/core/parallel.hpp"

namespace tread {

OptionSet describe(DepthOptions& options) {
  OptionSet set;
  set.add("min_depth_m", options.min_depth_m, "nearest depth kept, m", 0.0, 1e4);
  set.add("max_depth_m", options.max_depth_m, "farthest depth kept, m", 0.0, 1e4);
  set.require({"min_depth_m", "max_depth_m"}, "the nearest must be less than the farthest",
              [&options] { return options.min_depth_m < options.max_depth_m; });
  return set;
}

void depth_image(ImageView<const Disparity> disparity, const RectifiedRig& rig,
                 const DepthOptions& options, Image<float>& depth, const Context& context) {
  const ScopedTimer timer(context, "stereo/depth");
  depth.resize(disparity.width, disparity.height);
  // Eq. 1 without branches, so that the compiler makes vectors of it.
  constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
  const auto bf = static_cast<float>(rig.baseline_m * rig.fx_px);
  const auto offset = static_cast<float>(rig.cx_offset_px);
  const auto nearest = static_cast<float>(options.min_depth_m);
  const auto farthest = static_cast<float>(options.max_depth_m);
  parallel_chunks(context, 0, disparity.height, 64, [&](int first, int last) {
    for (int y = first; y < last; ++y) {
      const Disparity* from = disparity.row(y);
      float* to = depth.row(y);
      for (int x = 0; x < disparity.width; ++x) {
        const float from_infinity = disparity_px(from[x]) + offset;
        const float z = bf / from_infinity;
        const bool known =
            (from[x] != kNoMatch) & (from_infinity > 0.0F) & (z >= nearest) & (z <= farthest);
        to[x] = known ? z : kUnknown;
      }
    }
  });
}

void depth_cloud(ImageView<const float> depth, const RectifiedRig& rig, Reference reference,
                 ImageView<const Rgb> colour, PointCloud& cloud, const Context& context) {
  const ScopedTimer timer(context, "stereo/cloud");
  const bool coloured = !colour.empty() && same_size(colour, depth);
  const auto most = static_cast<std::size_t>(depth.width) * static_cast<std::size_t>(depth.height);
  cloud.points.resize(most);
  cloud.colours.resize(coloured ? most : 0);
  // Eq. 1: X = (u - cx) Z / fx, Y = (v - cy) Z / fy.
  const auto cx = static_cast<float>(rig.cx_px), cy = static_cast<float>(rig.cy_px);
  const auto per_fx = static_cast<float>(1.0 / rig.fx_px);
  const auto per_fy = static_cast<float>(1.0 / rig.fy_px);
  std::size_t count = 0;
  for (int y = 0; y < depth.height; ++y) {
    const float* row = depth.row(y);
    const float across_y = (static_cast<float>(y) - cy) * per_fy;
    for (int x = 0; x < depth.width; ++x) {
      const float z = row[x];
      if (std::isnan(z)) continue;
      // A pixel of the right image is a disparity further right in the left one.
      const float u =
          static_cast<float>(x) +
          (reference == Reference::kLeft ? 0.0F : static_cast<float>(rig.disparity_px(z)));
      cloud.points[count] = {(u - cx) * per_fx * z, across_y * z, z};
      if (coloured) cloud.colours[count] = colour(x, y);
      ++count;
    }
  }
  cloud.points.resize(count);
  if (coloured) cloud.colours.resize(count);
}

}  // namespace tread
