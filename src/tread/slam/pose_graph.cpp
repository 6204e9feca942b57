#include "tread/slam/pose_graph.hpp"

#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>

#include "tread/slam/edge_cost.hpp"

namespace tread {
namespace {

Matrix6d inverse_of(const Matrix6d& m) {
  const Matrix6d inverse = m.ldlt().solve(Matrix6d::Identity());
  return 0.5 * (inverse + inverse.transpose());
}

// The same measurement from b to a.
PoseEdge reversed(const PoseEdge& edge) {
  PoseEdge out = edge;
  std::swap(out.a, out.b);
  out.T_a_b = edge.T_a_b.inverse();
  // T_a_b exp(d) inverted is T_b_a exp(-Ad d) with Ad of T_a_b.
  const Matrix6d to_b = se3_adjoint(out.T_a_b);
  out.information = to_b.transpose() * edge.information * to_b;
  out.information = (0.5 * (out.information + out.information.transpose())).eval();
  return out;
}

// From first.a by way of first.b = second.a to second.b.
PoseEdge joined(const PoseEdge& first, const PoseEdge& second) {
  PoseEdge out;
  out.a = first.a;
  out.b = second.b;
  out.T_a_b = first.T_a_b * second.T_a_b;
  out.T_a_b.linear() = Eigen::Quaterniond(out.T_a_b.linear()).normalized().toRotationMatrix();
  const Matrix6d to_b = se3_adjoint(second.T_a_b.inverse());
  out.information = inverse_of(to_b * inverse_of(first.information) * to_b.transpose() +
                               inverse_of(second.information));
  out.loop = first.loop || second.loop;
  return out;
}

// How well the translation of an edge is known: the trace of its covariance, m^2.
double spread_of(const PoseEdge& edge) {
  return inverse_of(edge.information).topLeftCorner<3, 3>().trace();
}

double squared_error(const PoseEdge& edge, const Isometry3d& T_world_a,
                     const Isometry3d& T_world_b) {
  const Vector6d r = edge_residual(edge.T_a_b, T_world_a, T_world_b).r;
  return r.dot(edge.information * r);
}

}  // namespace

OptionSet describe(PoseGraphOptions& options) {
  OptionSet set;
  set.add("loop_scale", options.loop_scale, "loops farther off, in sigma, weigh less", 0.1, 1e3);
  set.add("most_residual", options.most_residual,
          "loops that are farther off afterwards, in sigma, are dropped", 0.1, 1e6);
  set.add("iterations", options.iterations, "at most", 1, 1000);
  return set;
}

EdgeResidual edge_residual(const Isometry3d& T_a_b, const Isometry3d& T_world_a,
                           const Isometry3d& T_world_b) {
  const Isometry3d T_b_a = T_world_b.inverse() * T_world_a;
  EdgeResidual out;
  out.r = se3_log(T_a_b.inverse() * T_b_a.inverse());
  // log(exp(r) exp(d)) = r + J_r^-1 d, and J_r(r) = J_l(-r).
  out.J_b = se3_left_jacobian(-out.r).inverse();
  out.J_a = -out.J_b * se3_adjoint(T_b_a);
  return out;
}

void PoseGraph::add(std::int64_t id, const Isometry3d& T_world) {
  assert(nodes_.empty() || id > nodes_.back().id);
  index_[id] = nodes_.size();
  nodes_.push_back({id, T_world});
}

bool PoseGraph::is_sound(const PoseEdge& edge) const {
  const Matrix6d& I = edge.information;
  return edge.a != edge.b && contains(edge.a) && contains(edge.b) && is_rigid(edge.T_a_b) &&
         I.allFinite() && (I - I.transpose()).norm() <= 1e-6 * I.norm() &&
         I.llt().info() == Eigen::Success;
}

bool PoseGraph::measure_again(const PoseEdge& edge) {
  if (!is_sound(edge)) return false;
  for (PoseEdge& known : edges_) {
    const bool turned = known.a == edge.b && known.b == edge.a;
    if (!turned && (known.a != edge.a || known.b != edge.b)) continue;
    const bool loop = known.loop;
    known = turned ? reversed(edge) : edge;
    known.loop = loop;
    return true;
  }
  return false;
}

bool PoseGraph::add_edge(const PoseEdge& edge) {
  if (!is_sound(edge)) return false;
  for (PoseEdge& known : edges_) {
    const bool same = known.a == edge.a && known.b == edge.b;
    if (!same && (known.a != edge.b || known.b != edge.a)) continue;
    // A loop must not take the place of what holds the path together.
    if (known.loop != edge.loop ? known.loop : spread_of(edge) < spread_of(known)) known = edge;
    return true;
  }
  edges_.push_back(edge);
  return true;
}

std::optional<std::int64_t> PoseGraph::remove(std::int64_t id) {
  const auto at = index_.find(id);
  if (at == index_.end()) return std::nullopt;
  std::vector<PoseEdge> from;  // all edges of this pose, seen from it
  for (const PoseEdge& edge : edges_) {
    if (edge.a == id) from.push_back(edge);
    if (edge.b == id) from.push_back(reversed(edge));
  }
  std::erase_if(edges_, [&](const PoseEdge& edge) { return edge.a == id || edge.b == id; });
  nodes_.erase(nodes_.begin() + static_cast<std::ptrdiff_t>(at->second));
  index_.erase(at);
  for (auto& [key, place] : index_) place -= key > id ? 1 : 0;
  if (from.empty()) return std::nullopt;
  const auto nearest =
      std::min_element(from.begin(), from.end(), [](const PoseEdge& x, const PoseEdge& y) {
        return x.loop != y.loop ? y.loop : spread_of(x) < spread_of(y);
      });
  const PoseEdge heir = reversed(*nearest);  // from the heir to the pose
  for (const PoseEdge& edge : from) {
    if (edge.b != heir.a) add_edge(joined(heir, edge));
  }
  return heir.a;
}

std::vector<std::size_t> PoseGraph::first_of_each_part(const std::vector<PoseEdge>& edges) const {
  std::vector<std::size_t> root(nodes_.size());
  std::iota(root.begin(), root.end(), std::size_t{0});
  const auto find = [&](std::size_t i) {
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  for (const PoseEdge& edge : edges) {
    const std::size_t a = find(index_.at(edge.a)), b = find(index_.at(edge.b));
    root[std::max(a, b)] = std::min(a, b);
  }
  std::vector<std::size_t> first;
  for (std::size_t i = 0; i < root.size(); ++i) {
    if (root[i] == i) first.push_back(i);
  }
  return first;
}

std::optional<std::vector<Isometry3d>> PoseGraph::solve(const PoseGraphOptions& options,
                                                        const std::vector<PoseEdge>& edges) const {
  std::vector<PoseBlock> blocks;
  for (const Node& node : nodes_) blocks.push_back(block_of(node.T_world));
  ceres::Problem::Options borrowed;
  borrowed.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  borrowed.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  PoseManifold manifold;
  ceres::CauchyLoss loss(options.loop_scale * std::sqrt(6.0));
  ceres::Problem problem(borrowed);
  for (PoseBlock& block : blocks) problem.AddParameterBlock(block.data(), 7, &manifold);
  for (const std::size_t i : first_of_each_part(edges)) {
    problem.SetParameterBlockConstant(blocks[i].data());
  }
  for (const PoseEdge& edge : edges) {
    problem.AddResidualBlock(new EdgeCost(edge), edge.loop ? &loss : nullptr,
                             blocks[index_.at(edge.a)].data(), blocks[index_.at(edge.b)].data());
  }
  ceres::Solver::Options solving;
  solving.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  // Of the libraries that Ceres knows the one whose sums no thread count changes.
  solving.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;
  solving.max_num_iterations = options.iterations;
  solving.num_threads = 1;
  solving.logging_type = ceres::SILENT;
  solving.function_tolerance = 1e-8;
  ceres::Solver::Summary summary;
  ceres::Solve(solving, &problem, &summary);
  if (!summary.IsSolutionUsable()) return std::nullopt;
  std::vector<Isometry3d> poses;
  for (const PoseBlock& block : blocks) poses.push_back(pose_of(block));
  return poses;
}

double PoseGraph::odometry_error() const {
  double sum = 0.0;
  for (const PoseEdge& edge : edges_) {
    if (!edge.loop) sum += squared_error(edge, pose(edge.a), pose(edge.b));
  }
  return sum;
}

GraphReport PoseGraph::optimise(const PoseGraphOptions& options, const Context& context) {
  const ScopedTimer timer(context, "slam/pose_graph");
  GraphReport report;
  if (edges_.empty()) return report;
  auto poses = solve(options, edges_);
  if (!poses) return report;
  // Once more from the start without what the rest contradicts: it has pulled until now.
  const double limit = 6.0 * options.most_residual * options.most_residual;
  std::vector<PoseEdge> kept;
  for (const PoseEdge& edge : edges_) {
    const bool wrong = edge.loop && !(squared_error(edge, (*poses)[index_.at(edge.a)],
                                                    (*poses)[index_.at(edge.b)]) <= limit);
    (wrong ? report.dropped : kept).push_back(edge);
  }
  if (!report.dropped.empty()) {
    poses = solve(options, kept);
    if (!poses) return {};
    edges_ = std::move(kept);
  }
  for (std::size_t i = 0; i < nodes_.size(); ++i) nodes_[i].T_world = (*poses)[i];
  report.solved = true;
  return report;
}

}  // namespace tread
