#include "command.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <iostream>

#include "tread/io/options_file.hpp"

namespace tread {

void add_common_options(CLI::App& command, CommonOptions& common) {
  command.add_option("-o,--output", common.output, "Write files into this folder")
      ->type_name("DIR");
  command.add_flag("--json", common.json, "Print one JSON object and nothing else");
  command.add_option("--threads", common.threads, "Threads to use; results do not depend on it")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
}

void add_setting_options(CLI::App& command, CommonOptions& common) {
  command.add_option("--config", common.config, "YAML file of options (docs/file-formats.md)")
      ->type_name("FILE");
  command.add_option("--set", common.settings, "Set one option, name=value; may be repeated")
      ->type_name("NAME=VALUE")
      ->allow_extra_args(false);
}

Status apply_settings(const CommonOptions& common, OptionSet options) {
  if (!common.config.empty()) {
    if (Status done = read_options(common.config, options); !done) return done;
  }
  for (const std::string& setting : common.settings) {
    const std::size_t equals = setting.find('=');
    if (equals == std::string::npos) {
      return fail(ErrorCode::kBadArgument, "no '=' in it", "--set " + setting,
                  "Write --set name=value");
    }
    if (Status done = options.set(setting.substr(0, equals), setting.substr(equals + 1)); !done) {
      done.error().where = "--set " + done.error().where;
      return done;
    }
  }
  return options.check();
}

Status make_output_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!error && std::filesystem::is_directory(folder, error)) return {};
  return fail(ErrorCode::kWriteFailed, "cannot make this folder: " + error.message(),
              folder.string(), "Give another one with -o");
}

void Output::line(const std::string& text) const {
  if (!json_) std::cout << text << '\n' << std::flush;
}

void Output::wrote(const std::filesystem::path& file) {
  values["files"].push_back(file.string());
}

void Output::print_json() const {
  if (json_) std::cout << values.dump(2) << '\n';
}

int print_error(const Error& error) {
  std::cerr << "tread: " << error.message() << '\n';
  return 1;
}

Progress::Progress(std::string label, int total, bool json)
    : label_(std::move(label)), total_(total), visible_(!json && isatty(STDERR_FILENO) != 0) {}

Progress::~Progress() {
  if (visible_) std::cerr << "\r\033[K" << std::flush;
}

void Progress::show(int done) {
  const auto now = std::chrono::steady_clock::now();
  if (!visible_ || total_ <= 0 || (now - last_ < std::chrono::milliseconds(50) && done < total_)) {
    return;
  }
  last_ = now;
  constexpr int kWidth = 30;
  const int filled = kWidth * done / total_;
  std::cerr << fmt::format("\r{} [{}{}] {}/{}\033[K", label_,
                           std::string(static_cast<std::size_t>(filled), '='),
                           std::string(static_cast<std::size_t>(kWidth - filled), ' '), done,
                           total_)
            << std::flush;
}

nlohmann::ordered_json json_of(const Timings& timings) {
  nlohmann::ordered_json stages = nlohmann::ordered_json::object();
  for (const auto& [path, entry] : timings.entries()) {
    stages[path] = {{"calls", entry.calls}, {"mean_ms", entry.mean_ms()}, {"max_ms", entry.max_ms}};
  }
  return stages;
}

nlohmann::ordered_json json_of(const Plan& plan) {
  nlohmann::ordered_json json = {{"status", to_string(plan.status)},
                                 {"reason", plan.reason},
                                 {"goal_beyond_map", plan.goal_beyond_map},
                                 {"length_m", plan.length_m},
                                 {"cost", plan.cost},
                                 {"expanded_cells", plan.expanded}};
  json["waypoints"] = nlohmann::ordered_json::array();
  for (const Eigen::Vector2d& p : plan.waypoints) json["waypoints"].push_back({p.x(), p.y()});
  return json;
}

std::string summary_of(const Plan& plan) {
  if (plan.status != PlanStatus::kFound) return "no path: " + plan.reason;
  return fmt::format(
      "path: {} waypoints, {:.1f} m, cost {:.1f}{}", plan.waypoints.size(), plan.length_m,
      plan.cost,
      plan.goal_beyond_map ? " (the goal lies beyond the map: straight from its edge)" : "");
}

std::string path_csv(const Plan& plan) {
  std::string text = "x_m,y_m\n";
  for (const Eigen::Vector2d& p : plan.waypoints)
    text += fmt::format("{:.4f},{:.4f}\n", p.x(), p.y());
  return text;
}

ColourScale cost_scale(const PlannerOptions& options) {
  ColourScale scale;
  scale.label = "cost";
  scale.palette = Palette::kCost;
  scale.low = 0.0F;
  scale.high = static_cast<float>(options.lethal_cost);
  scale.unknown_label = "unexplored";
  scale.lethal_from = static_cast<float>(options.lethal_cost);
  return scale;
}

void draw_plan(MapPicture& picture, const Plan& plan, const Eigen::Vector2d& start,
               const Eigen::Vector2d& goal) {
  if (plan.status == PlanStatus::kFound) {
    draw_path(picture, plan.waypoints);
    draw_waypoints(picture, plan.waypoints);
  }
  draw_start(picture, start);
  const bool has_last = plan.status == PlanStatus::kFound && plan.waypoints.size() > 1;
  draw_goal(picture, goal,
            has_last ? std::optional(plan.waypoints[plan.waypoints.size() - 2]) : std::nullopt);
}

std::string command_line(int argc, const char* const* argv) {
  std::string text = "tread";
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const bool plain =
        !word.empty() && word.find_first_of(" \t'\"\\$*?<>|&;()") == std::string::npos;
    text += plain ? " " + word : " '" + word + "'";
  }
  return text;
}

}  // namespace tread
