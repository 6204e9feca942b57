#include "tread/pipeline/slam_pipeline.hpp"

#include <algorithm>

#include "tread/slam/inertial_start.hpp"

namespace tread {
namespace {

// Depths of stereo err alike all over a window, and do so in frame after frame: as many pixels say
// what one would that errs by itself.
constexpr double kStereoCorrelation = 3000.0;

// What odometry says of the motion, for the dense tracker.
std::optional<MotionPrior> motion_of(const OdometryState& state) {
  const bool is_known =
      state.status == OdometryStatus::kTracked || state.status == OdometryStatus::kHeld;
  if (!is_known) return std::nullopt;
  // Both poses of a motion err; and nothing is known better than this.
  constexpr double kLeastWay_m = 1e-4, kLeastTurn_rad = 1e-5;
  MotionPrior motion{state.T_before_now, 2.0 * state.covariance};
  motion.covariance.diagonal().head<3>().array() += kLeastWay_m * kLeastWay_m;
  motion.covariance.diagonal().tail<3>().array() += kLeastTurn_rad * kLeastTurn_rad;
  return motion;
}

}  // namespace

OptionSet describe(SlamPipelineOptions& options) {
  OptionSet set = describe(options.slam);
  set.add_group("odometry", describe(options.odometry));
  set.add("use_odometry", options.use_odometry, "visual odometry, where there are pairs");
  set.add("use_imu", options.use_imu, "the IMU, where there is one");
  set.add_automatic("fit_to_rig", options.fit_to_rig,
                    "with stereo, voxels, range and gates that fit what the rig can see; off where "
                    "volume.voxel_m is given alone",
                    "volume.voxel_m");
  return set;
}

SlamPipelineOptions fit_to_rig(const DepthFrames& frames, SlamPipelineOptions options,
                               const OptionSet* given) {
  if (!frames.noise()) return options;
  const auto set = [&](const char* name, double& value, double to) {
    if (given == nullptr || !given->given(name)) value = to;
  };
  SlamOptions& slam = options.slam;
  set("noise.constant_m", slam.noise.constant_m, frames.noise()->constant_m);
  set("noise.quadratic_per_m", slam.noise.quadratic_per_m, frames.noise()->quadratic_per_m);
  set("align.observability.correlation", slam.align.observability.correlation, kStereoCorrelation);
  if (!options.fit_to_rig) return options;
  const double range = *frames.range_m();
  slam.volume.voxel_m = std::clamp(range / 400.0, 0.005, 0.2);
  set("integrate.farthest_m", slam.integrate.farthest_m, range);
  set("integrate.reference_m", slam.integrate.reference_m, range / 5.0);
  set("align.gate_m", slam.align.gate_m, std::max(0.1, 10.0 * slam.volume.voxel_m));
  set("speed_sigma_m_per_s", slam.speed_sigma_m_per_s, std::max(1.0, range / 8.0));
  return options;
}

SlamPipeline::SlamPipeline(const DepthFrames& frames, const SlamPipelineOptions& options)
    : options_(options) {
  if (!frames.rig()) options_.use_odometry = false;
}

void SlamPipeline::start(const DepthFrames& frames) {
  Isometry3d T_world_first = Isometry3d::Identity();
  T_world_first.linear() = R_body_optical();
  const std::optional<Imu> imu = options_.use_imu ? frames.imu() : std::nullopt;
  if (imu) {
    const auto level = level_camera(frames.pair().imu, imu->T_imu_left.inverse());
    if (level) T_world_first.linear() = *level;
  }
  slam_.emplace(frames.camera(), options_.slam, T_world_first);
  if (options_.use_odometry)
    odometry_.emplace(*frames.rig(), options_.odometry, T_world_first, imu);
}

Result<SlamStep> SlamPipeline::step(const DepthFrames& frames, const RgbdFrame& in,
                                    const Context& context) {
  if (!slam_) start(frames);
  SlamStep step;
  SlamFrame frame{in.stamp_ns, in.depth, in.grey, in.rgb};
  if (odometry_) {
    const DepthFrames::Pair pair = frames.pair();
    const auto state =
        odometry_->track({in.stamp_ns, pair.left, pair.right, std::nullopt, pair.imu}, context);
    if (!state) return forward(state);
    step.odometry = *state;
    frame.motion = motion_of(*state);
  }
  const auto state = slam_->track(frame, context);
  if (!state) return forward(state);
  step.slam = *state;
  const bool told_by_pair = step.odometry && step.odometry->status == OdometryStatus::kTracked;
  if (told_by_pair && step.slam.status == TrackStatus::kHeld) {
    step.slam.status = TrackStatus::kTracked;
  }
  return step;
}

}  // namespace tread
