#include "tread/sim/stereo_camera.hpp"

namespace tread::internal {

StereoCamera::StereoCamera(const StereoRig& rig, const CameraSetup& setup, std::uint64_t seed,
                           const Context& context)
    : rig_(rig), setup_(setup), seed_(seed), context_(context) {}

Result<StereoCamera> StereoCamera::make(const StereoRig& rig, const CameraSetup& setup,
                                        Random random, const Context& context) {
  StereoCamera camera(rig, setup, random.bits64(), context);
  for (const auto& [model, eye] :
       {std::pair(&rig.left, &camera.left_), {&rig.right, &camera.right_}}) {
    auto rays = make_camera_rays(*model, rig.size, context);
    if (!rays) return forward(rays);
    auto sensor = ImageSensor::make(setup.sensor, *rays);
    if (!sensor) return forward(sensor);
    eye->rays = std::move(*rays);
    eye->sensor.emplace(std::move(*sensor));
  }
  camera.exposure_.exposure_s = setup.sensor.exposure_s;
  return camera;
}

Status StereoCamera::look(const Scene& scene, const PoseAt& T_world_left,
                          const Isometry3d& T_left_eye, const Eye& eye) {
  // The stamp is the middle of the exposure.
  const double half_s = 0.5 * (exposure_.exposure_s + setup_.readout_s);
  CameraShot shot;
  shot.T_world_start = T_world_left(-half_s) * T_left_eye;
  shot.T_world_end = T_world_left(half_s) * T_left_eye;
  shot.exposure_s = exposure_.exposure_s;
  shot.readout_s = setup_.readout_s;
  return render(scene, eye.rays, shot, setup_.render, view_, context_);
}

Result<StereoFrame> StereoCamera::take(const Scene& scene, const PoseAt& T_world_left,
                                       Image<float>& depth) {
  StereoFrame frame;
  if (Status s = look(scene, T_world_left, Isometry3d::Identity(), left_); !s) return forward(s);
  depth = view_.depth;
  // Blur is that of the exposure of the frame before: it changes slowly.
  exposure_ = left_.sensor->meter(view_);
  const auto expose = [&](const Eye& eye, int number, auto& image) {
    return eye.sensor->expose(view_, exposure_, {seed_, frames_, number}, image, context_);
  };
  if (Status s = expose(left_, 0, frame.left); !s) return forward(s);
  if (setup_.render.colour) {
    if (Status s = expose(left_, 0, frame.left_colour); !s) return forward(s);
  }
  if (Status s = look(scene, T_world_left, rig_.T_left_right, right_); !s) return forward(s);
  if (Status s = expose(right_, 1, frame.right); !s) return forward(s);
  ++frames_;
  return frame;
}

}  // namespace tread::internal
