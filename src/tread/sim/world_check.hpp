// What must hold of a world before anything is made of it.
#pragma once

#include "tread/core/result.hpp"
#include "tread/sim/world.hpp"

namespace tread {

// Ground of at least 2 x 2 cells with finite heights and known materials, solids with sides above
// zero in rigid places, meshes whose triangles have vertices, people with a way to walk. Errors
// name the thing: "solids[3] (rock): half_m".
[[nodiscard]] Status check_world(const World& world);

}  // namespace tread
