// Stereo visual odometry: rectified pairs in, the camera's path out. Corners are followed from
// the last keyframe, the pose is fitted to them robustly, and the last keyframes are refined
// together (the scheme of Nister, Naroditsky, Bergen 2004, which paper R's rover drove by, with a
// window).
//
//   tread::VisualOdometry odometry(rig);
//   while (read(left, right)) {
//     const auto state = odometry.track({stamp_ns, left, right});
//     if (state && state->placed()) path.push_back({stamp_ns, state->T_world_camera});
//   }
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "tread/core/image.hpp"
#include "tread/core/options.hpp"
#include "tread/core/result.hpp"
#include "tread/slam/corner_tracker.hpp"
#include "tread/slam/fit_motion.hpp"
#include "tread/slam/motion_prior.hpp"
#include "tread/slam/refine_window.hpp"

namespace tread {

struct OdometryOptions {
  CornerOptions corners;
  FitMotionOptions fit;
  WindowOptions window;
  double nearest_m = 0.3;           // points nearer than that are not looked for
  double least_disparity_px = 0.8;  // nor those farther than where this is seen
  double key_share = 0.75;      // a new keyframe if a smaller part of the last one's points is left
  double key_flow = 0.04;       // or if they have moved so far, part of the image's width
  double key_interval_s = 0.5;  // or after so long, with an IMU
  double hold_s = 1.5;          // so long the IMU alone is believed
  [[nodiscard]] bool operator==(const OdometryOptions&) const = default;
};
[[nodiscard]] OptionSet describe(OdometryOptions& options);

struct OdometryFrame {
  std::int64_t stamp_ns = 0;
  ImageView<const std::uint8_t> left;   // rectified, of the rig's size
  ImageView<const std::uint8_t> right;  // likewise
  std::optional<MotionPrior> motion = {};
  std::span<const ImuSample> imu = {};  // since the frame before, if an IMU was given
};

enum class OdometryStatus {
  kFirst,    // the first pair with anything to see
  kTracked,  // the pose was fitted to points seen before
  kHeld,     // nothing fitted: the pose is what the IMU or the motion prior says
  kLost,     // nor did these: the pose is a guess. Points seen before are looked for a second
             // long; then it starts anew from the guess
};
[[nodiscard]] const char* name_of(OdometryStatus status);

struct OdometryState {
  std::int64_t stamp_ns = 0;
  OdometryStatus status = OdometryStatus::kLost;
  Isometry3d T_world_camera = Isometry3d::Identity();  // of the left camera
  // Of the motion since the frame before, of a twist in axes of the camera, m^2 and rad^2.
  Matrix6d covariance = Matrix6d::Identity();
  Isometry3d T_before_now = Isometry3d::Identity();
  int followed = 0;  // points of known place that were found again
  int inliers = 0;   // of these, that agree on the pose
  double rms_px = 0.0;
  bool keyframe = false;
  bool inertial = false;   // the IMU takes part
  bool restarted = false;  // from here on poses hang together with those before by a guess only
  [[nodiscard]] bool placed() const { return status != OdometryStatus::kLost; }
};

class VisualOdometry {
 public:
  // With an IMU, whose T_imu_left is of the rectified camera, frames bring its samples: it tells
  // the turn from the first frame on, and after a second or two, when gravity and velocity are
  // found, takes part in all (Forster et al. 2017). See level_camera() for a world with z up.
  explicit VisualOdometry(const RectifiedRig& rig, const OdometryOptions& options = {},
                          const Isometry3d& T_world_first = Isometry3d::Identity(),
                          const std::optional<Imu>& imu = {});
  ~VisualOdometry();
  VisualOdometry(VisualOdometry&&) noexcept;
  VisualOdometry& operator=(VisualOdometry&&) noexcept;

  // Errors, after which the state is as before: what it was made with is not sound, images that are
  // not of the rig's size, a motion without covariance, a time that is not after the last one's.
  [[nodiscard]] Result<OdometryState> track(const OdometryFrame& frame,
                                            const Context& context = {});

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tread
