// Steps of converters and encoders.
#pragma once

#include <cmath>

namespace tread {

// The nearest step; the value itself if the step is 0.
[[nodiscard]] inline double to_step(double value, double step) {
  return step > 0.0 ? step * std::round(value / step) : value;
}

// An incremental encoder: counts the marks that have gone by since the start, where it stood
// somewhere between two of them.
class Encoder {
 public:
  // `phase`: how far behind a mark it starts, 0 to below 1 of a step.
  Encoder(double step_rad, double phase) : step_rad_(step_rad), phase_(phase) {}
  // What it says when it has turned by an angle since the start: 0 there, then whole steps.
  [[nodiscard]] double read(double angle_rad) const {
    return step_rad_ * std::floor(angle_rad / step_rad_ + phase_);
  }

 private:
  double step_rad_;
  double phase_;
};

}  // namespace tread
