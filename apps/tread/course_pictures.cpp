#include "course_pictures.hpp"

#include <cmath>

#include "tread/sim/camera_view.hpp"
#include "tread/sim/image_sensor.hpp"

namespace tread {
namespace {

// A camera that no sensor spoils: even exposure, no noise to speak of.
Result<Image<Rgb>> photograph(const Scene& scene, const CameraModel& camera, const ImageSize& size,
                              const Isometry3d& T_world_camera, const Context& context) {
  auto rays = make_camera_rays(camera, size, context);
  if (!rays) return forward(rays);
  RenderOptions how;
  how.colour = true;
  how.samples = 8;
  CameraView view;
  if (Status s = render(scene, *rays, CameraShot::still(T_world_camera), how, view, context); !s) {
    return forward(s);
  }
  ImageSensorOptions options;
  options.full_well_e = 1e7;
  options.read_noise_e = 0.0;
  options.vignetting = 0.0;
  options.target_mean = 125.0;
  const auto sensor = ImageSensor::make(options, *rays);
  if (!sensor) return forward(sensor);
  Image<Rgb> image;
  if (Status s = sensor->expose(view, sensor->meter(view), {}, image, context); !s) {
    return forward(s);
  }
  return image;
}

}  // namespace

Result<PictureFromAbove> draw_from_above(const Scene& scene, int wanted_px,
                                         const Context& context) {
  constexpr double kAway = 2.0;  // times the size of the course: rays are not far from parallel
  const World& world = scene.world();
  const GridGeometry& ground = world.ground.geometry;
  const Eigen::Vector2d low = ground.centre({0, 0}),
                        high = ground.centre({ground.columns - 1, ground.rows - 1});
  const Eigen::Vector2d size = high - low;
  PictureFromAbove picture;
  picture.middle_m = 0.5 * (low + high);
  picture.pixels_per_m = wanted_px / size.maxCoeff();
  const ImageSize pixels{
      std::max(1, static_cast<int>(std::lround(size.x() * picture.pixels_per_m))),
      std::max(1, static_cast<int>(std::lround(size.y() * picture.pixels_per_m)))};
  const double up = kAway * size.maxCoeff(), focal = picture.pixels_per_m * up;
  const PinholeCamera camera{focal, focal, 0.5 * (pixels.width - 1), 0.5 * (pixels.height - 1),
                             0.0};
  Isometry3d T_world_camera = Isometry3d::Identity();
  T_world_camera.linear() << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  T_world_camera.translation() << picture.middle_m, up + ground_height(world, picture.middle_m);
  auto image = photograph(scene, camera, pixels, T_world_camera, context);
  if (!image) return forward(image);
  picture.image = std::move(*image);
  return picture;
}

Result<Image<Rgb>> draw_robots_eye(const Scene& scene, const RobotSetup& setup, int head,
                                   const Isometry3d& T_world_body, const Context& context) {
  const StereoRig rig = rig_of(setup, head);
  return photograph(scene, rig.left, rig.size, T_world_body * rig.mount->T_body_left, context);
}

}  // namespace tread
