#include "tread/pipeline/rover_mapper.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tread/core/shrink.hpp"
#include "tread/stereo/disparity_range.hpp"

namespace tread {
namespace {

// The depth at which a quarter of a pixel is one cell of the map.
double quarter_pixel_range(const RectifiedRig& rig, double cell_m) {
  return std::sqrt(cell_m * rig.baseline_m * rig.fx_px / 0.25);
}

// Whether any ray of the image points backwards, seen from the body.
bool sees_behind(const RectifiedRig& rig, const Eigen::Matrix3d& R_body_points) {
  for (double v : {0.0, rig.size.height - 1.0}) {
    if ((R_body_points * rig.point(rig.cx_px, v, 1.0)).x() < 0.0) return true;
  }
  return false;
}

}  // namespace

OptionSet describe(RoverMapOptions& options) {
  OptionSet set;
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
  set.add_group("local", describe(options.local));
  for (const char* reach : {"local.range_m", "local.behind_m"}) {
    set.withdraw(reach, "the mapper sets this from depth.max_depth_m and the camera's mount",
                 "Set depth.max_depth_m in its place");
  }
  set.add_group("global", describe(options.global));
  set.add_group("cost", describe(options.cost));
  return set;
}

RoverMapper::RoverMapper(const StereoRig& rig, const RoverMapOptions& options)
    : options_(options),
      size_(rig.size),
      ground_(options.local.resolution_m),
      cost_(options.cost, options.local.resolution_m) {}

Result<RoverMapper> RoverMapper::make(const StereoRig& full_rig, const RoverMapOptions& options) {
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
  if (own.extend_range) {
    own.depth.max_depth_m =
        std::max(own.depth.max_depth_m, quarter_pixel_range(mapper.rig_, own.local.resolution_m));
  }
  own.local.range_m = own.depth.max_depth_m;
  own.local.behind_m =
      sees_behind(mapper.rig_, mapper.T_body_points_.linear()) ? own.local.range_m : 0.0;
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
  options_.stereo.sad.num_disparities =
      std::min(left_.width, std::max(options_.stereo.sad.num_disparities, *needed));
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

Result<RoverFrame> RoverMapper::add(const StereoFrame& frame, const Context& context) {
  if (Status ok = check_frame(frame); !ok) return forward(ok);
  rectify(frame, context);
  if (Status ok = choose_range(context); !ok) return forward(ok);

  RoverFrame result;
  const auto disparity = matcher_.match(left_, right_, options_.stereo, context);
  if (!disparity) return forward(disparity);
  depth_image(*disparity, rig_, options_.depth, depth_, context);
  depth_cloud(depth_, rig_, options_.stereo.sad.reference, {}, cloud_, context);

  const Isometry3d T_world_body = *frame.T_world_left * T_left_body_;
  const Isometry3d T_level_points =
      Isometry3d(R_level_body(T_world_body.linear())) * T_body_points_;
  const Grid<float>& height = local_.build(cloud_.points, T_level_points, options_.local, context);
  sobel_squared(height, derivative_, context);

  result.pose = {T_world_body.translation(), yaw_pitch_roll(T_world_body.linear()).yaw_rad};
  if (Status ok = ground_.integrate(height, derivative_, result.pose, options_.global, context);
      !ok) {
    return forward(ok);
  }
  const std::vector<Cell> changes = ground_.take_changes();
  cost_.update(ground_, changes, context);
  cost_.reach(result.pose.position.head<2>());

  result.left = left_;
  result.disparity = *disparity;
  result.depth = depth_;
  result.cloud = &cloud_;
  result.height = &height;
  result.derivative = &derivative_;
  result.changed_cells = changes.size();
  return result;
}

MapLayers RoverMapper::layers() const {
  MapLayers map = ground_.layers();
  cost_.add_layer(map);
  return map;
}

}  // namespace tread
