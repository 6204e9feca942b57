// How a course looks.
#pragma once

#include "tread/core/image.hpp"
#include "tread/core/result.hpp"
#include "tread/core/timer.hpp"
#include "tread/sim/robot_setup.hpp"
#include "tread/sim/scene.hpp"

namespace tread {

// The whole course from far above, x to the right; its longer side has `wanted_px` pixels. `place`
// says where a point of the ground is in the picture.
struct PictureFromAbove {
  Image<Rgb> image;
  double pixels_per_m = 1.0;
  Eigen::Vector2d middle_m = Eigen::Vector2d::Zero();
  [[nodiscard]] Eigen::Vector2d pixel_of(const Eigen::Vector2d& p) const {
    return {0.5 * (image.width - 1) + pixels_per_m * (p.x() - middle_m.x()),
            0.5 * (image.height - 1) - pixels_per_m * (p.y() - middle_m.y())};
  }
};
[[nodiscard]] Result<PictureFromAbove> draw_from_above(const Scene& scene, int wanted_px,
                                                       const Context& context);

// What the left camera of a head sees from a pose of the body, in colour, without noise.
[[nodiscard]] Result<Image<Rgb>> draw_robots_eye(const Scene& scene, const RobotSetup& setup,
                                                 int head, const Isometry3d& T_world_body,
                                                 const Context& context);

}  // namespace tread
