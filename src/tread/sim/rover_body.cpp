#include "tread/sim/rover_body.hpp"

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

namespace tread {
namespace {

constexpr double kSettleS = 1.5;
// The controller of a wheel: a spring and a damper to where its encoder should be by now, stiff
// enough to follow within a tenth of a second, soft enough for a wheel in the air.
constexpr double kSpring = 400.0;  // Nm/rad
constexpr double kDamper = 40.0;   // Nm s/rad
// Rolling resistance is a spring that gives way: stiff enough to hold, soft enough for a caster.
constexpr double kResistSpring = 50.0, kResistDamper = 0.2;

// How high the hub of a wheel is that rests on the world, heading along `ahead`; NaN outside.
double hub_height(const World& world, const Eigen::Vector2d& place, const Eigen::Vector2d& ahead,
                  double radius_m, double width_m) {
  constexpr int kSteps = 12;
  const Eigen::Vector2d left(-ahead.y(), ahead.x());
  double height = top_height(world, place) + radius_m;
  for (int i = -kSteps; i <= kSteps; ++i) {
    const double along = 0.99 * radius_m * i / kSteps;
    for (const double across : {-0.5 * width_m, 0.0, 0.5 * width_m}) {
      // The tread is round across, too.
      const double edge = across == 0.0 ? 0.0 : radius_m;
      const double top = top_height(world, place + along * ahead + across * left);
      const double above = std::sqrt(radius_m * radius_m - along * along) - edge;
      if (!std::isnan(top) && above > 0.0) height = std::max(height, top + above);
    }
  }
  return height;
}

// The pose in which wheels rest on a plane through what is under them.
Result<Isometry3d> resting_pose(const World& world, const RoverModelOptions& options,
                                const RobotPlace& place) {
  const Eigen::Vector2d ahead(std::cos(place.yaw_rad), std::sin(place.yaw_rad)),
      left(-ahead.y(), ahead.x());
  Eigen::Matrix<double, 4, 3> A;
  Eigen::Vector4d b;
  const std::vector<RoverWheel> wheels = rover_wheels(options);
  for (int i = 0; i < 4; ++i) {
    const RoverWheel& wheel = wheels[static_cast<std::size_t>(i)];
    const Eigen::Vector3d& hub = wheel.hub_m;
    const double height = hub_height(world, place.position_m + hub.x() * ahead + hub.y() * left,
                                     ahead, wheel.radius_m, options.wheel_width_m);
    if (!std::isfinite(height)) {
      return fail(ErrorCode::kBadValue, fmt::format("there is no ground below its {}", wheel.name),
                  fmt::format("the rover at x {:.2f} m, y {:.2f} m", place.position_m.x(),
                              place.position_m.y()),
                  "Place the robot within the world");
    }
    A.row(i) << 1.0, hub.x(), hub.y();
    b(i) = height - wheel.radius_m;
  }
  const Eigen::Vector3d plane = (A.transpose() * A).ldlt().solve(A.transpose() * b);
  Isometry3d T_world_body = Isometry3d::Identity();
  T_world_body.linear() =
      rotation_from_yaw_pitch_roll(place.yaw_rad, -std::atan(plane.y()), std::atan(plane.z()));
  T_world_body.translation() << place.position_m, plane.x() + (b - A * plane).maxCoeff();
  return T_world_body;
}

}  // namespace

RoverBody::RoverBody(PhysicsModel physics, const RoverModelOptions& options)
    : Body(std::move(physics)), options_(options) {
  const mjModel_& model = engine().model();
  for (const RoverWheel& what : rover_wheels(options)) {
    const int joint = mj_name2id(&model, mjOBJ_JOINT, what.name.c_str());
    Wheel& wheel = wheels_.emplace_back();
    wheel.what = what;
    wheel.part = mj_name2id(&model, mjOBJ_GEOM, what.name.c_str());
    wheel.body = model.geom_bodyid[wheel.part];
    wheel.position = model.jnt_qposadr[joint];
    wheel.speed = model.jnt_dofadr[joint];
    // Steps of this length can follow no stiffer bristles on so light a wheel.
    const double inertia = model.dof_armature[wheel.speed] + model.body_inertia[3 * wheel.body];
    const double mass = inertia / (what.radius_m * what.radius_m);
    wheel.tyre.stiffness_n_per_m =
        std::min(wheel.tyre.stiffness_n_per_m, 0.1 * mass / (step_s() * step_s()));
    wheel.tyre.damping_n_s_per_m = std::min(wheel.tyre.damping_n_s_per_m, 0.35 * mass / step_s());
  }
}

Result<std::unique_ptr<RoverBody>> RoverBody::place(const World& world,
                                                    const RoverModelOptions& options,
                                                    const RobotPlace& place,
                                                    const PhysicsOptions& physics) {
  if (Status good = check_options(options); !good) return forward(good);
  if (!place.position_m.allFinite() || !std::isfinite(place.yaw_rad)) {
    return fail(ErrorCode::kBadValue, "its place is not finite", "the rover", "Write numbers");
  }
  auto model = PhysicsModel::make(world, rover_mjcf(options), physics, {});
  if (!model) return forward(model);
  const Result<Isometry3d> pose = resting_pose(world, options, place);
  if (!pose) return forward(pose);
  std::unique_ptr<RoverBody> rover(new RoverBody(std::move(*model), options));
  Status standing = rover->stand_at(*pose, kSettleS, "the rover");
  if (!standing) return forward(standing);
  for (Wheel& wheel : rover->wheels_) {
    wheel.start_rad = rover->physics().data().qpos[wheel.position];
  }
  return rover;
}

Status RoverBody::command(const DriveCommand& command) {
  if (!std::isfinite(command.speed_m_per_s) || !std::isfinite(command.yaw_rate_rad_per_s)) {
    return fail(ErrorCode::kBadValue, "a speed is not finite", "drive command",
                "Send numbers only");
  }
  command_ = limited(options_, command);
  return {};
}

void RoverBody::drive() {
  mjData_& data = engine().data();
  std::fill_n(data.qfrc_applied, engine().model().nv, 0.0);
  find_holds();
  const WheelSpeeds told = wheel_speeds(options_, command_);
  for (Wheel& wheel : wheels_) {
    if (wheel.what.driven) {
      turn(wheel, wheel.what.left ? told.left_rad_per_s : told.right_rad_per_s);
    }
    resist(wheel);
    hold(wheel);
  }
}

// Contacts of a wheel with one thing, of which rough ground gives several, count as one. Where a
// wheel goes over the edge between two triangles, or hops, its load jumps for a few milliseconds,
// which a tyre would even out.
void RoverBody::find_holds() {
  struct Sum {
    double load_n = 0.0;
    Eigen::Vector3d place_m = Eigen::Vector3d::Zero(), normal = Eigen::Vector3d::Zero();
  };
  constexpr double kEvenS = 0.03, kNoLoad = 1.0;
  const double share = step_s() / (kEvenS + step_s());
  const std::vector<Touch> all = touches();
  for (Wheel& wheel : wheels_) {
    for (const Touch& touch : all) {
      const bool known = std::any_of(wheel.holds.begin(), wheel.holds.end(),
                                     [&](const Hold& hold) { return hold.other == touch.other; });
      if (touch.part == wheel.part && !known) wheel.holds.emplace_back().other = touch.other;
    }
    for (Hold& hold : wheel.holds) {
      Sum sum;
      for (const Touch& touch : all) {
        const double load = touch.force_n.dot(touch.normal);
        if (touch.part != wheel.part || touch.other != hold.other || !(load > 0.0)) continue;
        sum.load_n += load;
        sum.place_m += load * touch.place_m;
        sum.normal += load * touch.normal;
        hold.footing = physics().footing(touch);
      }
      hold.load_n += share * (sum.load_n - hold.load_n);
      if (!(sum.load_n > 0.0)) continue;
      hold.place_m = sum.place_m / sum.load_n;
      hold.normal = sum.normal.normalized();
    }
    std::erase_if(wheel.holds, [](const Hold& hold) { return !(hold.load_n > kNoLoad); });
  }
}

void RoverBody::turn(Wheel& wheel, double told_rad_per_s) {
  mjData_& data = engine().data();
  const double angle = data.qpos[wheel.position], speed = data.qvel[wheel.speed];
  const double most = options_.acceleration_m_per_s2 / options_.wheel_radius_m * step_s();
  wheel.told_rad_per_s += std::clamp(told_rad_per_s - wheel.told_rad_per_s, -most, most);
  // The spring is not wound up beyond what the motor can give.
  const double stretch = options_.torque_nm_per_a * options_.current_limit_a / kSpring;
  wheel.told_rad = std::clamp(wheel.told_rad + wheel.told_rad_per_s * step_s(), angle - stretch,
                              angle + stretch);
  const double wanted =
      kSpring * (wheel.told_rad - angle) + kDamper * (wheel.told_rad_per_s - speed);
  wheel.torque_nm = std::clamp(wanted, motor_torque_limit_nm(options_, speed, false),
                               motor_torque_limit_nm(options_, speed, true));
  data.qfrc_applied[wheel.speed] += wheel.torque_nm;
}

void RoverBody::resist(Wheel& wheel) {
  mjData_& data = engine().data();
  double most = 0.0;
  for (const Hold& hold : wheel.holds) {
    most += hold.footing.rolling_resistance * hold.load_n * wheel.what.radius_m;
  }
  const double speed = data.qvel[wheel.speed];
  wheel.wound_rad += speed * step_s();
  wheel.wound_rad = std::clamp(wheel.wound_rad, -most / kResistSpring, most / kResistSpring);
  const double torque = kResistSpring * wheel.wound_rad + kResistDamper * speed;
  data.qfrc_applied[wheel.speed] -= std::clamp(torque, -most, most);
}

void RoverBody::hold(Wheel& wheel) {
  const mjModel_& model = engine().model();
  mjData_& data = engine().data();
  std::array<mjtNum, 6> motion{};  // turn, then velocity of the hub, world axes
  mj_objectVelocity(&model, &data, mjOBJ_XBODY, wheel.body, motion.data(), 0);
  const Eigen::Map<const Eigen::Vector3d> turn(motion.data()), velocity(motion.data() + 3),
      hub(data.xpos + 3 * wheel.body);
  const mjtNum* R = data.xmat + 9 * wheel.body;
  const Eigen::Vector3d axle(R[1], R[4], R[7]);
  TyreContact contact;
  contact.rolling_m_per_s = data.qvel[wheel.speed] * wheel.what.radius_m;
  wheel.slip = 0.0;
  for (Hold& hold : wheel.holds) {
    const Eigen::Vector3d ahead = axle.cross(hold.normal);
    if (!(ahead.norm() > 0.1)) continue;  // on its side
    contact.normal = hold.normal;
    contact.ahead = ahead.normalized();
    contact.velocity_m_per_s = velocity + turn.cross(hold.place_m - hub);
    contact.load_n = hold.load_n;
    contact.footing = hold.footing;
    const Eigen::Vector3d force = tyre_force(contact, wheel.tyre, step_s(), hold.bristle_m);
    const std::array<mjtNum, 3> no_torque{};
    mj_applyFT(&model, &data, force.data(), no_torque.data(), hold.place_m.data(), wheel.body,
               data.qfrc_applied);
    constexpr double kTurnsM = 0.05;  // m/s
    if (std::abs(contact.rolling_m_per_s) > kTurnsM) {
      const double slip = -contact.velocity_m_per_s.dot(contact.ahead) / contact.rolling_m_per_s;
      wheel.slip = std::max(wheel.slip, std::clamp(slip, 0.0, 1.0));
    }
  }
}

WheelSample RoverBody::wheels() const {
  WheelSample sample;
  sample.stamp_ns = std::llround(1e9 * time_s());
  const double share = options_.drive == RoverModelOptions::Drive::kSkid ? 0.5 : 1.0;
  for (const Wheel& wheel : wheels_) {
    if (!wheel.what.driven) continue;
    (wheel.what.left ? sample.left_rad : sample.right_rad) +=
        share * (physics().data().qpos[wheel.position] - wheel.start_rad);
    (wheel.what.left ? sample.left_current_a : sample.right_current_a) +=
        wheel.torque_nm / options_.torque_nm_per_a;
  }
  return sample;
}

double RoverBody::slip(bool left) const {
  double most = 0.0;
  for (const Wheel& wheel : wheels_) {
    if (wheel.what.driven && wheel.what.left == left) most = std::max(most, wheel.slip);
  }
  return most;
}

double RoverBody::bumper_force_n() const {
  double sum = 0.0;
  for (const Touch& touch : touches()) {
    if (physics().name_of(touch.part) == kBumperPart) sum += touch.force_n.norm();
  }
  return sum;
}

bool RoverBody::bumper_pressed() const {
  return bumper_force_n() >= options_.bumper_force_n;
}

}  // namespace tread
