// What the commands share: common options, errors, progress on a terminal, settings.
#pragma once

#include <array>
#include <chrono>
#include <exception>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pictures.hpp"
#include "tread/core/options.hpp"
#include "tread/core/result.hpp"
#include "tread/core/timer.hpp"
#include "tread/io/atomic_file.hpp"
#include "tread/plan/planner.hpp"

namespace CLI {
class App;
}

namespace tread {

struct CommonOptions {
  std::optional<std::string> output;  // -o
  bool json = false;                  // --json
  int threads = 2;                    // --threads
  std::string config;                 // --config
  std::vector<std::string> settings;  // --set name=value
  bool print_config = false;          // --print-config
  std::optional<std::string> method;  // --method
};
// -o, --json, --threads; with settings also --config, --set and --print-config, beside which
// nothing else is required.
void add_common_options(CLI::App& command, CommonOptions& common);
void add_setting_options(CLI::App& command, CommonOptions& common);
// --method, for the commands that match images.
void add_method_option(CLI::App& command, CommonOptions& common);

// An option of its own for what --set could give: --method sgm for --set stereo.method=sgm.
struct Shorthand {
  std::string option;  // "--method"
  std::string name;    // "stereo.method"
  std::string value;
};

// Reads --config and then --set, --method and the shorthands into the described options, and checks
// them. Afterwards options.given() tells what the user gave.
[[nodiscard]] Status apply_settings(const CommonOptions& common, OptionSet& options,
                                    std::vector<Shorthand> shorthands = {});
// What --print-config prints: a file for --config that gives these options again.
void print_config(const std::string& command, const OptionSet& options);

// "1 frame", "30 frames"
[[nodiscard]] std::string frames_text(std::size_t count);

// A place of the command line: finite, and on this earth.
[[nodiscard]] Status check_place(const std::string& option, const std::vector<double>& place);

// Before the work: makes the folder of -o, if one is given, and tries to write into it.
[[nodiscard]] Status prepare_output(const CommonOptions& common);

// Writes one file of a set; `write(path)` does it. Errors name the file and not its temporary name.
template <class Write>
[[nodiscard]] Status add_file(FileSet& set, const std::string& name, const Write& write) {
  Status done = write(set.add(name));
  if (!done) done.error().where = (set.folder() / name).string();
  return done;
}
// A folder in which all files of `always` are is known as one that the same command wrote before:
// the files of `sometimes` that it wrote and this run does not go with the commit.
void remove_earlier(FileSet& set, std::span<const char* const> always,
                    std::span<const char* const> sometimes);

// Collects what a command says: lines for people, or with --json one object at the end.
class Output {
 public:
  explicit Output(bool json) : json_(json) {}
  nlohmann::ordered_json values;  // what --json prints
  void line(const std::string& text) const;
  // Commits the set and says what is in the folder now.
  [[nodiscard]] Status commit(FileSet& set);
  void print_json() const;

 private:
  bool json_;
};

// "tread: ..." on standard error; gives the exit status.
int print_error(const Error& error);
// The same for what was thrown: people are told what it means for them, without the inner words of
// libraries.
int print_exception(const std::exception& error);
// How many of the frames could not be used, and the first ones of the reasons.
int print_problems(const std::vector<Error>& problems, std::size_t unused, std::size_t frames);

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

// The names of the commands, for messages.
inline constexpr std::array<const char*, 6> kCommands = {"depth", "slam",     "map",
                                                         "plan",  "simulate", "info"};
// The whole program: parses, runs, gives the exit status. 0: the work was done; 1: it was not; 2:
// the command line was wrong.
int run_program(int argc, const char* const* argv, const std::string& version);

// Each adds its command; running it sets the exit status.
void add_depth_command(CLI::App& app, int& status, const std::string& command_line);
void add_slam_command(CLI::App& app, int& status, const std::string& command_line);
void add_map_command(CLI::App& app, int& status, const std::string& command_line);
void add_plan_command(CLI::App& app, int& status);
void add_simulate_command(CLI::App& app, int& status, const std::string& command_line);
void add_info_command(CLI::App& app, int& status);

}  // namespace tread
