// Edge images: matching depends on changes of brightness and not on brightness itself, which light
// and exposure alter (paper Q, IV-A.1). 8 bit, centred on 128, cut off symmetrically: a strong edge
// counts no more than a fair one, so that few pixels cannot decide for a whole window.
#pragma once

#include <cstdint>

#include "tread/core/image.hpp"
#include "tread/core/options.hpp"
#include "tread/core/timer.hpp"

namespace tread {

enum class EdgeKind {
  kGradient,   // horizontal Sobel: the direction in which the images differ; the better one on
               // real pairs (BENCHMARKS.md)
  kLaplacian,  // Laplacian of Gaussian, as the library of both papers had it (METHODS 4)
  kNone,       // match on the grey values themselves
};

struct EdgeOptions {
  EdgeKind kind = EdgeKind::kGradient;
  double gain = 1.0;  // response 128 + gain * filter
  int limit = 15;     // the response stays within 128 - limit .. 128 + limit
  int mask_px = 7;    // of the Laplacian: side of the mask, odd; sigma is a sixth of it
  [[nodiscard]] bool operator==(const EdgeOptions&) const = default;
};
[[nodiscard]] OptionSet describe(EdgeOptions& options);

// Pixels outside the image are the nearest ones inside. Integer arithmetic: the same bits
// everywhere. `edges` is resized to the input.
//   gradient:  (-1 0 1; -2 0 2; -1 0 1) * I
//   Laplacian: LoG * I, bright spots positive, scaled so that the positive part sums to 1
// Cost: nine taps a pixel for the gradient, 4 mask_px for the Laplacian.
void edge_image(ImageView<const std::uint8_t> image, const EdgeOptions& options,
                Image<std::uint8_t>& edges, const Context& context = {});

// The largest difference that two pixels of such images can have.
[[nodiscard]] int largest_edge_difference(const EdgeOptions& options);

}  // namespace tread
