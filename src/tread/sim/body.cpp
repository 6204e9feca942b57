#include "tread/sim/body.hpp"

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

namespace tread {
namespace {

constexpr double kMostDepthM = 0.003;  // that a robot may be inside something where it is put
constexpr double kMostMovedM = 0.25;   // while it settles
constexpr double kMostTiltedRad = 0.7;
constexpr double kFallM = 2.0;  // below the lowest ground

}  // namespace

Body::Body(PhysicsModel physics) : physics_(std::move(physics)) {
  const std::vector<float>& heights = physics_.world().ground.values;
  floor_m_ = static_cast<double>(*std::min_element(heights.begin(), heights.end())) - kFallM;
  look(0.0);
}

// Where it is now; accelerations from what it was `passed_s` ago, none if no time has passed.
void Body::look(double passed_s) {
  const BodyMotion before = now_;
  const mjData_& data = physics_.data();
  now_.T_world_body.translation() << data.qpos[0], data.qpos[1], data.qpos[2];
  const Eigen::Quaterniond q(data.qpos[3], data.qpos[4], data.qpos[5], data.qpos[6]);
  now_.T_world_body.linear() = q.normalized().toRotationMatrix();
  now_.velocity_m_per_s << data.qvel[0], data.qvel[1], data.qvel[2];
  // MuJoCo has the turn of a free body in its own axes, as we do.
  now_.rate_rad_per_s << data.qvel[3], data.qvel[4], data.qvel[5];
  now_.acceleration_m_per_s2.setZero();
  now_.rate_change_rad_per_s2.setZero();
  if (passed_s <= 0.0) return;
  now_.acceleration_m_per_s2 = (now_.velocity_m_per_s - before.velocity_m_per_s) / passed_s;
  now_.rate_change_rad_per_s2 = (now_.rate_rad_per_s - before.rate_rad_per_s) / passed_s;
}

Status Body::step() {
  if (Status done = physics_.begin_step(); !done) return done;
  drive();
  mjtNum* const pushed = physics_.data().xfrc_applied + 6;  // of body 1, the robot's
  for (int i = 0; i < 3; ++i) pushed[i] = push_left_s_ > 0.0 ? push_n_(i) : 0.0;
  push_left_s_ -= step_s();
  if (Status done = physics_.end_step(); !done) return done;
  look(step_s());
  if (now_.T_world_body.translation().z() >= floor_m_) return {};
  return fail(ErrorCode::kBadValue,
              fmt::format("it has fallen off the edge of the ground at {:.1f} s", time_s()),
              "robot", "Keep it within the world");
}

void Body::push(const Eigen::Vector3d& force_n, double duration_s) {
  push_n_ = force_n;
  push_left_s_ = duration_s - 0.5 * step_s();  // whole steps, whatever rounding does
}

// Contacts from below lift; those from the side are for someone else to resolve.
Status Body::lift_out(Isometry3d T_world_body, const std::string& where) {
  constexpr int kTries = 20;
  constexpr double kSteep = 0.5;  // upward part of a normal
  for (int i = 0; i < kTries; ++i) {
    if (Status done = physics_.set_robot_pose(T_world_body); !done) return done;
    const std::vector<Touch> touches = physics_.touches();
    const auto deepest =
        std::max_element(touches.begin(), touches.end(),
                         [](const Touch& a, const Touch& b) { return a.depth_m < b.depth_m; });
    if (deepest == touches.end() || deepest->depth_m <= kMostDepthM) return {};
    // Wheels and feet have been put on top of what is there; so nothing but the slope of the ground
    // can lift them by much.
    constexpr double kMostLiftM = 0.05;
    const bool from_below = deepest->normal.z() > kSteep;
    if (!from_below || (physics_.is_solid(deepest->other) && deepest->depth_m > kMostLiftM)) {
      return fail(ErrorCode::kBadValue,
                  fmt::format("its {} is {:.3f} m inside {}", physics_.name_of(deepest->part),
                              deepest->depth_m, physics_.name_of(deepest->other)),
                  where, "Place the robot elsewhere");
    }
    T_world_body.translation().z() += deepest->depth_m / deepest->normal.z();
  }
  return fail(ErrorCode::kBadValue, "it finds no room between ground and solids", where,
              "Place the robot elsewhere");
}

Status Body::stand_at(const Isometry3d& T_world_body, double settle_s, const std::string& robot) {
  const Eigen::Vector3d p = T_world_body.translation();
  const std::string where = fmt::format("{} at x {:.2f} m, y {:.2f} m", robot, p.x(), p.y());
  // To its place first: where the model was made it may be deep in the ground.
  if (Status done = physics_.set_robot_pose(T_world_body); !done) return done;
  if (Status done = physics_.set_time(-settle_s); !done) return done;
  if (Status done = lift_out(T_world_body, where); !done) return done;
  look(0.0);
  for (double t = 0.0; t < settle_s; t += step_s()) {
    if (Status done = step(); !done) return done;
  }
  if (Status done = physics_.set_time(0.0); !done) return done;
  look(0.0);
  const double moved = (now_.T_world_body.translation() - p).head<2>().norm();
  const double tilt = std::acos(std::clamp(now_.T_world_body.linear()(2, 2), -1.0, 1.0));
  if (moved <= kMostMovedM && tilt <= kMostTiltedRad) return {};
  return fail(ErrorCode::kBadValue,
              fmt::format("it does not stay there: it moves {:.2f} m and tilts {:.0f} degrees",
                          moved, tilt * 180.0 / std::numbers::pi),
              where, "Place the robot on more level ground");
}

double ball_height(const World& world, const Eigen::Vector2d& place, double radius_m) {
  constexpr int kRings = 4, kSpokes = 12;
  double height = top_height(world, place) + radius_m;
  for (int ring = 1; ring <= kRings; ++ring) {
    const double r = radius_m * (ring - 0.2) / kRings;
    for (int k = 0; k < kSpokes; ++k) {
      const double angle = 2.0 * std::numbers::pi * k / kSpokes;
      const double top =
          top_height(world, place + r * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
      if (!std::isnan(top)) {
        height = std::max(height, top + std::sqrt(radius_m * radius_m - r * r));
      }
    }
  }
  return height;
}

}  // namespace tread
