// The command line program: see `tread --help`.
#include <CLI/CLI.hpp>
#include <exception>
#include <iostream>
#include <new>

#include "command.hpp"

int main(int argc, char** argv) {
  CLI::App app("tread: from stereo images to the ground a robot can cross, and the way across it",
               "tread");
  app.require_subcommand(1);
  app.set_version_flag("--version", TREAD_VERSION);
  int status = 0;
  const std::string line = tread::command_line(argc, argv);
  tread::add_depth_command(app, status, line);
  tread::add_map_command(app, status, line);
  tread::add_plan_command(app, status);
  tread::add_info_command(app, status);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error);
  } catch (const std::bad_alloc&) {
    std::cerr << "tread: there is not enough memory. Use larger cells (local.resolution_m), a "
                 "smaller map, or a machine with more.\n";
    return 1;
  } catch (const std::exception& error) {  // a full disk: say so, do not abort
    std::cerr << "tread: " << error.what() << '\n';
    return 1;
  }
  return status;
}
