#include "tread/sim/camera_rays.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <string>

#include "tread/core/parallel.hpp"

namespace tread {
namespace {

bool has_ray(const PixelRay& ray) {
  return ray.spread_rad >= 0.0F;
}
Eigen::Vector3d bearing(const PixelRay& ray) {
  return {ray.x, ray.y, ray.z};
}

// How much the bearing changes by a pixel to the right and one down, from the neighbours that have
// a ray.
Eigen::Vector3d change(const Image<PixelRay>& pixels, int u, int v, int right, int down) {
  Eigen::Vector3d steps[2];
  int known = 0;
  for (const int sign : {-1, 1}) {
    const int x = u + sign * right, y = v + sign * down;
    if (x < 0 || y < 0 || x >= pixels.width || y >= pixels.height || !has_ray(pixels(x, y))) {
      continue;
    }
    steps[known++] = sign * (bearing(pixels(x, y)) - bearing(pixels(u, v)));
  }
  if (known == 0) return Eigen::Vector3d::Zero();
  return known == 1 ? steps[0] : Eigen::Vector3d(0.5 * (steps[0] + steps[1]));
}

}  // namespace

Eigen::Vector3d CameraRays::beside(int u, int v, double du, double dv) const {
  return (bearing(pixels(u, v)) + du * change(pixels, u, v, 1, 0) + dv * change(pixels, u, v, 0, 1))
      .normalized();
}

Result<CameraRays> make_camera_rays(const CameraModel& camera, const ImageSize& size,
                                    const Context& context) {
  if (size.width <= 0 || size.height <= 0) {
    return fail(ErrorCode::kBadArgument,
                "an image of " + std::to_string(size.width) + " x " + std::to_string(size.height) +
                    " has no pixels",
                "size", "Write width and height in pixels, above 0");
  }
  if (Status sound = check_camera(camera, "camera"); !sound) return forward(sound);
  CameraRays rays{Image<PixelRay>(size.width, size.height)};
  constexpr int kRows = 8;
  parallel_chunks(context, 0, size.height, kRows, [&](int first, int last) {
    for (int v = first; v < last; ++v) {
      for (int u = 0; u < size.width; ++u) {
        const Unprojection seen = unproject(camera, Eigen::Vector2d(u, v));
        rays.pixels(u, v) = {seen.bearing.x(), seen.bearing.y(), seen.bearing.z(),
                             seen.valid ? 0.0F : std::numeric_limits<float>::quiet_NaN()};
      }
    }
  });
  const float usual = 1.0F / static_cast<float>(pinhole_of(camera).fx);
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      PixelRay& ray = rays.pixels(u, v);
      if (!has_ray(ray)) continue;
      const double area =
          change(rays.pixels, u, v, 1, 0).cross(change(rays.pixels, u, v, 0, 1)).norm();
      ray.spread_rad = area > 0.0 ? static_cast<float>(std::sqrt(area)) : usual;
    }
  }
  return rays;
}

}  // namespace tread
