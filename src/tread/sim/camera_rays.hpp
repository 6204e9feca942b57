// The ray of every pixel of a camera, made once: whatever its model, rendering then costs the same.
#pragma once

#include "tread/core/image.hpp"
#include "tread/core/timer.hpp"
#include "tread/geometry/camera.hpp"

namespace tread {

struct PixelRay {
  double x = 0.0, y = 0.0, z = 0.0;  // unit length, camera optical axes
  float spread_rad = 0.0F;           // side of a square of the pixel's solid angle; NaN: no ray
};

struct CameraRays {
  Image<PixelRay> pixels;
  // The ray (du, dv) pixels, less than one each way, beside the centre of a pixel that has a ray:
  // along the chords to its neighbours, to some 1e-7 rad in usual cameras.
  [[nodiscard]] Eigen::Vector3d beside(int u, int v, double du, double dv) const;
};

// Errors: a size without pixels, and those of check_camera(). Pixels that the model has no bearing
// for have no ray.
[[nodiscard]] Result<CameraRays> make_camera_rays(const CameraModel& camera, const ImageSize& size,
                                                  const Context& context = {});

}  // namespace tread
