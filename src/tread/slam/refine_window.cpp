#include "tread/slam/refine_window.hpp"

#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <algorithm>
#include <memory>

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
    Eigen::Vector3d r = stereo_projection(rig, q) - sighting.sight.vector();
    if (!sighting.sight.has_right()) r.z() = 0.0;
    return !(r.norm() < limit_px);
  });
}

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
                   const Context& context) {
  const ScopedTimer timer(context, "odometry/refine");
  if (frames.size() < 2) return false;
  for (WindowPoint* point : points) forget_lost_frames(frames, *point);

  std::vector<PoseBlock> poses;
  for (const WindowFrame& frame : frames) poses.push_back(block_of(frame.T_world_camera));
  std::vector<Eigen::Vector3d> places;
  for (const WindowPoint* point : points) places.push_back(point->p_world);

  ceres::Problem::Options borrowed;
  borrowed.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  borrowed.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  PoseManifold manifold;
  ceres::HuberLoss loss(1.5);
  ceres::Problem problem(borrowed);
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  // The oldest is never free: it says where the world is.
  const std::size_t n = frames.size();
  const std::size_t first_free =
      std::max<std::size_t>(1, n - std::min(n, static_cast<std::size_t>(options.free_keyframes)));
  for (std::size_t i = 0; i < n; ++i) {
    problem.AddParameterBlock(poses[i].data(), 7, &manifold);
    ordering->AddElementToGroup(poses[i].data(), 1);
    if (i < first_free) problem.SetParameterBlockConstant(poses[i].data());
  }
  const std::int64_t first_free_id = frames[first_free].id;
  int rows = 0;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const WindowPoint& point = *points[k];
    if (point.seen.size() < 2 || point.seen.back().frame < first_free_id) continue;
    for (const WindowPoint::Sighting& sighting : point.seen) {
      const auto i = static_cast<std::size_t>(frame_of(frames, sighting.frame) - frames.data());
      problem.AddResidualBlock(new SightCost(rig, sighting.sight, sigma_px), &loss, poses[i].data(),
                               places[k].data());
      ++rows;
    }
    ordering->AddElementToGroup(places[k].data(), 0);
  }
  if (rows == 0) return false;
  ceres::Solver::Options solving;
  solving.linear_solver_type = ceres::DENSE_SCHUR;
  solving.linear_solver_ordering = ordering;
  solving.max_num_iterations = options.iterations;
  solving.num_threads = 1;
  solving.logging_type = ceres::SILENT;
  solving.function_tolerance = 1e-4;
  ceres::Solver::Summary summary;
  ceres::Solve(solving, &problem, &summary);
  if (!summary.IsSolutionUsable()) return false;

  for (std::size_t i = first_free; i < n; ++i) frames[i].T_world_camera = pose_of(poses[i]);
  const double limit_px = options.outlier * sigma_px * 1.5;
  for (std::size_t k = 0; k < points.size(); ++k) {
    points[k]->p_world = places[k];
    forget_outliers(rig, limit_px, frames, *points[k]);
  }
  return true;
}

}  // namespace tread
