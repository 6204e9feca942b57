#include "tread/slam/fit_motion.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

namespace tread {
namespace {

// Numbers that follow from a seed on every machine (Steele, Lea, Flood 2014: SplitMix64).
class Draws {
 public:
  explicit Draws(std::uint64_t seed) : state_(seed) {}
  [[nodiscard]] std::size_t below(std::size_t n) {
    state_ += 0x9E3779B97F4A7C15ULL;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    return static_cast<std::size_t>((z ^ (z >> 31)) % n);
  }

 private:
  std::uint64_t state_;
};

// Residual and Jacobian by a twist of one point; the third row is zero where the right camera does
// not see it. False if the point is behind the camera.
struct Row {
  Eigen::Vector3d r = Eigen::Vector3d::Zero();
  Eigen::Matrix<double, 3, 6> J = Eigen::Matrix<double, 3, 6>::Zero();
  int coordinates = 3;
};
bool residual_of(const RectifiedRig& rig, const Isometry3d& T_camera_world, const SeenPoint& point,
                 Row& row) {
  const Eigen::Vector3d q = T_camera_world * point.p_world;
  if (!(q.z() > kLeastDepth_m)) return false;
  Eigen::Matrix3d J;
  row.r = sight_residual(rig, q, point.sight, &J);
  row.J = J * point_by_twist(q);
  row.coordinates = point.sight.has_right() ? 3 : 2;
  return true;
}

double squared_error(const RectifiedRig& rig, const Isometry3d& T_camera_world,
                     const SeenPoint& point) {
  const Eigen::Vector3d q = T_camera_world * point.p_world;
  if (!(q.z() > kLeastDepth_m)) return std::numeric_limits<double>::infinity();
  return sight_residual(rig, q, point.sight).squaredNorm();
}

// The pose that three points ask for, by Gauss-Newton from the guess. Empty if it does not settle.
std::optional<Isometry3d> pose_of_three(const RectifiedRig& rig,
                                        const std::array<const SeenPoint*, 3>& three,
                                        Isometry3d T) {
  constexpr int kIterations = 10;
  for (int i = 0; i < kIterations; ++i) {
    Matrix6d H = Matrix6d::Zero();
    Vector6d g = Vector6d::Zero();
    const Isometry3d inverse = T.inverse();
    for (const SeenPoint* point : three) {
      Row row;
      if (!residual_of(rig, inverse, *point, row)) return std::nullopt;
      H.noalias() += row.J.transpose() * row.J;
      g.noalias() += row.J.transpose() * row.r;
    }
    const Eigen::LDLT<Matrix6d> solver(H);
    if (!solver.isPositive() || solver.rcond() < 1e-12) return std::nullopt;
    const Vector6d step = solver.solve(-g);
    if (!step.allFinite()) return std::nullopt;
    T = T * se3_exp(step);
    if (step.norm() < 1e-5) return T;
  }
  return std::nullopt;
}

class Fit {
 public:
  Fit(const RectifiedRig& rig, std::span<const SeenPoint> points, const FitMotionOptions& options)
      : rig_(rig), points_(points), options_(options) {
    limit_ = options.gate * options.sigma_px;
    limit_ *= limit_;
  }

  // Truncated squared error of all points, and how many are within the gate.
  [[nodiscard]] double score(const Isometry3d& T, int& inliers) const {
    const Isometry3d inverse = T.inverse();
    double sum = 0.0;
    inliers = 0;
    for (const SeenPoint& point : points_) {
      const double error = squared_error(rig_, inverse, point);
      inliers += error < limit_ ? 1 : 0;
      sum += std::min(error, limit_);
    }
    return sum;
  }

  [[nodiscard]] Isometry3d best_hypothesis(const Isometry3d& guess, std::uint64_t seed) const {
    Isometry3d best = guess;
    int best_inliers = 0;
    double best_score = score(guess, best_inliers);
    Draws draws(seed);
    const std::size_t n = points_.size();
    int needed = options_.hypotheses;
    for (int i = 0; n >= 3 && i < needed; ++i) {
      const std::size_t a = draws.below(n), b = draws.below(n), c = draws.below(n);
      if (a == b || b == c || a == c) continue;
      const auto T = pose_of_three(rig_, {&points_[a], &points_[b], &points_[c]}, best);
      if (!T) continue;
      int inliers = 0;
      const double here = score(*T, inliers);
      if (here < best_score) {
        best = *T;
        best_score = here;
        best_inliers = inliers;
      }
      needed = std::min(needed, needed_for(best_inliers));
    }
    return best;
  }

  // Robust refinement (Cauchy) on all points near enough.
  void refine(const Isometry3d& guess, const Matrix6d& information, MotionFit& fit) const {
    constexpr int kIterations = 12;
    Isometry3d& T = fit.T_world_camera;
    for (int i = 0; i < kIterations; ++i) {
      Matrix6d H = information;
      const Vector6d from_guess = se3_log(guess.inverse() * T);
      Vector6d g = information * from_guess;
      sum_rows(T, H, g);
      const Vector6d step = H.ldlt().solve(-g);
      if (!step.allFinite()) return;
      T = T * se3_exp(step);
      if (step.norm() < 1e-7) break;
    }
    judge(information, fit);
  }

 private:
  // After so many draws three inliers were among them with a probability of 0.999.
  [[nodiscard]] int needed_for(int inliers) const {
    const double share = static_cast<double>(inliers) / static_cast<double>(points_.size());
    const double all_good = share * share * share;
    if (all_good < 1e-3) return options_.hypotheses;
    if (all_good > 0.999) return 1;
    return static_cast<int>(std::ceil(std::log(1e-3) / std::log(1.0 - all_good)));
  }

  void sum_rows(const Isometry3d& T, Matrix6d& H, Vector6d& g) const {
    const Isometry3d inverse = T.inverse();
    const double information = 1.0 / (options_.sigma_px * options_.sigma_px);
    const double knee = 4.0 * options_.sigma_px * options_.sigma_px;
    for (const SeenPoint& point : points_) {
      Row row;
      if (!residual_of(rig_, inverse, point, row)) continue;
      const double error = row.r.squaredNorm();
      if (error > 4.0 * limit_) continue;
      const double w = information / (1.0 + error / knee);
      H.noalias() += w * row.J.transpose() * row.J;
      g.noalias() += w * row.J.transpose() * row.r;
    }
  }

  void judge(const Matrix6d& information, MotionFit& fit) const {
    const Isometry3d inverse = fit.T_world_camera.inverse();
    Matrix6d H = Matrix6d::Zero();
    double sum = 0.0;
    int coordinates = 0;
    fit.inliers = 0;
    fit.is_inlier.assign(points_.size(), 0);
    for (std::size_t i = 0; i < points_.size(); ++i) {
      Row row;
      if (!residual_of(rig_, inverse, points_[i], row)) continue;
      const double error = row.r.squaredNorm();
      if (error >= limit_) continue;
      fit.is_inlier[i] = 1;
      ++fit.inliers;
      sum += error;
      coordinates += row.coordinates;
      H.noalias() += row.J.transpose() * row.J;
    }
    if (fit.inliers < options_.least_inliers) return;
    fit.rms_px = std::sqrt(sum / coordinates);
    // If points spread more than was told, the pose is as much less certain; not the other way.
    const double sigma = std::max(options_.sigma_px, fit.rms_px);
    H = H / (sigma * sigma) + information;
    const Eigen::LDLT<Matrix6d> solver(H);
    if (!solver.isPositive() || solver.rcond() < 1e-14) return;
    fit.covariance = solver.solve(Matrix6d::Identity());
    fit.covariance = (0.5 * (fit.covariance + fit.covariance.transpose())).eval();
    fit.found = fit.covariance.allFinite();
  }

  const RectifiedRig& rig_;
  std::span<const SeenPoint> points_;
  const FitMotionOptions& options_;
  double limit_ = 0.0;  // pixels squared
};

}  // namespace

OptionSet describe(FitMotionOptions& options) {
  OptionSet set;
  set.add("sigma_px", options.sigma_px, "of a feature's place in each image, px", 0.01, 10.0);
  set.add("gate", options.gate, "beyond so many sigma a point is an outlier", 1.0, 100.0);
  set.add("hypotheses", options.hypotheses, "of three points each, at most", 1, 100'000);
  set.add("least_inliers", options.least_inliers, "for a motion to be believed", 4, 100'000);
  return set;
}

MotionFit fit_motion(const RectifiedRig& rig, std::span<const SeenPoint> points,
                     const Isometry3d& guess, const Matrix6d& information,
                     const FitMotionOptions& options, std::uint64_t seed) {
  MotionFit fit;
  fit.T_world_camera = guess;
  fit.is_inlier.assign(points.size(), 0);
  if (points.empty()) return fit;
  const Fit fitting(rig, points, options);
  fit.T_world_camera = fitting.best_hypothesis(guess, seed);
  fitting.refine(guess, information, fit);
  return fit;
}

}  // namespace tread
