// A robot in a simulated world, behind the interface that hardware has: told what to do, it senses.
// Beside that interface it tells the truth, for data sets and for scores.
//
//   auto course = find_course("meadow");
//   auto robot = SimulatedRobot::make(*course, rover_setup(), {});
//   (*robot)->command({.drive = DriveCommand{0.5, 0.1}});
//   const SensorBatch batch = *(*robot)->advance(100'000'000);
//
// Time goes in steps of the physics; within a step sensors measure in order of time. Same course,
// setup, seed and commands: same batches to the bit, whatever the threads and however the time is
// cut into calls of advance().
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "tread/core/timer.hpp"
#include "tread/robot/robot.hpp"
#include "tread/sim/body_motion.hpp"
#include "tread/sim/carried_body.hpp"
#include "tread/sim/course.hpp"
#include "tread/sim/robot_setup.hpp"

namespace tread {

struct SimulationOptions {
  std::uint64_t seed = 1;  // of the sensors; the world has its own
  bool carried = false;    // along the course's route, by no force of its own
  CarryOptions carry;
  bool cameras = true;            // frames take nearly all of the time
  bool frames_know_pose = false;  // frames come with T_world_left, for data sets
  std::int64_t epoch_ns = 1'600'000'000'000'000'000;  // what clocks say at the start
};

// The truth of a pair of images.
struct FrameTruth {
  int head = 0;
  std::int64_t stamp_ns = 0;  // by a right clock
  Isometry3d T_world_left = Isometry3d::Identity();
  Image<float> depth;  // of the left camera, metres along its axis; NaN: the sky
};

class SimulatedRobot final : public Robot {
 public:
  // At the start of the course. Faults of sensors that this robot does not have do nothing. Errors:
  // options out of range, what makes a body's place impossible, a carried robot without a route.
  [[nodiscard]] static Result<std::unique_ptr<SimulatedRobot>> make(
      const Course& course, const RobotSetup& setup, const SimulationOptions& options,
      const Context& context = {});
  ~SimulatedRobot() override;

  [[nodiscard]] const std::vector<StereoRig>& heads() const override;
  [[nodiscard]] Status command(const RobotCommand& command) override;
  [[nodiscard]] Result<SensorBatch> advance(std::int64_t duration_ns) override;

  // The truth, now.
  [[nodiscard]] std::int64_t time_ns() const;  // since the start
  [[nodiscard]] const BodyMotion& motion() const;
  [[nodiscard]] HeadCommand head() const;
  [[nodiscard]] const World& world() const;
  // Of the IMU: x, y, z of the gyroscope, rad/s, and of the accelerometer, m/s^2.
  [[nodiscard]] const Eigen::Vector3d& gyro_bias_rad_per_s() const;
  [[nodiscard]] const Eigen::Vector3d& accel_bias_m_per_s2() const;
  // When a carried robot is at its end.
  [[nodiscard]] std::optional<double> duration_s() const;
  // Called with each pair that is taken, also those that get lost on their way.
  void on_frame(std::function<void(FrameTruth&&)> listener);

 private:
  struct Parts;
  explicit SimulatedRobot(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace tread
