#include "tread/sim/moving_body.hpp"

#include <cmath>

namespace tread::internal {
namespace {

constexpr std::int64_t kCarriedStep_ns = 2'000'000;

std::int64_t step_of(const MovingBody::Kind& kind) {
  const auto in_ns = [](double step_s) { return std::llround(step_s * 1e9); };
  if (const auto* rover = std::get_if<std::unique_ptr<RoverBody>>(&kind)) {
    return in_ns((*rover)->step_s());
  }
  if (const auto* walker = std::get_if<std::unique_ptr<WalkerBody>>(&kind)) {
    return in_ns((*walker)->step_s());
  }
  return kCarriedStep_ns;
}

}  // namespace

MovingBody::MovingBody(Kind kind, const Isometry3d& T_base_body)
    : kind_(std::move(kind)), T_base_body_(T_base_body), step_ns_(step_of(kind_)) {
  look();
}

RoverBody* MovingBody::rover() const {
  const auto* body = std::get_if<std::unique_ptr<RoverBody>>(&kind_);
  return body != nullptr ? body->get() : nullptr;
}

WalkerBody* MovingBody::walker() const {
  const auto* body = std::get_if<std::unique_ptr<WalkerBody>>(&kind_);
  return body != nullptr ? body->get() : nullptr;
}

Status MovingBody::step() {
  Status done;
  if (RoverBody* body = rover()) done = body->step();
  if (WalkerBody* body = walker()) done = body->step();
  if (!done) return done;
  ++steps_;
  look();
  return {};
}

void MovingBody::look() {
  if (const CarriedBody* body = carried())
    now_ = body->motion(1e-9 * static_cast<double>(time_ns()));
  if (const RoverBody* body = rover()) now_ = at_mount(body->motion(), T_base_body_);
  if (const WalkerBody* body = walker()) now_ = at_mount(body->motion(), T_base_body_);
}

BodyMotion MovingBody::motion_at(std::int64_t time_ns) const {
  if (const CarriedBody* body = carried()) return body->motion(1e-9 * static_cast<double>(time_ns));
  // Physics has constant velocities within a step.
  BodyMotion motion = now_;
  motion.T_world_body = pose_after(now_, 1e-9 * static_cast<double>(time_ns - this->time_ns()));
  return motion;
}

}  // namespace tread::internal
