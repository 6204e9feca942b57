// Poses and what was measured between pairs of them, brought into agreement (Lu and Milios 1997;
// Grisetti and others 2010), solved by Ceres:
//   sum over odometry |r|^2 + sum over loops rho(|r|^2),  r = L^T log(T_a_b^-1 T_a^-1 T_b)
// with the information L L^T of the edge and Cauchy's rho. Some 0.1 ms a pose.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "tread/core/options.hpp"
#include "tread/core/timer.hpp"
#include "tread/geometry/pose.hpp"

namespace tread {

struct PoseGraphOptions {
  double loop_scale = 3.0;     // sigma: loops farther off weigh less
  double most_residual = 4.0;  // sigma: loops that are farther off afterwards are dropped
  int iterations = 50;         // at most
  [[nodiscard]] bool operator==(const PoseGraphOptions&) const = default;
};
[[nodiscard]] OptionSet describe(PoseGraphOptions& options);

struct PoseEdge {
  std::int64_t a = 0, b = 0;  // ids of poses
  Isometry3d T_a_b = Isometry3d::Identity();
  Matrix6d information = Matrix6d::Identity();  // of a twist d in axes of b: T_a_b exp(d)
  bool loop = false;                            // may be wrong
};

// The residual of an edge, not whitened, and how it changes with twists of both poses in their own
// axes, T exp(d): axes of b.
struct EdgeResidual {
  Vector6d r;
  Matrix6d J_a, J_b;
};
[[nodiscard]] EdgeResidual edge_residual(const Isometry3d& T_a_b, const Isometry3d& T_world_a,
                                         const Isometry3d& T_world_b);

struct GraphReport {
  bool solved = false;            // else nothing has changed
  std::vector<PoseEdge> dropped;  // loops that the others and odometry contradict
};

class PoseGraph {
 public:
  struct Node {
    std::int64_t id = 0;
    Isometry3d T_world = Isometry3d::Identity();
  };

  // Ids must increase.
  void add(std::int64_t id, const Isometry3d& T_world);
  // False, and nothing is added, if an end is not there, both are the same, or the information is
  // not symmetric and positive. Of two edges of the same ends the better known stays.
  bool add_edge(const PoseEdge& edge);
  // Changes what an edge of the same ends has measured, not whether it is a loop; false if there is
  // none, or it is not as add_edge() asks.
  bool measure_again(const PoseEdge& edge);
  // Takes a pose out. What was measured to it is from then on between its neighbours: all its edges
  // are joined to the one that hangs together with it best, whose id is returned. Empty if it had
  // none, or is not there.
  std::optional<std::int64_t> remove(std::int64_t id);

  // Moves all poses but the first one of each part that hangs together. The same poses and edges
  // give the same result to the bit.
  GraphReport optimise(const PoseGraphOptions& options, const Context& context = {});

  // Sum of |r|^2 over odometry: how far it has given way.
  [[nodiscard]] double odometry_error() const;

  [[nodiscard]] bool contains(std::int64_t id) const { return index_.contains(id); }
  [[nodiscard]] const Isometry3d& pose(std::int64_t id) const {
    return nodes_[index_.at(id)].T_world;
  }
  [[nodiscard]] const std::vector<Node>& nodes() const { return nodes_; }
  [[nodiscard]] const std::vector<PoseEdge>& edges() const { return edges_; }

 private:
  [[nodiscard]] std::vector<std::size_t> first_of_each_part(
      const std::vector<PoseEdge>& edges) const;
  [[nodiscard]] std::optional<std::vector<Isometry3d>> solve(
      const PoseGraphOptions& options, const std::vector<PoseEdge>& edges) const;
  [[nodiscard]] bool is_sound(const PoseEdge& edge) const;

  std::vector<Node> nodes_;
  std::vector<PoseEdge> edges_;
  std::map<std::int64_t, std::size_t> index_;
};

}  // namespace tread
