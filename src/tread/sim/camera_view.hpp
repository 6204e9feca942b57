// What a camera in a simulated world sees: light of every pixel, and true depth.
//
// Surfaces scatter evenly (Lambert): light = albedo (sun n.s / shadow + sky), the sky a hemisphere
// and the ground below it a dim one. The sun is a point: shadows are hard. Units of light: a white
// surface that faces the sun of strength 1 has 1 from it. Above is a sky with soft clouds; in
// between, a thin haze.
//
// Samples of a pixel are spread over its area and over its exposure (Cook 1984): several of them
// smooth edges and blur motion alike; one is taken at the middle of both. Rows of a rolling shutter
// are exposed one after another, each with the pose of its own time.
//
// Cost: some 200 ns a sample where there is much foliage: half of it to find what is there and
// exactly where, a quarter each for textures with light and for the shadow
// (bench/simulated_cameras).
#pragma once

#include "tread/core/options.hpp"
#include "tread/core/timer.hpp"
#include "tread/geometry/pose.hpp"
#include "tread/sim/camera_rays.hpp"
#include "tread/sim/scene.hpp"

namespace tread {

struct RenderOptions {
  bool light = true;    // else depth only
  bool colour = false;  // red, green and blue beside grey, at little cost
  bool shadows = true;  // of the sun
  int samples = 1;      // of a pixel; 8 and more for motion blur
};
[[nodiscard]] OptionSet describe(RenderOptions& options);

// The camera from the opening of its first row to the closing of its last: poses between are
// linear in place and even in turn. With no exposure and no readout all rows
// are taken half way.
struct CameraShot {
  Isometry3d T_world_start = Isometry3d::Identity();
  Isometry3d T_world_end = Isometry3d::Identity();
  double exposure_s = 0.0;  // of each row
  double readout_s = 0.0;   // from the opening of the first row to that of the last: 0 if global

  [[nodiscard]] static CameraShot still(const Isometry3d& T_world_camera) {
    return {T_world_camera, T_world_camera, 0.0, 0.0};
  }
};

struct LightRgb {
  float r = 0.0F, g = 0.0F, b = 0.0F;
};
// How bright red, green and blue are to a grey camera (Rec. 709).
inline constexpr LightRgb kGreyOf{0.2126F, 0.7152F, 0.0722F};

struct CameraView {
  Image<float> grey;       // light, linear; 0 where the camera has no ray
  Image<LightRgb> colour;  // likewise; empty unless asked for
  Image<float> depth;  // metres along the optical axis, of the middle of the pixel in the middle
                       // of its exposure; NaN: sky, behind the camera, or no ray
};

// `view` keeps its memory. Errors: options out of range, poses or times that are none.
[[nodiscard]] Status render(const Scene& scene, const CameraRays& rays, const CameraShot& shot,
                            const RenderOptions& options, CameraView& view,
                            const Context& context = {});

}  // namespace tread
