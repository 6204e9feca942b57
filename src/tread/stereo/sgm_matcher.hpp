// Semi-global matching (Hirschmueller 2008) for where texture is poor: a pixel's cost is smoothed
// along paths that end in it, so that disparities of textured pixels reach into plain ones.
//
//   C(x, d)   = popcount(census(x) ^ census'(x - d)) + min(11, (sum over 5x3 of |E - E'|) / 8)
//               census: 5x5, of the grey values; E: edge images
//   L_r(x, d) = C(x, d) + min(L_r(x-r, d), L_r(x-r, d +- 1) + p1, min L_r(x-r) + p2) - min L_r(x-r)
//   S(x, d)   = sum of L_r over the paths: three, from the left, from the right and from above;
//               four, also from below; eight, also along both diagonals, both ways
//
// Three paths need one pass down the image. C is at most 35 and p2 at most 49, so that S fits a
// byte: 64 disparities of it are one AVX-512 register. More paths need a pass up as well, and a
// byte for each pixel and disparity of the image. Winner, checks and sub-pixel as in SadMatcher.
// Cost: O(pixels x disparities x paths).
#pragma once

#include <vector>

#include "tread/core/options.hpp"
#include "tread/core/timer.hpp"
#include "tread/stereo/hole_filter.hpp"
#include "tread/stereo/sad_matcher.hpp"
#include "tread/stereo/speckle_filter.hpp"

namespace tread {

enum class SgmPaths { kThree, kFour, kEight };

struct SgmOptions {
  // The range is not described: StereoMatcher hands on that of SadOptions.
  int min_disparity_px = 0;  // first disparity tried
  int num_disparities = 64;  // how many are tried
  SgmPaths paths = SgmPaths::kThree;
  int p1 = 10;  // price of a step of one disparity along a path
  int p2 = 49;  // of a larger step; at most 49
  SubPixel sub_pixel = SubPixel::kSymmetricV;
  bool strict_sub_pixel = true;  // as in SadOptions, these four
  int uniqueness_percent = 3;
  int left_right_tolerance_px = 1;
  // In the place of StereoOptions' own. Smoothed surfaces hold together where block matching's fall
  // apart; and their holes are mostly noise within a surface, not edges.
  HoleFilterOptions holes = {.max_spread_px = 0.0};
  SpeckleOptions speckle = {true, 200, 1.0};
  [[nodiscard]] bool operator==(const SgmOptions&) const = default;
};
[[nodiscard]] OptionSet describe(SgmOptions& options);

// Working memory, kept between frames.
class SgmMatcher {
 public:
  // The grey images and their edge images must have one size and at least one pixel, the options be
  // in range (StereoMatcher checks). `disparity`, of the left image, is resized, as is
  // `residual` if it is not null.
  void match(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right,
             ImageView<const std::uint8_t> left_edges, ImageView<const std::uint8_t> right_edges,
             const SgmOptions& options, Image<Disparity>& disparity,
             Image<std::uint8_t>* residual = nullptr, const Context& context = {});

 private:
  struct Job;
  void match_streaming(const Job& job);
  void match_full(const Job& job);

  Image<std::uint8_t> left_census_;
  Image<std::uint8_t> right_census_;
  Image<std::uint8_t> costs_;                // of a block of rows: C, then both side paths
  Image<std::uint8_t> above_;                // the path from above, of the row before
  Image<std::uint8_t> fronts_;               // two fronts, and the sum of a row of paths up
  Image<std::uint8_t> down_;                 // of all of the image: the sum of the paths down
  Image<std::uint8_t> pixels_;               // results of the rows of a block
  std::vector<Image<std::uint8_t>> memory_;  // by worker
};

}  // namespace tread
