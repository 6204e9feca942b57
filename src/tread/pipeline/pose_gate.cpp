#include "tread/pipeline/pose_gate.hpp"

#include <algorithm>
#include <cmath>

namespace tread {

OptionSet describe(PoseGateOptions& options) {
  OptionSet set;
  set.add("check_jumps", options.check_jumps, "refuse frames that are too far from the one before");
  set.add("max_step_m", options.max_step_m,
          "farthest a frame may be from the one before, whatever the time between them, m", 0.0,
          1e9);
  set.add("max_speed_m_per_s", options.max_speed_m_per_s,
          "and this much farther for each second between them, m/s", 0.0, 1e6);
  set.add("confirm_frames", options.confirm_frames,
          "frames in a row that agree on another place until it is believed", 1, 1'000'000);
  return set;
}

double PoseGate::allowed_m(const Place& from, std::int64_t stamp_ns) const {
  // As floating point: the difference of two stamps may not fit into 64 bits.
  const double seconds =
      1e-9 * std::abs(static_cast<double>(stamp_ns) - static_cast<double>(from.stamp_ns));
  return options_.max_step_m + options_.max_speed_m_per_s * seconds;
}

bool PoseGate::near(const Place& from, const Place& to) const {
  return (to.position - from.position).norm() <= allowed_m(from, to.stamp_ns);
}

PoseGate::Answer PoseGate::judge(std::int64_t stamp_ns, const Eigen::Vector3d& position) {
  Place here{stamp_ns, position, 1};
  Answer answer;
  if (accepted_.frames > 0) {
    answer.distance_m = (position - accepted_.position).norm();
    answer.allowed_m = allowed_m(accepted_, stamp_ns);
  }
  const bool follows = accepted_.frames == 0 || !options_.check_jumps || near(accepted_, here);
  if (!follows) {
    if (refused_.frames > 0 && near(refused_, here)) here.frames += refused_.frames;
    if (here.frames < options_.confirm_frames) {
      refused_ = here;
      answer.verdict = Verdict::kRefused;
      return answer;
    }
    const bool few = accepted_.frames < options_.confirm_frames;
    answer.verdict = few ? Verdict::kRestart : Verdict::kMoved;
  }
  // More than confirm_frames need not be told apart.
  if (answer.verdict != Verdict::kRestart) {
    here.frames = std::min(accepted_.frames, options_.confirm_frames) + 1;
  }
  accepted_ = here;
  refused_ = {};
  return answer;
}

}  // namespace tread
