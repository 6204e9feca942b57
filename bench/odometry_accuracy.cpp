// How well and how fast visual odometry follows a rig: a flight through a made room with and
// without its IMU, a walk that looks at the ground, a drive down a made street, and the recorded
// drive of the data folder against its reference. One set of defaults for all.
//   drift  error of the last pose, per cent of the path, both seen from the first
//   abs    absolute trajectory error, and over one second, rms
//   ms     processor time a frame, one thread, and of its stages
// Usage: odometry_accuracy [--json] [--seconds N] [name=value ...]   (options of OdometryOptions)
#include <fmt/format.h>

#include <functional>
#include <nlohmann/json.hpp>

#include "arguments.hpp"
#include "plane_world.hpp"
#include "rendered_scene.hpp"
#include "stereo_pairs.hpp"
#include "times.hpp"
#include "tread/geometry/trajectory_error.hpp"
#include "tread/pipeline/depth_frames.hpp"
#include "tread/slam/inertial_start.hpp"
#include "tread/slam/visual_odometry.hpp"

namespace {

using namespace tread;

struct Drive {
  std::string name;
  PlaneWorld world;
  RectifiedRig rig;
  double rate_hz;
  std::function<Isometry3d(double)> pose;
  bool with_imu = false;
};

RectifiedRig rig_of(ImageSize size, double focal_px, double baseline_m) {
  RectifiedRig rig;
  rig.size = size;
  rig.fx_px = rig.fy_px = focal_px;
  rig.cx_px = 0.5 * (size.width - 1);
  rig.cy_px = 0.5 * (size.height - 1);
  rig.baseline_m = baseline_m;
  return rig;
}

std::vector<Drive> drives() {
  const auto street = [](double t) {
    return bench::camera_at({11.0 * t, 0.3 * std::sin(0.5 * t), 1.65}, 3.0 * std::sin(1.1 * t),
                            0.5 * std::sin(3.0 * t), 0.3 * std::sin(2.0 * t));
  };
  const auto walk = [](double t) {
    Isometry3d T = bench::walking_camera(t);
    T.translation().x() -= 1.5;  // stays in the room for eight seconds
    return T;
  };
  const RectifiedRig small = rig_of({640, 480}, 435.0, 0.11);
  return {
      {"flight in a room", PlaneWorld::room(), small, 20.0, plane_world_pose},
      {"flight in a room, IMU", PlaneWorld::room(), small, 20.0, plane_world_pose, true},
      {"walk, looking at the ground", PlaneWorld::room(), small, 20.0, walk},
      {"street at 11 m/s", PlaneWorld::street(), rig_of({1226, 370}, 707.0, 0.537), 10.0, street}};
}

struct DriveResult {
  std::string name;
  int frames = 0, placed = 0, inertial = 0;
  Trajectory estimate, truth;
  Timings timings;

  [[nodiscard]] double path_m() const {
    double sum = 0.0;
    for (std::size_t i = 1; i < truth.size(); ++i) {
      sum += (truth[i].pose.translation() - truth[i - 1].pose.translation()).norm();
    }
    return sum;
  }
  [[nodiscard]] double end_error_m() const {
    const Isometry3d is = estimate.front().pose.inverse() * estimate.back().pose;
    const Isometry3d should = truth.front().pose.inverse() * truth.back().pose;
    return (is.translation() - should.translation()).norm();
  }
  void add(const OdometryState& state, const Isometry3d& T_true) {
    ++frames;
    placed += state.placed() ? 1 : 0;
    inertial += state.inertial ? 1 : 0;
    estimate.push_back({state.stamp_ns, state.T_world_camera});
    truth.push_back({state.stamp_ns, T_true});
  }
};

DriveResult follow(const Drive& drive, double seconds, const OdometryOptions& options) {
  const Eigen::Vector3d gyro_bias(0.02, -0.03, 0.01), accel_bias(0.08, -0.05, 0.1);
  std::optional<Imu> imu;
  Isometry3d first = Isometry3d::Identity();
  if (drive.with_imu) {
    imu.emplace();
    const auto rest = plane_world_imu(-0.5, 0.0, gyro_bias, accel_bias);
    first.linear() = level_camera(rest, Isometry3d::Identity()).value();
  }
  VisualOdometry odometry(drive.rig, options, first, imu);
  DriveResult result;
  result.name = drive.name;
  for (int i = 0; i < static_cast<int>(seconds * drive.rate_hz); ++i) {
    const double t = i / drive.rate_hz;
    const auto pair =
        drive.world.pair(drive.rig, drive.pose(t), 2.0, static_cast<std::uint32_t>(i));
    OdometryFrame frame{std::llround(t * 1e9), pair.left, pair.right};
    const auto samples = plane_world_imu(t - 1.0 / drive.rate_hz, t, gyro_bias, accel_bias);
    if (drive.with_imu) frame.imu = samples;
    const auto state = odometry.track(frame, {1, &result.timings});
    if (!state) throw std::runtime_error(state.error().message());
    result.add(*state, drive.pose(t));
  }
  return result;
}

tread::Result<DriveResult> recorded(const std::filesystem::path& folder,
                                    const OdometryOptions& options) {
  auto frames = DepthFrames::open(folder, {});
  if (!frames) return forward(frames);
  VisualOdometry odometry(*frames->rig(), options);
  DriveResult result;
  result.name = "recorded, 30 frames of KITTI";
  for (;;) {
    const auto frame = frames->next();
    if (!frame) return forward(frame);
    if (!*frame) return result;
    const auto pair = frames->pair();
    const auto state =
        odometry.track({(*frame)->stamp_ns, pair.left, pair.right}, {1, &result.timings});
    if (!state) return forward(state);
    if ((*frame)->T_world_camera) result.add(*state, *(*frame)->T_world_camera);
  }
}

}  // namespace

int main(int argc, char** argv) {
  bool json = false;
  int seconds = 5;
  OdometryOptions options;
  OptionSet described = describe(options);
  bench::Arguments arguments("odometry_accuracy");
  arguments.flag("--json", json).number("--seconds", seconds, 2).options(described);
  if (const auto status = arguments.read(argc, argv)) return *status;
  nlohmann::ordered_json all = {{"benchmark", "odometry_accuracy"}};
  if (!json) {
    fmt::print("{:30} {:>6} {:>6} {:>7} {:>7} {:>7} {:>9} {:>5}  {}\n", "drive", "frames", "placed",
               "path m", "drift %", "abs mm", "mm over s", "ms",
               "pyramids follow right fit settle+refine+detect a keyframe");
  }
  const auto tell = [&](const DriveResult& r) {
    const auto mean = [&](const char* stage) {
      const auto entry = r.timings.entries().find(stage);
      return entry == r.timings.entries().end() ? 0.0 : entry->second.mean_ms();
    };
    const auto absolute = absolute_trajectory_error(r.estimate, r.truth);
    const auto relative = relative_pose_error(r.estimate, r.truth, 1.0);
    const double path = r.path_m(), drift = 100.0 * r.end_error_m() / path;
    const double abs_mm = absolute ? 1e3 * absolute->rmse_m : std::nan("");
    const double second_mm = relative ? 1e3 * relative->rmse_m : std::nan("");
    all[r.name] = {{"frames", r.frames},          {"placed", r.placed},
                   {"inertial", r.inertial},      {"path_m", path},
                   {"drift_percent", drift},      {"absolute_mm", abs_mm},
                   {"mm_over_second", second_mm}, {"ms", mean("odometry")}};
    if (json) return;
    fmt::print(
        "{:30} {:6} {:6} {:7.2f} {:7.3f} {:7.1f} {:9.1f} {:5.1f}  {:.1f} {:.1f} {:.1f} "
        "{:.1f} {:.1f}\n",
        r.name, r.frames, r.placed, path, drift, abs_mm, second_mm, mean("odometry"),
        mean("odometry/pyramids"), mean("odometry/follow"), mean("odometry/find_right"),
        mean("odometry/fit"),
        mean("odometry/settle") + mean("odometry/refine") + mean("odometry/detect"));
  };
  if (const auto result = recorded(bench::data_folder() / "stereo_seq" / "kitti_seq_1", options)) {
    tell(*result);
  } else {
    fmt::print(stderr, "{}\n", result.error().message());
  }
  for (const Drive& drive : drives()) tell(follow(drive, seconds, options));
  const double peak_mb = bench::peak_memory_mb();
  all["peak_memory_mb"] = peak_mb;
  if (json) {
    fmt::print("{}\n", all.dump(2));
  } else {
    fmt::print("peak memory {:.0f} MiB\n", peak_mb);
  }
  return 0;
}
