// Something that comes and goes without memory: begins so many times an hour while it is away, and
// stays for an exponentially distributed time (a two-state Markov process in continuous time).
#pragma once

#include <cstdint>

#include "tread/sim/random.hpp"

namespace tread {

class Spells {
 public:
  // Begins away.
  Spells(double per_hour, double mean_s, const Random& random);

  // Lets time go by, in which it begins `factor` times as often. True if it is there at the end.
  bool advance(double passed_s, double factor = 1.0);
  [[nodiscard]] bool there() const { return there_; }
  // How often it has begun.
  [[nodiscard]] std::int64_t count() const { return count_; }

 private:
  double per_s_;
  double mean_s_;
  Random random_;
  double left_;  // until it changes, in mean times
  bool there_ = false;
  std::int64_t count_ = 0;
};

}  // namespace tread
