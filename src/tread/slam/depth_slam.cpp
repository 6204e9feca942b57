#include "tread/slam/depth_slam.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "tread/slam/keyframe_bank.hpp"
#include "tread/slam/loop_closer.hpp"
#include "tread/slam/ray_cast.hpp"
#include "tread/slam/slam_input.hpp"

namespace tread {
namespace {

constexpr int kHalveFrom = 480;  // images at least so wide are tracked at half their resolution
constexpr double kPlaceSigma = 0.05;  // m and rad: how well a place says where a lost camera is

LoopSetup loop_setup(const SlamOptions& options) {
  constexpr double kNear = 0.6;  // of the distance of two keyframes
  LoopSetup setup;
  setup.loop = options.loop;
  setup.noise = options.noise;
  setup.align = options.align;
  setup.voxel_m = options.volume.voxel_m;
  setup.farthest_m = options.integrate.farthest_m;
  setup.near_way = kNear * options.key_way;
  setup.near_rad = kNear * options.key_turn_deg * std::numbers::pi / 180.0;
  return setup;
}

double turn_between(const Isometry3d& a, const Isometry3d& b) {
  return so3_log(a.linear().transpose() * b.linear()).norm();
}

}  // namespace

struct DepthSlam::Impl {
  Impl(const PinholeCamera& with, const SlamOptions& chosen, const Isometry3d& T_world_first)
      : made(check_start(with, chosen, T_world_first)),
        camera(Pinhole::of(with)),
        options(chosen),
        volume(made ? chosen.volume : VolumeOptions{}),
        loops(loop_setup(made ? chosen : SlamOptions{})),
        T_world(T_world_first) {}

  void prepare(const SlamFrame& in, const Context& context);
  [[nodiscard]] PosePrior predict(const SlamFrame& in) const;
  [[nodiscard]] TrackStatus judge(const Alignment& found, bool has_prior) const;
  [[nodiscard]] bool holds(const SlamFrame& in) const;
  void map(const SlamFrame& in, SlamState& state, const Context& context);
  void see_model(const Context& context);
  void see_model_from(const Isometry3d& T, double band_m, const Context& context);
  void relocalise(const SlamFrame& in, SlamState& state, const Context& context);
  bool find_place(const SlamFrame& in, SlamState& state, const Context& context);
  void believe(const Alignment& found, std::int64_t anchor, SlamState& state);
  void close_loop(const SlamFrame& in, SlamState& state, const Context& context);
  [[nodiscard]] bool fits_again(const Alignment& found) const;
  void renew_keyframe(SlamState& state);
  void learn_share(const Alignment& found);

  Status made;  // whether it was made with what it can work with
  Pinhole camera;
  SlamOptions options;
  VoxelVolume volume;
  Integrator integrator;
  NormalFinder normals;
  LoopCloser loops;
  bool started = false;
  bool halved = false;
  int width = 0, height = 0;
  std::int64_t stamp_ns = 0;
  Isometry3d T_world;                    // of the last frame
  Vector6d velocity = Vector6d::Zero();  // right twist, a second
  AlignFrame frame, before;              // at hand, and the one before
  Image<float> half;                     // depth as measured, at tracking resolution
  Image<float> clean;                    // as given, unknown made NaN
  std::array<DepthLevel, 3> model;
  Isometry3d T_world_model = Isometry3d::Identity();
  PhotoKeyframe key;
  bool has_key = false;
  KeyframeBank bank;
  bool lost = false;             // the frame before
  double intensity_share = 0.2;  // until more is known
  double mean_depth_m = 1.0;
};

void DepthSlam::Impl::prepare(const SlamFrame& in, const Context& context) {
  const ScopedTimer timer(context, "slam/prepare");
  // What is not a depth is not a number from here on.
  clean.resize(in.depth.width, in.depth.height);
  const auto farthest = static_cast<float>(options.integrate.farthest_m);
  for (int y = 0; y < in.depth.height; ++y) {
    const float* from = in.depth.row(y);
    float* to = clean.row(y);
    for (int x = 0; x < in.depth.width; ++x) {
      to[x] =
          from[x] > 0.0F && from[x] <= farthest ? from[x] : std::numeric_limits<float>::quiet_NaN();
    }
  }
  halved = in.depth.width >= kHalveFrom;
  if (halved) {
    halve_depth(clean, options.noise, half, context);
  } else {
    half = clean;
  }
  DepthLevel& fine = frame.depth[0];
  fine.resize(halved ? camera.halved() : camera, half.width, half.height);
  fine.depth = half;
  if (const double mean = mean_depth(half); mean > 0.0) mean_depth_m = mean;
  normals.build_pyramid(options.noise, frame.depth, context);
  if (in.grey.empty()) {
    for (GreyLevel& level : frame.grey) level.intensity.resize(0, 0);
  } else {
    build_grey_pyramid(in.grey, halved, frame.grey, context);
  }
}

PosePrior DepthSlam::Impl::predict(const SlamFrame& in) const {
  const double dt = static_cast<double>(in.stamp_ns - stamp_ns) * 1e-9;
  PosePrior prior;
  if (in.motion) {
    prior.T_world_camera = T_world * in.motion->T_before_now;
    prior.information = in.motion->covariance.inverse();
    return prior;
  }
  // After a gap nothing is known of the speed.
  Isometry3d motion = dt < 0.3 ? se3_exp(Vector6d(velocity * dt)) : Isometry3d::Identity();
  if (options.turn_first && frame.has_grey() && before.has_grey()) {
    const Eigen::Matrix3d turn =
        align_rotation(before.grey[2], frame.grey[2], frame.depth[2].camera, motion.linear());
    motion.linear() = turn;
  }
  prior.T_world_camera = T_world * motion;
  const double way = options.speed_sigma_m_per_s * dt, turn = options.turn_sigma_rad_per_s * dt;
  prior.information.diagonal() << Eigen::Vector3d::Constant(1.0 / (way * way)),
      Eigen::Vector3d::Constant(1.0 / (turn * turn));
  return prior;
}

TrackStatus DepthSlam::Impl::judge(const Alignment& found, bool has_prior) const {
  if (!found.T_world_camera.matrix().allFinite()) return TrackStatus::kLost;
  const auto matched = static_cast<double>(found.matched);
  if (found.measured < 100 ||
      matched < options.least_matched * static_cast<double>(found.measured) ||
      found.depth_rms > options.largest_rms) {
    return TrackStatus::kLost;
  }
  if (!found.observability.all_known()) {
    return has_prior ? TrackStatus::kHeld : TrackStatus::kUnobservable;
  }
  return TrackStatus::kTracked;
}

// A motion known to better than a voxel, over all that is in view, needs no fit to go on by.
bool DepthSlam::Impl::holds(const SlamFrame& in) const {
  if (!in.motion || lost) return false;
  const Matrix6d& c = in.motion->covariance;
  const double way = std::sqrt(c.topLeftCorner<3, 3>().trace()),
               turn = std::sqrt(c.bottomRightCorner<3, 3>().trace());
  return way + turn * mean_depth_m < options.volume.voxel_m;
}

// The model as a camera at T sees it, at most band_m from the depths at hand.
void DepthSlam::Impl::see_model_from(const Isometry3d& T, double band_m, const Context& context) {
  model[0].resize(frame.depth[0].camera, half.width, half.height);
  ray_cast(volume, T, frame.depth[0].depth, band_m, model[0], context);
  const ScopedTimer timer(context, "slam/model_pyramid");
  normals.build_pyramid(options.noise, model, context);
  T_world_model = T;
}

void DepthSlam::Impl::see_model(const Context& context) {
  see_model_from(T_world, std::max(options.align.gate_m, 6.0 * options.volume.voxel_m), context);
}

bool DepthSlam::Impl::fits_again(const Alignment& found) const {
  return found.T_world_camera.matrix().allFinite() && found.measured >= 100 &&
         static_cast<double>(found.matched) >=
             options.least_matched_again * static_cast<double>(found.measured) &&
         found.depth_rms <= options.largest_rms_again && found.observability.all_known() &&
         2 * found.photo_matched >= found.photo_points &&
         found.grey_rms <= options.largest_grey_again;
}

// Lost: the frame is tried at the places that look like it. Depth and image must both fit there.
void DepthSlam::Impl::relocalise(const SlamFrame& in, SlamState& state, const Context& context) {
  const ScopedTimer timer(context, "slam/relocalise");
  if (options.loop.enabled && frame.has_grey() && find_place(in, state, context)) return;
  constexpr std::size_t kCandidates = 4;
  constexpr double kBandM = 0.5;
  constexpr int kLeastPoints = 100;
  for (const KeyframeBank::Candidate& candidate : bank.find(frame, kCandidates)) {
    if (candidate.key.points[2].size() < kLeastPoints) continue;  // nothing to tell it by
    PosePrior prior;
    prior.T_world_camera = candidate.T_world_camera;
    prior.information.setIdentity();  // a metre, a radian
    AlignOptions wide = options.align;
    wide.gate_m = kBandM;
    wide.coarse_iterations = 30;
    wide.middle_iterations = 10;
    see_model_from(prior.T_world_camera, kBandM, context);
    prior.T_world_camera =
        align(frame, &model, T_world_model, &candidate.key, prior, options.noise, wide, context)
            .T_world_camera;
    if (!prior.T_world_camera.matrix().allFinite()) continue;
    // Once more from there, as strictly as always.
    see_model_from(prior.T_world_camera, kBandM, context);
    const Alignment found = align(frame, &model, T_world_model, &candidate.key, prior,
                                  options.noise, options.align, context);
    if (fits_again(found)) return believe(found, candidate.anchor, state);
  }
}

// By corners: from other angles as well, and not to be misled by a place that looks much the same.
bool DepthSlam::Impl::find_place(const SlamFrame& in, SlamState& state, const Context& context) {
  const auto place = loops.find({frame, in.rgb, T_world}, context);
  if (!place) return false;
  PosePrior prior;
  prior.T_world_camera = place->T_world_camera;
  prior.information.diagonal().setConstant(1.0 / (kPlaceSigma * kPlaceSigma));
  see_model_from(prior.T_world_camera, options.align.gate_m, context);
  const Alignment found =
      align(frame, &model, T_world_model, nullptr, prior, options.noise, options.align, context);
  // There is no image to compare with; the corners of the place have agreed already.
  if (!fits_again(found)) return false;
  believe(found, place->place, state);
  return true;
}

void DepthSlam::Impl::believe(const Alignment& found, std::int64_t anchor, SlamState& state) {
  state.alignment = found;
  state.covariance = found.covariance;
  state.status = TrackStatus::kTracked;
  state.relocalised = true;
  T_world = found.T_world_camera;
  velocity.setZero();
  loops.go_on_from(anchor, T_world, found.covariance);
}

void DepthSlam::Impl::renew_keyframe(SlamState& state) {
  const Alignment& found = state.alignment;
  if (!frame.has_grey() || !state.mapped()) return;
  if (has_key && found.photo_points > 0 && !state.relocalised) {
    const auto share = static_cast<double>(found.photo_matched) /
                       static_cast<double>(std::max<std::int64_t>(found.photo_points, 1));
    const double turn = turn_between(key.T_world_camera, T_world);
    const double way = (key.T_world_camera.translation() - T_world.translation()).norm();
    if (share >= options.key_matched && turn < options.key_turn_deg * std::numbers::pi / 180.0 &&
        way < options.key_way * mean_depth_m) {
      return;
    }
  }
  const double noise = grey_noise(frame.grey[0].intensity);
  for (std::size_t level = 0; level < 3; ++level) {
    const int most = options.photo_points >> (2 * level);
    const double least_slope = std::max(1.0, 3.0 * kSlopeNoise * noise / (1 << level));
    choose_photo_points(frame.grey[level], model[level], least_slope, std::max(most, 100),
                        key.points[level]);
    key.camera[level] = frame.depth[level].camera;
  }
  key.T_world_camera = T_world;
  has_key = true;
  state.keyframe = true;
}

// The keyframe at hand may show a place that was seen before.
void DepthSlam::Impl::close_loop(const SlamFrame& in, SlamState& state, const Context& context) {
  const auto corrected = loops.keyframe({frame, in.rgb, T_world}, context);
  if (!corrected) return;
  T_world = *corrected;
  key.T_world_camera = T_world;
  bank.move([this](std::int64_t anchor) { return loops.correction_of(anchor); });
  volume.clear();
  const Pinhole& fine = frame.depth[0].camera;
  loops.fuse_all(fine, options.window_ahead_m, options.integrate, volume, integrator, context);
  see_model(context);
  state.T_world_camera = T_world;
  state.loop_closed = true;
}

void DepthSlam::Impl::learn_share(const Alignment& found) {
  constexpr double kMemory = 0.7;  // of some three frames
  if (found.disagreement <= 0.0) return;
  const double fits = std::clamp(1.0 / (found.disagreement * found.disagreement),
                                 options.least_intensity_share, 1.0);
  intensity_share = kMemory * intensity_share + (1.0 - kMemory) * fits;
}

void DepthSlam::Impl::map(const SlamFrame& in, SlamState& state, const Context& context) {
  volume.centre_on(T_world * Eigen::Vector3d(0.0, 0.0, options.window_ahead_m));
  const FusionFrame fusion{clean, in.rgb, in.grey, camera, T_world};
  state.blocks = integrator.integrate(fusion, options.noise, options.integrate, volume, context);
}

DepthSlam::DepthSlam(const PinholeCamera& camera, const SlamOptions& options,
                     const Isometry3d& T_world_first)
    : impl_(std::make_unique<Impl>(camera, options, T_world_first)) {}
DepthSlam::~DepthSlam() = default;
DepthSlam::DepthSlam(DepthSlam&&) noexcept = default;
DepthSlam& DepthSlam::operator=(DepthSlam&&) noexcept = default;
const VoxelVolume& DepthSlam::volume() const {
  return impl_->volume;
}
const SlamOptions& DepthSlam::options() const {
  return impl_->options;
}
Trajectory DepthSlam::trajectory() const {
  return impl_->loops.trajectory();
}
int DepthSlam::loops() const {
  return impl_->loops.loops();
}
std::size_t DepthSlam::keyframe_bytes() const {
  return impl_->loops.bytes();
}

Result<SlamState> DepthSlam::track(const SlamFrame& in, const Context& context) {
  Impl& slam = *impl_;
  if (!slam.made) return tl::unexpected(slam.made.error());
  const SlamInput before{slam.started, slam.width, slam.height, slam.stamp_ns};
  if (Status good = check_frame(in, before); !good) return tl::unexpected(good.error());
  const ScopedTimer timer(context, "slam");
  std::swap(slam.frame, slam.before);
  slam.prepare(in, context);
  SlamState state;
  state.stamp_ns = in.stamp_ns;
  if (!slam.started) {
    slam.width = in.depth.width;
    slam.height = in.depth.height;
    slam.started = mean_depth(slam.frame.depth[1].depth) > 0.0;
    state.status = slam.started ? TrackStatus::kFirst : TrackStatus::kLost;
    state.covariance.setZero();
  } else {
    const PosePrior prior = slam.predict(in);
    AlignOptions options = slam.options.align;
    options.intensity_share *= slam.intensity_share;
    state.alignment =
        align(slam.frame, &slam.model, slam.T_world_model, slam.has_key ? &slam.key : nullptr,
              prior, slam.options.noise, options, context);
    slam.learn_share(state.alignment);
    state.status = slam.judge(state.alignment, in.motion.has_value());
    // What was lost must be found by more than a fair fit.
    if (slam.lost && state.status != TrackStatus::kLost && slam.frame.has_grey() &&
        !slam.fits_again(state.alignment)) {
      state.status = TrackStatus::kLost;
    }
    state.covariance = state.alignment.covariance;
    // Depths too rough to be fitted, as stereo has them after one frame: the motion is known.
    if (state.status == TrackStatus::kLost && slam.holds(in)) {
      state.status = TrackStatus::kHeld;
      state.alignment.T_world_camera = prior.T_world_camera;
      state.covariance = in.motion->covariance;
    }
    if (state.status != TrackStatus::kLost) {
      const double dt = static_cast<double>(in.stamp_ns - slam.stamp_ns) * 1e-9;
      slam.velocity = se3_log(slam.T_world.inverse() * state.alignment.T_world_camera) / dt;
      // A guess must not feed the next one.
      if (state.status == TrackStatus::kUnobservable) slam.velocity *= 0.8;
      slam.T_world = state.alignment.T_world_camera;
    } else {
      slam.velocity.setZero();
      const Isometry3d T_model = slam.T_world_model;
      const auto model = slam.model;
      slam.relocalise(in, state, context);
      if (state.status == TrackStatus::kLost) {  // as it was, for the next frame
        slam.model = model;
        slam.T_world_model = T_model;
      }
    }
    slam.lost = state.status == TrackStatus::kLost;
  }
  slam.stamp_ns = in.stamp_ns;
  state.T_world_camera = slam.T_world;
  if (state.mapped()) slam.map(in, state, context);
  if (state.status != TrackStatus::kLost) {
    slam.see_model(context);
    slam.renew_keyframe(state);
    if (!state.relocalised) slam.loops.follow(slam.T_world, state.covariance);
    if (state.keyframe && slam.options.loop.enabled) slam.close_loop(in, state, context);
    if (state.keyframe) {
      slam.bank.add(slam.frame, slam.model[2], slam.T_world, slam.loops.anchor());
    }
    if (state.mapped()) slam.loops.map(in.stamp_ns);
  }
  return state;
}

}  // namespace tread
