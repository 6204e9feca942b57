// What an IMU measured between two times as one motion, with its covariance and how it depends on
// the biases (Forster, Carlone, Dellaert, Scaramuzza 2017).
//
//   ImuPreintegration motion(imu, bias);
//   motion.integrate(samples, from_ns, to_ns);
//   const InertialState now = motion.predict(before, gravity_world);
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "tread/geometry/samples.hpp"
#include "tread/geometry/stereo_rig.hpp"

namespace tread {

struct ImuBias {
  Eigen::Vector3d gyro_rad_per_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel_m_per_s2 = Eigen::Vector3d::Zero();
};

struct InertialState {
  Isometry3d T_world_imu = Isometry3d::Identity();
  Eigen::Vector3d velocity_m_per_s = Eigen::Vector3d::Zero();  // in the world
  ImuBias bias;
};

class ImuPreintegration {
 public:
  using Matrix9d = Eigen::Matrix<double, 9, 9>;
  using BiasJacobian = Eigen::Matrix<double, 9, 6>;

  ImuPreintegration() = default;
  ImuPreintegration(const Imu& imu, const ImuBias& bias) : imu_(imu), bias_(bias) {}

  // Goes on from `from_ns` to `to_ns` by samples in order of time; measurements between samples are
  // interpolated, before the first and behind the last those of these. Each interval adds to the
  // one before. Intervals must follow upon each other.
  void integrate(std::span<const ImuSample> samples, std::int64_t from_ns, std::int64_t to_ns);

  // The motion in axes of the IMU at the start, gravity left out: p, v as an observer in free fall
  // would see them; R maps axes at the end into those at the start.
  struct Motion {
    Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
    Eigen::Vector3d v = Eigen::Vector3d::Zero();
    Eigen::Vector3d p = Eigen::Vector3d::Zero();
  };
  [[nodiscard]] double seconds() const { return seconds_; }
  [[nodiscard]] const Motion& motion() const { return motion_; }
  [[nodiscard]] const ImuBias& bias() const { return bias_; }
  [[nodiscard]] const Imu& imu() const { return imu_; }
  // With another bias, to first order.
  [[nodiscard]] Motion motion_with(const ImuBias& bias) const;
  // Of (rotation, v, p), the rotation as a vector applied from the right.
  [[nodiscard]] const Matrix9d& covariance() const { return covariance_; }
  // d (rotation, v, p) / d (gyro bias, accelerometer bias)
  [[nodiscard]] const BiasJacobian& by_bias() const { return by_bias_; }
  // The same measurements once more, with another bias.
  [[nodiscard]] ImuPreintegration again(const ImuBias& bias) const;

  // Where this motion leads to. gravity_world points down, 9.81 m/s^2 long.
  [[nodiscard]] InertialState predict(const InertialState& before,
                                      const Eigen::Vector3d& gravity_world) const;

 private:
  struct Step {
    double seconds;
    Eigen::Vector3d gyro, accel;  // mean over it, as measured
  };
  void add(const Step& step);

  Imu imu_;
  ImuBias bias_;
  double seconds_ = 0.0;
  Motion motion_;
  Matrix9d covariance_ = Matrix9d::Zero();
  BiasJacobian by_bias_ = BiasJacobian::Zero();
  std::vector<Step> steps_;
};

}  // namespace tread
