// The whole way from a rectified pair to a disparity image (paper Q, Fig. 4):
// edge images -> SAD with checks and sub-pixel -> hole filter -> speckle filter; or semi-global
// matching in the place of SAD.
#pragma once

#include <optional>

#include "tread/core/result.hpp"
#include "tread/stereo/edge_image.hpp"
#include "tread/stereo/hole_filter.hpp"
#include "tread/stereo/sad_matcher.hpp"
#include "tread/stereo/sgm_matcher.hpp"
#include "tread/stereo/speckle_filter.hpp"
#include "tread/stereo/temporal_filter.hpp"

namespace tread {

enum class StereoMethod {
  kSad,  // block matching: the fastest, and few errors
  kSgm,  // semi-global matching: more pixels where texture is poor, at three times the time
};

struct StereoOptions {
  StereoMethod method = StereoMethod::kSad;
  EdgeOptions edges;
  SadOptions sad;  // its range of disparities is that of both methods
  SgmOptions sgm;
  HoleFilterOptions holes;
  SpeckleOptions speckle;
  TemporalOptions temporal;
  bool rate = false;  // also how sure each match is: StereoMatcher::residual()
  [[nodiscard]] bool operator==(const StereoOptions&) const = default;
};
[[nodiscard]] OptionSet describe(StereoOptions& options);

// As paper Q ran it: 640x480, right reference, disparities 10 to 74 px, quarter-pixel steps, no
// uniqueness, texture or left-right check, hole filter over space and time, speckle filter.
[[nodiscard]] StereoOptions paper_q_stereo_options();

// One a stream: keeps the working memory and the previous frame.
//   StereoMatcher matcher;
//   Result<ImageView<const Disparity>> disparity = matcher.match(left, right, options);
class StereoMatcher {
 public:
  // The images must be rectified, 8-bit grey, of one size. The view is valid until the next call.
  // With one thread nothing is allocated after the first frame of a size and options, except with
  // edges of kind laplacian and with windows that the kernels do not take (SadOptions). Errors:
  // empty images, sizes that differ, options out of range, a range wider than the image, images
  // wider than 65535 px.
  [[nodiscard]] Result<ImageView<const Disparity>> match(ImageView<const std::uint8_t> left,
                                                         ImageView<const std::uint8_t> right,
                                                         const StereoOptions& options,
                                                         const Context& context = {});
  // Forgets the frame before, as where another stream begins.
  void reset() {
    holes_.reset();
    temporal_.reset();
  }
  // Of the last match, with options.rate; else empty. Of pixels that have a disparity.
  [[nodiscard]] ImageView<const std::uint8_t> residual() const { return residual_; }

 private:
  std::optional<StereoOptions> checked_;  // the last options found good
  Image<std::uint8_t> left_edges_;
  Image<std::uint8_t> right_edges_;
  Image<Disparity> disparity_;
  Image<std::uint8_t> residual_;
  SadMatcher sad_;
  SgmMatcher sgm_;
  HoleFilter holes_;
  SpeckleFilter speckle_;
  TemporalFilter temporal_;
};

}  // namespace tread
