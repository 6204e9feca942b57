// The light that comes along rays from what they met.
#pragma once

#include "tread/sim/scene.hpp"

namespace tread {

struct LightBatch {
  alignas(64) SurfaceBatch::Row<float> grey;
  alignas(64) std::array<SurfaceBatch::Row<float>, 3> colour;  // only if asked for
};

// `lit` as of Scene::light. Rays that met nothing bring light from the sky.
void shade(const Scene& scene, const RayBatch& rays, const SurfaceBatch& points,
           const SurfaceBatch::Row<float>& lit, bool colour, LightBatch& light);

}  // namespace tread
