// The command line program: see `tread --help`.
#include "command.hpp"

int main(int argc, char** argv) {
  return tread::run_program(argc, argv, TREAD_VERSION);
}
