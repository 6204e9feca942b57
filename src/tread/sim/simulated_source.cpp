#include "tread/sim/simulated_source.hpp"

#include <cmath>
#include <deque>

namespace tread {
namespace {

class SimulatedSource final : public StereoSource {
 public:
  SimulatedSource(std::unique_ptr<SimulatedRobot> robot, double rate_hz, bool has_imu)
      : robot_(std::move(robot)), rate_hz_(rate_hz), has_imu_(has_imu) {}

  [[nodiscard]] const StereoRig& rig() const override { return robot_->heads().front(); }
  [[nodiscard]] int frame_count() const override {
    return static_cast<int>(std::floor(*robot_->duration_s() * rate_hz_)) + 1;
  }
  [[nodiscard]] bool has_poses() const override { return true; }
  [[nodiscard]] bool has_imu() const override { return has_imu_; }
  [[nodiscard]] const std::vector<Error>& problems() const override { return problems_; }
  [[nodiscard]] std::string kind() const override { return "simulated course"; }

  [[nodiscard]] Result<std::optional<StereoFrame>> next() override {
    constexpr std::int64_t kStep_ns = 10'000'000, kPatience_ns = 200'000'000;
    const auto end_ns = static_cast<std::int64_t>(1e9 * (*robot_->duration_s() + 1.0));
    while (true) {
      // Samples of the IMU arrive sooner than images; those up to the stamp must all be there. One
      // that is silent is not waited for.
      if (!frames_.empty() && (imu_until_ns_ >= frames_.front().stamp_ns ||
                               now_ns_ > frames_.front().stamp_ns + kPatience_ns)) {
        return with_imu();
      }
      if (robot_->time_ns() > end_ns || given_ >= frame_count()) {
        return frames_.empty() || given_ >= frame_count() ? Result<std::optional<StereoFrame>>()
                                                          : with_imu();
      }
      auto batch = robot_->advance(kStep_ns);
      if (!batch) return forward(batch);
      for (HeadFrame& frame : batch->frames) {
        if (frame.head == 0) take(std::move(frame.frame));
      }
      now_ns_ = batch->now_ns;
      for (const ImuSample& sample : batch->imu) {
        imu_.push_back(sample);
        imu_until_ns_ = sample.stamp_ns;
      }
      if (!has_imu_) imu_until_ns_ = now_ns_;
    }
  }

 private:
  // Frames come in order of time: one that a fault repeats or brings late is left out, and told.
  void take(StereoFrame frame) {
    if (last_ns_ && frame.stamp_ns <= *last_ns_) {
      problems_.push_back({ErrorCode::kBadValue, "its stamp is not after the last one",
                           "frame " + frame.name, "It is left out"});
      return;
    }
    last_ns_ = frame.stamp_ns;
    frames_.push_back(std::move(frame));
  }
  [[nodiscard]] std::optional<StereoFrame> with_imu() {
    StereoFrame frame = std::move(frames_.front());
    frames_.pop_front();
    ++given_;
    while (!imu_.empty() && imu_.front().stamp_ns <= frame.stamp_ns) {
      frame.imu.push_back(imu_.front());
      imu_.pop_front();
    }
    return frame;
  }

  std::unique_ptr<SimulatedRobot> robot_;
  double rate_hz_;
  bool has_imu_;
  std::vector<Error> problems_;
  std::deque<StereoFrame> frames_;
  std::deque<ImuSample> imu_;
  std::int64_t imu_until_ns_ = 0, now_ns_ = 0;
  std::optional<std::int64_t> last_ns_;
  int given_ = 0;
};

}  // namespace

Result<std::unique_ptr<StereoSource>> open_simulated_source(const Course& course,
                                                            const RobotSetup& setup,
                                                            const SimulationOptions& options,
                                                            const Context& context) {
  SimulationOptions carried = options;
  carried.carried = carried.frames_know_pose = carried.cameras = true;
  RobotSetup single = setup;
  single.heads = 1;
  auto robot = SimulatedRobot::make(course, single, carried, context);
  if (!robot) return forward(robot);
  return std::make_unique<SimulatedSource>(std::move(*robot), setup.camera.channel.rate_hz,
                                           setup.has_imu);
}

}  // namespace tread
