// Where a frame was taken, from what it sees: depth against the surface of the model, intensity
// against a keyframe, and what was known before, in one least-squares problem.
#pragma once

#include <array>
#include <optional>

#include "tread/core/options.hpp"
#include "tread/slam/grey_level.hpp"
#include "tread/slam/observability.hpp"

namespace tread {

struct AlignOptions {
  int fine_iterations = 6;  // at most, from the finest level to the coarsest
  int middle_iterations = 6;
  int coarse_iterations = 8;
  double gate_m = 0.10;          // points farther apart are not the same
  double gate_angle_deg = 20.0;  // nor are those whose normals differ by more
  double least_step = 1e-5;      // metres and radians: smaller steps end a level
  bool intensity = true;         // use images as well
  double intensity_share = 1.0;  // weight of intensities beside depths
  double least_grey_sigma = 4.0;
  ObservabilityOptions observability;
  [[nodiscard]] bool operator==(const AlignOptions&) const = default;
};
[[nodiscard]] OptionSet describe(AlignOptions& options);

// A frame, prepared for all levels, finest first. No grey: intensity sizes are zero.
struct AlignFrame {
  std::array<DepthLevel, 3> depth;
  std::array<GreyLevel, 3> grey;
  [[nodiscard]] bool has_grey() const { return !grey[0].intensity.empty(); }
};

// The image that intensities are compared with.
struct PhotoKeyframe {
  std::array<PhotoPoints, 3> points;
  Isometry3d T_world_camera = Isometry3d::Identity();
  std::array<Pinhole, 3> camera;
};

// What was known before the frame was looked at: the pose, and how sure it was, as information
// (inverse covariance) of a twist (v, w) applied from the left in camera axes.
struct PosePrior {
  Isometry3d T_world_camera = Isometry3d::Identity();
  Matrix6d information = Matrix6d::Zero();
};

struct Alignment {
  Isometry3d T_world_camera = Isometry3d::Identity();
  Matrix6d covariance = Matrix6d::Identity();  // of a left twist in axes of the camera
  Observability observability;
  std::int64_t matched = 0;        // pixels of the finest level that met the surface
  std::int64_t measured = 0;       // pixels of it that have depth and a normal
  double depth_rms = 0.0;          // of the residuals, in their standard deviations
  std::int64_t photo_matched = 0;  // points of the keyframe that fall into the image
  std::int64_t photo_points = 0;   // of those it has, at the finest level where it has any
  double grey_rms = 0.0;
  double gain = 1.0, offset = 0.0;
  // Mean square of the difference between what depth and intensity say, in standard deviations: 1
  // if they agree. 0: not known.
  double disagreement = 0.0;
  bool converged = false;
};

// `model`: the surface as seen from T_world_model, normals filled; null: none. `key` may be null.
[[nodiscard]] Alignment align(const AlignFrame& frame, const std::array<DepthLevel, 3>* model,
                              const Isometry3d& T_world_model, const PhotoKeyframe* key,
                              const PosePrior& prior, const DepthNoise& noise,
                              const AlignOptions& options, const Context& context = {});

// The turn between two images that fits them best, as if all they show were far away: a start for
// align() that survives fast rotation. R_first_second, found at the coarsest level and at half of
// that; identity where nothing fits better.
[[nodiscard]] Eigen::Matrix3d align_rotation(
    const GreyLevel& first, const GreyLevel& second, const Pinhole& camera,
    const Eigen::Matrix3d& start = Eigen::Matrix3d::Identity());

}  // namespace tread
