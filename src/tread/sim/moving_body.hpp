// Internal to sim: whatever carries the sensors, driven by physics or along a route.
#pragma once

#include <memory>
#include <variant>

#include "tread/sim/carried_body.hpp"
#include "tread/sim/rover_body.hpp"
#include "tread/sim/walker_body.hpp"

namespace tread::internal {

// Body axes are those of the robot as its user knows it: the origin on the ground.
class MovingBody {
 public:
  using Kind = std::variant<CarriedBody, std::unique_ptr<RoverBody>, std::unique_ptr<WalkerBody>>;
  // `T_base_body`: from the axes in which the physics has the body.
  MovingBody(Kind kind, const Isometry3d& T_base_body);

  // Goes on by one step.
  [[nodiscard]] Status step();
  [[nodiscard]] std::int64_t time_ns() const { return steps_ * step_ns_; }
  // Now; within the step behind.
  [[nodiscard]] const BodyMotion& motion() const { return now_; }
  [[nodiscard]] BodyMotion motion_at(std::int64_t time_ns) const;

  [[nodiscard]] RoverBody* rover() const;
  [[nodiscard]] WalkerBody* walker() const;
  [[nodiscard]] const CarriedBody* carried() const { return std::get_if<CarriedBody>(&kind_); }

 private:
  void look();
  Kind kind_;
  Isometry3d T_base_body_;
  std::int64_t step_ns_;
  std::int64_t steps_ = 0;
  BodyMotion now_;
};

}  // namespace tread::internal
