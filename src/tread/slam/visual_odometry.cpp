#include "tread/slam/visual_odometry.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tread/slam/corner_track.hpp"
#include "tread/slam/inertial_track.hpp"

namespace tread {
namespace {

// After a longer gap nothing is known of the speed.
constexpr double kLongestStep_s = 0.5;
// So long it looks for what it saw before it starts anew.
constexpr double kPatience_s = 1.0;

constexpr int kLeastSide_px = 64;

Status check_start(const RectifiedRig& rig, const OdometryOptions& options,
                   const Isometry3d& T_world_first, const std::optional<Imu>& imu) {
  const auto wrong = [](const char* what, const char* field, const char* remedy) {
    return fail(ErrorCode::kBadValue, what, field, remedy);
  };
  const auto above_zero = [](double value) { return value > 0.0 && std::isfinite(value); };
  if (rig.size.width < kLeastSide_px || rig.size.height < kLeastSide_px) {
    return wrong("images of less than 64 pixels show too little", "rig.size",
                 "Give larger images, and their size");
  }
  if (!above_zero(rig.fx_px) || !above_zero(rig.fy_px) || !above_zero(rig.baseline_m) ||
      !std::isfinite(rig.cx_px + rig.cy_px + rig.cx_offset_px)) {
    return wrong("focal lengths and baseline are not all above zero", "rig",
                 "Give a rectified rig: see rectified_rig() and make_rectification()");
  }
  if (Status good = check_options(options); !good) return good;
  if (!is_rigid(T_world_first)) {
    return wrong("the pose of the first frame is not a rigid motion", "T_world_first",
                 "Give an orthonormal right-handed rotation and finite metres");
  }
  return imu ? check_imu(*imu) : Status{};
}

double median(std::vector<double>& values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

OptionSet describe(OdometryOptions& options) {
  OptionSet set;
  set.add_group("corners", describe(options.corners));
  set.add_group("fit", describe(options.fit));
  set.add_group("window", describe(options.window));
  set.add("nearest_m", options.nearest_m, "points nearer are not looked for, m", 0.01, 100.0);
  set.add("least_disparity_px", options.least_disparity_px,
          "nor those farther than where it is that, px", 0.1, 100.0);
  set.add("key_share", options.key_share,
          "a new keyframe if a smaller part of the last one's points is left", 0.0, 1.0);
  set.add("key_flow", options.key_flow, "or if they have moved so far, part of the image's width",
          0.0, 1.0);
  set.add("key_interval_s", options.key_interval_s, "or after so long, with an IMU, s", 0.05, 10.0);
  set.add("hold_s", options.hold_s, "so long the IMU alone is believed, s", 0.0, 60.0);
  return set;
}

const char* name_of(OdometryStatus status) {
  switch (status) {
    case OdometryStatus::kFirst:
      return "first";
    case OdometryStatus::kTracked:
      return "tracked";
    case OdometryStatus::kHeld:
      return "held";
    case OdometryStatus::kLost:
      return "lost";
  }
  return "";
}

struct VisualOdometry::Impl {
  Impl(const RectifiedRig& with, const OdometryOptions& chosen, const Isometry3d& T_world_first,
       const std::optional<Imu>& imu)
      : made(check_start(with, chosen, T_world_first, imu)),
        rig(with),
        options(chosen),
        tracker(chosen.corners),
        T_world(T_world_first) {
    if (imu) inertia.emplace(*imu);
  }

  // Where the camera should be by now, and how well that is known.
  struct Prediction {
    Isometry3d T_world_camera = Isometry3d::Identity();
    Matrix6d information = Matrix6d::Zero();
    bool holds = false;  // good enough to go on without seeing anything
  };

  // Tracks found again, by their index.
  struct Found {
    std::vector<std::size_t> index;
    std::vector<StereoSight> sights;
  };

  [[nodiscard]] Status check(const OdometryFrame& in) const;
  [[nodiscard]] Prediction predict(const OdometryFrame& in) const;
  [[nodiscard]] Found follow(const Isometry3d& T_predicted, const Context& context);
  [[nodiscard]] MotionFit fit(const Prediction& predicted, const Found& found,
                              const Context& context) const;
  void keep(const Found& found, const MotionFit& fit);
  [[nodiscard]] bool needs_keyframe(std::int64_t now_ns) const;
  void add_keyframe(const StereoView& view, const Context& context);
  void add_inertia();
  void start_anew(const StereoView& view, const Context& context);
  void find_points(const StereoView& view, const Context& context);
  void leave(CornerTrack& track) {
    if (track.point.seen.size() > 1) left_behind.push_back(std::move(track.point));
  }

  Status made;  // whether it was made with something sound
  RectifiedRig rig;
  OdometryOptions options;
  CornerTracker tracker;
  bool started = false;
  std::int64_t stamp_ns = 0;
  std::int64_t placed_ns = 0;  // when the pose was last fitted
  Isometry3d T_world;
  Vector6d velocity = Vector6d::Zero();  // right twist, a second
  std::vector<CornerTrack> tracks;
  // Points no longer followed, as long as keyframes of the window saw them: without them the older
  // keyframes would hang on the few points that are still in view.
  std::vector<WindowPoint> left_behind;
  std::vector<WindowFrame> keyframes;
  std::optional<InertialTrack> inertia;
  std::int64_t next_key = 0;
  std::int64_t key_ns = 0;  // when the last one was made
  std::size_t at_key = 0;   // tracks that the last keyframe had
  std::uint64_t frames = 0;
};

Status VisualOdometry::Impl::check(const OdometryFrame& in) const {
  if (!made) return made;
  for (const auto& image : {in.left, in.right}) {
    if (image.width == rig.size.width && image.height == rig.size.height) continue;
    return fail(ErrorCode::kBadArgument,
                fmt::format("the image is {} x {}, the rig's are {} x {}", image.width,
                            image.height, rig.size.width, rig.size.height),
                "left, right", "Give rectified images of the rig's size");
  }
  if (in.motion) {
    if (Status sound = check_motion(*in.motion); !sound) return sound;
  }
  if (started && in.stamp_ns <= stamp_ns) {
    return fail(
        ErrorCode::kBadValue,
        fmt::format("the time {} ns is not after the last one, {} ns", in.stamp_ns, stamp_ns),
        "stamp_ns", "Give frames in order of time, each once");
  }
  return {};
}

VisualOdometry::Impl::Prediction VisualOdometry::Impl::predict(const OdometryFrame& in) const {
  Prediction prediction;
  if (in.motion) {
    prediction.T_world_camera = T_world * in.motion->T_before_now;
    prediction.information = in.motion->covariance.inverse();
    prediction.holds = true;
    return prediction;
  }
  const double dt = static_cast<double>(in.stamp_ns - stamp_ns) * 1e-9;
  prediction.T_world_camera =
      dt > kLongestStep_s ? T_world : T_world * se3_exp(Vector6d(velocity * dt));
  if (!inertia || keyframes.empty()) return prediction;
  const auto by_imu = inertia->predict(keyframes.back(), T_world, prediction.T_world_camera);
  if (!by_imu) return prediction;
  prediction.T_world_camera = by_imu->T_world_camera;
  prediction.information = by_imu->information;
  prediction.holds =
      by_imu->holds && static_cast<double>(in.stamp_ns - placed_ns) * 1e-9 < options.hold_s;
  return prediction;
}

// Finds the points again, in both images.
VisualOdometry::Impl::Found VisualOdometry::Impl::follow(const Isometry3d& T_predicted,
                                                         const Context& context) {
  std::vector<Eigen::Vector2d> from, to;
  std::vector<double> disparities;
  const Isometry3d inverse = T_predicted.inverse();
  for (const CornerTrack& track : tracks) {
    const Eigen::Vector3d q = inverse * track.point.p_world;
    const bool ahead = q.z() > options.nearest_m;
    from.push_back(track.at_key);
    to.push_back(ahead ? Eigen::Vector2d(stereo_projection(rig, q).head<2>())
                       : Eigen::Vector2d(track.sight.u, track.sight.v));
    disparities.push_back(rig.disparity_px(std::max(q.z(), options.nearest_m)));
  }
  std::vector<std::uint8_t> is_found;
  tracker.follow(from, to, is_found, context);
  Found found;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    if (is_found[i] == 0) continue;
    found.index.push_back(i);
    found.sights.push_back({to[i].x(), to[i].y(), to[i].x() - disparities[i]});
  }
  tracker.find_right(found.sights, -rig.cx_offset_px, rig.disparity_px(options.nearest_m), context);
  return found;
}

MotionFit VisualOdometry::Impl::fit(const Prediction& predicted, const Found& found,
                                    const Context& context) const {
  const ScopedTimer timer(context, "odometry/fit");
  std::vector<SeenPoint> points;
  for (std::size_t k = 0; k < found.index.size(); ++k) {
    points.push_back({tracks[found.index[k]].point.p_world, found.sights[k]});
  }
  return fit_motion(rig, points, predicted.T_world_camera, predicted.information, options.fit,
                    frames);
}

// Goes on with the tracks that agree with the pose.
void VisualOdometry::Impl::keep(const Found& found, const MotionFit& fit) {
  std::vector<CornerTrack> kept;
  std::vector<std::uint8_t> is_kept(tracks.size(), 0);
  for (std::size_t k = 0; k < found.index.size(); ++k) {
    if (fit.is_inlier[k] == 0) continue;
    is_kept[found.index[k]] = 1;
    kept.push_back(std::move(tracks[found.index[k]]));
    kept.back().sight = found.sights[k];
  }
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    if (is_kept[i] == 0) leave(tracks[i]);
  }
  tracks = std::move(kept);
  T_world = fit.T_world_camera;
}

bool VisualOdometry::Impl::needs_keyframe(std::int64_t now_ns) const {
  if (inertia && static_cast<double>(now_ns - key_ns) * 1e-9 >= options.key_interval_s) return true;
  if (static_cast<double>(tracks.size()) < options.key_share * static_cast<double>(at_key)) {
    return true;
  }
  std::vector<double> flow;
  for (const CornerTrack& track : tracks) {
    flow.push_back((Eigen::Vector2d(track.sight.u, track.sight.v) - track.at_key).norm());
  }
  return median(flow) > options.key_flow * rig.size.width;
}

// New points where there are few, placed by what both images show.
void VisualOdometry::Impl::find_points(const StereoView& view, const Context& context) {
  std::vector<Eigen::Vector2d> taken;
  for (const CornerTrack& track : tracks) taken.emplace_back(track.sight.u, track.sight.v);
  const std::vector<Eigen::Vector2d> corners = tracker.detect(taken, context);
  std::vector<StereoSight> sights;
  for (const Eigen::Vector2d& p : corners) sights.push_back({p.x(), p.y()});
  const double least = options.least_disparity_px - rig.cx_offset_px;
  tracker.find_right(sights, least, rig.disparity_px(options.nearest_m), context);
  const std::int64_t key = keyframes.back().id;
  for (const StereoSight& sight : sights) {
    if (!sight.has_right()) continue;
    auto track = make_corner_track(view, sight);
    if (!track || track->sight.u - track->sight.u_right < least) continue;
    track->point.p_world = T_world * point_of(rig, track->sight);
    track->point.seen.push_back({key, track->sight});
    tracks.push_back(std::move(*track));
  }
}

void VisualOdometry::Impl::add_keyframe(const StereoView& view, const Context& context) {
  {
    const ScopedTimer timer(context, "odometry/settle");
    for (CornerTrack& track : tracks) settle(view, track);
  }
  const WindowOptions& window = options.window;
  const auto most = static_cast<std::size_t>(window.free_keyframes + window.fixed_keyframes);
  keyframes.push_back({next_key++, T_world});
  if (inertia) add_inertia();
  if (keyframes.size() > most) keyframes.erase(keyframes.begin());
  const std::int64_t key = keyframes.back().id;
  std::vector<WindowPoint*> points;
  for (CornerTrack& track : tracks) {
    track.point.seen.push_back({key, track.sight});
    points.push_back(&track.point);
  }
  for (WindowPoint& point : left_behind) points.push_back(&point);
  if (refine_window(rig, options.fit.sigma_px, window, keyframes, points,
                    inertia ? inertia->window() : nullptr, context)) {
    T_world = keyframes.back().T_world_camera;
    // Points whose last sight did not fit are not followed on.
    std::erase_if(tracks, [&](CornerTrack& track) {
      if (!track.point.seen.empty() && track.point.seen.back().frame == key) return false;
      leave(track);
      return true;
    });
  }
  std::erase_if(left_behind, [](const WindowPoint& point) { return point.seen.size() < 2; });
  if (inertia) {
    inertia->start(keyframes);
    inertia->at_keyframe(keyframes.back());
  }
  find_points(view, context);
  for (CornerTrack& track : tracks) track.at_key = {track.sight.u, track.sight.v};
  at_key = tracks.size();
  tracker.keep();
}

// What the IMU knows of the newest keyframe.
void VisualOdometry::Impl::add_inertia() {
  if (keyframes.size() < 2) return;
  const WindowFrame& before = keyframes[keyframes.size() - 2];
  WindowFrame& key = keyframes.back();
  key.bias = before.bias;
  key.velocity_m_per_s = before.velocity_m_per_s;
  if (const ImuPreintegration* since = inertia->since_key()) key.since = *since;
  if (const auto now = inertia->predict(before, before.T_world_camera, T_world)) {
    key.velocity_m_per_s = now->velocity_m_per_s;
  }
}

void VisualOdometry::Impl::start_anew(const StereoView& view, const Context& context) {
  tracks.clear();
  left_behind.clear();
  // The velocity goes on, as the IMU has it.
  WindowFrame next;
  if (inertia && !keyframes.empty()) {
    keyframes.push_back({next_key, T_world});
    add_inertia();
    next = keyframes.back();
  }
  keyframes.clear();
  add_keyframe(view, context);
  keyframes.back().velocity_m_per_s = next.velocity_m_per_s;
  keyframes.back().bias = next.bias;
  if (inertia) inertia->at_keyframe(keyframes.back());
}

VisualOdometry::VisualOdometry(const RectifiedRig& rig, const OdometryOptions& options,
                               const Isometry3d& T_world_first, const std::optional<Imu>& imu)
    : impl_(std::make_unique<Impl>(rig, options, T_world_first, imu)) {}
VisualOdometry::~VisualOdometry() = default;
VisualOdometry::VisualOdometry(VisualOdometry&&) noexcept = default;
VisualOdometry& VisualOdometry::operator=(VisualOdometry&&) noexcept = default;

Result<OdometryState> VisualOdometry::track(const OdometryFrame& in, const Context& context) {
  Impl& odometry = *impl_;
  if (Status good = odometry.check(in); !good) return tl::unexpected(good.error());
  const ScopedTimer timer(context, "odometry");
  const StereoView view{in.left, in.right};
  odometry.tracker.see(in.left, in.right, context);
  ++odometry.frames;
  OdometryState state;
  state.stamp_ns = in.stamp_ns;
  const auto has_points = [&] {
    return static_cast<int>(odometry.tracks.size()) >= odometry.options.fit.least_inliers;
  };
  if (!odometry.started) {
    odometry.start_anew(view, context);
    odometry.started = state.keyframe = has_points();
    odometry.key_ns = in.stamp_ns;
    if (odometry.started) state.status = OdometryStatus::kFirst;
    state.T_world_camera = odometry.T_world;
    state.covariance.setZero();
    odometry.stamp_ns = odometry.placed_ns = in.stamp_ns;
    return state;
  }
  const Isometry3d T_before = odometry.T_world;
  if (odometry.inertia) odometry.inertia->advance(in.imu, odometry.stamp_ns, in.stamp_ns);
  const Impl::Prediction predicted = odometry.predict(in);
  const Impl::Found found = odometry.follow(predicted.T_world_camera, context);
  const MotionFit fit = odometry.fit(predicted, found, context);
  state.followed = static_cast<int>(found.index.size());
  state.inliers = fit.inliers;
  state.rms_px = fit.rms_px;
  if (fit.found) {
    state.status = OdometryStatus::kTracked;
    state.covariance = fit.covariance;
    odometry.keep(found, fit);
    odometry.placed_ns = in.stamp_ns;
    state.keyframe = odometry.needs_keyframe(in.stamp_ns);
    if (state.keyframe) odometry.add_keyframe(view, context);
  } else {
    state.status = predicted.holds ? OdometryStatus::kHeld : OdometryStatus::kLost;
    if (predicted.holds) state.covariance = predicted.information.inverse();
    odometry.T_world = predicted.T_world_camera;
    if (static_cast<double>(in.stamp_ns - odometry.placed_ns) * 1e-9 > kPatience_s) {
      odometry.start_anew(view, context);
      state.keyframe = state.restarted = has_points();
      if (state.restarted) odometry.placed_ns = in.stamp_ns;
    }
  }
  if (state.keyframe) odometry.key_ns = in.stamp_ns;
  state.inertial = odometry.inertia && odometry.inertia->started();
  state.T_world_camera = odometry.T_world;
  state.T_before_now = T_before.inverse() * odometry.T_world;
  const double dt = static_cast<double>(in.stamp_ns - odometry.stamp_ns) * 1e-9;
  const bool is_known = fit.found && dt < kLongestStep_s;
  odometry.velocity = is_known ? Vector6d(se3_log(state.T_before_now) / dt) : Vector6d::Zero();
  odometry.stamp_ns = in.stamp_ns;
  return state;
}

}  // namespace tread
