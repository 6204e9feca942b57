#include "tread/slam/loop_closer.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "tread/core/shrink.hpp"

namespace tread {
namespace {

constexpr std::size_t kMiB = 1U << 20U;

double angle_of(const Isometry3d& T) {
  return so3_log(T.linear()).norm();
}

// Covariance to information, no better known than to these deviations.
Matrix6d information_of(const Matrix6d& covariance, double least_m, double least_rad) {
  Matrix6d sum = covariance;
  sum.diagonal().head<3>().array() += least_m * least_m;
  sum.diagonal().tail<3>().array() += least_rad * least_rad;
  const Matrix6d inverse = sum.ldlt().solve(Matrix6d::Identity());
  return 0.5 * (inverse + inverse.transpose());
}

Image<std::uint8_t> bytes_of(const Image<float>& grey) {
  Image<std::uint8_t> bytes(grey.width, grey.height);
  for (int y = 0; y < grey.height; ++y) {
    std::transform(grey.row(y), grey.row(y) + grey.width, bytes.row(y), [](float v) {
      return static_cast<std::uint8_t>(std::clamp(v + 0.5F, 0.0F, 255.0F));
    });
  }
  return bytes;
}

PlaceView view_of(const LoopFrame& in, const PlaceOptions& options, const Context& context) {
  const DepthLevel& fine = in.frame.depth[0];
  return view_place(bytes_of(in.frame.grey[0].intensity), fine.depth, fine.camera, options,
                    context);
}

}  // namespace

void LoopCloser::follow(const Isometry3d& T_world_camera, const Matrix6d& covariance) {
  if (!followed_) T_world_ = T_world_camera;
  followed_ = true;
  const Isometry3d step = T_world_.inverse() * T_world_camera;
  const Matrix6d to_here = se3_adjoint(step.inverse());
  covariance_ = to_here * covariance_ * to_here.transpose();
  if (covariance.allFinite()) covariance_ += covariance;
  way_m_ += step.translation().norm();
  turn_rad_ += angle_of(step);
  T_reference_here_ = T_reference_here_ * step;
  T_world_ = T_world_camera;
}

void LoopCloser::map(std::int64_t stamp_ns) {
  if (reference_ == FramePath::kWorld) {
    path_.add(stamp_ns, FramePath::kWorld, T_world_);
    return;
  }
  path_.add(stamp_ns, reference_, graph_.pose(reference_).inverse() * T_world_);
  ++nodes_.at(reference_).frames;
}

double LoopCloser::shift_of(const Isometry3d& T, double mean_depth_m) const {
  return T.translation().norm() + angle_of(T) * mean_depth_m;
}

bool LoopCloser::is_near(const Isometry3d& T, double mean_depth_m) const {
  return T.translation().norm() < setup_.near_way * mean_depth_m && angle_of(T) < setup_.near_rad;
}

bool LoopCloser::lately(std::int64_t id) const {
  return nodes_.at(id).last_seen > count_ - setup_.loop.not_within;
}

// So lately that the path since then can be relied upon.
std::optional<std::int64_t> LoopCloser::near_and_lately(const Isometry3d& T_world_camera,
                                                        double mean_depth_m) const {
  std::optional<std::int64_t> nearest;
  double least = 0.0;
  for (const auto& [id, node] : nodes_) {
    if (!lately(id)) continue;
    const Isometry3d T = graph_.pose(id).inverse() * T_world_camera;
    const double shift = shift_of(T, mean_depth_m);
    if (!is_near(T, mean_depth_m) || (nearest && shift >= least)) continue;
    nearest = id;
    least = shift;
  }
  return nearest;
}

bool LoopCloser::read_levels(std::int64_t place, const Pinhole& camera,
                             std::array<DepthLevel, 3>& levels, const Context& context) const {
  StoredKeyframe stored;
  if (!store_->get(place, stored)) return false;
  levels[0].resize(camera, stored.depth.width, stored.depth.height);
  levels[0].depth = std::move(stored.depth);
  NormalFinder normals;
  normals.build_pyramid(setup_.noise, levels, context);
  return true;
}

std::optional<LoopCloser::Seen> LoopCloser::compare(const AlignFrame& depth, const PlaceView& view,
                                                    std::int64_t place, const Isometry3d& guess,
                                                    const Context& context) const {
  const PlaceMatch match = places_.verify(place, view, guess, context);
  std::array<DepthLevel, 3> levels;
  if (!match.found || !read_levels(place, view.camera, levels, context)) return std::nullopt;
  const auto pose =
      compare_views(depth, levels, match, setup_.noise, setup_.align, setup_.loop, context);
  if (!pose) return std::nullopt;
  return Seen{place, *pose};
}

std::optional<LoopCloser::Seen> LoopCloser::see_again(const LoopFrame& in, const PlaceView& view,
                                                      const Context& context) const {
  const auto may_be = [this](std::int64_t id) { return !lately(id); };
  const auto most = static_cast<std::size_t>(setup_.loop.candidates);
  for (const auto& candidate : places_.find(view, most, may_be, context)) {
    const Isometry3d guess = graph_.pose(candidate.id).inverse() * in.T_world_camera;
    if (auto seen = compare(in.frame, view, candidate.id, guess, context)) return seen;
  }
  return std::nullopt;
}

std::optional<LoopCloser::Found> LoopCloser::find(const LoopFrame& in,
                                                  const Context& context) const {
  const PlaceView view = view_of(in, setup_.loop.places, context);
  const auto any = [](std::int64_t) { return true; };
  const auto most = static_cast<std::size_t>(setup_.loop.candidates);
  for (const auto& candidate : places_.find(view, most, any, context)) {
    const auto seen = compare(in.frame, view, candidate.id, Isometry3d::Identity(), context);
    if (seen) return Found{seen->place, graph_.pose(seen->place) * seen->pose.T_place_frame};
  }
  return std::nullopt;
}

void LoopCloser::refer_to(std::int64_t id, const Isometry3d& T_id_camera) {
  reference_ = id;
  nodes_.at(id).last_seen = count_;
  T_reference_here_ = T_id_camera;
  covariance_.setZero();
  way_m_ = turn_rad_ = 0.0;
  bridge_ = false;
}

void LoopCloser::go_on_from(std::int64_t place, const Isometry3d& T_world_camera,
                            const Matrix6d& covariance) {
  T_world_ = T_world_camera;
  followed_ = true;
  if (graph_.nodes().empty()) return;
  const std::int64_t id = existing(place);
  refer_to(id, graph_.pose(id).inverse() * T_world_camera);
  if (covariance.allFinite()) covariance_ = covariance;
  bridge_ = true;
}

PoseEdge LoopCloser::odometry_to(std::int64_t id) const {
  PoseEdge edge;
  edge.a = reference_;
  edge.b = id;
  edge.T_a_b = T_reference_here_;
  edge.T_a_b.linear() = Eigen::Quaterniond(edge.T_a_b.linear()).normalized().toRotationMatrix();
  // Errors of frames against one model do not average out over the way: a part of it.
  const double share = setup_.loop.drift;
  const double turn = turn_rad_ + way_m_ / mean_depth_m_;
  edge.information = information_of(covariance_, 0.2 * setup_.voxel_m + share * way_m_,
                                    0.2 * setup_.voxel_m / mean_depth_m_ + share * turn);
  edge.loop = bridge_;
  return edge;
}

PoseEdge LoopCloser::loop_to(std::int64_t id, const Seen& seen, double mean_depth_m) const {
  PoseEdge edge;
  edge.a = seen.place;
  edge.b = id;
  edge.T_a_b = seen.pose.T_place_frame;
  const double least_m = 0.4 * setup_.voxel_m;
  edge.information = information_of(seen.pose.covariance, least_m, least_m / mean_depth_m);
  edge.loop = true;
  return edge;
}

// Every second keyframe of the older half goes, the first one and the one at hand excepted. What
// hung on them hangs on their neighbours from then on.
void LoopCloser::thin_out() {
  std::vector<std::int64_t> gone;
  for (std::size_t i = 1; i < graph_.nodes().size() / 2; i += 2) {
    if (const std::int64_t id = graph_.nodes()[i].id; id != reference_) gone.push_back(id);
  }
  for (const std::int64_t id : gone) {
    const Isometry3d T = graph_.pose(id);
    const auto heir = graph_.remove(id);
    path_.move_anchor(id, heir.value_or(FramePath::kWorld),
                      heir ? graph_.pose(*heir).inverse() * T : T);
    if (heir) nodes_.at(*heir).frames += nodes_.at(id).frames;
    nodes_.erase(id);
    places_.remove(id);
    store_->remove(id);
  }
}

std::optional<std::int64_t> LoopCloser::add_node(const LoopFrame& in, const PlaceView& view) {
  if (store_ == nullptr) {
    store_ = std::make_unique<KeyframeStore>(setup_.noise, setup_.farthest_m,
                                             static_cast<std::size_t>(setup_.loop.memory_mb) * kMiB,
                                             static_cast<std::size_t>(setup_.loop.file_mb) * kMiB);
  }
  if (graph_.nodes().size() >= static_cast<std::size_t>(setup_.loop.most_keyframes)) thin_out();
  const Image<float>& depth = in.frame.depth[0].depth;
  Image<Rgb> half;
  ImageView<const Rgb> rgb = in.rgb;
  if (!rgb.empty() && !same_size(rgb, depth)) {
    shrink(rgb, 2, half);
    rgb = half;
  }
  Image<std::uint8_t> grey;
  if (rgb.empty()) grey = bytes_of(in.frame.grey[0].intensity);
  if (!store_->put(next_id_, depth, rgb, grey)) {
    thin_out();
    if (!store_->put(next_id_, depth, rgb, grey)) return std::nullopt;
  }
  const std::int64_t id = next_id_++;
  places_.add(id, view);
  graph_.add(id, in.T_world_camera);
  nodes_[id] = {};
  if (reference_ != FramePath::kWorld) graph_.add_edge(odometry_to(id));
  refer_to(id, Isometry3d::Identity());
  return id;
}

// Frames follow the surface. As soon as that of the old place is in view again they are drawn to
// it, and what took a whole round to drift apart seems to happen between two keyframes. So the last
// ones are compared with each other, without the surface.
void LoopCloser::measure_again(std::int64_t last, PoseGraph& graph, const Context& context) const {
  constexpr int kEdges = 6;
  for (int i = 0; i < kEdges; ++i) {
    const auto& edges = graph.edges();
    const auto to_last = std::find_if(edges.begin(), edges.end(), [last](const PoseEdge& edge) {
      return edge.b == last && !edge.loop;
    });
    if (to_last == edges.end()) return;
    PoseEdge edge = *to_last;
    last = edge.a;
    const PlaceView* view = places_.view(edge.b);
    AlignFrame depth;
    if (view == nullptr || !read_levels(edge.b, view->camera, depth.depth, context)) continue;
    const auto seen = compare(depth, *view, edge.a, edge.T_a_b, context);
    if (!seen) continue;
    edge.T_a_b = seen->pose.T_place_frame;
    graph.measure_again(edge);
  }
}

// Only if the path need not have drifted by far more than it may.
bool LoopCloser::close(const PoseEdge& loop, std::int64_t last, const Context& context) {
  PoseGraph corrected = graph_;
  measure_again(last, corrected, context);
  if (!corrected.measure_again(loop) && !corrected.add_edge(loop)) return false;
  const GraphReport report = corrected.optimise(setup_.loop.graph, context);
  if (!report.solved) return false;
  for (const PoseEdge& dropped : report.dropped) {
    if (dropped.a == loop.a && dropped.b == loop.b) return false;
  }
  const double most = 6.0 * setup_.loop.most_stretch * setup_.loop.most_stretch;
  if (!(corrected.odometry_error() - graph_.odometry_error() <= most)) return false;
  corrections_.clear();
  for (const PoseGraph::Node& node : graph_.nodes()) {
    corrections_[node.id] = corrected.pose(node.id) * node.T_world.inverse();
  }
  graph_ = std::move(corrected);
  ++loops_;
  return true;
}

// A place that is seen from where it was seen before needs no further keyframe: the path comes back
// to the one that there is.
bool LoopCloser::close_to_place(const LoopFrame& in, const PlaceView& view, const Seen& seen,
                                const Context& context) {
  if (reference_ == FramePath::kWorld || reference_ == seen.place) return false;
  PoseEdge edge = odometry_to(seen.place);
  const auto direct = compare(in.frame, view, reference_, edge.T_a_b, context);
  if (direct) edge.T_a_b = direct->pose.T_place_frame;
  edge.T_a_b = edge.T_a_b * seen.pose.T_place_frame.inverse();
  edge.loop = true;
  if (!close(edge, reference_, context)) return false;
  refer_to(seen.place, seen.pose.T_place_frame);
  T_world_ = graph_.pose(seen.place) * seen.pose.T_place_frame;
  return true;
}

std::optional<Isometry3d> LoopCloser::keyframe(const LoopFrame& in, const Context& context) {
  const ScopedTimer timer(context, "slam/loop");
  ++count_;
  if (const double mean = mean_depth(in.frame.depth[1].depth); mean > 0.0) mean_depth_m_ = mean;
  const PlaceView view = view_of(in, setup_.loop.places, context);
  const auto seen = see_again(in, view, context);
  bool corrects = false, near = false;
  if (seen) {
    nodes_.at(seen->place).last_seen = count_;
    const Isometry3d T_said = graph_.pose(seen->place) * seen->pose.T_place_frame;
    corrects = shift_of(T_said.inverse() * T_world_, mean_depth_m_) >
               setup_.loop.least_correction_voxels * setup_.voxel_m;
    near = is_near(seen->pose.T_place_frame, mean_depth_m_);
  }
  if (corrects && near) {
    return close_to_place(in, view, *seen, context) ? std::optional(T_world_) : std::nullopt;
  }
  if (near) {
    refer_to(seen->place, seen->pose.T_place_frame);
    return std::nullopt;
  }
  const auto beside = near_and_lately(T_world_, mean_depth_m_);
  if (!corrects && beside) {
    if (*beside != reference_) refer_to(*beside, graph_.pose(*beside).inverse() * T_world_);
    nodes_.at(*beside).last_seen = count_;
    return std::nullopt;
  }
  const auto id = add_node(in, view);
  if (!id || !seen || !nodes_.contains(seen->place)) return std::nullopt;
  const PoseEdge loop = loop_to(*id, *seen, mean_depth_m_);
  if (!corrects) {
    graph_.add_edge(loop);
    return std::nullopt;
  }
  if (!close(loop, *id, context)) return std::nullopt;
  T_world_ = graph_.pose(*id);
  return T_world_;
}

std::int64_t LoopCloser::existing(std::int64_t anchor) const {
  const auto after = nodes_.upper_bound(anchor);
  return after == nodes_.begin() ? after->first : std::prev(after)->first;
}

Isometry3d LoopCloser::correction_of(std::int64_t anchor) const {
  if (nodes_.empty()) return Isometry3d::Identity();
  const auto moved = corrections_.find(existing(anchor));
  return moved == corrections_.end() ? Isometry3d::Identity() : moved->second;
}

void LoopCloser::fuse_all(const Pinhole& camera, double ahead_m, const IntegrateOptions& options,
                          VoxelVolume& volume, Integrator& integrator,
                          const Context& context) const {
  const ScopedTimer timer(context, "slam/fuse_all");
  constexpr int kMostFrames = 8, kMostWeight = 64;
  StoredKeyframe stored;
  for (const PoseGraph::Node& node : graph_.nodes()) {
    if (!store_->get(node.id, stored)) continue;
    // One stands for all the frames that were mapped from it on.
    IntegrateOptions heavy = options;
    const int frames = std::clamp(nodes_.at(node.id).frames, 1, kMostFrames);
    heavy.full_weight = std::min(frames * options.full_weight, kMostWeight);
    heavy.carve_every = 1;
    heavy.colour_every = 1;
    volume.centre_on(node.T_world * Eigen::Vector3d(0.0, 0.0, ahead_m));
    const FusionFrame fusion{stored.depth, stored.rgb, stored.grey, camera, node.T_world};
    integrator.integrate(fusion, setup_.noise, heavy, volume, context);
  }
  volume.centre_on(T_world_ * Eigen::Vector3d(0.0, 0.0, ahead_m));
}

Trajectory LoopCloser::trajectory() const {
  return path_.poses([this](std::int64_t anchor) { return graph_.pose(anchor); });
}

std::size_t LoopCloser::bytes() const {
  return places_.bytes() + (store_ ? store_->memory_bytes() : 0) +
         graph_.nodes().size() * sizeof(PoseGraph::Node) + graph_.edges().size() * sizeof(PoseEdge);
}

}  // namespace tread
