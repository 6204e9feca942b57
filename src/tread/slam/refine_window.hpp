// The last keyframes and the points they see, refined together: bundle adjustment over a window
// (Triggs, McLauchlan, Hartley, Fitzgibbon 2000), solved by Ceres.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "tread/core/options.hpp"
#include "tread/core/timer.hpp"
#include "tread/slam/imu_preintegration.hpp"
#include "tread/slam/stereo_sight.hpp"

namespace tread {

struct WindowOptions {
  int free_keyframes = 8;   // poses that are refined
  int fixed_keyframes = 6;  // older ones that hold the points where they were
  int iterations = 6;       // at most
  double outlier = 4.0;     // sights farther off, in sigma of three coordinates, are forgotten
  [[nodiscard]] bool operator==(const WindowOptions&) const = default;
};
[[nodiscard]] OptionSet describe(WindowOptions& options);

// A keyframe of the window.
struct WindowFrame {
  std::int64_t id = 0;
  Isometry3d T_world_camera = Isometry3d::Identity();
  // With an IMU only.
  Eigen::Vector3d velocity_m_per_s = Eigen::Vector3d::Zero();  // of the IMU, in the world
  ImuBias bias = {};
  std::optional<ImuPreintegration> since = {};  // measured from the keyframe before to this one
};

// What the IMU needs besides to take part.
struct WindowInertia {
  Isometry3d T_camera_imu = Isometry3d::Identity();
  Eigen::Vector3d gravity_world = {0.0, 0.0, -9.81};
  bool gravity_known = false;  // else its direction is found as well
};

// A point and the keyframes that saw it, oldest first.
struct WindowPoint {
  struct Sighting {
    std::int64_t frame = 0;  // WindowFrame::id
    StereoSight sight;
  };
  Eigen::Vector3d p_world = Eigen::Vector3d::Zero();
  std::vector<Sighting> seen;
};

// Moves the newest free_keyframes of `frames` (in order of id) and the points so that sights, and
// what an IMU measured between keyframes, fit: in least squares with Huber's loss for sights. Takes
// out of the points what does not fit then, and sights in frames that are no longer there. Points
// with less than two sights are left as they are. False if there was nothing to refine or the
// solver failed; all is then as it was.
bool refine_window(const RectifiedRig& rig, double sigma_px, const WindowOptions& options,
                   std::vector<WindowFrame>& frames, std::vector<WindowPoint*>& points,
                   WindowInertia* inertia, const Context& context);

}  // namespace tread
