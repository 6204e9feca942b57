// A simulated inertial measurement unit, for each axis of gyroscope and accelerometer
//   y = (1 + s) x + b + n,  b' = w
// with a scale error s that stays, white noise n, and a bias b that starts somewhere and walks;
// then clipped to the range and rounded to a step. In discrete time the noise of a sample has the
// standard deviation density * sqrt(rate), a step of the bias walk * sqrt(period), so that the
// Allan deviation is sqrt(density^2 / tau + walk^2 tau / 3) (IEEE 952). 0.3 us a sample.
#pragma once

#include <cstdint>
#include <optional>

#include "tread/geometry/samples.hpp"
#include "tread/geometry/stereo_rig.hpp"
#include "tread/sim/body_motion.hpp"
#include "tread/sim/random.hpp"
#include "tread/sim/sensor_channel.hpp"

namespace tread {

// The noise is that of an ordinary MEMS unit (see Imu), range and steps those of EuRoC's ADIS16448.
struct ImuSensorOptions {
  SensorChannelOptions channel = {.rate_hz = 200.0, .latency_s = 0.002};
  double gyro_noise = Imu{}.gyro_noise;    // white noise, rad/s/sqrt(Hz)
  double accel_noise = Imu{}.accel_noise;  // white noise, m/s^2/sqrt(Hz)
  double gyro_walk = Imu{}.gyro_walk;      // random walk of the bias, rad/s^2/sqrt(Hz)
  double accel_walk = Imu{}.accel_walk;    // random walk of the bias, m/s^3/sqrt(Hz)
  double gyro_bias_rad_per_s = 5e-3;       // at the start, one standard deviation
  double accel_bias_m_per_s2 = 0.1;        // at the start, one standard deviation
  double gyro_scale = 2e-3;                // error, one standard deviation; 0.002: a fifth of a %
  double accel_scale = 2e-3;               // error, one standard deviation
  double gyro_range_rad_per_s = 17.5;      // both ways
  double accel_range_m_per_s2 = 176.0;     // both ways
  double gyro_step_rad_per_s = 7e-4;       // 0: not rounded
  double accel_step_m_per_s2 = 8.2e-3;     // 0: not rounded
  [[nodiscard]] bool operator==(const ImuSensorOptions&) const = default;
};
[[nodiscard]] OptionSet describe(ImuSensorOptions& options);

// What a rig file says of such a unit.
[[nodiscard]] Imu imu_of(const ImuSensorOptions& options, const Isometry3d& T_imu_left);

// What a unit without errors feels at its place on the body, in its own axes: the turn, and the
// specific force f = R^T (a + w' x r + w x (w x r) - g).
[[nodiscard]] ImuSample felt_motion(const BodyMotion& motion, const Isometry3d& T_body_imu);

class ImuSensor {
 public:
  ImuSensor(const ImuSensorOptions& options, const Isometry3d& T_body_imu, std::uint64_t seed);

  // To be asked in order of time. The stamp is left to the channel.
  [[nodiscard]] ImuSample measure(std::int64_t time_ns, const BodyMotion& motion);

  // At the time of the last measurement.
  [[nodiscard]] const Eigen::Vector3d& gyro_bias_rad_per_s() const { return gyro_.bias; }
  [[nodiscard]] const Eigen::Vector3d& accel_bias_m_per_s2() const { return accel_.bias; }
  // The ends of the ranges.
  [[nodiscard]] ImuSample full_scale() const;

 private:
  struct Axes {
    Random noise;
    Random walk;
    Eigen::Vector3d bias;
    Eigen::Vector3d scale;
  };
  struct Figures {
    double noise, walk, range, step;
  };
  static Axes start(const Random& random, double bias, double scale);
  [[nodiscard]] Eigen::Vector3d spoil(const Eigen::Vector3d& truth, double passed_s,
                                      const Figures& figures, Axes& axes) const;

  ImuSensorOptions options_;
  Isometry3d T_body_imu_;
  Axes gyro_;
  Axes accel_;
  std::optional<std::int64_t> last_ns_;
};

}  // namespace tread
