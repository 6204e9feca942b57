// tread map: a drive of stereo frames to the maps of the ground, and the way to a goal. Frames that
// come without poses are placed by visual odometry.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <array>
#include <cmath>

#include "command.hpp"
#include "interrupt.hpp"
#include "map_report.hpp"
#include "open_pairs.hpp"
#include "tread/core/problems.hpp"
#include "tread/io/atomic_file.hpp"
#include "tread/io/image_file.hpp"
#include "tread/io/map_files.hpp"
#include "tread/io/source.hpp"
#include "tread/io/trajectory_file.hpp"
#include "tread/pipeline/odometry_source.hpp"
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
  ImageReading images;
  RoverMapOptions map;
  PlannerOptions plan;
};

constexpr const char* kPlanUnexplored = "plan.unexplored_cost";

OptionSet describe(MapSettings& settings) {
  OptionSet set = describe(settings.map);
  set.add_group("images", describe(settings.images));
  set.add_group("plan", describe(settings.plan));
  return set;
}

Status choose_settings(const CommonOptions& common, MapSettings& settings, OptionSet& options) {
  if (Status applied = apply_settings(common, options); !applied) return applied;
  // The plan charges unknown ground as the cost map does, unless the user wants it otherwise.
  if (!options.given(kPlanUnexplored)) {
    settings.plan.unexplored_cost = settings.map.cost.unexplored_cost;
  }
  return check_options(settings);
}

// Takes all frames in. What goes wrong with one frame is kept and the next one is tried.
void map_frames(StereoSource& source, RoverMapper& mapper, const Context& context,
                const CommonOptions& common, MapRun& run) {
  Progress progress("mapping", source.frame_count(), common.json);
  const bool single = source.frame_count() == 1 && !source.has_poses();
  const int kept = source.frame_count() / 2;  // the frame that the report shows
  run.problems = source.problems();
  const Interrupt interrupt;
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0;; ++i) {
    progress.show(i);
    if (Interrupt::requested()) {
      run.problems.push_back(
          {ErrorCode::kInterrupted,
           fmt::format("interrupted after {} of {}", i,
                       frames_text(static_cast<std::size_t>(source.frame_count()))),
           "map", "What was mapped until then is here"});
      break;
    }
    auto frame = source.next();
    if (!frame) {
      ++run.frames;
      run.problems.push_back(frame.error());
      if (i > 2 * source.frame_count() + 10) break;  // a source that never ends
      continue;
    }
    if (!*frame) break;
    ++run.frames;
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
    if (i <= kept) run.sample = sample_of(**frame, *mapped, mapper);
  }
  run.wall_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
}

Error nothing_mapped(const MapArguments& arguments, const MapRun& run) {
  return {ErrorCode::kBadValue,
          fmt::format("no ground was mapped from {}", frames_text(run.trajectory.size())),
          arguments.source,
          fmt::format("Likely nothing was matched, the rig, its mount or the poses are wrong, "
                      "depth.max_depth_m and local.max_height_m leave nothing, or the cells "
                      "(local.resolution_m) are too small for the points: see the stages of a "
                      "frame in report.html{}",
                      arguments.common.output ? "" : " (-o DIR)")};
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

// What the run of a drive that gave no map does not write, and one that gave a map did.
void remove_earlier_map(FileSet& set) {
  constexpr std::array<const char*, 3> kAlways = {"trajectory.tum", "path.csv", "report.html"};
  constexpr std::array<const char*, 4> kPictures = {"picture_height.png", "picture_derivative.png",
                                                    "picture_explored.png", "picture_cost.png"};
  remove_earlier(set, kAlways, kPictures);
  remove_map(set);
}

Status write_results(const MapArguments& arguments, const MapSettings& settings,
                     const StereoSource& source, const RoverMapper& mapper, const MapRun& run,
                     Output& output) {
  FileSet set(*arguments.common.output);
  const std::vector<MapFigure> figures = map_figures(run, settings.plan);
  if (figures.empty()) {
    remove_earlier_map(set);
  } else if (Status s = add_map(run.layers, set); !s) {
    return s;
  }
  const auto add = [&](const std::string& name, const auto& write) {
    return add_file(set, name, write);
  };
  Status s = add("trajectory.tum",
                 [&](const fs::path& path) { return write_tum_trajectory(path, run.trajectory); });
  if (s) s = add("path.csv", [&](const fs::path& p) { return write_file(p, path_csv(run.plan)); });
  for (const MapFigure& figure : figures) {
    if (!s) return s;
    const Image<Rgb> picture = with_colour_bar(figure.picture.image, figure.scale);
    s = add("picture_" + figure.name + ".png",
            [&](const fs::path& path) { return write_png(path, picture); });
  }
  const Report report = map_report(arguments.command_line, source, mapper, settings.plan, run);
  if (s) s = add("report.html", [&](const fs::path& path) { return report.write(path); });
  return s ? output.commit(set) : s;
}

void summarise(const RoverMapper& mapper, const MapRun& run, Output& output) {
  const double frames = static_cast<double>(run.trajectory.size());
  const double cell = mapper.ground().resolution_m();
  output.values["frames"] = run.trajectory.size();
  output.values["frames_failed"] = run.frames - run.trajectory.size();
  output.values["range_m"] = mapper.options().depth.max_depth_m;
  output.values["num_disparities"] = mapper.options().stereo.sad.num_disparities;
  output.values["explored_m2"] = run.explored_cells * cell * cell;
  output.values["mean_frame_ms"] = run.frame_ms / frames;
  output.values["frames_per_second"] = 1000.0 * frames / run.frame_ms;
  output.values["frames_per_second_with_reading"] = 1000.0 * frames / run.wall_ms;
  output.line(fmt::format(
      "{}, {} disparities, range {:.1f} m: {:.1f} frames per second ({:.1f} with reading)",
      frames_text(run.trajectory.size()), mapper.options().stereo.sad.num_disparities,
      mapper.options().depth.max_depth_m, 1000.0 * frames / run.frame_ms,
      1000.0 * frames / run.wall_ms));
  const CellRect& bounds = mapper.ground().bounds();
  output.line(fmt::format("map: {:.1f} x {:.1f} m, {} explored in cells of {:g} m",
                          bounds.columns() * cell, bounds.rows() * cell,
                          number_text(run.explored_cells * cell * cell, "m2"), cell));
  output.values["plan"] = json_of(run.plan);
  if (!run.nothing) output.line(summary_of(run.plan));
}

// Layers and plan of the frames taken in.
Status finish_map(const MapArguments& arguments, const MapSettings& settings,
                  const RoverMapper& mapper, const Context& context, MapRun& run) {
  auto layers = mapper.layers();
  if (!layers) return forward(layers);
  run.layers = std::move(*layers);
  run.layers.numbers["lethal_cost"] = settings.plan.lethal_cost;
  run.layers.numbers["unexplored_cost"] = settings.plan.unexplored_cost;
  for (float e : run.layers.find("explored")->grid.values) {
    run.explored_cells += e > 0.0F ? 1.0 : 0.0;
  }
  choose_ends(arguments, mapper, run);
  if (run.explored_cells == 0.0) {
    run.nothing = nothing_mapped(arguments, run);
    run.plan.reason = "no ground was mapped";
    return {};
  }
  if (arguments.features) add_feature_layers(context, run.layers);
  run.plan =
      plan_waypoints(run.layers.find("cost")->grid, run.start, run.goal, settings.plan, context);
  return {};
}

// Each kind of problem, since there is no map beside which the first ones would do.
int print_all_failed(const MapRun& run) {
  for (const Error& problem : distinct_problems(run.problems)) print_error(problem);
  return print_error({ErrorCode::kBadValue,
                      fmt::format("none of {} could be mapped", frames_text(run.frames)), "map",
                      "Mend what is said above"});
}

// What is wrong is said at the end, below what was done.
int report_problems(const MapRun& run, Output& output) {
  if (run.nothing) output.values["problems"].push_back(run.nothing->message());
  for (const Error& problem : run.problems) {
    output.values["problems"].push_back(problem.message());
  }
  output.print_json();
  // What could be mapped was; that not all could is not silent.
  int status = print_problems(run.problems, run.frames - run.trajectory.size(), run.frames);
  if (run.nothing) status = print_error(*run.nothing);
  return status;
}

int run_map(const MapArguments& arguments) {
  MapSettings settings;
  OptionSet options = describe(settings);
  if (Status s = choose_settings(arguments.common, settings, options); !s) {
    return print_error(s.error());
  }
  if (arguments.common.print_config) {
    print_config("map", options);
    return 0;
  }
  for (const auto& [option, place] :
       {std::pair{"--start", &arguments.start}, std::pair{"--goal", &arguments.goal}}) {
    if (Status s = check_place(option, *place); !s) return print_error(s.error());
  }
  MapRun run;
  const Context context{arguments.common.threads, &run.timings};
  auto source =
      open_pairs(arguments.source, {arguments.rig, arguments.poses, settings.images}, context);
  if (source && !(*source)->has_poses() && (*source)->frame_count() > 1) {
    source = with_odometry(std::move(*source), {}, context);
  }
  if (!source) return print_error(source.error());
  auto mapper = RoverMapper::make((*source)->rig(), settings.map);
  if (!mapper) return print_error(mapper.error());
  if (Status s = prepare_output(arguments.common); !s) return print_error(s.error());

  Output output(arguments.common.json);
  output.values["command"] = "map";
  output.line(fmt::format("{}: {}", (*source)->kind(),
                          frames_text(static_cast<std::size_t>((*source)->frame_count()))));
  map_frames(**source, *mapper, context, arguments.common, run);
  if (run.trajectory.empty() && run.problems.empty()) {
    return print_error({ErrorCode::kNotFound, "there are no frames", arguments.source,
                        "Give a folder with images"});
  }
  if (run.trajectory.empty()) return print_all_failed(run);
  if (Status s = finish_map(arguments, settings, *mapper, context, run); !s) {
    return print_error(s.error());
  }
  summarise(*mapper, run, output);
  output.values["timings"] = json_of(run.timings);
  if (arguments.common.output) {
    if (Status s = write_results(arguments, settings, **source, *mapper, run, output); !s) {
      return print_error(s.error());
    }
  }
  return report_problems(run, output);
}

}  // namespace

void add_map_command(CLI::App& app, int& status, const std::string& command_line) {
  CLI::App* command =
      app.add_subcommand("map", "Maps of the ground from a drive, and the way to a goal");
  auto arguments = std::make_shared<MapArguments>();
  arguments->command_line = command_line;
  command
      ->add_option("SOURCE", arguments->source,
                   "KITTI odometry folder (.../sequences/00), or a folder with left/ and right/ "
                   "images and a rig; 'tread info SOURCE' tells what is in it")
      ->type_name("")
      ->required();
  command->add_option("--rig", arguments->rig, "Calibration file, if the folder brings none")
      ->type_name("RIG");
  command
      ->add_option("--poses", arguments->poses,
                   "Where the left camera was, if the folder does not say: TUM (world with z up) "
                   "or KITTI format")
      ->type_name("FILE");
  command
      ->add_option("--start", arguments->start,
                   "Start of the plan, m in the world of the poses; default: the first pose")
      ->option_text("X Y")
      ->expected(2);
  command
      ->add_option("--goal", arguments->goal,
                   "Goal of the plan, m; default: ahead of the last pose, beyond the map")
      ->option_text("X Y")
      ->expected(2);
  command->add_flag("--features", arguments->features,
                    "Also layers slope, step, roughness and traversability (1 good, 0 bad)");
  add_method_option(*command, arguments->common);
  add_common_options(*command, arguments->common);
  add_setting_options(*command, arguments->common);
  command->footer(
      "Examples:\n"
      "  tread map kitti/sequences/00 -o out/drive\n"
      "  tread map drive --set cost.window_m=0.8 --goal 20 0 -o out/drive\n"
      "  tread map --print-config > options.yaml\n"
      "Writes map.yaml with one GeoTIFF a layer, a map for Nav2's map server,\n"
      "trajectory.tum, path.csv, pictures and report.html. Files of an earlier run there\n"
      "are replaced. Frames that cannot be used are named, what the others gave is\n"
      "written, and the exit status is 1.");
  command->callback([arguments, &status] { status = run_map(*arguments); });
}

}  // namespace tread
