// Ctrl-C ends the work, not the program: what was done so far is kept.
#pragma once

namespace tread {

// While one lives, the first interrupt (SIGINT) or request to end (SIGTERM) is noted; the second
// ends the program as always. One at a time.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;
  [[nodiscard]] static bool requested();
};

}  // namespace tread
