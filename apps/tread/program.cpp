// Parsing of the command line, and what is said where it is wrong.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>

#include "command.hpp"

namespace tread {
namespace {

int wrong_usage(const std::string& what, const std::string& command) {
  std::cerr << fmt::format("tread: {}{} See '{} --help'.\n", what,
                           what.ends_with('.') || what.ends_with('?') ? "" : ".", command);
  return 2;
}

// The first word that is no option, if it is not a command.
std::optional<std::string> unknown_command(int argc, const char* const* argv) {
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word.starts_with('-')) continue;
    if (std::find(kCommands.begin(), kCommands.end(), word) != kCommands.end()) return std::nullopt;
    return word;
  }
  return std::nullopt;
}

// A value that is empty is a variable of a shell that was not set. For CLI11: what is wrong.
std::string not_empty(const std::string& value) {
  return value.empty() ? "the value is empty" : "";
}

// CLI11's words, and for an unknown option the one that may have been meant.
std::string words_of(const CLI::ParseError& error, const CLI::App& command) {
  std::string what = error.what();
  for (const std::string& word : command.remaining()) {
    if (!word.starts_with("--")) continue;
    std::vector<std::string> names;
    for (const CLI::Option* option : command.get_options()) {
      for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    }
    const std::string name = word.substr(0, word.find('='));
    const std::string near = nearest_name(name, names);
    return fmt::format("there is no option {}{}", name,
                       near.empty() ? "" : ". Did you mean " + near + "?");
  }
  return what;
}

// Broken into lines that fit beside the names of the options on 80 to 100 columns.
std::string wrapped(const std::string& text) {
  constexpr std::size_t kWidth = 64;
  std::string out;
  std::size_t column = 0;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find(' ', at), text.size());
    const std::string word = text.substr(at, end - at);
    const bool breaks = column > 0 && column + 1 + word.size() > kWidth;
    if (column > 0) out += breaks ? '\n' : ' ';
    column = breaks ? word.size() : column + word.size() + (column > 0 ? 1 : 0);
    out += word;
    at = end + 1;
  }
  return out;
}

}  // namespace

int run_program(int argc, const char* const* argv, const std::string& version) {
  CLI::App app("tread: from stereo images to the ground a robot can cross, and the way across it",
               "tread");
  app.require_subcommand(1);
  app.set_version_flag("--version", version);
  app.footer(
      "'tread COMMAND --help' tells more of each. Exit status: 0 the work was done, 1 it was not,\n"
      "2 the command line was wrong.");
  int status = 0;
  const std::string line = command_line(argc, argv);
  add_depth_command(app, status, line);
  add_slam_command(app, status, line);
  add_map_command(app, status, line);
  add_plan_command(app, status);
  add_simulate_command(app, status, line);
  add_info_command(app, status);
  for (CLI::App* command : app.get_subcommands({})) {
    for (CLI::Option* option : command->get_options()) {
      option->description(wrapped(option->get_description()));
      option->check(CLI::Validator(not_empty, ""));
    }
  }
  const std::string commands = fmt::format("{}", fmt::join(kCommands, ", "));
  if (argc < 2) return wrong_usage("no command. Commands are: " + commands, "tread");
  if (const auto word = unknown_command(argc, argv)) {
    const std::string near = nearest_name(*word, {kCommands.begin(), kCommands.end()});
    return wrong_usage(fmt::format("'{}' is not a command.{} Commands are: {}", *word,
                                   near.empty() ? "" : " Did you mean '" + near + "'?", commands),
                       "tread");
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // help or version
    const auto parsed = app.get_subcommands();
    const CLI::App& command = parsed.empty() ? app : *parsed.front();
    return wrong_usage(words_of(error, command),
                       parsed.empty() ? "tread" : "tread " + command.get_name());
  } catch (const std::exception& error) {  // out of memory, say: an answer, no abort
    return print_exception(error);
  }
  return status;
}

}  // namespace tread
