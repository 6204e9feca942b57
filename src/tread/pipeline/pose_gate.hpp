// Keeps poses that cannot be out of the maps: a frame whose pose is farther from the one before
// than a robot can have come. Only distances between frames count, so that a drive may begin
// anywhere (UTM coordinates are thousands of kilometres from the origin).
//
// A frame is allowed max_step_m plus max_speed_m_per_s times the time since the last accepted
// frame, so that frames may be left out of a drive, and stamps may be missing. What is farther is
// refused, until confirm_frames frames in a row agree with each other by the same rule: the place
// has changed for good (the localisation was reset, the trajectory has a gap without time), and the
// last of them is accepted. If fewer frames than that had been accepted before it, they were the
// ones that stood wrong: then the drive begins with this one.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "tread/core/options.hpp"

namespace tread {

struct PoseGateOptions {
  bool check_jumps = true;
  double max_step_m = 50.0;         // from frame to frame, whatever the time between them
  double max_speed_m_per_s = 50.0;  // and this much more for each second; 180 km/h
  int confirm_frames = 3;  // frames in a row that agree on another place until it is believed
};
[[nodiscard]] OptionSet describe(PoseGateOptions& options);

class PoseGate {
 public:
  enum class Verdict {
    kAccepted,
    kRefused,
    kMoved,    // accepted: the jump is confirmed
    kRestart,  // accepted: the jump is confirmed, and the few frames before it stood wrong
  };
  struct Answer {
    Verdict verdict = Verdict::kAccepted;
    double distance_m = 0.0;  // from the last accepted frame
    double allowed_m = 0.0;
  };

  explicit PoseGate(const PoseGateOptions& options = {}) : options_(options) {}
  // The position must be finite, metres in the world. Refused frames are remembered only for the
  // next one.
  [[nodiscard]] Answer judge(std::int64_t stamp_ns, const Eigen::Vector3d& position);

 private:
  struct Place {
    std::int64_t stamp_ns = 0;
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    int frames = 0;  // in a row up to this one; 0: there is none
  };
  [[nodiscard]] double allowed_m(const Place& from, std::int64_t stamp_ns) const;
  [[nodiscard]] bool near(const Place& from, const Place& to) const;

  PoseGateOptions options_;
  Place accepted_;
  Place refused_;
};

}  // namespace tread
