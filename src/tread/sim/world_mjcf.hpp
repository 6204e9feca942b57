// The world as MuJoCo reads it (MJCF). Geoms are called by numbers ("solid_3"), never by what a
// course calls them, so no name can break the file. Axes as the world's.
#pragma once

#include <string>
#include <string_view>

#include "tread/core/result.hpp"
#include "tread/sim/world.hpp"

namespace tread {

// Whether physics can be made from it: ground without holes, materials that exist, solids with a
// size and a rigid pose. An error names the thing.
[[nodiscard]] Status check_for_physics(const World& world);

// What stands in a file beside the world.
struct RobotMjcf {
  std::string assets;    // of <asset>
  std::string bodies;    // of <worldbody>
  std::string settings;  // of the top: <option>, <size>, ...
};

// Robot parts collide with the world, but neither with each other nor parts of the world with
// themselves: geoms of the world have contype 1, those of the robot must have conaffinity 1.
// Foliage is left out. Heights of the ground are no part of it: fill_ground.
[[nodiscard]] std::string world_mjcf(const World& world, const RobotMjcf& robot);

// Of the field of heights in that file.
struct GroundField {
  int rows = 0, columns = 0;
  double low_m = 0.0, range_m = 0.0;
  std::vector<float> data;  // 0 to 1, row by row
};
// MuJoCo cuts the squares of a height field from its corner (x, y) to (x+1, y+1), the world from
// (x+1, y) to (x, y+1): so the field lies turned by 90 degrees, its x along world y and its y
// against world x.
[[nodiscard]] GroundField ground_field(const World& world);

// The friction of geoms as MJCF has it: sliding, torsional, rolling.
[[nodiscard]] std::string friction_attribute(const Footing& footing);

}  // namespace tread
