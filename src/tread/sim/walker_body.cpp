#include "tread/sim/walker_body.hpp"

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "tread/sim/walker_mjcf.hpp"

namespace tread {
namespace {

constexpr double kSettleS = 2.0;
constexpr int kFirstPosition = 7, kFirstSpeed = 6;  // of joints, after the free body's

template <class T>
bool all_finite(const T& values, double least) {
  return std::all_of(values.begin(), values.end(),
                     [=](double v) { return std::isfinite(v) && v >= least; });
}

// The trunk level, its height such that the feet are as far below it as at home, on average.
struct Stance {
  Isometry3d T_world_body = Isometry3d::Identity();
  std::array<double, kLegJoints> joints_rad{};
};

Result<Stance> find_stance(const World& world, const WalkerModelOptions& options,
                           const RobotPlace& place) {
  const std::string where = fmt::format("the walker at x {:.2f} m, y {:.2f} m",
                                        place.position_m.x(), place.position_m.y());
  Stance stance;
  stance.T_world_body.linear() = rotation_from_yaw_pitch_roll(place.yaw_rad, 0.0, 0.0);
  stance.T_world_body.translation() << place.position_m, 0.0;
  std::array<Eigen::Vector3d, kLegs> feet;  // body axes; z of the world
  double height = 0.0;
  for (int leg = 0; leg < kLegs; ++leg) {
    Eigen::Vector3d& foot = feet[static_cast<std::size_t>(leg)];
    foot = foot_position(options, leg, joints_of_leg(home_joints(), leg));
    height -= 0.25 * foot.z();
    const Eigen::Vector3d p = stance.T_world_body * foot;
    foot.z() = ball_height(world, p.head<2>(), options.foot_radius_m);
    if (!std::isfinite(foot.z())) {
      return fail(ErrorCode::kBadValue,
                  fmt::format("there is no ground below its {} foot", leg_name(leg)), where,
                  "Place the robot within the world");
    }
    height += 0.25 * foot.z();
  }
  stance.T_world_body.translation().z() = height;
  for (int leg = 0; leg < kLegs; ++leg) {
    Eigen::Vector3d foot = feet[static_cast<std::size_t>(leg)];
    foot.z() -= height;
    const LegJoints found = joints_for_foot(options, leg, foot);
    if (!found.reached()) {
      return fail(ErrorCode::kBadValue,
                  fmt::format("its {} foot cannot reach the ground {:.2f} m below its hip",
                              leg_name(leg), -foot.z()),
                  where, "Place the robot on more level ground");
    }
    for (int k = 0; k < 3; ++k) {
      stance.joints_rad[static_cast<std::size_t>(3 * leg + k)] = found.joints_rad(k);
    }
  }
  return stance;
}

}  // namespace

WalkerBody::WalkerBody(PhysicsModel physics, const WalkerModelOptions& options)
    : Body(std::move(physics)), options_(options) {}

Result<std::unique_ptr<WalkerBody>> WalkerBody::place(const World& world,
                                                      const WalkerModelOptions& options,
                                                      const RobotPlace& place,
                                                      const StandOptions& stand,
                                                      const PhysicsOptions& physics) {
  if (Status good = check_options(options); !good) return forward(good);
  if (Status good = check_options(stand); !good) return forward(good);
  if (!place.position_m.allFinite() || !std::isfinite(place.yaw_rad)) {
    return fail(ErrorCode::kBadValue, "its place is not finite", "the walker", "Write numbers");
  }
  std::vector<std::string> feet;
  for (int leg = 0; leg < kLegs; ++leg) feet.push_back(foot_part(leg));
  auto model = PhysicsModel::make(world, walker_mjcf(options), physics, feet);
  if (!model) return forward(model);
  const Result<Stance> stance = find_stance(world, options, place);
  if (!stance) return forward(stance);
  std::unique_ptr<WalkerBody> walker(new WalkerBody(std::move(*model), options));
  std::copy(stance->joints_rad.begin(), stance->joints_rad.end(),
            walker->engine().data().qpos + kFirstPosition);
  walker->command_ = stand_command(options, stance->joints_rad, Eigen::Vector3d::UnitZ(), stand);
  Status standing = walker->stand_at(stance->T_world_body, kSettleS, "the walker");
  if (!standing) return forward(standing);
  return walker;
}

Status WalkerBody::command(const JointCommand& command) {
  constexpr double kAny = -std::numeric_limits<double>::infinity();
  if (!all_finite(command.position_rad, kAny) || !all_finite(command.velocity_rad_per_s, kAny) ||
      !all_finite(command.torque_nm, kAny) || !all_finite(command.stiffness_nm_per_rad, 0.0) ||
      !all_finite(command.damping_nm_s_per_rad, 0.0)) {
    return fail(ErrorCode::kBadValue, "a value is not finite, or a spring or damper is negative",
                "joint command", "Send numbers only");
  }
  command_ = command;
  return {};
}

// Springs and dampers are computed anew in every step, as fast as the joint controllers of the real
// machine run.
void WalkerBody::drive() {
  mjData_& data = engine().data();
  for (std::size_t i = 0; i < kLegJoints; ++i) {
    const double q = data.qpos[kFirstPosition + i], v = data.qvel[kFirstSpeed + i];
    const double limit = joint_torque_limit_nm(options_, static_cast<int>(i % 3));
    double torque = command_.torque_nm[i] +
                    command_.stiffness_nm_per_rad[i] * (command_.position_rad[i] - q) +
                    command_.damping_nm_s_per_rad[i] * (command_.velocity_rad_per_s[i] - v);
    torque = std::clamp(torque, -limit, limit);
    // Towards its top speed a joint loses what drives it on, not what brakes it.
    constexpr double kFade = 0.2;
    if (torque * v > 0.0) {
      const double top = options_.joint_speed_rad_per_s;
      torque *= std::clamp((top - std::abs(v)) / (kFade * top), 0.0, 1.0);
    }
    torque_nm_[i] = torque;
    data.qfrc_applied[kFirstSpeed + i] = torque;
  }
}

LegSample WalkerBody::legs() const {
  const mjData_& data = physics().data();
  LegSample sample;
  sample.stamp_ns = std::llround(1e9 * time_s());
  std::copy_n(data.qpos + kFirstPosition, kLegJoints, sample.position_rad.begin());
  std::copy_n(data.qvel + kFirstSpeed, kLegJoints, sample.velocity_rad_per_s.begin());
  sample.torque_nm = torque_nm_;
  const Eigen::Matrix3d R_body_world = motion().T_world_body.linear().transpose();
  for (std::size_t leg = 0; leg < kLegs; ++leg) {
    sample.foot_force_n[leg] = R_body_world * physics().treads()[leg].force_n;
  }
  return sample;
}

Eigen::Vector3d WalkerBody::foot_m(int leg) const {
  const auto sample = legs();
  return motion().T_world_body *
         foot_position(options_, leg, joints_of_leg(sample.position_rad, leg));
}

Eigen::Vector3d WalkerBody::contact_force_n() const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Touch& touch : touches()) sum += touch.force_n;
  return sum;
}

}  // namespace tread
