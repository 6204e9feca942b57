// What tread simulate shows of a run.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "course_pictures.hpp"
#include "report.hpp"
#include "tread/geometry/trajectory.hpp"

namespace tread {

struct SimulateRun {
  std::string course, robot;
  std::uint64_t world_seed = 0, sensor_seed = 0;
  double duration_s = 0.0, wall_s = 0.0, cpu_s = 0.0;
  double way_m = 0.0;
  std::string end;                                            // "arrived", "stuck after 3.2 m", ...
  std::vector<std::pair<std::string, std::int64_t>> samples;  // of each sensor
  Trajectory path;                                            // of the body, thinned out
  std::vector<Eigen::Vector2d> route;
  std::vector<std::string> faults;
  PictureFromAbove above;
  Image<Rgb> eye;
  Image<std::uint8_t> left, right;  // a pair from the middle of the run
  Image<float> depth;               // of its left camera
  std::int64_t depth_stamp_ns = 0;
  Grid<float> height, traversable;
  std::vector<Error> problems;
  Timings timings;
};

// The course from above with the route and the way that was gone.
[[nodiscard]] Image<Rgb> draw_course(const SimulateRun& run);
[[nodiscard]] Report simulate_report(const std::string& command_line, const SimulateRun& run);

}  // namespace tread
