// Writes what a robot's sensors gave, and the truth if it is known, as a folder in the layout of
// EuRoC/ASL, so that open_stereo_source and the tools of others read it:
//
//   DIR/recording.yaml      what it is, and how many samples of each kind
//   DIR/rig.yaml            head 0 with its mount, and the IMU (write_rig)
//   DIR/poses.txt           if the head turns: T_world_left of head 0 (TUM)
//   DIR/mav0/camN/          N = 2 h for the left and 2 h + 1 for the right camera of head h
//     data/STAMP.png, data.csv, sensor.yaml
//   DIR/mav0/imu0/          data.csv, sensor.yaml
//   DIR/mav0/gnss0/         data.csv, sensor.yaml
//   DIR/mav0/wheels0/, legs0/, head0/, bump0/                     data.csv
//   DIR/mav0/state_groundtruth_estimate0/data.csv                 the 17 columns of EuRoC
//   DIR/truth/body.tum      T_world_body
//   DIR/truth/left.tum      T_world_left of head 0; left1.tum of head 1, ...
//   DIR/truth/depth/STAMP.tif     of the left camera of head 0, metres; depth1/ of head 1, ...
//   DIR/truth/NAME.tif      rasters: height, traversable
//
// Stamps are nanoseconds, file names of images have 19 digits. T_BS maps the axes of a sensor into
// those of the body (x forward, y left, z up; docs/frames.md). Rows stand in the order in which
// samples came: what a sensor sent out of order, or twice, stands there so. Numbers are printed so
// that they are read back equal.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "tread/core/grid.hpp"
#include "tread/core/result.hpp"
#include "tread/geometry/samples.hpp"
#include "tread/geometry/stereo_rig.hpp"

namespace tread {

struct RecordingSetup {
  std::string description;       // one line
  std::vector<StereoRig> heads;  // each with its mount (at rest); the IMU is that of head 0
  double camera_rate_hz = 10.0;
  bool head_turns = false;  // head 0 moves on the body: the IMU is then not fixed to the cameras,
                            // and poses come from the frames
  double gnss_rate_hz = 1.0;
  Eigen::Vector3d p_body_antenna_m = Eigen::Vector3d::Zero();
};

// Where the body was in truth, and what its IMU's biases were.
struct BodyTruth {
  std::int64_t stamp_ns = 0;
  Isometry3d T_world_body = Isometry3d::Identity();
  Eigen::Vector3d velocity_m_per_s = Eigen::Vector3d::Zero();  // world axes
  Eigen::Vector3d gyro_bias_rad_per_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel_bias_m_per_s2 = Eigen::Vector3d::Zero();
};

// Nothing of an earlier recording in the folder is touched before finish(), which replaces it as a
// whole; a writer that goes without leaves the folder as it was. After an error of the disk nothing
// more is taken, and finish() gives that error again.
class DataSetWriter {
 public:
  // Makes the folder. Refused: a folder that holds something but no recording, or an old recording
  // with files that are no part of one; a head without mount; a camera that sensor.yaml has no form
  // for (it knows pinhole without skew, Brown with K1 to K3, P1 and P2, and Kannala-Brandt).
  [[nodiscard]] static Result<DataSetWriter> create(const std::filesystem::path& folder,
                                                    const RecordingSetup& setup);
  ~DataSetWriter();
  DataSetWriter(DataSetWriter&&) noexcept;
  DataSetWriter& operator=(DataSetWriter&&) = delete;

  // Images of the size of the rig; the left one in colour if the frame has that, else grey. A frame
  // of a stamp that was there before is left out, as its files have the name of the stamp.
  [[nodiscard]] Status add(int head, const StereoFrame& frame);
  // Numbers must be finite and stamps not negative, here and below.
  [[nodiscard]] Status add(const ImuSample& sample);
  [[nodiscard]] Status add(const GnssFix& fix);
  [[nodiscard]] Status add(const WheelSample& sample);
  [[nodiscard]] Status add(const LegSample& sample);
  [[nodiscard]] Status add(const HeadState& state);
  [[nodiscard]] Status add(const BumpEvent& event);
  [[nodiscard]] Status add(const BodyTruth& truth);
  // Depth along the optical axis of the left camera as it is (not rectified), NaN where unknown.
  [[nodiscard]] Status add_depth(int head, std::int64_t stamp_ns, ImageView<const float> depth);
  // truth/NAME.tif, north up; a second one of a name replaces the first.
  [[nodiscard]] Status add_raster(const std::string& name, const Grid<float>& raster);

  // Puts the recording in its place; only then it is there. Nothing can be added afterwards.
  [[nodiscard]] Status finish();

 private:
  struct State;
  explicit DataSetWriter(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace tread
