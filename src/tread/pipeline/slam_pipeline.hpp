// Where the camera was and the surface it saw: visual odometry where there are pairs, with the IMU
// where there is one, and the dense map on top of it.
//
//   auto frames = tread::DepthFrames::open(folder, {});
//   tread::SlamPipeline pipeline(*frames, tread::fit_to_rig(*frames, {}));
//   while (true) {
//     const auto frame = frames->next();
//     if (!frame || !*frame) break;
//     const auto step = pipeline.step(*frames, **frame);
//     if (step && step->slam.mapped()) path.push_back({step->slam.stamp_ns,
//     step->slam.T_world_camera});
//   }
#pragma once

#include <optional>

#include "tread/pipeline/depth_frames.hpp"
#include "tread/slam/visual_odometry.hpp"

namespace tread {

struct SlamPipelineOptions {
  SlamOptions slam;
  OdometryOptions odometry;
  bool use_odometry = true;  // where there are pairs
  bool use_imu = true;       // where there is one
  bool fit_to_rig = true;    // see there
};
[[nodiscard]] OptionSet describe(SlamPipelineOptions& options);

// Options for what a stereo rig can see: it does so far, and so finely, as its baseline lets it. A
// four-hundredth of the range is a voxel. Of an RGB-D camera they are left as they are; so are
// those that `given`, if there is one, says were chosen.
[[nodiscard]] SlamPipelineOptions fit_to_rig(const DepthFrames& frames, SlamPipelineOptions options,
                                             const OptionSet* given = nullptr);

// What odometry fitted to a pair and the dense tracker took over counts as tracked, not as held.
struct SlamStep {
  SlamState slam;
  std::optional<OdometryState> odometry;  // of pairs
};

class SlamPipeline {
 public:
  // Errors of the options are those of the first step.
  SlamPipeline(const DepthFrames& frames, const SlamPipelineOptions& options);

  // The frame that `frames` yielded last. Errors: those of DepthSlam::track.
  [[nodiscard]] Result<SlamStep> step(const DepthFrames& frames, const RgbdFrame& frame,
                                      const Context& context = {});

  // Whether there was a step; before that there is no slam().
  [[nodiscard]] bool started() const { return slam_.has_value(); }
  // x ahead, y left, z up, by the IMU or, without, if the first camera was
  // level.
  [[nodiscard]] const DepthSlam& slam() const { return *slam_; }

 private:
  void start(const DepthFrames& frames);

  SlamPipelineOptions options_;
  std::optional<DepthSlam> slam_;
  std::optional<VisualOdometry> odometry_;
};

}  // namespace tread
