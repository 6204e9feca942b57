#include "tread/slam/inertial_start.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <cmath>

namespace tread {
namespace {

constexpr double kGravity = 9.81;  // m/s^2; 0.3 % more or less over the Earth
constexpr std::size_t kLeastFrames = 6;
constexpr double kLeastSeconds = 1.0;

// Gauss-Newton on the rotations alone.
std::optional<Eigen::Vector3d> gyro_bias(const std::vector<WindowFrame>& frames,
                                         const Isometry3d& T_camera_imu) {
  constexpr double kLargest = 0.5;  // rad/s: more is no bias
  Eigen::Vector3d bias = frames[1].since->bias().gyro_rad_per_s;
  for (int i = 0; i < 3; ++i) {
    Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
    Eigen::Vector3d g = Eigen::Vector3d::Zero();
    for (std::size_t k = 1; k < frames.size(); ++k) {
      const ImuPreintegration measured = frames[k].since->again({bias, Eigen::Vector3d::Zero()});
      const Eigen::Matrix3d R_a = frames[k - 1].T_world_camera.linear() * T_camera_imu.linear();
      const Eigen::Matrix3d R_b = frames[k].T_world_camera.linear() * T_camera_imu.linear();
      const Eigen::Vector3d r = so3_log(measured.motion().R.transpose() * R_a.transpose() * R_b);
      const Eigen::Matrix3d J = measured.by_bias().block<3, 3>(0, 0);
      H += J.transpose() * J;
      g += J.transpose() * r;
    }
    bias += H.ldlt().solve(g);
  }
  if (!bias.allFinite() || bias.norm() > kLargest) return std::nullopt;
  return bias;
}

}  // namespace

std::optional<Eigen::Vector3d> start_inertia(std::vector<WindowFrame>& frames,
                                             const Isometry3d& T_camera_imu) {
  const std::size_t n = frames.size();
  if (n < kLeastFrames) return std::nullopt;
  double seconds = 0.0;
  for (std::size_t k = 1; k < n; ++k) {
    if (!frames[k].since) return std::nullopt;
    seconds += frames[k].since->seconds();
  }
  if (seconds < kLeastSeconds) return std::nullopt;
  const auto bias = gyro_bias(frames, T_camera_imu);
  if (!bias) return std::nullopt;
  // v_b - v_a - g dt = R_a dv;  p_b - p_a - v_a dt - g dt^2 / 2 = R_a dp. Unknown: all v, g.
  const auto rows = static_cast<Eigen::Index>(6 * (n - 1)),
             columns = static_cast<Eigen::Index>(3 * n + 3);
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(rows, columns);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(rows);
  for (std::size_t k = 1; k < n; ++k) {
    const ImuPreintegration measured = frames[k].since->again({*bias, Eigen::Vector3d::Zero()});
    const double dt = measured.seconds();
    const Isometry3d T_a = frames[k - 1].T_world_camera * T_camera_imu;
    const Isometry3d T_b = frames[k].T_world_camera * T_camera_imu;
    const auto row = static_cast<Eigen::Index>(6 * (k - 1)),
               v_a = static_cast<Eigen::Index>(3 * (k - 1));
    const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
    A.block<3, 3>(row, v_a) = -I;
    A.block<3, 3>(row, v_a + 3) = I;
    A.block<3, 3>(row, columns - 3) = -dt * I;
    b.segment<3>(row) = T_a.linear() * measured.motion().v;
    // Divided by the time: both rows are speeds then.
    A.block<3, 3>(row + 3, v_a) = -I;
    A.block<3, 3>(row + 3, columns - 3) = -0.5 * dt * I;
    b.segment<3>(row + 3) =
        (T_a.linear() * measured.motion().p - (T_b.translation() - T_a.translation())) / dt;
  }
  const Eigen::VectorXd x = A.colPivHouseholderQr().solve(b);
  const Eigen::Vector3d gravity = x.tail<3>();
  constexpr double kTolerance = 1.0;  // an accelerometer bias of 0.1 g
  if (!x.allFinite() || std::abs(gravity.norm() - kGravity) > kTolerance) return std::nullopt;
  for (std::size_t k = 0; k < n; ++k) {
    frames[k].velocity_m_per_s = x.segment<3>(static_cast<Eigen::Index>(3 * k));
    frames[k].bias = {*bias, Eigen::Vector3d::Zero()};
    if (frames[k].since) frames[k].since = frames[k].since->again(frames[k].bias);
  }
  return Eigen::Vector3d(kGravity * gravity.normalized());
}

std::optional<Eigen::Matrix3d> level_camera(std::span<const ImuSample> samples,
                                            const Isometry3d& T_camera_imu) {
  if (samples.empty()) return std::nullopt;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const ImuSample& sample : samples) mean += sample.accel_m_per_s2;
  mean /= static_cast<double>(samples.size());
  constexpr double kTolerance = 1.5;
  if (!(std::abs(mean.norm() - kGravity) < kTolerance)) return std::nullopt;
  const Eigen::Vector3d up = (T_camera_imu.linear() * mean).normalized();
  // Ahead is where the camera looks, or where its upper edge is if it looks straight up or down.
  Eigen::Vector3d ahead = Eigen::Vector3d::UnitZ() - up.z() * up;
  if (ahead.norm() < 0.1) ahead = -Eigen::Vector3d::UnitY() + up.y() * up;
  ahead.normalize();
  Eigen::Matrix3d R_camera_world;
  R_camera_world << ahead, up.cross(ahead), up;
  return Eigen::Matrix3d(R_camera_world.transpose());
}

}  // namespace tread
