// What tread simulate writes of a run, as it comes.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <vector>

#include "tread/io/data_set_writer.hpp"
#include "tread/sim/simulated_robot.hpp"

namespace tread {

class SimulateRecording {
 public:
  // Counts only, without a writer. Both must outlive it.
  SimulateRecording(DataSetWriter* writer, const SimulatedRobot& robot, std::int64_t epoch_ns)
      : writer_(writer), robot_(robot), epoch_ns_(epoch_ns) {}

  // The first thing that could not be written.
  [[nodiscard]] const Status& status() const { return status_; }
  // Samples of each sensor.
  [[nodiscard]] const std::map<std::string, std::int64_t>& counts() const { return counts_; }

  // The depth of a frame that is on its way; it is written when that arrives.
  void expect(const FrameTruth& truth);
  // What arrived, and where the robot is now.
  void add(const SensorBatch& batch);

 private:
  void add_frame(const HeadFrame& frame);
  void keep(const Status& status);
  template <class Sample>
  void add_all(const char* name, const std::vector<Sample>& samples);

  DataSetWriter* writer_;
  const SimulatedRobot& robot_;
  std::int64_t epoch_ns_;
  std::deque<FrameTruth> depths_;
  Status status_;
  std::map<std::string, std::int64_t> counts_;
};

}  // namespace tread
