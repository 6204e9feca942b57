// Internal to sim: what of an upright line is inside a solid.
#pragma once

#include <optional>

#include "tread/sim/world.hpp"

namespace tread::internal {

struct HeightRange {
  double low = 0.0, high = 0.0;
};

// From where to where the line over a place is inside; empty if it passes by.
[[nodiscard]] std::optional<HeightRange> height_range(const World& world, const Solid& solid,
                                                      const Eigen::Vector2d& place);
// The radius of a circle about its origin that holds it, seen from above.
[[nodiscard]] double outer_radius(const World& world, const Solid& solid);

}  // namespace tread::internal
