#include "tread/slam/inertial_track.hpp"

#include <algorithm>

#include "tread/slam/inertial_start.hpp"

namespace tread {
namespace {

constexpr double kLongestHole_s = 0.05;
// Gravity has settled after so many keyframes; it does not move then.
constexpr int kSettled = 20;
// What a prediction may be off besides the noise of the measurements.
constexpr double kTurnSigma_rad = 0.003;
constexpr double kPlaceSigma_m = 0.01;
constexpr double kSpeedSigma_m_per_s = 0.1;

}  // namespace

InertialTrack::InertialTrack(const Imu& imu) : imu_(imu) {
  window_.T_camera_imu = imu.T_imu_left.inverse();
}

void InertialTrack::advance(std::span<const ImuSample> samples, std::int64_t from_ns,
                            std::int64_t to_ns) {
  const std::optional<ImuSample> last =
      samples_.empty() ? std::nullopt : std::optional(samples_.back());
  samples_.clear();
  if (last) samples_.push_back(*last);
  for (const ImuSample& sample : samples) {
    const bool sound = sample.gyro_rad_per_s.allFinite() && sample.accel_m_per_s2.allFinite() &&
                       (samples_.empty() || sample.stamp_ns > samples_.back().stamp_ns);
    if (sound) samples_.push_back(sample);
  }
  std::int64_t at = from_ns, hole = 0;
  for (const ImuSample& sample : samples_) {
    if (sample.stamp_ns <= from_ns) continue;
    hole = std::max(hole, std::min(sample.stamp_ns, to_ns) - at);
    at = sample.stamp_ns;
  }
  hole = std::max(hole, to_ns - at);
  if (samples_.empty() || static_cast<double>(hole) * 1e-9 > kLongestHole_s) whole_ = false;
  since_before_ = ImuPreintegration(imu_, bias_);
  since_before_.integrate(samples_, from_ns, to_ns);
  if (whole_) since_key_.integrate(samples_, from_ns, to_ns);
}

void InertialTrack::at_keyframe(const WindowFrame& key) {
  if (started_) {
    bias_ = key.bias;
    window_.gravity_known = ++keyframes_ > kSettled;
  }
  since_key_ = ImuPreintegration(imu_, bias_);
  whole_ = true;
}

void InertialTrack::start(std::vector<WindowFrame>& keyframes) {
  if (started_) return;
  const auto gravity = start_inertia(keyframes, window_.T_camera_imu);
  if (!gravity) return;
  window_.gravity_world = *gravity;
  started_ = true;
}

std::optional<InertialTrack::Prediction> InertialTrack::predict(const WindowFrame& key,
                                                                const Isometry3d& T_before,
                                                                const Isometry3d& T_guess) const {
  if (!whole_ || since_before_.seconds() <= 0.0) return std::nullopt;
  const Isometry3d& T_camera_imu = window_.T_camera_imu;
  Prediction prediction;
  Vector6d sigma;
  if (!started_) {
    const Eigen::Matrix3d turn =
        T_camera_imu.linear() * since_before_.motion().R * T_camera_imu.linear().transpose();
    prediction.T_world_camera = T_guess;
    prediction.T_world_camera.linear() = T_before.linear() * turn;
    // The bias is not known yet: a few degrees a second.
    const double turn_sigma = kTurnSigma_rad + 0.03 * since_before_.seconds();
    prediction.information.diagonal().tail<3>().setConstant(1.0 / (turn_sigma * turn_sigma));
    return prediction;
  }
  const InertialState at_key{key.T_world_camera * T_camera_imu, key.velocity_m_per_s, key.bias};
  const InertialState now = since_key_.predict(at_key, window_.gravity_world);
  prediction.T_world_camera = now.T_world_imu * T_camera_imu.inverse();
  prediction.velocity_m_per_s = now.velocity_m_per_s;
  prediction.holds = true;
  const double dt = since_key_.seconds();
  const auto& covariance = since_key_.covariance();
  const double turn = covariance.topLeftCorner<3, 3>().trace() / 3.0,
               place = covariance.bottomRightCorner<3, 3>().trace() / 3.0;
  const double place_sigma = kPlaceSigma_m + kSpeedSigma_m_per_s * dt;
  prediction.information.diagonal()
      << Eigen::Vector3d::Constant(1.0 / (place + place_sigma * place_sigma)),
      Eigen::Vector3d::Constant(1.0 / (turn + kTurnSigma_rad * kTurnSigma_rad));
  return prediction;
}

}  // namespace tread
