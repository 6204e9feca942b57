// What tread slam shows of a run.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "report.hpp"
#include "tread/geometry/mesh.hpp"
#include "tread/geometry/samples.hpp"
#include "tread/geometry/trajectory_error.hpp"
#include "tread/slam/depth_slam.hpp"
#include "tread/slam/visual_odometry.hpp"

namespace tread {

struct SlamRun {
  std::string kind;
  std::vector<SlamState> states;           // of the frames that could be read
  std::vector<OdometryState> odometry;     // of the same, if they were pairs
  std::optional<Isometry3d> T_camera_imu;  // if there is an IMU
  Trajectory trajectory;                   // of those that were placed
  std::size_t frames = 0;                  // also those that could not be read
  std::vector<Error> problems;
  double path_m = 0.0;
  int loops = 0;                        // closed
  double track_ms = 0.0, cpu_ms = 0.0;  // of all frames; cpu: also reading
  double peak_memory_mb = 0.0;
  std::size_t volume_bytes = 0;
  std::int64_t refused_blocks = 0;
  Mesh mesh;
  std::optional<TrajectoryError> absolute, relative;  // against the reference, over a second
  RgbdFrame sample;                                   // the frame that the report shows
  Timings timings;
};

// Frames with this status.
[[nodiscard]] std::size_t count_of(const SlamRun& run, TrackStatus status);
// stamp, status and figures of each frame.
[[nodiscard]] std::string tracking_csv(const SlamRun& run);
// The way from above over the heights of the surface.
[[nodiscard]] MapPicture draw_way(const SlamRun& run, ColourScale& scale);
[[nodiscard]] Report slam_report(const std::string& command_line, const SlamOptions& options,
                                 const SlamRun& run);

}  // namespace tread
