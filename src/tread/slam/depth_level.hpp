// A depth image and what tracking needs of it, at one resolution.
#pragma once

#include <array>
#include <cmath>

#include "tread/core/image.hpp"
#include "tread/core/timer.hpp"
#include "tread/geometry/camera.hpp"
#include "tread/slam/depth_noise.hpp"

namespace tread {

// Pinhole camera in single precision, as kernels use it: pixel (u, v) at depth z is the point
// z ((u - cx) / fx, (v - cy) / fy, 1).
struct Pinhole {
  float fx = 0.0F, fy = 0.0F, cx = 0.0F, cy = 0.0F;
  [[nodiscard]] static Pinhole of(const PinholeCamera& camera) {
    return {static_cast<float>(camera.fx), static_cast<float>(camera.fy),
            static_cast<float>(camera.cx), static_cast<float>(camera.cy)};
  }
  // Of the image at half the resolution: its pixels stand for two by two of this one's.
  [[nodiscard]] Pinhole halved() const {
    return {fx / 2.0F, fy / 2.0F, (cx + 0.5F) / 2.0F - 0.5F, (cy + 0.5F) / 2.0F - 0.5F};
  }
  [[nodiscard]] bool operator==(const Pinhole&) const = default;
};

// Depths are along the optical axis, metres, NaN where unknown. Normals are unit vectors in camera
// axes that point to the camera, NaN where the surface around a pixel is not known.
struct DepthLevel {
  Pinhole camera;
  Image<float> depth;
  std::array<Image<float>, 3> normal;

  void resize(const Pinhole& with, int width, int height);
  [[nodiscard]] int width() const { return depth.width; }
  [[nodiscard]] int height() const { return depth.height; }
};

// Halves a depth image. Of four pixels those count that are not behind the nearest one by more than
// three sigma: an edge does not become a slope. An odd last row or column is left out.
void halve_depth(ImageView<const float> depth, const DepthNoise& noise, Image<float>& half,
                 const Context& context = {});

// The mean of those among 5 x 5 pixels around each, `spacing` apart, that can be of one surface
// with it: whose depth differs by no more than three sigma and what a slope of 1.5 makes.
void smooth_depth(ImageView<const float> depth, const DepthNoise& noise, float focal_px,
                  int spacing, Image<float>& smooth, const Context& context = {});

// Normals of a level, from the four neighbours of each pixel, which must be known and within a
// sixteenth of its depth. Depths are smoothed for them, the more the larger their noise is beside
// the distance of neighbours: a normal that is off by more than some ten degrees says nothing.
// Keeps its memory.
class NormalFinder {
 public:
  void find(const DepthNoise& noise, DepthLevel& level, const Context& context = {});
  // Levels of decreasing size; the first is given with its depth, the others are made, and normals
  // of all.
  void build_pyramid(const DepthNoise& noise, std::array<DepthLevel, 3>& levels,
                     const Context& context = {});

 private:
  Image<float> smooth_, smoother_;
};

// Mean of the known depths, of every fourth pixel each way; 0 if none is known.
[[nodiscard]] double mean_depth(ImageView<const float> depth);

}  // namespace tread
