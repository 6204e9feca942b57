#include "tread/slam/grey_level.hpp"

#include <algorithm>
#include <cmath>

#include "tread/core/parallel.hpp"

namespace tread {
namespace {

void halve(const auto& from, Image<float>& to, const Context& context) {
  to.resize(from.width / 2, from.height / 2);
  parallel_chunks(context, 0, to.height, 32, [&](int first, int last) {
    for (int y = first; y < last; ++y) {
      const auto* upper = from.row(2 * y);
      const auto* lower = from.row(2 * y + 1);
      float* out = to.row(y);
      for (int x = 0; x < to.width; ++x) {
        const auto sum = upper[2 * x] + upper[2 * x + 1] + lower[2 * x] + lower[2 * x + 1];
        out[x] = 0.25F * static_cast<float>(sum);
      }
    }
  });
}

void find_slopes(GreyLevel& level, const Context& context) {
  const int width = level.intensity.width, height = level.intensity.height;
  level.gx.resize(width, height);
  level.gy.resize(width, height);
  parallel_chunks(context, 0, height, 32, [&](int first, int last) {
    for (int y = first; y < last; ++y) {
      float* gx = level.gx.row(y);
      float* gy = level.gy.row(y);
      std::fill(gx, gx + width, 0.0F);
      std::fill(gy, gy + width, 0.0F);
      if (y == 0 || y + 1 == height) continue;
      const float* above = level.intensity.row(y - 1);
      const float* here = level.intensity.row(y);
      const float* below = level.intensity.row(y + 1);
      for (int x = 1; x + 1 < width; ++x) {
        const float right = above[x + 1] + 2.0F * here[x + 1] + below[x + 1];
        const float left = above[x - 1] + 2.0F * here[x - 1] + below[x - 1];
        const float lower = below[x - 1] + 2.0F * below[x] + below[x + 1];
        const float upper = above[x - 1] + 2.0F * above[x] + above[x + 1];
        gx[x] = 0.125F * (right - left);
        gy[x] = 0.125F * (lower - upper);
      }
    }
  });
}

}  // namespace

void build_grey_pyramid(ImageView<const std::uint8_t> grey, bool halved,
                        std::array<GreyLevel, 3>& levels, const Context& context) {
  Image<float>& first = levels[0].intensity;
  if (halved) {
    halve(grey, first, context);
  } else {
    first.resize(grey.width, grey.height);
    for (int y = 0; y < grey.height; ++y) {
      std::copy(grey.row(y), grey.row(y) + grey.width, first.row(y));
    }
  }
  find_slopes(levels[0], context);
  for (std::size_t i = 1; i < levels.size(); ++i) {
    halve(levels[i - 1].intensity, levels[i].intensity, context);
    find_slopes(levels[i], context);
  }
}

GreyLevel with_slopes(const Image<float>& intensity) {
  GreyLevel level;
  level.intensity = intensity;
  find_slopes(level, {});
  return level;
}

GreyLevel halved(const GreyLevel& level) {
  GreyLevel half;
  halve(level.intensity, half.intensity, {});
  find_slopes(half, {});
  return half;
}

double grey_noise(const Image<float>& intensity) {
  // In tenths of a grey value, so that the median is a walk over a histogram.
  std::array<int, 1024> histogram{};
  int count = 0;
  for (int y = 1; y + 1 < intensity.height; y += 2) {
    const float* above = intensity.row(y - 1);
    const float* here = intensity.row(y);
    const float* below = intensity.row(y + 1);
    for (int x = 1; x + 1 < intensity.width; x += 2) {
      const float laplacian = (above[x - 1] + above[x + 1] + below[x - 1] + below[x + 1]) -
                              2.0F * (above[x] + below[x] + here[x - 1] + here[x + 1]) +
                              4.0F * here[x];
      const auto bin = static_cast<std::size_t>(std::min(1023.0F, 10.0F * std::abs(laplacian)));
      ++histogram[bin];
      ++count;
    }
  }
  int seen = 0;
  std::size_t bin = 0;
  while (bin + 1 < histogram.size() && (seen += histogram[bin]) < count / 2) ++bin;
  // The mask has norm 6; the median of |normal| is 0.6745 of its deviation.
  return (static_cast<double>(bin) + 0.5) / 10.0 / 6.0 / 0.6745;
}

void choose_photo_points(const GreyLevel& grey, const DepthLevel& depth, double least_slope,
                         int most, PhotoPoints& points) {
  points.clear();
  const Image<float>& intensity = grey.intensity;
  const auto slope_at = [&](int x, int y) {
    return std::hypot(grey.gx.row(y)[x], grey.gy.row(y)[x]);
  };
  // Where the limit must be for `most` points: by a histogram in quarters of a grey value.
  std::array<int, 512> histogram{};
  for (int y = 1; y + 1 < intensity.height; ++y) {
    for (int x = 1; x + 1 < intensity.width; ++x) {
      if (!(depth.depth.row(y)[x] > 0.0F)) continue;
      ++histogram[static_cast<std::size_t>(std::min(511.0F, 4.0F * slope_at(x, y)))];
    }
  }
  std::size_t bin = histogram.size();
  int sum = 0;
  while (bin > 0 && sum + histogram[bin - 1] <= most) sum += histogram[--bin];
  const auto limit = static_cast<float>(std::max(least_slope, static_cast<double>(bin) / 4.0));
  const Pinhole& camera = depth.camera;
  for (int y = 1; y + 1 < intensity.height; ++y) {
    for (int x = 1; x + 1 < intensity.width; ++x) {
      const float z = depth.depth.row(y)[x];
      if (!(z > 0.0F) || slope_at(x, y) < limit) continue;
      points.x.push_back(z * (static_cast<float>(x) - camera.cx) / camera.fx);
      points.y.push_back(z * (static_cast<float>(y) - camera.cy) / camera.fy);
      points.z.push_back(z);
      points.intensity.push_back(intensity.row(y)[x]);
      points.gx.push_back(grey.gx.row(y)[x]);
      points.gy.push_back(grey.gy.row(y)[x]);
    }
  }
}

}  // namespace tread
