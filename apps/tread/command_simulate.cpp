// tread simulate: a robot over a simulated course, to a data set with the truth beside it.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <array>
#include <chrono>
#include <ctime>

#include "command.hpp"
#include "interrupt.hpp"
#include "simulate_recording.hpp"
#include "simulate_report.hpp"
#include "tread/io/data_set_writer.hpp"
#include "tread/io/image_file.hpp"
#include "tread/io/recording_files.hpp"
#include "tread/sim/named_courses.hpp"
#include "tread/sim/route_driver.hpp"
#include "tread/sim/simulated_robot.hpp"
#include "tread/sim/true_maps.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;

struct SimulateArguments {
  std::string course, robot = "rover", command_line;
  std::optional<std::int64_t> seed;
  std::optional<double> duration_s;
  bool carried = false, preview = false;
  CommonOptions common;
};

struct SimulateSettings {
  RobotSetup robot;
  RouteDriverOptions drive;
  CarryOptions carry;
  TraverseOptions traverse;
  double map_resolution_m = 0.05;
  double longest_s = 600.0;
  bool depth = true;
};

OptionSet describe(SimulateSettings& settings) {
  OptionSet set;
  set.add_group("robot", describe(settings.robot));
  set.add_group("drive", describe(settings.drive));
  set.add_group("carry", describe(settings.carry));
  set.add_group("traverse", describe(settings.traverse));
  set.add("map_resolution_m", settings.map_resolution_m, "of the true maps", 0.005, 10.0);
  set.add("longest_s", settings.longest_s, "a run ends then, unless --duration says otherwise", 0.1,
          1e6);
  set.add("depth", settings.depth, "write the true depth of every pair");
  return set;
}

SimulateSettings settings_for(const std::string& robot) {
  SimulateSettings settings;
  if (robot == "walker") {
    settings.robot = walker_setup();
    settings.carry.gait_hz = 1.65;
    settings.carry.speed_m_per_s = 0.3;
  } else {
    settings.robot = rover_setup();
  }
  return settings;
}

// On the ground at the start, level.
Isometry3d body_at(const World& world) {
  Isometry3d T = Isometry3d::Identity();
  T.linear() = rotation_from_yaw_pitch_roll(world.start.yaw_rad, 0.0, 0.0);
  T.translation() << world.start.position_m, top_height(world, world.start.position_m);
  return T;
}

std::string names_of_courses() {
  return fmt::format("{}", fmt::join(course_names(), ", "));
}

double cpu_s() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

Result<DataSetWriter> open_writer(const SimulateArguments& arguments, const SimulatedRobot& robot,
                                  const RobotSetup& setup) {
  RecordingSetup recording;
  recording.description = fmt::format("tread simulate {} --robot {}, world seed {}",
                                      arguments.course, arguments.robot, robot.world().seed);
  recording.heads = robot.heads();
  recording.camera_rate_hz = setup.camera.channel.rate_hz;
  // Nobody turns it here: the IMU stays fixed to the cameras.
  recording.head_turns = false;
  recording.gnss_rate_hz = setup.gnss.channel.rate_hz;
  recording.p_body_antenna_m = pose_of(setup.antenna_mount).translation();
  return DataSetWriter::create(*arguments.common.output, recording);
}

// The report shows the pair whose true depth was kept.
void keep_pair(const SensorBatch& batch, SimulateRun& run) {
  for (const HeadFrame& frame : batch.frames) {
    if (frame.head != 0 || frame.frame.stamp_ns != run.depth_stamp_ns) continue;
    run.left = frame.frame.left;
    run.right = frame.frame.right;
  }
}

// Lets the robot go its way until it is there, or time is up.
Status go(const SimulateArguments& arguments, const SimulateSettings& settings,
          SimulatedRobot& robot, SimulateRecording& recording, SimulateRun& run) {
  constexpr std::int64_t kStep_ns = 5'000'000;
  constexpr double kAfter_s = 1.0;  // that it goes on after it has arrived
  double end_s = arguments.duration_s.value_or(robot.duration_s() ? *robot.duration_s() + kAfter_s
                                                                  : settings.longest_s);
  RouteDriver driver(robot.world(), settings.drive);
  if (!robot.duration_s() && driver.length_m() == 0.0 && !arguments.duration_s) {
    return fail(ErrorCode::kBadValue, "the route has no length", robot.world().name,
                "Give the course a route_m or a goal_m, or say how long to stand (--duration)");
  }
  const bool drives = !robot.duration_s() && settings.robot.kind == RobotSetup::Kind::kRover;
  Progress progress("simulating", static_cast<int>(end_s), arguments.common.json);
  const Interrupt interrupt;
  const auto now_s = [&] { return 1e-9 * static_cast<double>(robot.time_ns()); };
  recording.add(SensorBatch{});  // the truth of the start
  bool was_done = false;
  while (now_s() < end_s) {
    if (Interrupt::requested()) {
      run.problems.push_back({ErrorCode::kInterrupted,
                              fmt::format("interrupted after {:.1f} s", now_s()), "simulate",
                              "What was simulated until then is here"});
      break;
    }
    if (drives) {
      const DriveCommand command = driver.drive(now_s(), robot.motion().T_world_body);
      if (Status s = robot.command({.drive = command}); !s) return s;
    }
    const auto batch = robot.advance(kStep_ns);
    if (!batch) {
      // What was simulated until then is kept.
      run.problems.push_back(batch.error());
      break;
    }
    recording.add(*batch);
    if (!recording.status()) return recording.status();
    keep_pair(*batch, run);
    const Eigen::Vector3d p = robot.motion().T_world_body.translation();
    if (run.path.empty() || (p - run.path.back().pose.translation()).norm() > 0.05) {
      if (!run.path.empty()) run.way_m += (p - run.path.back().pose.translation()).norm();
      run.path.push_back({robot.time_ns(), robot.motion().T_world_body});
    }
    if (drives && driver.done() && !was_done && !arguments.duration_s) {
      end_s = std::min(end_s, now_s() + kAfter_s);
      was_done = true;
    }
    progress.show(static_cast<int>(now_s()));
  }
  run.duration_s = now_s();
  if (!run.problems.empty()) {
    run.end = fmt::format("Ended early, after {:.2f} m.", run.way_m);
  } else if (!drives) {
    run.end = fmt::format("Carried {:.2f} m along the route.", run.way_m);
  } else {
    run.end = driver.arrived() ? "Arrived."
              : driver.stuck() ? fmt::format("Got stuck after {:.1f} of {:.1f} m of the route.",
                                             driver.gone_m(), driver.length_m())
                               : fmt::format("Time was up after {:.1f} of {:.1f} m of the route.",
                                             driver.gone_m(), driver.length_m());
  }
  return {};
}

Status draw(const Scene& scene, const SimulateSettings& settings, const Isometry3d& T_world_body,
            const Context& context, SimulateRun& run) {
  ScopedTimer timer(context, "pictures");
  auto above = draw_from_above(scene, 1100, context);
  if (!above) return forward(above);
  run.above = std::move(*above);
  auto eye = draw_robots_eye(scene, settings.robot, 0, T_world_body, context);
  if (!eye) return forward(eye);
  run.eye = std::move(*eye);
  return {};
}

// What is known before anything moves.
void describe_course(const Course& course, const SimulateSettings& settings, const Context& context,
                     SimulateRun& run) {
  ScopedTimer timer(context, "true maps");
  const World& world = *course.world;
  run.course = world.name;
  run.world_seed = world.seed;
  run.height = true_height(world, map_geometry(world, settings.map_resolution_m));
  run.traversable = true_traversable(run.height, settings.traverse);
  run.route = way_of(world);
  for (const Fault& fault : course.faults) {
    run.faults.push_back(fmt::format("{} {} from {} to {} s, if this robot has one", fault.sensor,
                                     name_of(fault.kind), fault.from_s, fault.until_s));
  }
}

Status write_pictures(const SimulateArguments& arguments, const SimulateRun& run, Output& output) {
  FileSet set(*arguments.common.output);
  const Report report = simulate_report(arguments.command_line, run);
  Status s = add_file(set, "report.html", [&](const fs::path& p) { return report.write(p); });
  if (s) {
    s = add_file(set, "picture_above.png",
                 [&](const fs::path& p) { return write_png(p, draw_course(run).view()); });
  }
  if (s) {
    s = add_file(set, "picture_eye.png",
                 [&](const fs::path& p) { return write_png(p, run.eye.view()); });
  }
  return s ? output.commit(set) : s;
}

void summarise(const SimulateRun& run, Output& output) {
  output.values["course"] = run.course;
  output.values["robot"] = run.robot;
  output.values["world_seed"] = run.world_seed;
  output.values["seed"] = run.sensor_seed;
  output.values["duration_s"] = run.duration_s;
  output.values["way_m"] = run.way_m;
  output.values["cpu_s"] = run.cpu_s;
  output.values["end"] = run.end;
  std::string counts;
  for (const auto& [sensor, count] : run.samples) {
    output.values["samples"][sensor] = count;
    counts += fmt::format("{}{} {}", counts.empty() ? "" : ", ", sensor, count);
  }
  output.line(fmt::format("{}: {:.1f} s, {:.2f} m, {:.1f} s of CPU. {}", run.course, run.duration_s,
                          run.way_m, run.cpu_s, run.end));
  if (!counts.empty()) output.line("samples: " + counts);
}

// Drives or carries the robot; the run's samples, pictures of a pair, and what became of it.
Status simulate(const SimulateArguments& arguments, const SimulateSettings& settings,
                const Course& course, const Context& context, SimulateRun& run) {
  SimulationOptions options;
  options.seed = run.sensor_seed;
  options.carried = arguments.carried || settings.robot.kind == RobotSetup::Kind::kWalker;
  options.carry = settings.carry;
  options.frames_know_pose = true;
  auto robot = SimulatedRobot::make(course, settings.robot, options, context);
  if (!robot) return forward(robot);
  std::optional<DataSetWriter> writer;
  if (arguments.common.output) {
    auto opened = open_writer(arguments, **robot, settings.robot);
    if (!opened) return forward(opened);
    writer.emplace(std::move(*opened));
  }
  SimulateRecording recording(writer ? &*writer : nullptr, **robot, options.epoch_ns);
  const double middle_s =
      0.5 * arguments.duration_s.value_or((*robot)->duration_s().value_or(20.0));
  (*robot)->on_frame([&](FrameTruth&& truth) {
    if (settings.depth) recording.expect(truth);
    if (truth.head == 0 && 1e-9 * static_cast<double>((*robot)->time_ns()) < middle_s) {
      run.depth = std::move(truth.depth);
      run.depth_stamp_ns = truth.stamp_ns;
    }
  });
  if (Status s = go(arguments, settings, **robot, recording, run); !s) return s;
  for (const auto& [sensor, count] : recording.counts()) run.samples.emplace_back(sensor, count);
  if (!writer) return {};
  for (const auto& [name, raster] :
       {std::pair("height", &run.height), {"traversable", &run.traversable}}) {
    if (Status s = writer->add_raster(name, *raster); !s) return s;
  }
  return writer->finish();
}

int run_simulate(const SimulateArguments& arguments) {
  SimulateSettings settings = settings_for(arguments.robot);
  OptionSet described = describe(settings);
  if (Status s = apply_settings(arguments.common, described); !s) return print_error(s.error());
  if (arguments.common.print_config) {
    print_config("simulate", described);
    return 0;
  }
  if (arguments.duration_s && !(*arguments.duration_s > 0.0 && *arguments.duration_s <= 1e6)) {
    return print_error(
        {ErrorCode::kBadValue, "a run needs some time", "--duration", "Give seconds, above 0"});
  }
  if (arguments.seed && *arguments.seed < 0) {
    return print_error(
        {ErrorCode::kBadValue, "seeds are not negative", "--seed", "Give 0 or more"});
  }
  if (arguments.preview) {
    if (!arguments.common.output || is_recording(*arguments.common.output)) {
      return print_error({ErrorCode::kBadArgument,
                          arguments.common.output ? "there is a recording, whose report would go"
                                                  : "pictures need a folder",
                          "--preview", "Give a folder for them (-o DIR)"});
    }
  }
  const auto course = find_course(arguments.course, arguments.seed);
  if (!course) return print_error(course.error());
  SimulateRun run;
  run.robot = settings.robot.kind == RobotSetup::Kind::kRover ? "rover" : "walker";
  run.sensor_seed = static_cast<std::uint64_t>(arguments.seed.value_or(1));
  const Context context{arguments.common.threads, &run.timings};
  Output output(arguments.common.json);
  output.values["command"] = "simulate";
  const auto begin = std::chrono::steady_clock::now();
  describe_course(*course, settings, context, run);
  if (!arguments.preview) {
    if (Status s = simulate(arguments, settings, *course, context, run); !s) {
      return print_error(s.error());
    }
  } else {
    run.end = "Pictures only.";
    if (Status s = prepare_output(arguments.common); !s) return print_error(s.error());
  }
  run.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  run.cpu_s = cpu_s();
  if (arguments.common.output) {
    const auto scene = Scene::make(course->world);
    if (!scene) return print_error(scene.error());
    const Isometry3d start = run.path.empty() ? body_at(*course->world) : run.path.front().pose;
    if (Status s = draw(*scene, settings, start, context, run); !s) return print_error(s.error());
    if (Status s = write_pictures(arguments, run, output); !s) return print_error(s.error());
  }
  summarise(run, output);
  output.values["timings"] = json_of(run.timings);
  for (const Error& problem : run.problems) output.values["problems"].push_back(problem.message());
  output.print_json();
  if (run.problems.empty()) return 0;
  for (const Error& problem : run.problems) print_error(problem);
  return 1;
}

}  // namespace

void add_simulate_command(CLI::App& app, int& status, const std::string& command_line) {
  CLI::App* command = app.add_subcommand(
      "simulate", "A robot over a simulated course, to a data set with the truth beside it");
  auto arguments = std::make_shared<SimulateArguments>();
  arguments->command_line = command_line;
  command
      ->add_option("COURSE", arguments->course, "A course file, or a name: " + names_of_courses())
      ->type_name("")
      ->required();
  command
      ->add_option("--robot", arguments->robot,
                   "rover: drives by its wheels. walker: is carried with the motion of a trot")
      ->type_name("NAME")
      ->check(CLI::IsMember({"rover", "walker"}).description(""));
  command->add_option("--seed", arguments->seed, "Of the world and of the sensors")->type_name("N");
  command
      ->add_option("--duration", arguments->duration_s,
                   "Seconds; default: until the end of the route")
      ->type_name("S");
  command->add_flag("--carried", arguments->carried,
                    "Carry the rover along the route: smooth, and no wheels slip");
  command->add_flag("--preview", arguments->preview, "Only the pictures of the course");
  add_common_options(*command, arguments->common);
  add_setting_options(*command, arguments->common);
  command->footer(
      "Examples:\n"
      "  tread simulate meadow -o out/meadow\n"
      "  tread simulate stairs --robot walker --seed 3 -o out/stairs\n"
      "  tread simulate my_course.yaml --set robot.heads=1 -o out/mine\n"
      "Writes a folder as EuRoC/ASL lays data out (mav0/: pairs of images, IMU, satellite fixes,\n"
      "wheels, bumper), the truth (truth/: poses, depth, height.tif, traversable.tif), and\n"
      "report.html with pictures. 'tread slam', 'tread map' and 'tread info' read it; they also\n"
      "take sim:COURSE in place of a folder.");
  command->callback([arguments, &status] { status = run_simulate(*arguments); });
}

}  // namespace tread
