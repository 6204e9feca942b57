// tread map: a drive of stereo frames with poses to the maps of the ground, and the way to a goal.
#include <fmt/format.h>

#include <cmath>

#include "command.hpp"
#include "map_report.hpp"
#include "tread/core/problems.hpp"
#include "tread/io/atomic_file.hpp"
#include "tread/io/image_file.hpp"
#include "tread/io/map_files.hpp"
#include "tread/io/source.hpp"
#include "tread/io/trajectory_file.hpp"
#include "tread/terrain/features.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;

struct MapArguments {
  std::string source, rig, poses, command_line;
  std::vector<double> start, goal;
  bool features = false;
  CommonOptions common;
};

struct MapSettings {
  RoverMapOptions map;
  PlannerOptions plan;
};

OptionSet describe(MapSettings& settings) {
  OptionSet set = describe(settings.map);
  set.add_group("plan", describe(settings.plan));
  return set;
}

// Takes all frames in. What goes wrong with one frame is kept and the next one is tried.
Status map_frames(StereoSource& source, RoverMapper& mapper, const Context& context,
                  const CommonOptions& common, MapRun& run) {
  Progress progress("mapping", source.frame_count(), common.json);
  const bool single = source.frame_count() == 1 && !source.has_poses();
  const int kept = source.frame_count() / 2;  // the frame that the report shows
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0;; ++i) {
    progress.show(i);
    auto frame = source.next();
    if (!frame) {
      run.problems.push_back(frame.error());
      if (i > 2 * source.frame_count() + 10) break;  // a source that never ends
      continue;
    }
    if (!*frame) break;
    if (single) {
      // One pair and nothing else: the robot stands at the origin of the world.
      const CameraMount mount = source.rig().mount.value_or(level_mount(0.0, 0.0, true));
      (*frame)->T_world_left = mount.T_body_left;
    }
    const auto start = std::chrono::steady_clock::now();
    const auto mapped = mapper.add(**frame, context);
    const std::chrono::duration<double, std::milli> spent =
        std::chrono::steady_clock::now() - start;
    run.frame_ms += spent.count();
    if (!mapped) {
      run.problems.push_back(mapped.error());
      continue;
    }
    if (mapped->began_anew) {  // what was mapped before is not in the map
      run.problems.push_back(*mapped->began_anew);
      run.trajectory.clear();
      run.positions.clear();
    }
    run.trajectory.push_back({(*frame)->stamp_ns, *(*frame)->T_world_left});
    run.positions.push_back(mapped->pose.position);
    run.last_yaw_rad = mapped->pose.yaw_rad;
    if (i <= kept) run.sample = sample_of(**frame, *mapped);
  }
  run.wall_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
  if (!run.trajectory.empty()) return {};
  if (!run.problems.empty()) {
    for (const Error& problem : distinct_problems(run.problems)) print_error(problem);
    return fail(ErrorCode::kBadValue,
                fmt::format("none of {} frames could be mapped", run.problems.size()), "map",
                "Mend what is said above");
  }
  return fail(ErrorCode::kNotFound, "there are no frames", "source", "Give a folder with images");
}

// Where the plan begins and ends if the user does not say: from the first pose to straight ahead of
// the last one, beyond the map.
void choose_ends(const MapArguments& arguments, const RoverMapper& mapper, MapRun& run) {
  run.start = run.positions.front().head<2>();
  const double beyond = mapper.options().depth.max_depth_m + 20.0;
  run.goal = run.positions.back().head<2>() +
             beyond * Eigen::Vector2d(std::cos(run.last_yaw_rad), std::sin(run.last_yaw_rad));
  run.ends_chosen = arguments.goal.empty();
  if (!arguments.start.empty()) run.start = {arguments.start[0], arguments.start[1]};
  if (!arguments.goal.empty()) run.goal = {arguments.goal[0], arguments.goal[1]};
}

void add_feature_layers(const Context& context, MapLayers& map) {
  const Grid<float> height = map.find("height")->grid;
  // The windows must hold some cells, whatever their size.
  FeatureOptions options;
  const double least = 2.5 * height.geometry.resolution_m;
  for (double* radius : {&options.normal_radius_m, &options.step_radius_m,
                         &options.step_second_radius_m, &options.roughness_radius_m}) {
    *radius = std::max(*radius, least);
  }
  TerrainFeatures features = terrain_features(height, options, context);
  map.layers.push_back(
      {"slope", "1", "1 level, 0 at the critical slope", std::move(features.slope)});
  map.layers.push_back({"step", "1", "1 even, 0 at the critical step", std::move(features.step)});
  map.layers.push_back(
      {"roughness", "1", "1 smooth, 0 at the critical roughness", std::move(features.roughness)});
  map.layers.push_back({"traversability", "1", "mean of slope, step and roughness",
                        std::move(features.traversability)});
}

Status write_results(const MapArguments& arguments, const MapSettings& settings,
                     const StereoSource& source, const RoverMapper& mapper, const MapRun& run,
                     Output& output) {
  const fs::path folder = arguments.common.output;
  if (Status made = make_output_folder(folder); !made) return made;
  if (Status s = save_map(run.layers, folder); !s) return s;
  output.wrote(folder / "map.yaml");
  for (const MapLayer& layer : run.layers.layers) output.wrote(folder / (layer.name + ".tif"));
  if (Status s = write_tum_trajectory(folder / "trajectory.tum", run.trajectory); !s) return s;
  output.wrote(folder / "trajectory.tum");
  if (Status s = write_file(folder / "path.csv", path_csv(run.plan)); !s) return s;
  output.wrote(folder / "path.csv");
  for (const MapFigure& figure : map_figures(run, settings.plan)) {
    const fs::path file = folder / ("picture_" + figure.name + ".png");
    if (Status s = write_png(file, with_colour_bar(figure.picture.image, figure.scale)); !s)
      return s;
    output.wrote(file);
  }
  const Report report = map_report(arguments.command_line, source, mapper, settings.plan, run);
  if (Status s = report.write(folder / "report.html"); !s) return s;
  output.wrote(folder / "report.html");
  output.line("wrote " + folder.string() +
              ": map.yaml with height, derivative, explored and cost (.tif), nav2_map, path.csv, "
              "trajectory.tum, pictures, report.html");
  return {};
}

void summarise(const RoverMapper& mapper, const MapRun& run, Output& output) {
  const double frames = static_cast<double>(run.trajectory.size());
  const double cell = mapper.ground().resolution_m();
  output.values["frames"] = run.trajectory.size();
  output.values["frames_failed"] = run.problems.size();
  output.values["range_m"] = mapper.options().depth.max_depth_m;
  output.values["num_disparities"] = mapper.options().stereo.sad.num_disparities;
  output.values["explored_m2"] = run.explored_cells * cell * cell;
  output.values["mean_frame_ms"] = run.frame_ms / frames;
  output.values["frames_per_second"] = 1000.0 * frames / run.frame_ms;
  output.values["frames_per_second_with_reading"] = 1000.0 * frames / run.wall_ms;
  output.line(fmt::format(
      "{} frames, {} disparities, range {:.1f} m: {:.1f} frames per second ({:.1f} with reading)",
      run.trajectory.size(), mapper.options().stereo.sad.num_disparities,
      mapper.options().depth.max_depth_m, 1000.0 * frames / run.frame_ms,
      1000.0 * frames / run.wall_ms));
  const CellRect& bounds = mapper.ground().bounds();
  output.line(fmt::format("map: {:.1f} x {:.1f} m, {} explored in cells of {:g} m",
                          bounds.columns() * cell, bounds.rows() * cell,
                          number_text(run.explored_cells * cell * cell, "m2"), cell));
  output.values["plan"] = json_of(run.plan);
  output.line(summary_of(run.plan));
}

int run_map(const MapArguments& arguments) {
  MapSettings settings;
  if (Status s = apply_settings(arguments.common, describe(settings)); !s) {
    return print_error(s.error());
  }
  settings.plan.unexplored_cost = settings.map.cost.unexplored_cost;
  if (Status s = check_options(settings); !s) return print_error(s.error());
  for (const std::vector<double>* place : {&arguments.start, &arguments.goal}) {
    for (double coordinate : *place) {
      if (std::isfinite(coordinate)) continue;
      return print_error({ErrorCode::kBadValue, "a coordinate is not finite", "--start, --goal",
                          "Give metres in the frame of the map"});
    }
  }
  if (!arguments.common.output.empty()) {  // before the work, not after it
    if (Status s = make_output_folder(arguments.common.output); !s) return print_error(s.error());
  }
  const auto source = open_stereo_source(arguments.source, {arguments.rig, arguments.poses});
  if (!source) return print_error(source.error());
  auto mapper = RoverMapper::make((*source)->rig(), settings.map);
  if (!mapper) return print_error(mapper.error());

  MapRun run;
  const Context context{arguments.common.threads, &run.timings};
  Output output(arguments.common.json);
  output.values["command"] = "map";
  output.line(fmt::format("{}: {} frames", (*source)->kind(), (*source)->frame_count()));
  if (Status s = map_frames(**source, *mapper, context, arguments.common, run); !s) {
    return print_error(s.error());
  }
  auto layers = mapper->layers();
  if (!layers) return print_error(layers.error());
  run.layers = std::move(*layers);
  run.layers.numbers["lethal_cost"] = settings.plan.lethal_cost;
  for (float e : run.layers.find("explored")->grid.values)
    run.explored_cells += e > 0.0F ? 1.0 : 0.0;
  if (arguments.features) add_feature_layers(context, run.layers);
  choose_ends(arguments, *mapper, run);
  run.plan =
      plan_waypoints(run.layers.find("cost")->grid, run.start, run.goal, settings.plan, context);
  summarise(*mapper, run, output);
  output.values["timings"] = json_of(run.timings);
  if (!arguments.common.output.empty()) {
    if (Status s = write_results(arguments, settings, **source, *mapper, run, output); !s) {
      return print_error(s.error());
    }
  }
  for (const Error& problem : run.problems) {
    output.values["problems"].push_back(problem.message());
  }
  for (const Error& problem : distinct_problems(run.problems)) print_error(problem);
  output.print_json();
  // What could be mapped was; that not all could is not silent.
  return run.problems.empty() ? 0 : 1;
}

}  // namespace

void add_map_command(CLI::App& app, int& status, const std::string& command_line) {
  CLI::App* command =
      app.add_subcommand("map", "Maps of the ground from a drive, and the way to a goal");
  auto arguments = std::make_shared<MapArguments>();
  arguments->command_line = command_line;
  command
      ->add_option("SOURCE", arguments->source,
                   "KITTI odometry folder, or folder of left and right images with a rig")
      ->required();
  command->add_option("--rig", arguments->rig, "Calibration, if the folder brings none")
      ->type_name("RIG");
  command
      ->add_option("--poses", arguments->poses,
                   "Trajectory of the left camera: TUM (world with z up) or KITTI")
      ->type_name("FILE");
  command->add_option("--start", arguments->start, "Start of the plan, m; default: first pose")
      ->type_name("X Y")
      ->expected(2);
  command
      ->add_option("--goal", arguments->goal,
                   "Goal of the plan, m; default: ahead of the last pose, beyond the map")
      ->type_name("X Y")
      ->expected(2);
  command->add_flag("--features", arguments->features,
                    "Also layers slope, step, roughness and traversability");
  add_common_options(*command, arguments->common);
  add_setting_options(*command, arguments->common);
  command->footer(
      "Example:\n  tread map kitti/sequences/00 -o out/drive\n"
      "Writes map.yaml with one GeoTIFF a layer, a map for Nav2's map server,\n"
      "trajectory.tum, path.csv, pictures and report.html. Frames that cannot be used\n"
      "are named, and what the others gave is written.");
  command->callback([arguments, &status] { status = run_map(*arguments); });
}

}  // namespace tread
