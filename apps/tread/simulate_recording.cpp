#include "simulate_recording.hpp"

#include <fmt/format.h>

namespace tread {

void SimulateRecording::expect(const FrameTruth& truth) {
  constexpr std::size_t kMost = 16;  // on their way at once; frames that are lost never come
  if (writer_ == nullptr) return;
  depths_.push_back(truth);
  if (depths_.size() > kMost) depths_.pop_front();
}

void SimulateRecording::keep(const Status& status) {
  if (status_ && !status) status_ = status;
}

template <class Sample>
void SimulateRecording::add_all(const char* name, const std::vector<Sample>& samples) {
  for (const Sample& sample : samples) {
    ++counts_[name];
    if (writer_ != nullptr) keep(writer_->add(sample));
  }
}

void SimulateRecording::add_frame(const HeadFrame& frame) {
  ++counts_[fmt::format("camera{}", frame.head)];
  if (writer_ == nullptr) return;
  keep(writer_->add(frame.head, frame.frame));
  for (const FrameTruth& truth : depths_) {
    if (truth.head != frame.head || truth.stamp_ns != frame.frame.stamp_ns) continue;
    keep(writer_->add_depth(truth.head, truth.stamp_ns, truth.depth.view()));
  }
}

void SimulateRecording::add(const SensorBatch& batch) {
  for (const HeadFrame& frame : batch.frames) add_frame(frame);
  add_all("imu", batch.imu);
  add_all("gnss", batch.gnss);
  add_all("wheels", batch.wheels);
  add_all("legs", batch.legs);
  add_all("head", batch.head);
  add_all("bump", batch.bumps);
  if (writer_ == nullptr) return;
  const BodyMotion& motion = robot_.motion();
  keep(writer_->add(BodyTruth{epoch_ns_ + robot_.time_ns(), motion.T_world_body,
                              motion.velocity_m_per_s, robot_.gyro_bias_rad_per_s(),
                              robot_.accel_bias_m_per_s2()}));
}

}  // namespace tread
