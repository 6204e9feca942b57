// Point clouds: what stereo hands to terrain and to files.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tread/core/image.hpp"

namespace tread {

struct PointCloud {
  std::vector<Eigen::Vector3f> points;  // metres, in the frame the producer names
  std::vector<Rgb> colours;             // empty, or one a point
};

}  // namespace tread
