// tread plan: waypoints on a map that was saved before.
#include <fmt/format.h>

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

int run_plan(const PlanArguments& arguments) {
  const auto map = load_map(arguments.map);
  if (!map) return print_error(map.error());
  const auto cost = cost_of(*map, arguments.map);
  if (!cost) return print_error(cost.error());

  PlannerOptions options;
  if (const auto known = map->numbers.find("unexplored_cost"); known != map->numbers.end()) {
    options.unexplored_cost = known->second;
  }
  if (const auto known = map->numbers.find("lethal_cost"); known != map->numbers.end()) {
    options.lethal_cost = known->second;
  }
  if (Status s = apply_settings(arguments.common, describe(options)); !s) {
    return print_error(s.error());
  }
  const Eigen::Vector2d start(arguments.start[0], arguments.start[1]);
  const Eigen::Vector2d goal(arguments.goal[0], arguments.goal[1]);
  if (!start.allFinite() || !goal.allFinite()) {
    return print_error({ErrorCode::kBadValue, "a coordinate is not finite", "--start, --goal",
                        "Give metres in the frame of the map"});
  }
  const Plan plan = plan_waypoints(*cost, start, goal, options);

  Output output(arguments.common.json);
  output.values = json_of(plan);
  output.line(summary_of(plan));
  if (!arguments.common.output.empty()) {
    const fs::path folder = arguments.common.output;
    if (Status s = make_output_folder(folder); !s) return print_error(s.error());
    if (Status s = write_file(folder / "path.csv", path_csv(plan)); !s) {
      return print_error(s.error());
    }
    output.wrote(folder / "path.csv");
    const ColourScale scale = cost_scale(options);
    MapPicture picture = draw_map(*cost, scale);
    draw_scale_bar(picture);
    draw_plan(picture, plan, start, goal);
    if (Status s = write_png(folder / "plan.png", with_colour_bar(picture.image, scale)); !s) {
      return print_error(s.error());
    }
    output.wrote(folder / "plan.png");
    output.line("wrote " + folder.string() + ": path.csv, plan.png");
  }
  output.print_json();
  return 0;
}

}  // namespace

void add_plan_command(CLI::App& app, int& status) {
  CLI::App* command = app.add_subcommand("plan", "Waypoints from start to goal on a saved map");
  auto arguments = std::make_shared<PlanArguments>();
  command->add_option("MAP", arguments->map, "Folder of a map, or its map.yaml")->required();
  command->add_option("--start", arguments->start, "Where the robot is, m")
      ->type_name("X Y")
      ->expected(2)
      ->required();
  command->add_option("--goal", arguments->goal, "Where it should go, m; may lie beyond the map")
      ->type_name("X Y")
      ->expected(2)
      ->required();
  add_common_options(*command, arguments->common);
  add_setting_options(*command, arguments->common);
  command->footer(
      "Example:\n  tread plan out/map --start 0 0 --goal 30 2 -o out/plan\n"
      "That there is no path is an answer, with its reason, and not an error.\n"
      "Options for --set: lethal_cost, unexplored_cost, shortcut_tolerance.");
  command->callback([arguments, &status] { status = run_plan(*arguments); });
}

}  // namespace tread
