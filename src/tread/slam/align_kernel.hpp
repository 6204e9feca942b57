// Residuals of aligning a frame, written for one pixel or point (the definition, and what a GPU
// runs), and their sums, vectorised over the pixels of a row, or points.
#pragma once

#include <Eigen/Core>
#include <algorithm>
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

// One residual r, its Jacobian J, and weight; 0: it does not count, and all is 0. K is another
// estimate of J with noise of its own, for `cross`.
struct Residual {
  float r = 0.0F;
  float J[6] = {};
  float K[6] = {};
  float weight = 0.0F;
};

// p <- R p + t, R row-major.
inline void move_point(const float* R, const float* t, const float* p, float* moved) {
  for (int i = 0; i < 3; ++i) {
    moved[i] = R[3 * i] * p[0] + R[3 * i + 1] * p[1] + R[3 * i + 2] * p[2] + t[i];
  }
}

// (a, q x a): how a . q changes with v and w of q <- q + v + w x q.
inline void slope_of_motion(const float* a, const float* q, float* J) {
  for (int i = 0; i < 3; ++i) J[i] = a[i];
  J[3] = q[1] * a[2] - q[2] * a[1];
  J[4] = q[2] * a[0] - q[0] * a[2];
  J[5] = q[0] * a[1] - q[1] * a[0];
}

// 1, and beyond `limit` so that the error grows linearly only.
inline float huber_weight(float r, float limit) {
  return std::min(1.0F, limit / std::max(std::abs(r), limit));
}

// A DepthLevel that somebody else owns.
struct DepthView {
  Pinhole camera;
  ImageView<const float> depth;
  ImageView<const float> normal[3];
  [[nodiscard]] static DepthView of(const DepthLevel& level) {
    return {level.camera, level.depth, {level.normal[0], level.normal[1], level.normal[2]}};
  }
};

// Point to plane (Chen and Medioni 1991; paper Q's KinFu). A point q of the frame, in axes of the
// model's camera, projects to a pixel of the model with point p and normal n.
//   r = n . (q - p),  J = [n, q x n]  for q <- q + v + w x q
//   weight: 1 / sigma^2 of the frame's depth, by Huber beyond `huber` sigma
// K is J with the frame's own normal in the place of the model's: the noise of both is apart, so
// that J^T K keeps what is structure and loses what is noise.
struct IcpJob {
  DepthView frame, model;
  float R[9];  // model from frame, row-major
  float t[3];
  float gate_m = 0.1F;                              // farther apart: not the same
  float least_cosine = 0.94F;                       // between the normals
  float constant_m = 0.0F, quadratic_per_m = 0.0F;  // DepthNoise
  float huber = 2.0F;
};

// Of pixel (x, y) of the frame.
inline Residual icp_residual(const IcpJob& job, int x, int y) {
  const DepthView &frame = job.frame, &model = job.model;
  const float z = frame.depth.row(y)[x];
  if (!(z > 0.0F)) return {};
  const float seen[3] = {(static_cast<float>(x) - frame.camera.cx) / frame.camera.fx * z,
                         (static_cast<float>(y) - frame.camera.cy) / frame.camera.fy * z, z};
  float q[3];
  move_point(job.R, job.t, seen, q);
  if (!(q[2] > 0.0F)) return {};
  const float u = std::nearbyint(q[0] / q[2] * model.camera.fx + model.camera.cx);
  const float v = std::nearbyint(q[1] / q[2] * model.camera.fy + model.camera.cy);
  if (!(u >= 0.0F && v >= 0.0F && u < static_cast<float>(model.depth.width) &&
        v < static_cast<float>(model.depth.height))) {
    return {};
  }
  const int mx = static_cast<int>(u), my = static_cast<int>(v);
  const float model_z = model.depth.row(my)[mx];
  const float e[3] = {q[0] - (u - model.camera.cx) / model.camera.fx * model_z,
                      q[1] - (v - model.camera.cy) / model.camera.fy * model_z, q[2] - model_z};
  const float n[3] = {model.normal[0].row(my)[mx], model.normal[1].row(my)[mx],
                      model.normal[2].row(my)[mx]};
  const float normal[3] = {frame.normal[0].row(y)[x], frame.normal[1].row(y)[x],
                           frame.normal[2].row(y)[x]};
  constexpr float kNoShift[3] = {};
  float own[3];
  move_point(job.R, kNoShift, normal, own);
  // Unknown depths and normals are not a number, and no comparison with one holds.
  if (!(e[0] * e[0] + e[1] * e[1] + e[2] * e[2] <= job.gate_m * job.gate_m)) return {};
  if (!(own[0] * n[0] + own[1] * n[1] + own[2] * n[2] >= job.least_cosine)) return {};
  const float sigma = job.constant_m + job.quadratic_per_m * z * z;
  Residual out;
  out.r = n[0] * e[0] + n[1] * e[1] + n[2] * e[2];
  slope_of_motion(n, q, out.J);
  slope_of_motion(own, q, out.K);
  out.weight = huber_weight(out.r, job.huber * sigma) / (sigma * sigma);
  return out;
}
// Their sums over rows first to last - 1 of the frame; differ by rounding, and where that decides.
void icp_rows(const IcpJob& job, int first, int last, bool with_cross, NormalEquations& sums);

// What the image of a keyframe looks like, at the pixels that have depth and a gradient.
struct PhotoPoints {
  std::vector<float> x, y, z;  // metres, keyframe's camera
  std::vector<float> intensity;
  std::vector<float> gx, gy;  // grey values a pixel
  [[nodiscard]] int size() const { return static_cast<int>(x.size()); }
  void clear();
};
// PhotoPoints that somebody else owns.
struct PhotoPointsView {
  const float *x = nullptr, *y = nullptr, *z = nullptr;
  const float* intensity = nullptr;
  const float *gx = nullptr, *gy = nullptr;
  int size = 0;
  [[nodiscard]] static PhotoPointsView of(const PhotoPoints& points) {
    return {points.x.data(),  points.y.data(),  points.z.data(), points.intensity.data(),
            points.gx.data(), points.gy.data(), points.size()};
  }
};

// Intensity (direct alignment; Kerl, Sturm, Cremers 2013). A point P of the keyframe falls on a
// pixel of the image at hand.
//   r = gain I + offset - I_key,  J = [a, P x a],  a = (gx, gy) d pi / d P   (of the keyframe)
// for P <- P + v + w x P. Weight: 1 / sigma^2, by Huber. K has the gradient of the image at hand.
struct PhotoJob {
  PhotoPointsView points;
  ImageView<const float> image;
  ImageView<const float> image_gx, image_gy;  // for `cross`; same size and stride
  Pinhole camera;
  float R[9];  // image from keyframe
  float t[3];
  float gain = 1.0F, offset = 0.0F;
  float sigma = 5.0F;
  float huber = 1.5F;
};

// Between the four pixels around (u, v), which must be within the image.
inline float sample_image(const ImageView<const float>& image, float u, float v) {
  const int x = static_cast<int>(u), y = static_cast<int>(v);
  const float fu = u - static_cast<float>(x), fv = v - static_cast<float>(y);
  const float *a = image.row(y) + x, *b = image.row(y + 1) + x;
  const float upper = a[0] + (a[1] - a[0]) * fu, lower = b[0] + (b[1] - b[0]) * fu;
  return upper + (lower - upper) * fv;
}

// Of point i of the keyframe.
inline Residual photo_residual(const PhotoJob& job, int i) {
  const PhotoPointsView& points = job.points;
  const Pinhole& camera = job.camera;
  const float P[3] = {points.x[i], points.y[i], points.z[i]};
  float q[3];
  move_point(job.R, job.t, P, q);
  if (!(P[2] > 0.0F && q[2] > 0.0F)) return {};
  const float u = q[0] / q[2] * camera.fx + camera.cx, v = q[1] / q[2] * camera.fy + camera.cy;
  if (!(u >= 0.0F && v >= 0.0F && u < static_cast<float>(job.image.width - 1) &&
        v < static_cast<float>(job.image.height - 1))) {
    return {};
  }
  const auto slope = [&](float gx, float gy, float* J) {
    const float a = gx * camera.fx / P[2], b = gy * camera.fy / P[2];
    const float along[3] = {a, b, -(a * P[0] + b * P[1]) / P[2]};
    slope_of_motion(along, P, J);
  };
  Residual out;
  out.r = job.gain * sample_image(job.image, u, v) + job.offset - points.intensity[i];
  slope(points.gx[i], points.gy[i], out.J);
  slope(sample_image(job.image_gx, u, v), sample_image(job.image_gy, u, v), out.K);
  out.weight = huber_weight(out.r, job.huber * job.sigma) / (job.sigma * job.sigma);
  return out;
}
// What is besides needed to fit gain and offset, and the spread of the residuals.
struct PhotoSums {
  NormalEquations equations;
  double key = 0.0, here = 0.0, key_here = 0.0, here_here = 0.0;  // weighted sums
  double absolute = 0.0;                                          // sum of |r|
  PhotoSums& operator+=(const PhotoSums& other);
};
// Over points first to last - 1, as icp_rows.
void photo_points(const PhotoJob& job, int first, int last, bool with_cross, PhotoSums& sums);

}  // namespace tread
