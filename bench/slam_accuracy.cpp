// How well and how fast depth SLAM tracks: the RGB-D frames of the data folder against their
// reference poses, and walks over made ground against the truth, with the noise of both kinds of
// sensor. One set of defaults for all.
//   drift   error of the last pose, per cent of the path
//   second  error of the motion over one second, rms
//   unsure  frames that did not know where they were, by their own word
//   wrong   frames that thought they knew and were off by more than 5 cm
//   ms      processor time a frame, one thread, and of its stages
// Usage: slam_accuracy [--json] [--frames N] [name=value ...]   (options of SlamOptions)
#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>

#include "arguments.hpp"
#include "rendered_scene.hpp"
#include "stereo_pairs.hpp"
#include "times.hpp"
#include "tread/geometry/trajectory_error.hpp"
#include "tread/pipeline/depth_frames.hpp"
#include "tread/slam/depth_slam.hpp"

namespace {

using namespace tread;

struct SequenceResult {
  std::string name;
  int frames = 0, unsure = 0, wrongly_sure = 0;
  double path_m = 0.0, end_error_m = 0.0, absolute_m = 0.0;
  double second_m = 0.0;  // not a number where the sequence is shorter
  Timings timings;
};

struct Walk {
  std::string name;
  bench::Scene scene;
  std::function<Isometry3d(double)> pose;
};

std::vector<Walk> walks() {
  const auto in_room = [](double t) {
    return bench::camera_at({0.2 * t, 0.1 * std::sin(2.0 * t), 1.0}, 30.0 + 5.0 * std::sin(t), 15.0,
                            3.0 * std::sin(3.0 * t));
  };
  const auto turning = [](double t) {
    return bench::camera_at({0.05 * std::sin(3.0 * t), 0.05 * std::sin(2.0 * t), 1.0},
                            25.0 + 30.0 * std::sin(5.0 * t), 10.0 + 9.0 * std::sin(6.5 * t),
                            12.0 * std::sin(3.5 * t));
  };
  return {{"flat ground, texture", bench::flat_ground(true), bench::walking_camera},
          {"flat ground, plain", bench::flat_ground(false), bench::walking_camera},
          {"relief of 5 cm, plain", bench::rough_ground(0.05, false), bench::walking_camera},
          {"relief of 10 cm, plain", bench::rough_ground(0.10, false), bench::walking_camera},
          {"relief of 5 cm, texture", bench::rough_ground(0.05, true), bench::walking_camera},
          {"room", bench::room_corner(), in_room},
          {"room, turning at up to 150 deg/s", bench::room_corner(), turning}};
}

double over_a_second(const Trajectory& estimate, const Trajectory& truth) {
  const auto error = relative_pose_error(estimate, truth, 1.0);
  return error ? error->rmse_m : std::nan("");
}

SequenceResult walk(const Walk& walk, bool stereo, int frames, SlamOptions options) {
  bench::Sensor sensor;
  sensor.grey_sigma = 2.0;
  if (stereo) {
    sensor.stereo_sigma_px = 0.25;
    options.noise = stereo_noise(290.0, 0.12, 0.25);
  } else {
    sensor.noise = options.noise;
  }
  DepthSlam slam({290.0, 290.0, 159.5, 119.5, 0.0}, options, walk.pose(0.0));
  SequenceResult result;
  result.name = walk.name;
  result.frames = frames;
  Trajectory estimate, truth;
  for (int i = 0; i < frames; ++i) {
    const Isometry3d T = walk.pose(i / 30.0);
    const bench::RenderedFrame frame =
        bench::render(walk.scene, sensor, T, 100U + static_cast<unsigned>(i));
    const auto state =
        slam.track({i * 33'333'333LL, frame.depth, frame.grey}, {1, &result.timings});
    if (!state) throw std::runtime_error(state.error().message());
    if (i > 0) result.path_m += (T.translation() - truth.back().pose.translation()).norm();
    const double error = (T.inverse() * state->T_world_camera).translation().norm();
    result.unsure += state->mapped() ? 0 : 1;
    result.wrongly_sure += state->mapped() && error > 0.05 ? 1 : 0;
    result.end_error_m = error;
    estimate.push_back({i * 33'333'333LL, state->T_world_camera});
    truth.push_back({i * 33'333'333LL, T});
  }
  if (const auto e = absolute_trajectory_error(estimate, truth)) result.absolute_m = e->rmse_m;
  result.second_m = over_a_second(estimate, truth);
  return result;
}

tread::Result<SequenceResult> recorded(const std::filesystem::path& folder,
                                       const SlamOptions& options) {
  auto frames = DepthFrames::open(folder, {});
  if (!frames) return forward(frames);
  DepthSlam slam(frames->camera(), options);
  SequenceResult result;
  result.name = "kitchen, 25 frames of 7-Scenes";
  Trajectory estimate;
  for (;;) {
    auto frame = frames->next();
    if (!frame) return forward(frame);
    if (!*frame) break;
    const auto state = slam.track(
        {(*frame)->stamp_ns, (*frame)->depth, (*frame)->grey, (*frame)->rgb}, {1, &result.timings});
    if (!state) return forward(state);
    ++result.frames;
    result.unsure += state->mapped() ? 0 : 1;
    if (!estimate.empty()) {
      result.path_m +=
          (state->T_world_camera.translation() - estimate.back().pose.translation()).norm();
    }
    estimate.push_back({(*frame)->stamp_ns, state->T_world_camera});
  }
  if (const auto e = absolute_trajectory_error(estimate, frames->truth())) {
    result.absolute_m = e->rmse_m;
  }
  result.second_m = over_a_second(estimate, frames->truth());
  result.end_error_m = std::nan("");
  return result;
}

}  // namespace

int main(int argc, char** argv) {
  bool json = false;
  int frames = 150;
  SlamOptions options;
  OptionSet described = describe(options);
  bench::Arguments arguments("slam_accuracy");
  arguments.flag("--json", json).number("--frames", frames, 3).options(described);
  if (const auto status = arguments.read(argc, argv)) return *status;
  nlohmann::ordered_json all = {{"benchmark", "slam_accuracy"}};
  const auto tell = [&](const std::string& sensor, const SequenceResult& r) {
    const auto mean = [&](const char* stage) {
      const auto entry = r.timings.entries().find(stage);
      return entry == r.timings.entries().end() ? 0.0 : entry->second.mean_ms();
    };
    const double drift = 100.0 * r.end_error_m / r.path_m;
    all[sensor][r.name] = {
        {"frames", r.frames},     {"unsure", r.unsure},         {"wrongly_sure", r.wrongly_sure},
        {"drift_percent", drift}, {"absolute_m", r.absolute_m}, {"over_second_m", r.second_m},
        {"ms", mean("slam")}};
    if (json) return;
    fmt::print(
        "{:18} {:34} {:7.2f} {:7.2f} {:7.1f} {:7.1f} {:5} {:5}  {:5.1f}  {:.1f} {:.1f} {:.1f} "
        "{:.1f}\n",
        sensor, r.name, r.path_m, drift, 1e3 * r.absolute_m, 1e3 * r.second_m, r.unsure,
        r.wrongly_sure, mean("slam"), mean("slam/prepare"), mean("slam/align"),
        mean("slam/integrate"), mean("slam/ray_cast") + mean("slam/model_pyramid"));
  };
  if (!json) {
    fmt::print(
        "{:18} {:34} {:>7} {:>7} {:>7} {:>7} {:>5} {:>5}  {:>5}  prepare align integrate cast\n",
        "sensor", "sequence", "path m", "drift %", "abs mm", "second", "unsure", "wrong", "ms");
  }
  const std::filesystem::path kitchen = bench::data_folder() / "rgbd_seq" / "3dmatch_tsdf_fusion50";
  if (const auto result = recorded(kitchen, options)) {
    tell("recorded", *result);
  } else {
    fmt::print(stderr, "{}\n", result.error().message());
  }
  for (const bool stereo : {false, true}) {
    for (const Walk& w : walks()) {
      tell(stereo ? "stereo" : "structured light", walk(w, stereo, frames, options));
    }
  }
  const double peak_mb = bench::peak_memory_mb();
  all["peak_memory_mb"] = peak_mb;
  if (json) {
    fmt::print("{}\n", all.dump(2));
  } else {
    fmt::print("peak memory {:.0f} MiB\n", peak_mb);
  }
  return 0;
}
