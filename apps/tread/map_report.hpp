// Pictures and report of `tread map`: every stage of one frame, and the maps of the whole drive.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "pictures.hpp"
#include "report.hpp"
#include "tread/io/source.hpp"
#include "tread/pipeline/rover_mapper.hpp"
#include "tread/plan/planner.hpp"

namespace tread {

// The stages of one frame, copied.
struct FrameSample {
  std::string name;
  Image<Rgb> left;
  Image<std::uint8_t> right;
  Image<std::uint8_t> edges;  // of the left image, as matched
  Image<float> disparity_px;
  Image<float> depth;
  PointCloud cloud;  // coloured
  Isometry3d T_level_points = Isometry3d::Identity();
  Grid<float> height;
  Grid<float> derivative;
};
[[nodiscard]] FrameSample sample_of(const StereoFrame& frame, const RoverFrame& mapped,
                                    const RoverMapper& mapper);

// What a run of the command has gathered.
struct MapRun {
  MapLayers layers;
  Trajectory trajectory;                   // T_world_left
  std::vector<Eigen::Vector3d> positions;  // of the body
  double last_yaw_rad = 0.0;
  FrameSample sample;
  std::size_t frames = 0;        // that were there, used or not
  std::vector<Error> problems;   // why frames could not be used
  std::optional<Error> nothing;  // why there is no map
  double explored_cells = 0.0;
  double frame_ms = 0.0;  // all frames, reading left out
  double wall_ms = 0.0;   // reading included
  Eigen::Vector2d start = Eigen::Vector2d::Zero();
  Eigen::Vector2d goal = Eigen::Vector2d::Zero();
  bool ends_chosen = false;  // by the program, not by the user
  Plan plan;
  Timings timings;
};

struct MapFigure {
  std::string name;  // "cost"
  std::string title;
  std::string caption;
  MapPicture picture;
  ColourScale scale;
  PictureValues values;
};
// Height, derivative, explored and cost with the way driven and the plan; those that have cells.
[[nodiscard]] std::vector<MapFigure> map_figures(const MapRun& run, const PlannerOptions& options);

[[nodiscard]] Report map_report(const std::string& command_line, const StereoSource& source,
                                const RoverMapper& mapper, const PlannerOptions& options,
                                const MapRun& run);

}  // namespace tread
