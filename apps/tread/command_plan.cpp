// tread plan: waypoints on a map that was saved before.
#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "command.hpp"
#include "tread/io/atomic_file.hpp"
#include "tread/io/image_file.hpp"
#include "tread/io/map_files.hpp"
#include "tread/terrain/cost_map.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;

struct PlanArguments {
  std::string map;
  std::vector<double> start, goal;
  CommonOptions common;
};

// The cost layer, computed from the derivative where the map has none.
Result<Grid<float>> cost_of(const MapLayers& map, const std::string& where) {
  if (const MapLayer* cost = map.find("cost")) return cost->grid;
  auto ground = GlobalMap::from_layers(map);
  if (!ground) {
    return fail(ErrorCode::kNotFound,
                "no layer 'cost', and none 'height' and 'derivative' to make it", where,
                "Give a map that 'tread map' has written");
  }
  if (!covers_ground({}, ground->resolution_m())) {
    return fail(ErrorCode::kUnsupported,
                fmt::format("its cells of {:g} m do not suit the cost map", ground->resolution_m()),
                where, "Give a map with a layer 'cost'");
  }
  CostMap cost({}, ground->resolution_m());
  cost.update(*ground, ground->take_changes());
  return cost.grid();
}

// What the map was made for.
void take_numbers(const MapLayers& map, PlannerOptions& options) {
  if (const auto known = map.numbers.find("unexplored_cost"); known != map.numbers.end()) {
    options.unexplored_cost = known->second;
  }
  if (const auto known = map.numbers.find("lethal_cost"); known != map.numbers.end()) {
    options.lethal_cost = known->second;
  }
}

Status write_results(const PlanArguments& arguments, const Grid<float>& cost,
                     const PlannerOptions& options, const Plan& plan, Output& output) {
  FileSet set(*arguments.common.output);
  Status s = add_file(set, "path.csv",
                      [&](const fs::path& path) { return write_file(path, path_csv(plan)); });
  if (!s) return s;
  const ColourScale scale = cost_scale(options);
  MapPicture picture = draw_map(cost, scale);
  draw_scale_bar(picture);
  draw_plan(picture, plan, {arguments.start[0], arguments.start[1]},
            {arguments.goal[0], arguments.goal[1]});
  const Image<Rgb> image = with_colour_bar(picture.image, scale);
  s = add_file(set, "plan.png", [&](const fs::path& path) { return write_png(path, image); });
  return s ? output.commit(set) : s;
}

int print_plan_config(const PlanArguments& arguments) {
  PlannerOptions options;
  if (!arguments.map.empty()) {
    const auto map = load_map(arguments.map);
    if (!map) return print_error(map.error());
    take_numbers(*map, options);
  }
  OptionSet set = describe(options);
  if (Status s = apply_settings(arguments.common, set); !s) return print_error(s.error());
  print_config("plan", set);
  return 0;
}

int run_plan(const PlanArguments& arguments) {
  if (arguments.common.print_config) return print_plan_config(arguments);
  const auto map = load_map(arguments.map);
  if (!map) return print_error(map.error());
  const auto cost = cost_of(*map, arguments.map);
  if (!cost) return print_error(cost.error());
  PlannerOptions options;
  take_numbers(*map, options);
  OptionSet set = describe(options);
  if (Status s = apply_settings(arguments.common, set); !s) return print_error(s.error());
  if (Status s = check_place("--start", arguments.start); !s) return print_error(s.error());
  if (Status s = check_place("--goal", arguments.goal); !s) return print_error(s.error());
  if (Status s = prepare_output(arguments.common); !s) return print_error(s.error());

  const Plan plan = plan_waypoints(*cost, {arguments.start[0], arguments.start[1]},
                                   {arguments.goal[0], arguments.goal[1]}, options);
  Output output(arguments.common.json);
  output.values = json_of(plan);
  output.line(summary_of(plan));
  if (arguments.common.output) {
    if (Status s = write_results(arguments, *cost, options, plan, output); !s) {
      return print_error(s.error());
    }
  }
  output.print_json();
  return 0;
}

}  // namespace

void add_plan_command(CLI::App& app, int& status) {
  CLI::App* command = app.add_subcommand("plan", "Waypoints from start to goal on a saved map");
  auto arguments = std::make_shared<PlanArguments>();
  command
      ->add_option("MAP", arguments->map, "Folder that 'tread map -o' has written, or its map.yaml")
      ->type_name("")
      ->required();
  command
      ->add_option("--start", arguments->start,
                   "Where the robot is, m in the frame of the map; must lie on it")
      ->option_text("X Y REQUIRED")
      ->expected(2)
      ->required();
  command->add_option("--goal", arguments->goal, "Where it should go, m; may lie beyond the map")
      ->option_text("X Y REQUIRED")
      ->expected(2)
      ->required();
  add_common_options(*command, arguments->common);
  add_setting_options(*command, arguments->common);
  command->footer(
      "Example:\n"
      "  tread plan out/map --start 0 0 --goal 30 2 -o out/plan\n"
      "'tread info MAP' tells where the map lies. Writes path.csv and plan.png. That there\n"
      "is no path is an answer, with its reason, and not an error (exit status 0).\n"
      "Options for --set: lethal_cost, unexplored_cost, shortcut_tolerance.");
  command->callback([arguments, &status] { status = run_plan(*arguments); });
}

}  // namespace tread
