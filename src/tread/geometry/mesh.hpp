// Triangle meshes: what mapping hands to files.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "tread/core/image.hpp"

namespace tread {

struct Mesh {
  std::vector<Eigen::Vector3f> vertices;  // metres, in the frame the producer names
  std::vector<Rgb> colours;               // empty, or one a vertex
  std::vector<std::array<std::int32_t, 3>> triangles;  // counter-clockwise seen from outside
};

}  // namespace tread
