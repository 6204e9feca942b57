// Where rays meet the ground, and what is there, sixteen at a time for every instruction set that
// the machine may have. In double precision as far as distances go.
#pragma once

#include <cstdint>

#include "tread/sim/surface_batch.hpp"

namespace tread {

// What the ground is at the centre of a cell.
struct GroundVertex {
  float height = 0.0F;
  float slope_x = 0.0F, slope_y = 0.0F;  // of a smooth surface through the heights
  std::uint32_t look = 0;                // material; kGroundBorder: others are beside it
};
inline constexpr std::uint32_t kGroundBorder = 0x100U;

// Least cosine of the angle at which a surface counts as seen, for footprints; how far off it rays
// to the sun start, in metres and as a share of the distance from the middle of the scene.
inline constexpr float kGrazing = 0.02F, kOffM = 2e-4F, kOffShare = 2e-6F;

struct GroundView {
  const GroundVertex* vertices = nullptr;
  std::int32_t columns = 0, rows = 0;
  double resolution_m = 1.0;
  double first_x = 0.0, first_y = 0.0;  // the centre of cell (0, 0), scene axes
};

// For rays `first` to `first` + 15 of a batch that met squares `part` of the ground at about
// `rough` metres, sets all that the batch holds of them. Rays that met something else need a part
// and a distance, too; what is set for them means nothing.
void meet_ground(const GroundView& ground, const RayBatch& rays, const Eigen::Vector3d& centre,
                 const Eigen::Vector3d& sun, int first, const std::uint32_t* part,
                 const float* rough, SurfaceBatch& points);

}  // namespace tread
