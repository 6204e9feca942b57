// The local height map of one stereo frame, in the levelled frame of the robot: paper R,
// "Coordinate Transformations" and "Taking a Derivative".
//
// Levelled frame: origin at the body's origin, z up against gravity, x ahead (the body's x axis
// projected onto the horizontal plane), y left: the body turned back by its pitch and roll, not by
// its yaw.
#pragma once

#include <Eigen/Geometry>
#include <span>

#include "tread/core/grid.hpp"
#include "tread/core/options.hpp"
#include "tread/core/timer.hpp"
#include "tread/geometry/stereo_rig.hpp"

namespace tread {

struct LocalMapOptions {
  double resolution_m = 0.1;  // side of a cell; paper R: 0.1
  int min_points = 2;         // a cell with fewer is unknown
  enum class Height { kMean, kMax } height = Height::kMean;
  double max_height_m = 3.0;    // points higher above the levelled origin are left out
  double min_height_m = -10.0;  // and lower than this; below max_height_m
  // Points this much above the ground that is known below them are left out: what a robot passes
  // under, crowns of trees and false matches in the sky. 0: none. Not in the papers.
  double overhead_m = 2.0;
};
[[nodiscard]] OptionSet describe(LocalMapOptions& options);

// A rectangle of the levelled frame, metres. Paper R: {{0, -6}, {6, 6}}.
using LevelArea = Eigen::AlignedBox2d;
// What a camera sees up to a depth, from above: the rectangle around its place and the corners of
// its image at that depth, wherever it is mounted and looks.
[[nodiscard]] LevelArea view_from_above(const RectifiedRig& rig,
                                        const Eigen::Isometry3d& T_level_points, double depth_m);
// The cells that hold it; their corners are multiples of the resolution.
[[nodiscard]] GridGeometry local_cells(const LevelArea& area, double resolution_m);
// Whether a local map of these cells takes at most 1 GiB, 28 bytes a cell.
[[nodiscard]] bool local_map_fits(const LevelArea& area, double resolution_m);

// R_level_body for an attitude: Ry(pitch) Rx(roll) of T_world_body, its yaw left out (Eq. 1).
[[nodiscard]] Eigen::Matrix3d R_level_body(const Eigen::Matrix3d& R_world_body);

// What else is known about the points of a local map.
struct LocalMapHints {
  const Grid<float>* known = nullptr;   // of the same cells, the heights known before
                                        // (GlobalMap::heights_below), for overhead_m
  std::span<const float> sigma_m = {};  // of each point: a mean weighs it by 1 / sigma^2; or none
};

// Heights of the points, NaN where fewer than min_points fell. T_level_points maps the points into
// the levelled frame. Points that are not finite or outside the cells are left out. The sums are
// made in the order of the points, so the result is the same on every run. Cost: O(points + cells).
class LocalMapBuilder {
 public:
  [[nodiscard]] const Grid<float>& build(std::span<const Eigen::Vector3f> points,
                                         const Eigen::Isometry3d& T_level_points,
                                         const GridGeometry& cells, const LocalMapOptions& options,
                                         const LocalMapHints& hints = {},
                                         const Context& context = {});

 private:
  struct Sum {
    double height = 0.0;  // weighted sum, or maximum
    float weight = 0.0F;
    int points = 0;
  };
  Grid<Sum> sums_;
  Grid<float> heights_;
};

// Squared Sobel response (paper R, Eq. 2 without the root): (s fx)^2 + (s fy)^2 over the 3x3 cells
// around each cell, metres squared; NaN unless all nine are known, so that the border of the known
// area gives none. A slope g over cells of 0.1 m gives 0.64 g^2, a step of h gives 16 h^2.
void sobel_squared(const Grid<float>& height, Grid<float>& derivative, const Context& context = {});

}  // namespace tread
