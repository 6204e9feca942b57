// Internal to slam: the IMU beside visual odometry, from the last keyframe to now.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "tread/slam/imu_preintegration.hpp"
#include "tread/slam/refine_window.hpp"

namespace tread {

class InertialTrack {
 public:
  explicit InertialTrack(const Imu& imu);

  // Samples of the time since the frame before. If they have holes, nothing is known until the next
  // keyframe.
  void advance(std::span<const ImuSample> samples, std::int64_t from_ns, std::int64_t to_ns);
  // A keyframe was made at the frame at hand, and the window refined.
  void at_keyframe(const WindowFrame& key);
  // Finds gravity and velocities if that has not been done and the keyframes allow it.
  void start(std::vector<WindowFrame>& keyframes);
  // What is to be refined, or nothing before it has started.
  [[nodiscard]] WindowInertia* window() { return started_ ? &window_ : nullptr; }
  [[nodiscard]] bool started() const { return started_; }

  // Since the last keyframe; empty if samples are missing.
  [[nodiscard]] const ImuPreintegration* since_key() const {
    return whole_ ? &since_key_ : nullptr;
  }

  struct Prediction {
    Isometry3d T_world_camera = Isometry3d::Identity();
    Eigen::Vector3d velocity_m_per_s = Eigen::Vector3d::Zero();  // of the IMU
    Matrix6d information = Matrix6d::Zero();                     // of a twist in axes of the camera
    bool holds = false;  // all six directions are known for a while
  };
  // From the last keyframe if it has started; before, the turn alone, on top of `T_guess`.
  [[nodiscard]] std::optional<Prediction> predict(const WindowFrame& key,
                                                  const Isometry3d& T_before,
                                                  const Isometry3d& T_guess) const;

 private:
  Imu imu_;
  WindowInertia window_;
  bool started_ = false;
  bool whole_ = false;
  int keyframes_ = 0;  // since it started
  ImuBias bias_;
  ImuPreintegration since_key_, since_before_;
  std::vector<ImuSample> samples_;  // of this interval, and the last one before it
};

}  // namespace tread
