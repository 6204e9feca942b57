// Block matching by the sum of absolute differences over a square window (paper Q, IV-A.1): for
// every pixel of the reference image the disparity whose window differs least, refined below the
// pixel, with optional checks.
//
//   C(x, d) = sum over the window of |E_ref(x) - E_other(x -+ d)|     (left reference: x - d)
//   d0 = argmin C, ties to the smaller disparity
//   delta = (l - r) / (2 (max(l, r) - c)), l, c, r = C(d0 - 1), C(d0), C(d0 + 1)   symmetric V
//
// Cost: O(pixels x disparities), whatever the window, by running sums.
#pragma once

#include <vector>

#include "tread/core/options.hpp"
#include "tread/core/timer.hpp"
#include "tread/stereo/disparity.hpp"

namespace tread {

enum class Reference { kLeft, kRight };
enum class SubPixel {
  kNone,
  kSymmetricV,  // right for costs that grow linearly from the minimum, as SAD does (METHODS 4)
  kParabola,
};
enum class Border {
  kFullWindow,  // pixels whose window leaves the image have no match (paper Q's library)
  kReplicate,   // the window continues with the nearest pixels
};

struct SadOptions {
  Reference reference = Reference::kLeft;
  // Odd. Windows whose sum of differences can exceed 32766 (11x11 without edge images, 33x33 with
  // the default ones) are matched in plain code, some 25 times as slow.
  int window_width_px = 13;
  int window_height_px = 5;  // odd; lower than wide suits ground, whose disparity changes by row
  int min_disparity_px = 0;  // first disparity tried
  int num_disparities = 64;  // how many are tried
  Border border = Border::kReplicate;
  // At the border of the image the whole range does not fit: match there with the part of it that
  // does, or leave those pixels without match.
  bool reduced_range_at_border = true;
  SubPixel sub_pixel = SubPixel::kSymmetricV;
  int sub_pixel_steps = 64;  // steps a pixel that disparities are rounded to; paper Q: 4
  // No match where the best disparity is an end of the range, or its neighbours are not both
  // dearer: nothing says that it is a minimum.
  bool strict_sub_pixel = true;
  // No match unless every disparity but the best and its neighbours costs more than the best by
  // this many per cent, cut to 1/65536. 0: not checked.
  int uniqueness_percent = 15;
  // No match where the edge image varies less over the window, grey levels a pixel. 0: not checked.
  double min_texture = 0.0;
  // Where several pixels chose the same pixel of the other image, it belongs to the one with the
  // least cost; no match for those whose disparity differs from that one's by more than this.
  // Negative: not checked.
  int left_right_tolerance_px = 0;
  [[nodiscard]] bool operator==(const SadOptions&) const = default;
};
[[nodiscard]] OptionSet describe(SadOptions& options);

// Working memory, kept between frames.
class SadMatcher {
 public:
  // The images must have one size and at least one pixel, the options be in range (check_options);
  // both are the caller's to check (StereoMatcher does). No two pixels may differ by more than
  // largest_difference. `disparity` is resized,
  // as is `residual` if it is not null.
  void match(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right,
             const SadOptions& options, int largest_difference, Image<Disparity>& disparity,
             Image<std::uint8_t>* residual = nullptr, const Context& context = {});

 private:
  std::vector<Image<std::uint8_t>> memory_;  // by worker
  std::vector<int> column_sums_;             // of texture
};

}  // namespace tread
