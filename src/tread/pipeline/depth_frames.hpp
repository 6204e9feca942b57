// Depth images from whatever there is: RGB-D folders give them, stereo pairs are matched.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tread/geometry/rectification.hpp"
#include "tread/io/rgbd_source.hpp"
#include "tread/io/source.hpp"
#include "tread/slam/depth_slam.hpp"
#include "tread/stereo/depth.hpp"
#include "tread/stereo/stereo_matcher.hpp"

namespace tread {

struct DepthFramesOptions {
  RgbdOptions rgbd;
  SourceOptions stereo_source;
  StereoOptions stereo;
  DepthOptions depth{0.3, 200.0};
};

// Not to be shared by two threads.
class DepthFrames {
 public:
  [[nodiscard]] static Result<DepthFrames> open(const std::filesystem::path& path,
                                                const DepthFramesOptions& options);
  // Depths of the pairs of a source that is open already.
  [[nodiscard]] static Result<DepthFrames> from(std::unique_ptr<StereoSource> pairs,
                                                const DepthFramesOptions& options);

  [[nodiscard]] const PinholeCamera& camera() const { return camera_; }
  // What is known of the depths by how they are measured. Only stereo says; else the sensor's.
  [[nodiscard]] const std::optional<DepthNoise>& noise() const { return noise_; }
  // Up to where a depth is good to a fortieth of itself; stereo only.
  [[nodiscard]] std::optional<double> range_m() const;
  [[nodiscard]] int frame_count() const;
  [[nodiscard]] std::string kind() const;
  // Reference poses of the camera, as far as they are known (of frames read so far, with stereo).
  [[nodiscard]] const Trajectory& truth() const;
  [[nodiscard]] const std::vector<Error>& problems() const;
  // Of pairs: the rectified rig, whose left camera is camera(); the IMU beside it, if there is one;
  // and the pair that the last depth image was made of, with what the IMU measured since the pair
  // before that (the first: in the second before).
  [[nodiscard]] const std::optional<RectifiedRig>& rig() const { return rig_; }
  [[nodiscard]] const std::optional<Imu>& imu() const { return imu_; }
  struct Pair {
    ImageView<const std::uint8_t> left, right;
    std::span<const ImuSample> imu;
  };
  [[nodiscard]] Pair pair() const { return {left_, right_, samples_}; }
  // As StereoSource::next(). Depth, grey and rgb have one size.
  [[nodiscard]] Result<std::optional<RgbdFrame>> next(const Context& context = {});

 private:
  DepthFrames() = default;
  [[nodiscard]] Status prepare_stereo();
  [[nodiscard]] Result<std::optional<RgbdFrame>> next_pair(const Context& context);

  DepthFramesOptions options_;
  PinholeCamera camera_;
  std::optional<DepthNoise> noise_;
  std::unique_ptr<RgbdSource> rgbd_;
  std::unique_ptr<StereoSource> pairs_;
  // Of pairs.
  std::optional<RectifiedRig> rig_;
  std::optional<Imu> imu_;
  std::optional<Rectification> rectification_;
  Isometry3d T_left_camera_ = Isometry3d::Identity();  // of the rectified camera
  StereoMatcher matcher_;
  bool range_chosen_ = false;
  Trajectory truth_;
  Image<std::uint8_t> left_, right_;
  std::vector<ImuSample> samples_;
};

}  // namespace tread
