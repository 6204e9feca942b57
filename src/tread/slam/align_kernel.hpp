// Residuals of aligning a frame, and their sums: vectorised over the pixels of a row, or points.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <vector>

#include "tread/geometry/pose.hpp"
#include "tread/slam/depth_level.hpp"

namespace tread {

// Sums over residuals r with Jacobian J (1 x 6) and weight w. The step that lessens them is
// -H^-1 g.
struct NormalEquations {
  Matrix6d H = Matrix6d::Zero();      // sum of w J^T J
  Vector6d g = Vector6d::Zero();      // sum of w J^T r
  Matrix6d cross = Matrix6d::Zero();  // sum of w (J^T K + K^T J) / 2, see there; if asked for
  double error = 0.0;                 // sum of w r^2
  double weight = 0.0;                // sum of w
  std::int64_t count = 0;

  NormalEquations& operator+=(const NormalEquations& other);
};

// Point to plane (Chen and Medioni 1991; paper Q's KinFu). A point q of the frame, in axes of the
// model's camera, projects to a pixel of the model with point p and normal n.
//   r = n . (q - p),  J = [n, q x n]  for q <- q + v + w x q
//   weight: 1 / sigma^2 of the frame's depth, by Huber beyond `huber` sigma
// K is J with the frame's own normal in the place of the model's: the noise of both is apart, so
// that J^T K keeps what is structure and loses what is noise.
struct IcpJob {
  const DepthLevel* frame = nullptr;
  const DepthLevel* model = nullptr;
  float R[9];  // model from frame, row-major
  float t[3];
  float gate_m = 0.1F;                              // farther apart: not the same
  float least_cosine = 0.94F;                       // between the normals
  float constant_m = 0.0F, quadratic_per_m = 0.0F;  // DepthNoise
  float huber = 2.0F;
};
// Rows first to last - 1 of the frame.
void icp_rows(const IcpJob& job, int first, int last, bool with_cross, NormalEquations& sums);

// What the image of a keyframe looks like, at the pixels that have depth and a gradient.
struct PhotoPoints {
  std::vector<float> x, y, z;  // metres, keyframe's camera
  std::vector<float> intensity;
  std::vector<float> gx, gy;  // grey values a pixel
  [[nodiscard]] int size() const { return static_cast<int>(x.size()); }
  void clear();
};

// Intensity (direct alignment; Kerl, Sturm, Cremers 2013). A point P of the keyframe falls on a
// pixel of the image at hand.
//   r = gain I + offset - I_key,  J = [a, P x a],  a = (gx, gy) d pi / d P   (of the keyframe)
// for P <- P + v + w x P. Weight: 1 / sigma^2, by Huber. K has the gradient of the image at hand.
struct PhotoJob {
  const PhotoPoints* points = nullptr;
  ImageView<const float> image;
  ImageView<const float> image_gx, image_gy;  // for `cross`
  Pinhole camera;
  float R[9];  // image from keyframe
  float t[3];
  float gain = 1.0F, offset = 0.0F;
  float sigma = 5.0F;
  float huber = 1.5F;
};
// What is besides needed to fit gain and offset, and the spread of the residuals.
struct PhotoSums {
  NormalEquations equations;
  double key = 0.0, here = 0.0, key_here = 0.0, here_here = 0.0;  // weighted sums
  double absolute = 0.0;                                          // sum of |r|
  PhotoSums& operator+=(const PhotoSums& other);
};
void photo_points(const PhotoJob& job, int first, int last, bool with_cross, PhotoSums& sums);

}  // namespace tread
