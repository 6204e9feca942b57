#include "tread/sim/tyre.hpp"

#include <algorithm>
#include <cmath>

namespace tread {
namespace {

constexpr double kMostUsed = 0.95;  // beyond which the tread slides as a whole
constexpr double kRollsM = 0.02;    // m/s from which resistance is that of rolling

Eigen::Vector3d along(const Eigen::Vector3d& v, const Eigen::Vector3d& normal) {
  return v - v.dot(normal) * normal;
}

// At most so long.
Eigen::Vector3d shortened(const Eigen::Vector3d& v, double most) {
  const double length = v.norm();
  return length > most ? Eigen::Vector3d(v * (most / length)) : v;
}

}  // namespace

double slip_ratio(const Footing& footing, double used) {
  return -footing.slip * std::log2(1.0 - std::clamp(used, 0.0, kMostUsed));
}

Eigen::Vector3d tyre_force(const TyreContact& contact, const TyreOptions& options, double step_s,
                           Eigen::Vector3d& bristle_m) {
  const Footing& footing = contact.footing;
  const double most = footing.friction * contact.load_n;
  if (!(most > 0.0)) {
    bristle_m.setZero();
    return Eigen::Vector3d::Zero();
  }
  const double k = options.stiffness_n_per_m;
  const Eigen::Vector3d velocity = along(contact.velocity_m_per_s, contact.normal);
  bristle_m = along(bristle_m, contact.normal);
  const double rolls = std::tanh(contact.rolling_m_per_s / kRollsM);
  const Eigen::Vector3d used =
      (rolls * footing.rolling_resistance * contact.load_n * contact.ahead - k * bristle_m) / most;
  const double share = used.norm();
  const Eigen::Vector3d before = bristle_m;
  bristle_m += step_s * velocity;
  if (share > 0.0) {
    const double slips =
        step_s * std::abs(contact.rolling_m_per_s) * slip_ratio(footing, share) / share;
    // In a step no more than a third is rolled out: near the limit of friction the law is too steep
    // for steps of this length.
    bristle_m += shortened(slips * used, share * most / (3.0 * k));
  }
  bristle_m = shortened(bristle_m, most / k);
  const double damping = options.damping_n_s_per_m / step_s;
  return shortened(-k * bristle_m - damping * (bristle_m - before), most);
}

}  // namespace tread
