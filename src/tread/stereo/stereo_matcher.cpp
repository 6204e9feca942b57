#include "tread/stereo/stereo_matcher.hpp"

#include <fmt/format.h>

namespace tread {
namespace {

Status check_images(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right) {
  if (left.empty() || right.empty()) {
    return fail(ErrorCode::kBadArgument, "an image is empty", "stereo", "Give two images");
  }
  if (!same_size(left, right)) {
    return fail(ErrorCode::kBadArgument,
                fmt::format("the left image is {}x{}, the right one {}x{}", left.width, left.height,
                            right.width, right.height),
                "stereo", "Give a rectified pair of one size");
  }
  if (left.stride < left.width || right.stride < right.width) {
    return fail(ErrorCode::kBadArgument, "the rows of an image overlap", "stereo",
                "Give a stride of at least the width, in pixels");
  }
  return {};
}

Status check_against_image(const StereoOptions& options, int width) {
  constexpr int kWidest = 65535;  // what every file format has; sizes of memory fit an int
  if (width > kWidest) {
    return fail(ErrorCode::kTooLarge, fmt::format("the images are {} px wide", width), "stereo",
                fmt::format("Give images of at most {} px", kWidest));
  }
  const SadOptions& sad = options.sad;
  if (sad.min_disparity_px + sad.num_disparities > width) {
    return fail(
        ErrorCode::kBadValue,
        fmt::format("disparities {} to {} do not fit an image {} px wide", sad.min_disparity_px,
                    sad.min_disparity_px + sad.num_disparities - 1, width),
        "sad.num_disparities", "Search fewer disparities, or give larger images");
  }
  return {};
}

}  // namespace

OptionSet describe(StereoOptions& options) {
  OptionSet set;
  set.add_choice("method", options.method, "how pixels are matched",
                 {{"sad", StereoMethod::kSad}, {"sgm", StereoMethod::kSgm}});
  set.add_group("edges", describe(options.edges));
  set.add_group("sad", describe(options.sad));
  set.add_group("sgm", describe(options.sgm));
  set.add_group("holes", describe(options.holes));
  set.add_group("speckle", describe(options.speckle));
  set.add_group("temporal", describe(options.temporal));
  set.add("rate", options.rate, "also estimate how sure each match is");
  set.require({"sad.min_texture", "edges.kind"},
              "texture is measured on edge images: it must be 0 where they are off", [&options] {
                return options.sad.min_texture <= 0.0 || options.edges.kind != EdgeKind::kNone;
              });
  set.require({"method", "sad.reference"}, "sgm matches the left image only", [&options] {
    return options.method == StereoMethod::kSad || options.sad.reference == Reference::kLeft;
  });
  return set;
}

StereoOptions paper_q_stereo_options() {
  StereoOptions options;
  options.edges = {EdgeKind::kLaplacian, 4.0, 128, 7};
  options.sad.reference = Reference::kRight;
  options.sad.window_width_px = 11;
  options.sad.window_height_px = 11;
  options.sad.min_disparity_px = 10;
  options.sad.num_disparities = 65;  // 10 to 74, both included
  options.sad.border = Border::kFullWindow;
  options.sad.reduced_range_at_border = false;
  options.sad.sub_pixel_steps = 4;
  options.sad.uniqueness_percent = 0;
  options.sad.min_texture = 0.0;
  options.sad.left_right_tolerance_px = -1;
  options.holes = {};
  options.holes.temporal = true;
  options.holes.median = HoleFilterOptions::Median::kAll;
  options.holes.max_spread_px = 0.0;
  options.holes.passes = 1;
  options.speckle.max_size_px = 200;
  options.speckle.max_difference_px = 1.0;
  return options;
}

Result<ImageView<const Disparity>> StereoMatcher::match(ImageView<const std::uint8_t> left,
                                                        ImageView<const std::uint8_t> right,
                                                        const StereoOptions& options,
                                                        const Context& context) {
  if (Status ok = check_images(left, right); !ok) return forward(ok);
  if (checked_ != options) {
    if (Status ok = check_options(options); !ok) return forward(ok);
    checked_ = options;
  }
  if (Status ok = check_against_image(options, left.width); !ok) return forward(ok);
  Image<std::uint8_t>* residual = options.rate ? &residual_ : nullptr;
  if (!options.rate) residual_ = {};
  edge_image(left, options.edges, left_edges_, context);
  edge_image(right, options.edges, right_edges_, context);
  if (options.method == StereoMethod::kSgm) {
    SgmOptions sgm = options.sgm;
    sgm.min_disparity_px = options.sad.min_disparity_px;
    sgm.num_disparities = options.sad.num_disparities;
    sgm_.match(left, right, left_edges_, right_edges_, sgm, disparity_, residual, context);
  } else {
    sad_.match(left_edges_, right_edges_, options.sad, largest_edge_difference(options.edges),
               disparity_, residual, context);
  }
  const bool by_sgm = options.method == StereoMethod::kSgm;
  holes_.apply(disparity_, by_sgm ? options.sgm.holes : options.holes, context);
  speckle_.apply(disparity_, by_sgm ? options.sgm.speckle : options.speckle, context);
  temporal_.apply(disparity_, options.temporal, context);
  return disparity_.view();
}

}  // namespace tread
