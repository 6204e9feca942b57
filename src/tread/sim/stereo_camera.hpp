// Internal to sim: both cameras of a stereo head, from light to pixels.
#pragma once

#include <functional>
#include <optional>

#include "tread/core/timer.hpp"
#include "tread/geometry/samples.hpp"
#include "tread/geometry/stereo_rig.hpp"
#include "tread/sim/camera_rays.hpp"
#include "tread/sim/camera_view.hpp"
#include "tread/sim/image_sensor.hpp"
#include "tread/sim/random.hpp"
#include "tread/sim/robot_setup.hpp"

namespace tread::internal {

class StereoCamera {
 public:
  // T_world_left a little earlier or later.
  using PoseAt = std::function<Isometry3d(double later_s)>;

  [[nodiscard]] static Result<StereoCamera> make(const StereoRig& rig, const CameraSetup& setup,
                                                 Random random, const Context& context);

  // A pair whose middle of the exposure is now. `depth` becomes the true depth of the left camera.
  [[nodiscard]] Result<StereoFrame> take(const Scene& scene, const PoseAt& T_world_left,
                                         Image<float>& depth);

 private:
  struct Eye {
    CameraRays rays;
    std::optional<ImageSensor> sensor;
  };
  StereoCamera(const StereoRig& rig, const CameraSetup& setup, std::uint64_t seed,
               const Context& context);
  [[nodiscard]] Status look(const Scene& scene, const PoseAt& T_world_left,
                            const Isometry3d& T_left_eye, const Eye& eye);

  StereoRig rig_;
  CameraSetup setup_;
  std::uint64_t seed_;
  Context context_;
  Eye left_, right_;
  Exposure exposure_;
  std::int64_t frames_ = 0;
  CameraView view_;
};

}  // namespace tread::internal
