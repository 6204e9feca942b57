#include "tread/pipeline/depth_frames.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "tread/stereo/disparity_range.hpp"

namespace tread {
namespace {

constexpr double kSigmaDisparityPx = 0.25;

}  // namespace

Result<DepthFrames> DepthFrames::open(const std::filesystem::path& path,
                                      const DepthFramesOptions& options) {
  if (looks_like_rgbd(path)) {
    DepthFrames frames;
    frames.options_ = options;
    auto source = open_rgbd_source(path, options.rgbd);
    if (!source) return forward(source);
    frames.rgbd_ = std::move(*source);
    frames.camera_ = frames.rgbd_->camera().pinhole;
    return frames;
  }
  auto source = open_stereo_source(path, options.stereo_source);
  if (!source) return forward(source);
  return from(std::move(*source), options);
}

Result<DepthFrames> DepthFrames::from(std::unique_ptr<StereoSource> pairs,
                                      const DepthFramesOptions& options) {
  DepthFrames frames;
  frames.options_ = options;
  frames.pairs_ = std::move(pairs);
  if (Status ok = frames.prepare_stereo(); !ok) return tl::unexpected(ok.error());
  return frames;
}

Status DepthFrames::prepare_stereo() {
  const StereoRig& rig = pairs_->rig();
  if (rig.rectified) {
    const auto rectified = rectified_rig(rig);
    if (!rectified) return forward(rectified);
    rig_ = *rectified;
  } else {
    auto rectification = make_rectification(rig);
    if (!rectification) return forward(rectification);
    rectification_ = std::move(*rectification);
    rig_ = rectification_->rig;
    T_left_camera_.linear() = rectification_->R_rectified_left.transpose();
  }
  camera_ = {rig_->fx_px, rig_->fy_px, rig_->cx_px, rig_->cy_px, 0.0};
  noise_ = stereo_noise(rig_->fx_px, rig_->baseline_m, kSigmaDisparityPx);
  if (rig.imu && pairs_->has_imu()) {
    imu_ = rig.imu;
    imu_->T_imu_left = imu_->T_imu_left * T_left_camera_;
  }
  return {};
}

std::optional<double> DepthFrames::range_m() const {
  if (!noise_) return std::nullopt;
  return 1.0 / (40.0 * noise_->quadratic_per_m);
}

int DepthFrames::frame_count() const {
  return rgbd_ ? rgbd_->frame_count() : pairs_->frame_count();
}

std::string DepthFrames::kind() const {
  return rgbd_ ? rgbd_->kind() : pairs_->kind();
}

const Trajectory& DepthFrames::truth() const {
  return rgbd_ ? rgbd_->truth() : truth_;
}

const std::vector<Error>& DepthFrames::problems() const {
  return rgbd_ ? rgbd_->problems() : pairs_->problems();
}

Result<std::optional<RgbdFrame>> DepthFrames::next(const Context& context) {
  return rgbd_ ? rgbd_->next() : next_pair(context);
}

Result<std::optional<RgbdFrame>> DepthFrames::next_pair(const Context& context) {
  auto pair = pairs_->next();
  if (!pair) return forward(pair);
  if (!*pair) return std::optional<RgbdFrame>();
  StereoFrame& in = **pair;
  RgbdFrame out;
  out.stamp_ns = in.stamp_ns;
  out.name = in.name;
  samples_ = std::move(in.imu);
  if (rectification_) {
    left_.resize(in.left.width, in.left.height);
    right_.resize(in.right.width, in.right.height);
    remap(in.left, rectification_->left, left_, context);
    remap(in.right, rectification_->right, right_, context);
    if (!in.left_colour.empty()) {
      out.rgb.resize(in.left.width, in.left.height);
      remap(in.left_colour, rectification_->left, out.rgb, context);
    }
  } else {
    std::swap(left_, in.left);
    std::swap(right_, in.right);
    out.rgb = std::move(in.left_colour);
  }
  if (!range_chosen_) {
    const auto needed = estimate_num_disparities(left_, right_, options_.stereo, context);
    if (!needed) return forward(needed);
    int& range = options_.stereo.sad.num_disparities;
    range = std::min(left_.width - options_.stereo.sad.min_disparity_px, std::max(range, *needed));
    range_chosen_ = true;
  }
  const auto disparity = matcher_.match(left_, right_, options_.stereo, context);
  if (!disparity) return forward(disparity);
  depth_image(*disparity, *rig_, options_.depth, out.depth, context);
  out.grey = left_;
  if (in.T_world_left) {
    out.T_world_camera = *in.T_world_left * T_left_camera_;
    truth_.push_back({in.stamp_ns, *out.T_world_camera});
  }
  return std::optional(std::move(out));
}

}  // namespace tread
