#include "interrupt.hpp"

#include <csignal>

namespace tread {
namespace {

// The only thing that a signal may touch.
volatile std::sig_atomic_t g_requested = 0;

void note(int signal) {
  g_requested = 1;
  std::signal(signal, SIG_DFL);
}

}  // namespace

Interrupt::Interrupt() {
  g_requested = 0;
  std::signal(SIGINT, note);
  std::signal(SIGTERM, note);
}

Interrupt::~Interrupt() {
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
}

bool Interrupt::requested() {
  return g_requested != 0;
}

}  // namespace tread
