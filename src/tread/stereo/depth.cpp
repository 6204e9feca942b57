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
  const float unknown = std::numeric_limits<float>::quiet_NaN();
  parallel_chunks(context, 0, disparity.height, 64, [&](int first, int last) {
    for (int y = first; y < last; ++y) {
      const Disparity* from = disparity.row(y);
      float* to = depth.row(y);
      for (int x = 0; x < disparity.width; ++x) {
        to[x] = unknown;
        if (from[x] == kNoMatch) continue;
        const double z = rig.depth_m(disparity_px(from[x]));
        if (z >= options.min_depth_m && z <= options.max_depth_m) to[x] = static_cast<float>(z);
      }
    }
  });
}

void depth_cloud(ImageView<const float> depth, const RectifiedRig& rig, Reference reference,
                 ImageView<const Rgb> colour, PointCloud& cloud, const Context& context) {
  const ScopedTimer timer(context, "stereo/cloud");
  cloud.points.clear();
  cloud.colours.clear();
  const bool coloured = !colour.empty() && same_size(colour, depth);
  for (int y = 0; y < depth.height; ++y) {
    const float* row = depth.row(y);
    for (int x = 0; x < depth.width; ++x) {
      if (std::isnan(row[x])) continue;
      const double z = row[x];
      // A pixel of the right image is a disparity further right in the left one.
      const double u = reference == Reference::kLeft ? x : x + rig.disparity_px(z);
      cloud.points.push_back(rig.point(u, y, z).cast<float>());
      if (coloured) cloud.colours.push_back(colour(x, y));
    }
  }
}

}  // namespace tread
