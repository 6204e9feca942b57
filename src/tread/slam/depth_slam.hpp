// Dense localisation and mapping: depth images in, the camera's path and the surface out (paper Q
// §IV-B; Newcombe et al. 2011; Whelan et al. 2012 for the volume that moves).
//
//   tread::DepthSlam slam({.fx = 585, .fy = 585, .cx = 320, .cy = 240});
//   while (read(depth, grey)) {
//     const auto state = slam.track({stamp_ns, depth, grey});
//     if (state && state->mapped()) path.push_back({stamp_ns, state->T_world_camera});
//   }
//   const tread::Mesh surface = extract_mesh(slam.volume());
#pragma once

#include <memory>
#include <optional>

#include "tread/core/options.hpp"
#include "tread/core/result.hpp"
#include "tread/geometry/camera.hpp"
#include "tread/geometry/trajectory.hpp"
#include "tread/slam/align.hpp"
#include "tread/slam/integrate.hpp"
#include "tread/slam/loop_options.hpp"
#include "tread/slam/motion_prior.hpp"

namespace tread {

struct SlamOptions {
  VolumeOptions volume;
  IntegrateOptions integrate;
  AlignOptions align;
  DepthNoise noise;
  double window_ahead_m = 0.0;  // where the middle of the volume's window is, ahead of the camera
  bool turn_first = true;       // start from the turn that fits the images best
  // What is assumed of the motion between frames where nothing else is known: that it goes on as
  // before, to these deviations for each second.
  double speed_sigma_m_per_s = 1.0;
  double turn_sigma_rad_per_s = 3.0;
  double least_matched = 0.2;  // lost if less of the frame's surface meets the model's
  double largest_rms = 3.0;    // lost if residuals are larger, in their standard deviations
  // After it was lost, a frame must fit better than that to be believed.
  double least_matched_again = 0.5;
  double largest_rms_again = 1.5;
  double largest_grey_again = 9.0;  // mean difference to the picture of that place
  double key_matched = 0.75;         // a new keyframe if less of the old one is in view
  double key_turn_deg = 12.0;        // or after such a turn
  double key_way = 0.12;             // or after so much way, part of the mean depth
  // Images that are not quite those of the depth camera, or surfaces that shine, pull away from
  // what depth says: intensities weigh less as that is seen, but never less than this part.
  double least_intensity_share = 0.02;
  int photo_points = 20'000;  // of a keyframe at its finest level, at most
  LoopOptions loop;           // of frames with images
  [[nodiscard]] bool operator==(const SlamOptions&) const = default;
};
[[nodiscard]] OptionSet describe(SlamOptions& options);

struct SlamFrame {
  std::int64_t stamp_ns = 0;
  ImageView<const float> depth;  // metres along the optical axis, NaN (or <= 0) where unknown
  ImageView<const std::uint8_t> grey =
      {};                         // empty, or of the size of depth, seen by the same camera
  ImageView<const Rgb> rgb = {};  // only for the colour of the surface
  std::optional<MotionPrior> motion = {};
};

enum class TrackStatus {
  kFirst,         // the first frame with any depth: it is where the camera is
  kTracked,       // six directions told by the frame
  kHeld,          // some only by the motion prior, or all, if it is that good
  kUnobservable,  // some by nothing: the pose is a guess in these, and nothing is fused
  kLost,          // the frame does not fit the map: the pose is the last known, nothing is fused,
                  // and each frame is compared with all places seen until one fits
};
[[nodiscard]] const char* name_of(TrackStatus status);

struct SlamState {
  std::int64_t stamp_ns = 0;
  TrackStatus status = TrackStatus::kLost;
  Isometry3d T_world_camera = Isometry3d::Identity();
  // Of a left twist (v, w) in axes of the camera, m^2 and rad^2: of this frame's motion.
  Matrix6d covariance = Matrix6d::Identity();
  Alignment alignment;  // how it was found
  bool keyframe = false;
  bool relocalised = false;  // found again by what the place looks like
  // A place was recognised, and the path corrected: this pose and those of trajectory() are in
  // agreement with it, poses given before are not, and the surface was made anew.
  bool loop_closed = false;
  int blocks = 0;  // updated by this frame
  [[nodiscard]] bool mapped() const {
    return status == TrackStatus::kFirst || status == TrackStatus::kTracked ||
           status == TrackStatus::kHeld;
  }
};

class DepthSlam {
 public:
  // Options out of their range, a camera whose focal length is not above zero, and a first pose
  // that is not rigid are errors of every track().
  explicit DepthSlam(const PinholeCamera& camera, const SlamOptions& options = {},
                     const Isometry3d& T_world_first = Isometry3d::Identity());
  ~DepthSlam();
  DepthSlam(DepthSlam&&) noexcept;
  DepthSlam& operator=(DepthSlam&&) noexcept;

  // Errors, after which the state is as before: images whose size differs from the first frame's or
  // from each other, a time that is not after the last one's.
  [[nodiscard]] Result<SlamState> track(const SlamFrame& frame, const Context& context = {});

  [[nodiscard]] const VoxelVolume& volume() const;
  [[nodiscard]] const SlamOptions& options() const;
  // The path of all mapped frames as it is known now; of a very long one the older half is given
  // more coarsely (frame_path.hpp).
  [[nodiscard]] Trajectory trajectory() const;
  // How often the path was corrected, and the memory of what is kept for that (besides the file).
  [[nodiscard]] int loops() const;
  [[nodiscard]] std::size_t keyframe_bytes() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tread
