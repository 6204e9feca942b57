// What `tread depth` gathers on its way, and what it makes of it: numbers, files, the report.
#pragma once

#include <optional>
#include <string>

#include "command.hpp"
#include "tread/geometry/rectification.hpp"
#include "tread/io/image_file.hpp"
#include "tread/stereo/depth.hpp"
#include "tread/stereo/stereo_matcher.hpp"

namespace tread {

struct DepthSettings {
  StereoOptions stereo;
  DepthOptions depth{0.0, 1e4};
  int shrink = 1;
  bool auto_num_disparities = true;
  ImageReading images = {};
};

struct DepthArguments {
  std::string left, right, rig, profile = "general", command_line;
  std::optional<int> num_disparities;
  CommonOptions common;
};

struct DepthRun {
  ImageSize full_size;  // before shrinking
  Image<Rgb> colour_left, colour_right;
  Image<std::uint8_t> left, right;
  std::optional<RectifiedRig> rig;  // empty without --rig: disparity only
  DepthSettings settings;
  Image<Disparity> disparity;
  Image<float> disparity_px;  // NaN where there is no match
  Image<float> confidence;    // with stereo.rate: that a match is right, 0 to 1, NaN as above
  Image<float> sigma_px;      // and the standard deviation of its disparity
  Image<float> depth;
  PointCloud cloud;
  Isometry3d T_level_points = level_mount(0.0, 0.0, true).T_body_left;  // for pictures of it
  Timings timings;
  std::optional<Error> problem;  // why there is no result
};

// What hinders, if nothing was matched or none of it lies within the kept depths.
[[nodiscard]] std::optional<Error> find_problem(const DepthArguments& arguments,
                                                const DepthRun& run);
// A few lines, and the same for --json.
void summarise(const DepthRun& run, Output& output);
// The files of -o.
[[nodiscard]] Status write_results(const DepthArguments& arguments, const DepthRun& run,
                                   Output& output);

}  // namespace tread
