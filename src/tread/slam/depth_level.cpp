#include "tread/slam/depth_level.hpp"

#include <limits>

#include "tread/core/parallel.hpp"
#include "tread/slam/depth_kernel.hpp"

namespace tread {
namespace {
constexpr int kRows = 16;  // of a chunk
constexpr double kLargestSlopeNoise = 0.1;
}  // namespace

void DepthLevel::resize(const Pinhole& with, int width, int height) {
  camera = with;
  depth.resize(width, height);
  for (Image<float>& n : normal) n.resize(width, height);
}

void halve_depth(ImageView<const float> depth, const DepthNoise& noise, Image<float>& half,
                 const Context& context) {
  half.resize(depth.width / 2, depth.height / 2);
  parallel_chunks(context, 0, half.height, kRows, [&](int first, int last) {
    for (int y = first; y < last; ++y) halve_depth_row(depth, noise, y, half.row(y));
  });
}

void smooth_depth(ImageView<const float> depth, const DepthNoise& noise, float focal_px,
                  int spacing, Image<float>& smooth, const Context& context) {
  smooth.resize(depth.width, depth.height);
  parallel_chunks(context, 0, depth.height, kRows, [&](int first, int last) {
    for (int y = first; y < last; ++y) {
      smooth_depth_row(depth, noise, focal_px, spacing, y, smooth.row(y));
    }
  });
}

double mean_depth(ImageView<const float> depth) {
  double sum = 0.0;
  int count = 0;
  for (int y = 0; y < depth.height; y += 4) {
    const float* row = depth.row(y);
    for (int x = 0; x < depth.width; x += 4) {
      if (!(row[x] > 0.0F)) continue;
      sum += row[x];
      ++count;
    }
  }
  return count > 0 ? sum / count : 0.0;
}

void NormalFinder::find(const DepthNoise& noise, DepthLevel& level, const Context& context) {
  const double z = mean_depth(level.depth);
  if (z <= 0.0) {
    for (Image<float>& n : level.normal) {
      n = Image<float>(level.width(), level.height(), std::numeric_limits<float>::quiet_NaN());
    }
    return;
  }
  // Noise of the slope between neighbours, which each pass divides by some five times its spacing.
  double slope = noise.sigma_m(z) * static_cast<double>(level.camera.fx) / z;
  const Image<float>* depth = &level.depth;
  for (int spacing = 1; slope > kLargestSlopeNoise && spacing <= 8; spacing *= 2) {
    smooth_depth(*depth, noise, level.camera.fx, spacing, smoother_, context);
    std::swap(smooth_, smoother_);
    depth = &smooth_;
    slope /= 4.0;
  }
  parallel_chunks(context, 0, level.height(), kRows, [&](int first, int last) {
    for (int y = first; y < last; ++y) {
      normal_row(level.camera, noise, *depth, y, level.normal[0].row(y), level.normal[1].row(y),
                 level.normal[2].row(y));
    }
  });
}

void NormalFinder::build_pyramid(const DepthNoise& noise, std::array<DepthLevel, 3>& levels,
                                 const Context& context) {
  find(noise, levels[0], context);
  for (std::size_t i = 1; i < levels.size(); ++i) {
    const DepthLevel& finer = levels[i - 1];
    levels[i].resize(finer.camera.halved(), finer.width() / 2, finer.height() / 2);
    halve_depth(finer.depth, noise, levels[i].depth, context);
    find(noise, levels[i], context);
  }
}

}  // namespace tread
