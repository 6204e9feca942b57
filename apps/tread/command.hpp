// What the commands share: common options, errors, progress on a terminal, settings.
#pragma once

#include <CLI/CLI.hpp>
#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "pictures.hpp"
#include "tread/core/options.hpp"
#include "tread/core/result.hpp"
#include "tread/core/timer.hpp"
#include "tread/plan/planner.hpp"

namespace tread {

struct CommonOptions {
  std::string output;                 // -o
  bool json = false;                  // --json
  int threads = 2;                    // --threads
  std::string config;                 // --config
  std::vector<std::string> settings;  // --set name=value
};
// -o, --json, --threads; with settings also --config and --set.
void add_common_options(CLI::App& command, CommonOptions& common);
void add_setting_options(CLI::App& command, CommonOptions& common);

// Reads --config and then --set into the described options, and checks them.
[[nodiscard]] Status apply_settings(const CommonOptions& common, OptionSet options);

// The folder of -o, made if it is not there.
[[nodiscard]] Status make_output_folder(const std::filesystem::path& folder);

// Collects what a command says: lines for people, or with --json one object at the end.
class Output {
 public:
  explicit Output(bool json) : json_(json) {}
  nlohmann::ordered_json values;  // what --json prints
  void line(const std::string& text) const;
  void wrote(const std::filesystem::path& file);
  void print_json() const;

 private:
  bool json_;
};

// "tread: ..." on standard error; gives the exit status.
int print_error(const Error& error);

// A bar on standard error, if that is a terminal and there is no --json.
class Progress {
 public:
  Progress(std::string label, int total, bool json);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  void show(int done);

 private:
  std::string label_;
  int total_;
  bool visible_;
  std::chrono::steady_clock::time_point last_;
};

[[nodiscard]] nlohmann::ordered_json json_of(const Timings& timings);
[[nodiscard]] nlohmann::ordered_json json_of(const Plan& plan);
// "12 waypoints, 48.2 m, ..." or why there is none.
[[nodiscard]] std::string summary_of(const Plan& plan);
[[nodiscard]] std::string path_csv(const Plan& plan);
// The scale of cost pictures.
[[nodiscard]] ColourScale cost_scale(const PlannerOptions& options);
void draw_plan(MapPicture& picture, const Plan& plan, const Eigen::Vector2d& start,
               const Eigen::Vector2d& goal);
// The command line as it was given, for the report.
[[nodiscard]] std::string command_line(int argc, const char* const* argv);

// Each adds its command; running it sets the exit status.
void add_depth_command(CLI::App& app, int& status, const std::string& command_line);
void add_map_command(CLI::App& app, int& status, const std::string& command_line);
void add_plan_command(CLI::App& app, int& status);
void add_info_command(CLI::App& app, int& status);

}  // namespace tread
