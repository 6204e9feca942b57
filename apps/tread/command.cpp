#include "command.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <iostream>
#include <new>

#include "tread/io/options_file.hpp"

namespace tread {

void add_common_options(CLI::App& command, CommonOptions& common) {
  command.add_option("-o,--output", common.output, "Write the results into this folder")
      ->type_name("DIR");
  command.add_flag("--json", common.json, "Print one JSON object and nothing else");
  command
      .add_option("--threads", common.threads, "Threads to use, 1 to 256; the results are equal")
      ->type_name("N")
      ->check(CLI::Range(1, 256).description(""))
      ->capture_default_str();
}

void add_setting_options(CLI::App& command, CommonOptions& common) {
  command.add_option("--config", common.config, "YAML file of options; --print-config prints one")
      ->type_name("FILE");
  command
      .add_option("--set", common.settings, "Set one option; wins over --config; may be repeated")
      ->type_name("NAME=VALUE")
      ->allow_extra_args(false);
  command
      .add_flag_callback(
          "--print-config",
          [&command, &common] {
            common.print_config = true;
            for (CLI::Option* option : command.get_options()) option->required(false);
          },
          "Print all options with their values, meanings and ranges as YAML, and do nothing else")
      ->trigger_on_parse();
}

void add_method_option(CLI::App& command, CommonOptions& common) {
  command
      .add_option("--method", common.method,
                  "How pixels are matched: sad (block matching, the fastest; the default) or sgm "
                  "(semi-global matching: more pixels where texture is poor, about three times the "
                  "time). Short for --set stereo.method=NAME")
      ->type_name("NAME")
      ->check(CLI::IsMember({"sad", "sgm"}).description(""));
}

namespace {

Status apply_shorthand(const CommonOptions& common, const Shorthand& shorthand,
                       OptionSet& options) {
  for (const std::string& other : common.settings) {
    if (!other.starts_with(shorthand.name + "=")) continue;
    return fail(ErrorCode::kBadArgument, "it is also given by --set " + other, shorthand.option,
                "Give one of them");
  }
  return options.set(shorthand.name, shorthand.value);
}

}  // namespace

Status apply_settings(const CommonOptions& common, OptionSet& options,
                      std::vector<Shorthand> shorthands) {
  if (!common.config.empty()) {
    if (Status done = read_options(common.config, options); !done) return done;
  }
  for (const std::string& setting : common.settings) {
    const std::size_t equals = setting.find('=');
    if (equals == std::string::npos || equals == 0) {
      return fail(ErrorCode::kBadArgument, equals == 0 ? "no name before the '='" : "no '=' in it",
                  "--set " + setting, "Write --set name=value");
    }
    if (Status done = options.set(setting.substr(0, equals), setting.substr(equals + 1)); !done) {
      done.error().where = "--set " + done.error().where;
      return done;
    }
  }
  if (common.method) shorthands.push_back({"--method", "stereo.method", *common.method});
  for (const Shorthand& shorthand : shorthands) {
    if (Status done = apply_shorthand(common, shorthand, options); !done) return done;
  }
  options.settle();
  return options.check();
}

void print_config(const std::string& command, const OptionSet& options) {
  std::cout << "# Options of 'tread " << command << "', for --config.\n"
            << options_as_yaml(options);
}

std::string frames_text(std::size_t count) {
  return fmt::format("{} frame{}", count, count == 1 ? "" : "s");
}

Status check_place(const std::string& option, const std::vector<double>& place) {
  constexpr double kFarthest_m = 1e7;  // from the equator to a pole
  for (const double coordinate : place) {
    const bool finite = std::isfinite(coordinate);
    if (finite && std::abs(coordinate) <= kFarthest_m) continue;
    return fail(ErrorCode::kBadValue,
                finite ? fmt::format("a coordinate of {:g} m is not on this earth", coordinate)
                       : "a coordinate is not finite",
                option, "Give metres in the frame of the map, x ahead and y left of its origin");
  }
  return {};
}

Status prepare_output(const CommonOptions& common) {
  if (!common.output) return {};
  const std::filesystem::path folder = *common.output;
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder, error)) {
    return fail(ErrorCode::kWriteFailed,
                "cannot make this folder: " + (error ? error.message() : "it is a file"),
                folder.string(), "Give another one with -o");
  }
  if (Status finished = FileSet::finish_interrupted(folder); !finished) return finished;
  FileSet probe(folder);  // removed again: only a try tells what permissions and mounts allow
  if (Status written = write_file(probe.add("probe"), ""); !written) {
    written.error().where = folder.string();
    written.error().remedy = "Check its permissions, or give another folder with -o";
    return written;
  }
  return {};
}

void remove_earlier(FileSet& set, std::span<const char* const> always,
                    std::span<const char* const> sometimes) {
  const auto is_there = [&](const char* name) {
    std::error_code ignored;
    return std::filesystem::is_regular_file(set.folder() / name, ignored);
  };
  if (!std::all_of(always.begin(), always.end(), is_there)) return;
  for (const char* name : sometimes) {
    const std::vector<std::string>& made = set.names();
    const bool made_now = std::find(made.begin(), made.end(), name) != made.end();
    if (!made_now && is_there(name)) set.remove(name);
  }
}

void Output::line(const std::string& text) const {
  if (!json_) std::cout << text << '\n' << std::flush;
}

Status Output::commit(FileSet& set) {
  const std::vector<std::string> names = set.names();
  if (Status done = set.commit(); !done) return done;
  for (const std::string& name : names) values["files"].push_back((set.folder() / name).string());
  line(fmt::format("wrote {}: {}", set.folder().string(), fmt::join(names, ", ")));
  return {};
}

void Output::print_json() const {
  if (json_) std::cout << values.dump(2) << '\n';
}

int print_error(const Error& error) {
  std::cerr << "tread: " << error.message() << '\n';
  return 1;
}

int print_exception(const std::exception& error) {
  std::string text = error.what();
  const bool memory = dynamic_cast<const std::bad_alloc*>(&error) != nullptr ||
                      text.find("Insufficient memory") != std::string::npos;
  if (memory) {
    return print_error({ErrorCode::kUnsupported, "out of memory", "",
                        "Close other programs, match smaller images (--set shrink=2), or map "
                        "less (--set depth.max_depth_m=10) or coarser cells (--set "
                        "local.resolution_m=0.2)"});
  }
  // OpenCV: "OpenCV(4.6.0) file:line: error: (code) what in function 'f'"
  if (const std::size_t said = text.find("error: ");
      text.starts_with("OpenCV") && said != text.npos)
    text = text.substr(said + 7, text.find(" in function") - said - 7);
  return print_error({ErrorCode::kUnsupported,
                      "this should not happen: " + text.substr(0, text.find('\n')), "",
                      "Please report it with the command line and the input"});
}

int print_problems(const std::vector<Error>& problems, std::size_t unused, std::size_t frames) {
  if (problems.empty()) return 0;
  constexpr std::size_t kShown = 5;
  std::cerr << (unused > 0
                    ? fmt::format("tread: {} of {} frames could not be used\n", unused, frames)
                    : fmt::format("tread: all {} frames were used, but\n", frames));
  for (std::size_t i = 0; i < std::min(problems.size(), kShown); ++i) {
    std::cerr << "tread:   " << problems[i].message() << '\n';
  }
  if (problems.size() > kShown) {
    std::cerr << fmt::format("tread:   and {} more: --json lists them all\n",
                             problems.size() - kShown);
  }
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
