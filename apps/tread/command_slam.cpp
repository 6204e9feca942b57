// tread slam: where the camera was and the surface it saw, from depth images or stereo pairs.
#include <fmt/format.h>
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <cmath>

#include "command.hpp"
#include "interrupt.hpp"
#include "open_pairs.hpp"
#include "slam_report.hpp"
#include "tread/core/problems.hpp"
#include "tread/io/image_file.hpp"
#include "tread/io/mesh_file.hpp"
#include "tread/io/trajectory_file.hpp"
#include "tread/pipeline/slam_pipeline.hpp"
#include "tread/slam/extract_mesh.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;

struct SlamArguments {
  std::string source, camera, rig, poses, command_line;
  std::string profile = "general";
  CommonOptions common;
};

struct SlamSettings {
  ImageReading images;
  StereoOptions stereo;
  DepthOptions depth{0.3, 200.0};
  SlamPipelineOptions pipeline;
  MeshOptions mesh;
};

OptionSet describe(SlamSettings& settings) {
  OptionSet set = describe(settings.pipeline);
  set.add_group("images", describe(settings.images));
  set.add_group("stereo", describe(settings.stereo));
  set.add_group("depth", describe(settings.depth));
  set.add_group("mesh", describe(settings.mesh));
  return set;
}

// KinFu large scale as paper Q used it (PCL): 3 m in 512 voxels, 30 mm, 4, 5 and 10 iterations, 10
// cm and 20 degrees, one weight for all, depth alone, loops left open.
SlamOptions paper_q_slam_options() {
  SlamOptions o;
  o.volume.voxel_m = 3.0 / 512.0;
  o.volume.window_log2 = 6;  // 64 blocks of 8
  o.volume.shift_m = 1.5;
  o.window_ahead_m = 1.8;
  o.integrate.truncation_voxels = 0.03 / o.volume.voxel_m;
  o.integrate.reference_m = 1000.0;
  o.integrate.full_weight = 1;
  o.integrate.most_weight = 128;
  o.integrate.along_ray = true;
  o.align.fine_iterations = 10;
  o.align.middle_iterations = 5;
  o.align.coarse_iterations = 4;
  o.align.gate_m = 0.10;
  o.align.gate_angle_deg = 20.0;
  o.align.intensity = false;
  o.loop.enabled = false;
  o.turn_first = false;
  o.integrate.farthest_m = 4.0;
  return o;
}

double process_cpu_ms() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto ms = [](const timeval& t) {
    return 1e3 * static_cast<double>(t.tv_sec) + 1e-3 * static_cast<double>(t.tv_usec);
  };
  return ms(usage.ru_utime) + ms(usage.ru_stime);
}

double peak_memory_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

void track_frames(DepthFrames& frames, SlamPipeline& pipeline, const Context& context,
                  const CommonOptions& common, SlamRun& run) {
  Progress progress("tracking", frames.frame_count(), common.json);
  const int kept = frames.frame_count() / 2;
  const Interrupt interrupt;
  const double cpu_before = process_cpu_ms();
  for (int i = 0;; ++i) {
    progress.show(i);
    if (Interrupt::requested()) {
      run.problems.push_back({ErrorCode::kInterrupted,
                              fmt::format("interrupted after {} frames", i), "slam",
                              "What was tracked until then is here"});
      break;
    }
    auto frame = frames.next(context);
    if (!frame) {
      ++run.frames;
      run.problems.push_back(frame.error());
      if (i > 2 * frames.frame_count() + 10) break;  // a source that never ends
      continue;
    }
    if (!*frame) break;
    ++run.frames;
    const auto start = std::chrono::steady_clock::now();
    const auto step = pipeline.step(frames, **frame, context);
    const std::chrono::duration<double, std::milli> spent =
        std::chrono::steady_clock::now() - start;
    run.track_ms += spent.count();
    if (!step) {
      Error error = step.error();
      error.where = (*frame)->name + ": " + error.where;
      run.problems.push_back(error);
      continue;
    }
    const SlamState& state = step->slam;
    run.states.push_back(state);
    if (step->odometry) run.odometry.push_back(*step->odometry);
    if (i <= kept) run.sample = std::move(**frame);
  }
  run.cpu_ms = process_cpu_ms() - cpu_before;
}

void compare(const DepthFrames& frames, SlamRun& run) {
  if (frames.truth().empty() || run.trajectory.size() < 3) return;
  if (const auto e = absolute_trajectory_error(run.trajectory, frames.truth())) run.absolute = *e;
  if (const auto e = relative_pose_error(run.trajectory, frames.truth(), 1.0)) run.relative = *e;
}

void summarise(const SlamRun& run, Output& output) {
  const auto frames = static_cast<double>(std::max<std::size_t>(run.states.size(), 1));
  auto& values = output.values;
  values["frames"] = run.frames;
  for (const TrackStatus status : {TrackStatus::kTracked, TrackStatus::kHeld,
                                   TrackStatus::kUnobservable, TrackStatus::kLost}) {
    values[name_of(status)] = count_of(run, status);
  }
  values["path_m"] = run.path_m;
  values["loops"] = run.loops;
  values["ms_per_frame"] = run.track_ms / frames;
  values["cpu_ms_per_frame_with_reading"] = run.cpu_ms / frames;
  values["peak_memory_mb"] = run.peak_memory_mb;
  values["triangles"] = run.mesh.triangles.size();
  if (run.absolute) {
    values["absolute_error_m"] = run.absolute->rmse_m;
    values["compared"] = run.absolute->compared;
  }
  if (run.relative) values["relative_error_m_per_s"] = run.relative->rmse_m;
  output.line(fmt::format(
      "{}: {} tracked, {} held, {} unobservable, {} lost; path {:.2f} m", frames_text(run.frames),
      count_of(run, TrackStatus::kTracked) + count_of(run, TrackStatus::kFirst),
      count_of(run, TrackStatus::kHeld), count_of(run, TrackStatus::kUnobservable),
      count_of(run, TrackStatus::kLost), run.path_m));
  if (!run.odometry.empty()) {
    const auto of = [&](OdometryStatus status) {
      return std::count_if(run.odometry.begin(), run.odometry.end(),
                           [status](const OdometryState& o) { return o.status == status; });
    };
    const auto inertial = std::count_if(run.odometry.begin(), run.odometry.end(),
                                        [](const OdometryState& o) { return o.inertial; });
    values["odometry"] = {{"tracked", of(OdometryStatus::kTracked)},
                          {"held", of(OdometryStatus::kHeld)},
                          {"lost", of(OdometryStatus::kLost)},
                          {"inertial", inertial}};
    output.line(fmt::format("odometry: {} fitted, {} held, {} lost; IMU in {}",
                            of(OdometryStatus::kTracked), of(OdometryStatus::kHeld),
                            of(OdometryStatus::kLost), inertial));
  }
  if (run.loops > 0) output.line(fmt::format("{} loops closed", run.loops));
  output.line(fmt::format("{:.1f} ms a frame, {} triangles, {:.0f} MiB", run.track_ms / frames,
                          run.mesh.triangles.size(), run.peak_memory_mb));
  if (run.absolute) {
    output.line(fmt::format(
        "against the reference: {:.1f} mm rms{}", 1e3 * run.absolute->rmse_m,
        run.relative ? fmt::format(", {:.1f} mm over a second", 1e3 * run.relative->rmse_m) : ""));
  }
}

Status write_results(const SlamArguments& arguments, const SlamOptions& options, const SlamRun& run,
                     Output& output) {
  FileSet set(*arguments.common.output);
  const auto add = [&](const std::string& name, const auto& write) {
    return add_file(set, name, write);
  };
  Status s = add("trajectory.tum",
                 [&](const fs::path& p) { return write_tum_trajectory(p, run.trajectory); });
  if (s && run.T_camera_imu) {
    Trajectory body = run.trajectory;
    for (StampedPose& pose : body) pose.pose = pose.pose * *run.T_camera_imu;
    s = add("trajectory_imu.tum", [&](const fs::path& p) { return write_tum_trajectory(p, body); });
  }
  if (s) s = add("mesh.ply", [&](const fs::path& p) { return write_ply(p, run.mesh); });
  if (s) {
    s = add("tracking.csv", [&](const fs::path& p) { return write_file(p, tracking_csv(run)); });
  }
  ColourScale scale;
  const MapPicture way = draw_way(run, scale);
  if (s && !way.image.empty()) {
    const Image<Rgb> picture = with_colour_bar(way.image, scale);
    s = add("picture_path.png", [&](const fs::path& p) { return write_png(p, picture); });
  }
  const Report report = slam_report(arguments.command_line, options, run);
  if (s) s = add("report.html", [&](const fs::path& p) { return report.write(p); });
  return s ? output.commit(set) : s;
}

Result<DepthFrames> open_frames(const std::string& source, const DepthFramesOptions& options,
                                const Context& context) {
  if (!is_simulated(source)) return DepthFrames::open(source, options);
  auto pairs = open_pairs(source, options.stereo_source, context);
  if (!pairs) return forward(pairs);
  return DepthFrames::from(std::move(*pairs), options);
}

int run_slam(const SlamArguments& arguments) {
  SlamSettings settings;
  if (arguments.profile == "paper-q") {
    settings.pipeline.slam = paper_q_slam_options();
    settings.pipeline.use_odometry = false;
  }
  OptionSet options = describe(settings);
  if (Status s = apply_settings(arguments.common, options); !s) return print_error(s.error());
  if (arguments.common.print_config) {
    print_config("slam", options);
    return 0;
  }
  DepthFramesOptions reading;
  reading.rgbd.camera = arguments.camera;
  reading.rgbd.poses = arguments.poses;
  reading.stereo_source = {arguments.rig, arguments.poses, settings.images};
  reading.stereo = settings.stereo;
  reading.depth = settings.depth;
  SlamRun run;
  const Context context{arguments.common.threads, &run.timings};
  auto frames = open_frames(arguments.source, reading, context);
  if (!frames) return print_error(frames.error());
  settings.pipeline = fit_to_rig(*frames, settings.pipeline, &options);
  if (Status s = check_options(settings.pipeline); !s) return print_error(s.error());
  if (Status s = prepare_output(arguments.common); !s) return print_error(s.error());

  run.kind = frames->kind();
  Output output(arguments.common.json);
  output.values["command"] = "slam";
  output.line(fmt::format("{}: {}", run.kind,
                          frames_text(static_cast<std::size_t>(frames->frame_count()))));
  SlamPipeline pipeline(*frames, settings.pipeline);
  track_frames(*frames, pipeline, context, arguments.common, run);
  // As it is now: loops have moved frames of the past.
  if (pipeline.started()) run.trajectory = pipeline.slam().trajectory();
  for (std::size_t i = 1; i < run.trajectory.size(); ++i) {
    run.path_m +=
        (run.trajectory[i].pose.translation() - run.trajectory[i - 1].pose.translation()).norm();
  }
  if (pipeline.started()) run.loops = pipeline.slam().loops();
  run.T_camera_imu =
      frames->imu() ? std::optional(frames->imu()->T_imu_left.inverse()) : std::nullopt;
  const std::vector<Error>& notices = frames->problems();
  const std::size_t noticed = notices.size();
  run.problems.insert(run.problems.begin(), notices.begin(), notices.end());
  if (run.trajectory.empty()) {
    for (const Error& problem : distinct_problems(run.problems)) print_error(problem);
    return print_error({ErrorCode::kBadValue,
                        fmt::format("none of {} could be placed", frames_text(run.frames)),
                        arguments.source, "Likely there is no depth in them: see tread info"});
  }
  const VoxelVolume& volume = pipeline.slam().volume();
  run.mesh = extract_mesh(volume, settings.mesh);
  run.volume_bytes = volume.bytes();
  run.refused_blocks = volume.refused();
  if (run.refused_blocks > 0) {
    run.problems.push_back({ErrorCode::kTooLarge,
                            fmt::format("{} blocks of voxels found no room", run.refused_blocks),
                            "volume.memory_mb", "Give it more, or larger voxels"});
  }
  if (2 * run.trajectory.size() < run.states.size()) {
    run.problems.push_back(
        {ErrorCode::kBadValue,
         fmt::format("only {} of {} could be placed", run.trajectory.size(),
                     frames_text(run.states.size())),
         arguments.source,
         "See tracking.csv and the report (-o DIR): frames too far apart, too little to see, or "
         "noise.* and the intrinsics do not fit the camera"});
  }
  run.peak_memory_mb = peak_memory_mb();
  compare(*frames, run);
  summarise(run, output);
  output.values["timings"] = json_of(run.timings);
  if (arguments.common.output) {
    if (Status s = write_results(arguments, settings.pipeline.slam, run, output); !s) {
      return print_error(s.error());
    }
  }
  for (const Error& problem : run.problems) {
    output.values["problems"].push_back(problem.message());
  }
  output.print_json();
  // An assumed camera, or a line of a list left out, is said; it is no failure of the work.
  if (run.problems.size() == noticed) {
    for (const Error& problem : run.problems) {
      fmt::print(stderr, "tread: note: {}\n", problem.message());
    }
    return 0;
  }
  return print_problems(run.problems, run.frames - run.trajectory.size(), run.frames);
}

}  // namespace

void add_slam_command(CLI::App& app, int& status, const std::string& command_line) {
  CLI::App* command =
      app.add_subcommand("slam", "The camera's path and the surface, from depth or stereo images");
  auto arguments = std::make_shared<SlamArguments>();
  arguments->command_line = command_line;
  command
      ->add_option("SOURCE", arguments->source,
                   "TUM RGB-D folder, folder of frame-NNNNNN.depth.png (7-Scenes, 3DMatch), or "
                   "stereo images as for 'tread map', also sim:COURSE")
      ->type_name("")
      ->required();
  command
      ->add_option(
          "--camera", arguments->camera,
          "Intrinsics of the depth camera, if the folder brings none: a file with fx fy cx "
          "cy, a 3x3 matrix, ROS camera_info or a rig of ours")
      ->type_name("FILE");
  command->add_option("--rig", arguments->rig, "Calibration of a stereo pair, as for 'tread map'")
      ->type_name("RIG");
  command
      ->add_option("--poses", arguments->poses,
                   "Reference poses to compare with, TUM format; default: those of the folder")
      ->type_name("FILE");
  command
      ->add_option("--profile", arguments->profile,
                   "Where the options start from: general, or paper-q (KinFu large scale with the "
                   "numbers of paper Q)")
      ->type_name("NAME")
      ->check(CLI::IsMember({"general", "paper-q"}).description(""));
  add_method_option(*command, arguments->common);
  add_common_options(*command, arguments->common);
  add_setting_options(*command, arguments->common);
  command->footer(
      "Examples:\n"
      "  tread slam rgbd_dataset_freiburg1_desk -o out/desk\n"
      "  tread slam seq-01 --set volume.voxel_m=0.005 -o out/kitchen\n"
      "  tread slam kitti/sequences/07 --method sgm -o out/street\n"
      "Pairs are first followed by visual odometry, with the IMU if the folder brings one "
      "(EuRoC).\n"
      "Writes trajectory.tum (frames that were placed; with an IMU also its own,\n"
      "trajectory_imu.tum), mesh.ply, tracking.csv (what each\n"
      "frame said of itself), picture_path.png and report.html. Reference poses are only\n"
      "compared with, never used.");
  command->callback([arguments, &status] { status = run_slam(*arguments); });
}

}  // namespace tread
