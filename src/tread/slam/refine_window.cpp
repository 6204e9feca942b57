#include "tread/slam/refine_window.hpp"

#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>
#include <ceres/sphere_manifold.h>

#include <algorithm>
#include <memory>

#include "tread/slam/inertial_cost.hpp"
#include "tread/slam/pose_block.hpp"
#include "tread/slam/sight_cost.hpp"

namespace tread {
namespace {

const WindowFrame* frame_of(const std::vector<WindowFrame>& frames, std::int64_t id) {
  const auto at = std::lower_bound(frames.begin(), frames.end(), id,
                                   [](const WindowFrame& f, std::int64_t i) { return f.id < i; });
  return at != frames.end() && at->id == id ? &*at : nullptr;
}

void forget_lost_frames(const std::vector<WindowFrame>& frames, WindowPoint& point) {
  std::erase_if(point.seen, [&](const WindowPoint::Sighting& sighting) {
    return frame_of(frames, sighting.frame) == nullptr;
  });
}

void forget_outliers(const RectifiedRig& rig, double limit_px,
                     const std::vector<WindowFrame>& frames, WindowPoint& point) {
  std::erase_if(point.seen, [&](const WindowPoint::Sighting& sighting) {
    const Isometry3d& T = frame_of(frames, sighting.frame)->T_world_camera;
    const Eigen::Vector3d q = T.inverse() * point.p_world;
    if (!(q.z() > kLeastDepth_m)) return true;
    return !(sight_residual(rig, q, sighting.sight).norm() < limit_px);
  });
}

// The least-squares problem, and the memory its parameters live in.
class WindowProblem {
 public:
  WindowProblem(const RectifiedRig& rig, double sigma_px, const WindowOptions& options,
                std::vector<WindowFrame>& frames)
      : rig_(rig), sigma_px_(sigma_px), options_(options), frames_(frames), problem_(borrowed()) {
    const std::size_t n = frames.size(), free = static_cast<std::size_t>(options.free_keyframes);
    // The oldest is never free: it says where the world is.
    first_free_ = std::max<std::size_t>(1, n - std::min(n, free));
    state_.resize(n * kBlock + 3);
    for (std::size_t i = 0; i < n; ++i) {
      const PoseBlock block = block_of(frames[i].T_world_camera);
      std::copy(block.begin(), block.end(), pose(i));
      problem_.AddParameterBlock(pose(i), 7, &pose_manifold_);
      ordering_->AddElementToGroup(pose(i), 1);
      if (i < first_free_) problem_.SetParameterBlockConstant(pose(i));
    }
  }

  // How many there were.
  int add_sights(const std::vector<WindowPoint*>& points) {
    const std::int64_t first_free_id = frames_[first_free_].id;
    for (const WindowPoint* point : points) places_.push_back(point->p_world);
    int count = 0;
    for (std::size_t k = 0; k < points.size(); ++k) {
      const WindowPoint& point = *points[k];
      if (point.seen.size() < 2 || point.seen.back().frame < first_free_id) continue;
      for (const WindowPoint::Sighting& sighting : point.seen) {
        const auto i = static_cast<std::size_t>(frame_of(frames_, sighting.frame) - frames_.data());
        problem_.AddResidualBlock(new SightCost(rig_, sighting.sight, sigma_px_), &loss_, pose(i),
                                  places_[k].data());
        ++count;
      }
      ordering_->AddElementToGroup(places_[k].data(), 0);
    }
    return count;
  }

  void add_inertia(const WindowInertia& inertia) {
    Eigen::Map<Eigen::Vector3d> g(gravity());
    g = inertia.gravity_world;
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      Eigen::Map<Motion> m(motion(i));
      m << frames_[i].velocity_m_per_s, frames_[i].bias.gyro_rad_per_s,
          frames_[i].bias.accel_m_per_s2;
    }
    // Motions older than the free poses are known, unless there are no older ones.
    const std::size_t first = first_free_ > 1 ? first_free_ - 1 : 0;
    for (std::size_t i = first + 1; i < frames_.size(); ++i) {
      if (!frames_[i].since) continue;
      problem_.AddResidualBlock(new InertialCost(*frames_[i].since, inertia.T_camera_imu), nullptr,
                                pose(i - 1), motion(i - 1), pose(i), motion(i), gravity());
      has_inertia_ = true;
    }
    if (!has_inertia_) return;
    for (std::size_t i = first; i < frames_.size(); ++i) {
      if (!problem_.HasParameterBlock(motion(i))) continue;
      ordering_->AddElementToGroup(motion(i), 1);
      if (i < first_free_ && first_free_ > 1) {
        problem_.SetParameterBlockConstant(motion(i));
      } else if (i == first || !frames_[i].since) {
        problem_.AddResidualBlock(new BiasPriorCost(frames_[i].bias), nullptr, motion(i));
      }
    }
    problem_.SetManifold(gravity(), &sphere_);
    ordering_->AddElementToGroup(gravity(), 1);
    if (inertia.gravity_known) problem_.SetParameterBlockConstant(gravity());
  }

  [[nodiscard]] bool solve() {
    ceres::Solver::Options solving;
    solving.linear_solver_type = ceres::DENSE_SCHUR;
    solving.linear_solver_ordering = ordering_;
    solving.max_num_iterations = options_.iterations;
    solving.num_threads = 1;
    solving.logging_type = ceres::SILENT;
    solving.function_tolerance = 1e-4;
    ceres::Solver::Summary summary;
    ceres::Solve(solving, &problem_, &summary);
    return summary.IsSolutionUsable();
  }

  void give(const std::vector<WindowPoint*>& points, WindowInertia* inertia) {
    for (std::size_t i = first_free_; i < frames_.size(); ++i) {
      PoseBlock block{};
      std::copy(pose(i), pose(i) + block.size(), block.begin());
      frames_[i].T_world_camera = pose_of(block);
    }
    for (std::size_t k = 0; k < points.size(); ++k) points[k]->p_world = places_[k];
    if (!has_inertia_) return;
    inertia->gravity_world = Eigen::Map<Eigen::Vector3d>(gravity());
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      const Eigen::Map<Motion> m(motion(i));
      frames_[i].velocity_m_per_s = m.head<3>();
      frames_[i].bias = {m.segment<3>(3), m.tail<3>()};
    }
  }

 private:
  using Motion = Eigen::Matrix<double, 9, 1>;
  static constexpr std::size_t kBlock = 16;
  [[nodiscard]] double* pose(std::size_t i) { return state_.data() + kBlock * i; }
  [[nodiscard]] double* motion(std::size_t i) { return pose(i) + 7; }
  [[nodiscard]] double* gravity() { return pose(frames_.size()); }
  static ceres::Problem::Options borrowed() {
    ceres::Problem::Options options;
    options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    return options;
  }

  const RectifiedRig& rig_;
  double sigma_px_;
  const WindowOptions& options_;
  std::vector<WindowFrame>& frames_;
  std::size_t first_free_ = 1;
  // Poses with their motions, then gravity. All in one piece of memory: Ceres orders parameters by
  // their addresses, and another order rounds otherwise.
  std::vector<double> state_;
  std::vector<Eigen::Vector3d> places_;
  bool has_inertia_ = false;
  PoseManifold pose_manifold_;
  ceres::SphereManifold<3> sphere_;
  ceres::HuberLoss loss_{1.5};
  std::shared_ptr<ceres::ParameterBlockOrdering> ordering_ =
      std::make_shared<ceres::ParameterBlockOrdering>();
  ceres::Problem problem_;
};

}  // namespace

OptionSet describe(WindowOptions& options) {
  OptionSet set;
  set.add("free_keyframes", options.free_keyframes, "whose poses are refined", 2, 100);
  set.add("fixed_keyframes", options.fixed_keyframes, "older ones, that hold the points", 1, 100);
  set.add("iterations", options.iterations, "at most", 1, 100);
  set.add("outlier", options.outlier, "sights farther off, in sigma, are forgotten", 1.0, 100.0);
  return set;
}

bool refine_window(const RectifiedRig& rig, double sigma_px, const WindowOptions& options,
                   std::vector<WindowFrame>& frames, std::vector<WindowPoint*>& points,
                   WindowInertia* inertia, const Context& context) {
  const ScopedTimer timer(context, "odometry/refine");
  if (frames.size() < 2) return false;
  for (WindowPoint* point : points) forget_lost_frames(frames, *point);
  WindowProblem problem(rig, sigma_px, options, frames);
  if (problem.add_sights(points) == 0) return false;
  if (inertia != nullptr) problem.add_inertia(*inertia);
  if (!problem.solve()) return false;
  problem.give(points, inertia);
  const double limit_px = options.outlier * sigma_px * 1.5;
  for (WindowPoint* point : points) forget_outliers(rig, limit_px, frames, *point);
  return true;
}

}  // namespace tread
