#include "tread/stereo/edge_image.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "tread/core/parallel.hpp"
#include "tread/stereo/filter_kernel.hpp"

namespace tread {
namespace {

// LoG = g''(x) g(y) + g(x) g''(y), both factors in fixed point. g sums to kOne and g'' to 0, so
// that a constant image gives exactly 128.
constexpr int kBits = 10;
constexpr int kOne = 1 << kBits;

struct Kernels {
  std::vector<int> smooth;  // g
  std::vector<int> second;  // g''
  double positive_sum = 0;  // of the two-dimensional mask, in units of kOne^2
};

Kernels make_kernels(int mask_px) {
  const int radius = mask_px / 2;
  const double sigma = mask_px / 6.0;
  std::vector<double> g, g2;
  double sum = 0.0;
  for (int i = -radius; i <= radius; ++i) {
    const double t = i * i / (sigma * sigma);
    g.push_back(std::exp(-0.5 * t));
    g2.push_back((t - 1.0) * g.back());
    sum += g.back();
  }
  Kernels kernels;
  for (std::size_t i = 0; i < g.size(); ++i) {
    kernels.smooth.push_back(static_cast<int>(std::lround(kOne * g[i] / sum)));
    kernels.second.push_back(static_cast<int>(std::lround(kOne * g2[i] / sum)));
  }
  const auto centre = static_cast<std::size_t>(radius);
  int smooth_error = -kOne, second_error = 0;
  for (int k : kernels.smooth) smooth_error += k;
  for (int k : kernels.second) second_error += k;
  kernels.smooth[centre] -= smooth_error;
  kernels.second[centre] -= second_error;
  for (std::size_t i = 0; i < g.size(); ++i) {
    for (std::size_t j = 0; j < g.size(); ++j) {
      const double k = static_cast<double>(kernels.smooth[i]) * kernels.second[j] +
                       static_cast<double>(kernels.second[i]) * kernels.smooth[j];
      kernels.positive_sum += std::max(0.0, k);
    }
  }
  return kernels;
}

// One row smoothed and derived along x. `padded` has radius pixels on both sides of the row.
void filter_row(const std::uint8_t* padded, int width, const Kernels& kernels, int* smooth,
                int* second) {
  const int taps = static_cast<int>(kernels.smooth.size());
  std::fill(smooth, smooth + width, 0);
  std::fill(second, second + width, 0);
  for (int k = 0; k < taps; ++k) {
    const int g = kernels.smooth[static_cast<std::size_t>(k)];
    const int g2 = kernels.second[static_cast<std::size_t>(k)];
    for (int x = 0; x < width; ++x) {
      smooth[x] += g * padded[x + k];
      second[x] += g2 * padded[x + k];
    }
  }
}

std::uint8_t limited(int response, int limit) {
  return static_cast<std::uint8_t>(128 + std::clamp(response, -limit, std::min(limit, 127)));
}

void gradient(ImageView<const std::uint8_t> image, const EdgeOptions& options,
              Image<std::uint8_t>& edges, const Context& context) {
  const int scale = static_cast<int>(std::lround(options.gain * 256.0));
  parallel_chunks(context, 0, image.height, 64, [&](int first, int last) {
    for (int y = first; y < last; ++y) {
      const std::uint8_t* above = image.row(std::max(y - 1, 0));
      const std::uint8_t* here = image.row(y);
      const std::uint8_t* below = image.row(std::min(y + 1, image.height - 1));
      std::uint8_t* out = edges.row(y);
      if (scale == 256) {
        gradient_row(above, here, below, image.width, options.limit, out);
        continue;
      }
      for (int x = 0; x < image.width; ++x) {
        const int l = std::max(x - 1, 0), r = std::min(x + 1, image.width - 1);
        const int response = above[r] - above[l] + 2 * (here[r] - here[l]) + below[r] - below[l];
        out[x] = limited(response * scale / 256, options.limit);
      }
    }
  });
}

// A ring of filtered rows is all that is kept between rows.
void laplacian(ImageView<const std::uint8_t> image, const EdgeOptions& options,
               Image<std::uint8_t>& edges, const Context& context) {
  const int radius = options.mask_px / 2;
  const int taps = options.mask_px;
  const int width = image.width;
  const Kernels kernels = make_kernels(options.mask_px);
  // After both passes the values are scaled by 2^(2 kBits); the first pass drops kDrop bits so
  // that 32 bits hold the second.
  constexpr int kDrop = 5;
  // response * scale >> 16 is gain * LoG with the positive part of the mask summing to 1.
  const double normal = options.gain * std::ldexp(1.0, kDrop) / kernels.positive_sum;
  constexpr int kShift = 24;
  const auto scale = static_cast<std::int64_t>(std::llround(-std::ldexp(normal, kShift)));

  parallel_chunks(context, 0, image.height, 64, [&](int first, int last) {
    // A ring of filtered rows; row r of the image lives in slot r mod taps.
    std::vector<std::uint8_t> padded(static_cast<std::size_t>(width + 2 * radius));
    std::vector<int> smooth(static_cast<std::size_t>(taps * width));
    std::vector<int> second(smooth.size());
    std::vector<int> sum(static_cast<std::size_t>(width));
    const auto slot = [&](int y) {
      return static_cast<std::size_t>(((y % taps) + taps) % taps) * static_cast<std::size_t>(width);
    };
    const auto load = [&](int y) {
      const std::uint8_t* row = image.row(std::clamp(y, 0, image.height - 1));
      std::fill(padded.begin(), padded.begin() + radius, row[0]);
      std::copy(row, row + width, padded.begin() + radius);
      std::fill(padded.end() - radius, padded.end(), row[width - 1]);
      filter_row(padded.data(), width, kernels, &smooth[slot(y)], &second[slot(y)]);
      for (int x = 0; x < width; ++x) {
        const auto i = slot(y) + static_cast<std::size_t>(x);
        smooth[i] >>= kDrop;
        second[i] >>= kDrop;
      }
    };
    for (int y = first - radius; y < first + radius; ++y) load(y);
    for (int y = first; y < last; ++y) {
      load(y + radius);
      std::fill(sum.begin(), sum.end(), 0);
      for (int k = 0; k < taps; ++k) {
        const int g = kernels.smooth[static_cast<std::size_t>(k)];
        const int g2 = kernels.second[static_cast<std::size_t>(k)];
        const int* s = &smooth[slot(y - radius + k)];
        const int* d = &second[slot(y - radius + k)];
        for (int x = 0; x < width; ++x) sum[static_cast<std::size_t>(x)] += g2 * s[x] + g * d[x];
      }
      std::uint8_t* out = edges.row(y);
      for (int x = 0; x < width; ++x) {
        const std::int64_t response = (sum[static_cast<std::size_t>(x)] * scale) >> kShift;
        out[x] = limited(static_cast<int>(response), options.limit);
      }
    }
  });
}

}  // namespace

OptionSet describe(EdgeOptions& options) {
  OptionSet set;
  set.add_choice("kind", options.kind, "what is matched",
                 {{"gradient", EdgeKind::kGradient},
                  {"laplacian", EdgeKind::kLaplacian},
                  {"none", EdgeKind::kNone}});
  set.add("gain", options.gain, "contrast of the edge image", 0.1, 64.0);
  set.add("limit", options.limit, "largest response, grey levels", 1, 128);
  set.add_odd("mask_px", options.mask_px, "side of the Laplacian of Gaussian mask, px", 3, 11);
  return set;
}

void edge_image(ImageView<const std::uint8_t> image, const EdgeOptions& options,
                Image<std::uint8_t>& edges, const Context& context) {
  const ScopedTimer timer(context, "stereo/edges");
  edges.resize(image.width, image.height);
  if (image.empty()) return;
  switch (options.kind) {
    case EdgeKind::kGradient:
      return gradient(image, options, edges, context);
    case EdgeKind::kLaplacian:
      return laplacian(image, options, edges, context);
    case EdgeKind::kNone:
      for (int y = 0; y < image.height; ++y) {
        std::copy(image.row(y), image.row(y) + image.width, edges.row(y));
      }
  }
}

int largest_edge_difference(const EdgeOptions& options) {
  return options.kind == EdgeKind::kNone ? 255 : std::min(255, 2 * options.limit);
}

}  // namespace tread
