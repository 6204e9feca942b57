// A point cloud as one sees it standing beside it.
#pragma once

#include "tread/geometry/cloud.hpp"
#include "tread/geometry/pose.hpp"

namespace tread {

// Drawn without perspective, from behind the camera, above it and a little to its right, so that
// heights can be told from distances. `T_level_points` turns the points upright (z up, x ahead).
// Points are discs as large as they lie apart; those without colours are coloured by height. What
// few points lie far off is outside the picture. Empty if there are no points.
[[nodiscard]] Image<Rgb> draw_cloud(const PointCloud& cloud, const Isometry3d& T_level_points,
                                    int width_px, int height_px);

}  // namespace tread
