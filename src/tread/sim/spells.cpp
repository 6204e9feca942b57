#include "tread/sim/spells.hpp"

namespace tread {

Spells::Spells(double per_hour, double mean_s, const Random& random)
    : per_s_(per_hour / 3600.0), mean_s_(mean_s), random_(random), left_(random_.exponential()) {}

bool Spells::advance(double passed_s, double factor) {
  for (;;) {
    const double rate = there_ ? 1.0 / mean_s_ : factor * per_s_;
    const double used = passed_s * rate;
    if (!(used >= left_)) {
      left_ -= used;
      return there_;
    }
    passed_s -= left_ / rate;
    left_ = random_.exponential();
    there_ = !there_;
    if (there_) ++count_;
  }
}

}  // namespace tread
