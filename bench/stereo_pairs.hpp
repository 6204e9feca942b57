// Stereo pairs with ground truth for the benchmarks, from $TREAD_DATA or ../shared/data.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tread/core/image.hpp"
#include "tread/core/result.hpp"

namespace tread::bench {

struct StereoPair {
  std::string name;  // "cones", "kitti2012/000020"
  std::string set;   // "cones", "kitti2012"
  Image<std::uint8_t> left;
  Image<std::uint8_t> right;
  Image<float> truth;        // disparity of the left image, px, NaN where unknown
  int num_disparities = 64;  // searched by every method
};

// The folder of the development data, empty if there is none.
[[nodiscard]] std::filesystem::path data_folder();

// Middlebury cones, Cloth3 and Motorcycle, and the pairs of KITTI 2012 that are there. The scales
// of the ground truth: cones value / 4, Cloth3 value / 2, KITTI value / 256.
[[nodiscard]] Result<std::vector<StereoPair>> load_stereo_pairs(const std::filesystem::path& data);

}  // namespace tread::bench
