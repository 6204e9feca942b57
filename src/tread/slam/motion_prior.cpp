#include "tread/slam/motion_prior.hpp"

#include <Eigen/Cholesky>

namespace tread {

Status check_motion(const MotionPrior& motion) {
  const Matrix6d& c = motion.covariance;
  const Eigen::LDLT<Matrix6d> parts(c);
  const bool sound = c.allFinite() && (c - c.transpose()).norm() <= 1e-6 * c.norm() &&
                     parts.isPositive() && parts.vectorD().minCoeff() > 0.0;
  if (sound && is_rigid(motion.T_before_now)) return {};
  return fail(ErrorCode::kBadValue,
              "the motion is not rigid, or its covariance not symmetric and positive", "motion",
              "Give variances above zero, however small, or leave the motion out");
}

}  // namespace tread
