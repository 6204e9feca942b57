#include "tread/pipeline/rover_mapper.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "tread/core/shrink.hpp"
#include "tread/stereo/disparity_range.hpp"
#include "tread/stereo/uncertainty.hpp"

namespace tread {
namespace {

// The depth at which a quarter of a pixel is one cell of the map.
double quarter_pixel_range(const RectifiedRig& rig, double cell_m) {
  return std::sqrt(cell_m * rig.baseline_m * rig.fx_px / 0.25);
}

// Farther than this no rig sees a cell of the map, whatever its baseline.
constexpr double kFarthestExtended_m = 1000.0;

// Whatever way the robot leans, what its camera sees up to a depth lies within this.
LevelArea reach(const RectifiedRig& rig, const Isometry3d& T_body_points, double depth_m) {
  double radius_m = T_body_points.translation().norm();
  for (const int u : {0, rig.size.width}) {
    for (const int v : {0, rig.size.height}) {
      radius_m = std::max(radius_m, (T_body_points * rig.point(u, v, depth_m)).norm());
    }
  }
  const Eigen::Vector2d corner = Eigen::Vector2d::Constant(radius_m);
  return {-corner, corner};
}

// That the search fits the images, as far as it is known before the first frame.
Status check_disparities(const SadOptions& sad, bool widened, ImageSize matched) {
  const int least = sad.min_disparity_px + (widened ? 1 : sad.num_disparities);
  if (least <= matched.width) return {};
  return fail(ErrorCode::kBadValue,
              fmt::format("{} disparities from {} on do not fit images matched {} px wide",
                          sad.num_disparities, sad.min_disparity_px, matched.width),
              "stereo.sad.min_disparity_px, stereo.sad.num_disparities",
              "Search fewer, or lower shrink");
}

}  // namespace

OptionSet describe(RoverMapOptions& options) {
  OptionSet set;
  set.add_group("pose", describe(options.pose));
  set.add_group("stereo", describe(options.stereo));
  set.add("shrink", options.shrink, "match images shrunk by this factor", 1, 16);
  set.add_automatic("auto_num_disparities", options.auto_num_disparities,
                    "widen the search to what the first frame needs; off where num_disparities is "
                    "given alone",
                    "stereo.sad.num_disparities");
  set.add_group("depth", describe(options.depth));
  set.add_automatic("extend_range", options.extend_range,
                    "see as far as a quarter of a pixel is one cell of the map; off where "
                    "max_depth_m is given alone",
                    "depth.max_depth_m");
  set.add("weigh_points", options.weigh_points,
          "weigh the points of a cell by how sure their matches are");
  set.add_group("local", describe(options.local));
  set.add_group("global", describe(options.global));
  set.add_group("cost", describe(options.cost));
  set.require({"depth.max_depth_m", "local.resolution_m"},
              "a local map as wide as that must take at most 1 GiB, 28 bytes a cell", [&options] {
                const Eigen::Vector2d far = Eigen::Vector2d::Constant(options.depth.max_depth_m);
                return local_map_fits({-far, far}, options.local.resolution_m);
              });
  set.require(
      {"cost.window_m", "cost.cells_per_side", "local.resolution_m"},
      "the window must be as wide as a cell of the cost map, so that no ground lies between "
      "two, and at most 500 cells of the ground",
      [&options] { return covers_ground(options.cost, options.local.resolution_m); });
  return set;
}

RoverMapper::RoverMapper(const StereoRig& rig, const RoverMapOptions& options)
    : options_(options),
      size_(rig.size),
      gate_(options.pose),
      ground_(options.local.resolution_m),
      cost_(options.cost, options.local.resolution_m, options.global.max_map_mib) {}

Result<RoverMapper> RoverMapper::make(const StereoRig& rig, const RoverMapOptions& options) {
  return with_memory_checked("rig " + rig.name, "Give it more memory, or raise shrink",
                             [&] { return make_mapper(rig, options); });
}

Result<RoverMapper> RoverMapper::make_mapper(const StereoRig& full_rig,
                                             const RoverMapOptions& options) {
  if (Status ok = check_rig(full_rig); !ok) return forward(ok);
  if (Status ok = check_options(options); !ok) return forward(ok);
  RoverMapper mapper(full_rig, options);
  const StereoRig rig = shrunk(full_rig, options.shrink);
  Eigen::Matrix3d R_left_points = Eigen::Matrix3d::Identity();
  if (rig.rectified) {
    auto rectified = rectified_rig(rig);
    if (!rectified) return forward(rectified);
    mapper.rig_ = *rectified;
  } else {
    auto rectification = make_rectification(rig);
    if (!rectification) return forward(rectification);
    mapper.rectification_ = std::move(*rectification);
    mapper.rig_ = mapper.rectification_->rig;
    R_left_points = mapper.rectification_->R_rectified_left.transpose();
  }
  const CameraMount mount = rig.mount.value_or(level_mount(0.0, 0.0, true));
  mapper.T_left_body_ = mount.T_body_left.inverse();
  mapper.T_body_points_ = mount.T_body_left * Isometry3d(R_left_points);

  RoverMapOptions& own = mapper.options_;
  own.stereo.rate = own.stereo.rate || own.weigh_points;
  if (own.extend_range) {
    const double extended = quarter_pixel_range(mapper.rig_, own.local.resolution_m);
    own.depth.max_depth_m =
        std::max(own.depth.max_depth_m, std::min(extended, kFarthestExtended_m));
  }
  const LevelArea area = reach(mapper.rig_, mapper.T_body_points_, own.depth.max_depth_m);
  if (!local_map_fits(area, own.local.resolution_m)) {
    return fail(ErrorCode::kTooLarge,
                fmt::format("the cameras see {:.0f} m far; a local map of that reach would take "
                            "more than 1 GiB",
                            own.depth.max_depth_m),
                "depth.max_depth_m, extend_range",
                "Turn extend_range off, or raise local.resolution_m; check the camera's mount");
  }
  if (Status ok = check_disparities(own.stereo.sad, own.auto_num_disparities, mapper.rig_.size);
      !ok) {
    return forward(ok);
  }
  return mapper;
}

Status RoverMapper::check_frame(const StereoFrame& frame) const {
  const std::string where = "frame " + frame.name;
  if (!frame.T_world_left) {
    return fail(ErrorCode::kNotFound, "it has no pose", where,
                "Give a trajectory that covers it (--poses)");
  }
  if (!is_rigid(*frame.T_world_left)) {
    return fail(ErrorCode::kBadValue, "its pose is not finite or not a rigid motion", where,
                "Check the trajectory");
  }
  for (const auto* image : {&frame.left, &frame.right}) {
    if (image->width == size_.width && image->height == size_.height) continue;
    return fail(ErrorCode::kBadFormat,
                fmt::format("an image is {}x{}, the rig says {}x{}", image->width, image->height,
                            size_.width, size_.height),
                where, "Give images of the calibrated size");
  }
  return {};
}

Status RoverMapper::choose_range(const Context& context) {
  if (range_chosen_ || !options_.auto_num_disparities) return {};
  const auto needed = estimate_num_disparities(left_, right_, options_.stereo, context);
  if (!needed) return forward(needed);
  SadOptions& sad = options_.stereo.sad;
  sad.num_disparities =
      std::min(left_.width - sad.min_disparity_px, std::max(sad.num_disparities, *needed));
  range_chosen_ = true;
  return {};
}

void RoverMapper::rectify(const StereoFrame& frame, const Context& context) {
  Image<std::uint8_t>& left = rectification_ ? small_left_ : left_;
  Image<std::uint8_t>& right = rectification_ ? small_right_ : right_;
  {
    const ScopedTimer timer(context, "stereo/shrink");
    shrink(frame.left, options_.shrink, left);
    shrink(frame.right, options_.shrink, right);
  }
  if (!rectification_) return;
  left_.resize(left.width, left.height);
  right_.resize(right.width, right.height);
  remap(left, rectification_->left, left_, context);
  remap(right, rectification_->right, right_, context);
}

// After this the pose counts as one of the drive, whatever becomes of the images.
Status RoverMapper::check_pose(const StereoFrame& frame, const Isometry3d& T_world_body) {
  const std::string where = "frame " + frame.name;
  const PoseGate::Answer answer = gate_.judge(frame.stamp_ns, T_world_body.translation());
  const std::string jump =
      fmt::format("its pose is {:.4g} m from that of the last frame taken, {:.4g} m are allowed",
                  answer.distance_m, answer.allowed_m);
  if (answer.verdict == PoseGate::Verdict::kRefused) {
    ++refused_poses_;
    return fail(ErrorCode::kBadValue, jump, where,
                "Correct the trajectory, or raise pose.max_step_m if it is right");
  }
  if (answer.verdict == PoseGate::Verdict::kRestart) {
    ground_ = GlobalMap(options_.local.resolution_m);
    cost_.clear();
    began_anew_ = Error{ErrorCode::kBadValue,
                        "the map begins anew here, since the first frames stood elsewhere: " + jump,
                        where, "Correct their poses, or raise pose.max_step_m if they are right"};
  }
  if (!cost_.can_reach(T_world_body.translation().head<2>())) {
    return fail(ErrorCode::kTooLarge,
                fmt::format("it is so far from the map that both would take more than "
                            "global.max_map_mib, {} MiB",
                            options_.global.max_map_mib),
                where, "Check the poses; raise it if they are right");
  }
  return {};
}

Result<RoverFrame> RoverMapper::add(const StereoFrame& frame, const Context& context) {
  const std::string where = "frame " + frame.name;
  auto taken =
      with_memory_checked(where, "Make cells larger or the range shorter, or give it more memory",
                          [&] { return take(frame, context); });
  if (!taken && taken.error().where != where) {
    taken.error().where.insert(0, where + ": ");
  }
  return taken;
}

Result<RoverFrame> RoverMapper::take(const StereoFrame& frame, const Context& context) {
  if (Status ok = check_frame(frame); !ok) return forward(ok);
  const Isometry3d T_world_body = *frame.T_world_left * T_left_body_;
  if (Status ok = check_pose(frame, T_world_body); !ok) return forward(ok);
  rectify(frame, context);
  if (Status ok = choose_range(context); !ok) return forward(ok);

  const auto disparity = matcher_.match(left_, right_, options_.stereo, context);
  if (!disparity) return forward(disparity);
  depth_image(*disparity, rig_, options_.depth, depth_, context);
  depth_cloud(depth_, rig_, options_.stereo.sad.reference, {}, cloud_, context);
  if (options_.weigh_points) {
    depth_sigmas(depth_, matcher_.residual(), rig_, options_.stereo.method, sigma_m_);
  }

  const Isometry3d T_level_points =
      Isometry3d(R_level_body(T_world_body.linear())) * T_body_points_;
  RoverFrame result;
  result.pose = {T_world_body.translation(), yaw_pitch_roll(T_world_body.linear()).yaw_rad};
  const GridGeometry cells =
      local_cells(view_from_above(rig_, T_level_points, options_.depth.max_depth_m),
                  options_.local.resolution_m);
  ground_.heights_below(cells, result.pose, known_heights_, context);
  const Grid<float>& height = local_.build(cloud_.points, T_level_points, cells, options_.local,
                                           {&known_heights_, sigma_m_}, context);
  sobel_squared(height, derivative_, context);
  if (Status ok = ground_.integrate(height, derivative_, result.pose, options_.global, context);
      !ok) {
    return forward(ok);
  }
  const std::vector<Cell> changes = ground_.take_changes();
  cost_.update(ground_, changes, context);
  cost_.reach(result.pose.position.head<2>());

  result.began_anew = std::exchange(began_anew_, std::nullopt);
  result.left = left_;
  result.disparity = *disparity;
  result.depth = depth_;
  result.cloud = &cloud_;
  result.T_level_points = T_level_points;
  result.height = &height;
  result.derivative = &derivative_;
  result.changed_cells = changes.size();
  return result;
}

Result<MapLayers> RoverMapper::layers() const {
  return with_memory_checked("map", "Give it more memory, or make cells larger",
                             [this]() -> Result<MapLayers> {
                               MapLayers map = ground_.layers();
                               cost_.add_layer(map);
                               return map;
                             });
}

}  // namespace tread
