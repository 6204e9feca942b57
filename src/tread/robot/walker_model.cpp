#include "tread/robot/walker_model.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "tread/geometry/pose.hpp"

namespace tread {
namespace {

constexpr double kGravity = 9.81;  // m/s^2

double side_of(int leg) {
  return is_left(leg) ? 1.0 : -1.0;
}

// Lengths along a leg up to a point of it: to the foot all three, to the middle of the upper leg l0
// and half of l1.
struct Lengths {
  double l0 = 0.0, l1 = 0.0, l2 = 0.0;
};

Lengths of_foot(const WalkerModelOptions& options) {
  return {options.hip_m, options.upper_m, options.lower_m};
}

// Forward and downward in the plane of the leg, from its HAA axis.
struct InPlane {
  double x, r;
};
InPlane in_plane(const Lengths& l, const Eigen::Vector3d& q) {
  return {-l.l1 * std::sin(q.y()) - l.l2 * std::sin(q.y() + q.z()),
          l.l0 + l.l1 * std::cos(q.y()) + l.l2 * std::cos(q.y() + q.z())};
}

Eigen::Vector3d point(const WalkerModelOptions& options, int leg, const Lengths& l,
                      const Eigen::Vector3d& q) {
  const auto [x, r] = in_plane(l, q);
  return hip_position(options, leg) +
         Eigen::Vector3d(x, -side_of(leg) * r * std::sin(q.x()), -r * std::cos(q.x()));
}

Eigen::Matrix3d point_jacobian(int leg, const Lengths& l, const Eigen::Vector3d& q) {
  const auto [x, r] = in_plane(l, q);
  const double s = side_of(leg), s0 = std::sin(q.x()), c0 = std::cos(q.x());
  const double s12 = std::sin(q.y() + q.z()), c12 = std::cos(q.y() + q.z());
  Eigen::Matrix3d J;
  const auto column = [&](int i, double dx, double dr) {
    J.col(i) = Eigen::Vector3d(dx, -s * s0 * dr, -c0 * dr);
  };
  J.col(0) = Eigen::Vector3d(0.0, -s * r * c0, r * s0);
  column(1, l.l0 - r, x);
  column(2, -l.l2 * c12, -l.l2 * s12);
  return J;
}

// Each link as its middle and its mass.
struct LinkMass {
  Lengths middle;
  double mass_kg;
};
std::array<LinkMass, 3> link_masses(const WalkerModelOptions& options) {
  const double l0 = options.hip_m, l1 = options.upper_m, l2 = options.lower_m;
  return {{{{l0 / 2.0, 0.0, 0.0}, options.hip_kg},
           {{l0, l1 / 2.0, 0.0}, options.upper_kg},
           {{l0, l1, l2 / 2.0}, options.lower_kg}}};
}

void add_limits(OptionSet& set, const std::string& name, JointLimits& limits) {
  constexpr double kTurn = std::numbers::pi;
  set.add(name + "_low_rad", limits.low_rad, "least angle of a hind leg's " + name, -kTurn, kTurn);
  set.add(name + "_high_rad", limits.high_rad, "largest angle of a hind leg's " + name, -kTurn,
          kTurn);
  set.require({name + "_low_rad", name + "_high_rad"}, "the least must be below the largest angle",
              [&limits] { return limits.low_rad < limits.high_rad; });
}

void add_masses(OptionSet& set, WalkerModelOptions& options) {
  set.add("trunk_kg", options.trunk_kg, "mass of the trunk", 1.0, 1000.0);
  set.add("trunk_centre_x_m", options.trunk_centre_m.x(), "centre of that mass, forward", -1, 1);
  set.add("trunk_centre_y_m", options.trunk_centre_m.y(), "centre of that mass, left", -1, 1);
  set.add("trunk_centre_z_m", options.trunk_centre_m.z(), "centre of that mass, upward", -1, 1);
  set.add("trunk_inertia_x_kg_m2", options.trunk_inertia_kg_m2.x(), "of the trunk, rolling", 1e-3,
          1e3);
  set.add("trunk_inertia_y_kg_m2", options.trunk_inertia_kg_m2.y(), "of the trunk, pitching", 1e-3,
          1e3);
  set.add("trunk_inertia_z_kg_m2", options.trunk_inertia_kg_m2.z(), "of the trunk, turning", 1e-3,
          1e3);
  set.add("hip_kg", options.hip_kg, "mass of the link from HAA to HFE", 1e-2, 100.0);
  set.add("upper_kg", options.upper_kg, "mass of an upper leg", 1e-2, 100.0);
  set.add("lower_kg", options.lower_kg, "mass of a lower leg", 1e-2, 100.0);
  set.require({"trunk_inertia_x_kg_m2", "trunk_inertia_y_kg_m2", "trunk_inertia_z_kg_m2"},
              "no inertia of a body is more than the sum of the other two", [&options] {
                const Eigen::Vector3d& I = options.trunk_inertia_kg_m2;
                return 2.0 * I.maxCoeff() <= I.sum();
              });
}

// The smallest forces of the ground on the feet that carry the weight: f = A+ W, body axes.
std::array<Eigen::Vector3d, kLegs> bearing_forces(const WalkerModelOptions& options,
                                                  const std::array<double, kLegJoints>& joints,
                                                  const Eigen::Vector3d& up) {
  Eigen::Matrix<double, 6, 12> A;
  for (int leg = 0; leg < kLegs; ++leg) {
    A.block<3, 3>(0, 3 * leg).setIdentity();
    A.block<3, 3>(3, 3 * leg) = hat(foot_position(options, leg, joints_of_leg(joints, leg)));
  }
  const Eigen::Vector3d weight = walker_mass_kg(options) * kGravity * up;
  Vector6d W;
  W << weight, walker_centre_of_mass(options, joints).cross(weight);
  const Eigen::Matrix<double, 12, 1> f =
      A.transpose() * Matrix6d(A * A.transpose()).fullPivLu().solve(W);
  std::array<Eigen::Vector3d, kLegs> forces;
  for (int leg = 0; leg < kLegs; ++leg)
    forces[static_cast<std::size_t>(leg)] = f.segment<3>(3 * leg);
  return forces;
}

}  // namespace

OptionSet describe(WalkerModelOptions& options) {
  OptionSet set;
  set.add("hip_spacing_m", options.hip_spacing_m, "between front and hind hips", 0.05, 5.0);
  set.add("hip_width_m", options.hip_width_m, "between left and right hips", 0.05, 5.0);
  set.add("hip_m", options.hip_m, "from HAA to HFE", 0.0, 1.0);
  set.add("upper_m", options.upper_m, "from HFE to KFE", 0.05, 2.0);
  set.add("lower_m", options.lower_m, "from KFE to the middle of the foot", 0.05, 2.0);
  set.add("foot_radius_m", options.foot_radius_m, "of the ball of the foot", 0.005, 0.2);
  set.add("trunk_length_m", options.trunk_length_m, "of the trunk", 0.1, 5.0);
  set.add("trunk_top_width_m", options.trunk_top_width_m, "of the trunk above", 0.05, 3.0);
  set.add("trunk_bottom_width_m", options.trunk_bottom_width_m, "of the trunk below", 0.05, 3.0);
  set.add("trunk_height_m", options.trunk_height_m, "of the trunk", 0.05, 2.0);
  set.add("trunk_below_m", options.trunk_below_m, "underside of the trunk under the hips", -1, 1);
  add_masses(set, options);
  add_limits(set, "haa", options.haa);
  add_limits(set, "hfe", options.hfe);
  add_limits(set, "kfe", options.kfe);
  set.add("haa_torque_nm", options.haa_torque_nm, "most torque of HAA", 1.0, 1e4);
  set.add("hfe_torque_nm", options.hfe_torque_nm, "most torque of HFE", 1.0, 1e4);
  set.add("kfe_torque_nm", options.kfe_torque_nm, "most torque of KFE", 1.0, 1e4);
  set.add("joint_speed_rad_per_s", options.joint_speed_rad_per_s, "up to which joints are driven",
          0.1, 100.0);
  set.add("joint_inertia_kg_m2", options.joint_inertia_kg_m2, "of the drive, on its joint", 0.001,
          10.0);
  return set;
}

OptionSet describe(StandOptions& options) {
  OptionSet set;
  set.add("stiffness_nm_per_rad", options.stiffness_nm_per_rad, "of every joint", 0.0, 1e4);
  set.add("damping_nm_s_per_rad", options.damping_nm_s_per_rad, "of every joint", 0.0, 100.0);
  return set;
}

const char* leg_name(int leg) {
  constexpr std::array<const char*, kLegs> kNames{"left front", "right front", "left hind",
                                                  "right hind"};
  return kNames[static_cast<std::size_t>(leg)];
}

const char* joint_name(int joint) {
  constexpr std::array<const char*, 3> kNames{"HAA", "HFE", "KFE"};
  return kNames[static_cast<std::size_t>(joint)];
}

JointLimits joint_limits(const WalkerModelOptions& options, int leg, int joint) {
  const JointLimits& hind = joint == 0 ? options.haa : joint == 1 ? options.hfe : options.kfe;
  const bool mirrored = is_front(leg) && joint != 0;
  return mirrored ? JointLimits{-hind.high_rad, -hind.low_rad} : hind;
}

double joint_torque_limit_nm(const WalkerModelOptions& options, int joint) {
  return joint == 0   ? options.haa_torque_nm
         : joint == 1 ? options.hfe_torque_nm
                      : options.kfe_torque_nm;
}

std::array<double, kLegJoints> home_joints() {
  return {-0.2, 0.75, -1.5, -0.2, 0.75, -1.5, -0.2, -0.75, 1.5, -0.2, -0.75, 1.5};
}

Eigen::Vector3d joints_of_leg(const std::array<double, kLegJoints>& joints, int leg) {
  const auto first = static_cast<std::size_t>(3 * leg);
  return {joints[first], joints[first + 1], joints[first + 2]};
}

Eigen::Vector3d hip_position(const WalkerModelOptions& options, int leg) {
  return {(is_front(leg) ? 0.5 : -0.5) * options.hip_spacing_m,
          side_of(leg) * 0.5 * options.hip_width_m, 0.0};
}

Eigen::Vector3d foot_position(const WalkerModelOptions& options, int leg,
                              const Eigen::Vector3d& joints_rad) {
  return point(options, leg, of_foot(options), joints_rad);
}

Eigen::Matrix3d foot_jacobian(const WalkerModelOptions& options, int leg,
                              const Eigen::Vector3d& joints_rad) {
  return point_jacobian(leg, of_foot(options), joints_rad);
}

LegJoints joints_for_foot(const WalkerModelOptions& options, int leg,
                          const Eigen::Vector3d& p_body_foot) {
  const Eigen::Vector3d p = p_body_foot - hip_position(options, leg);
  const double l1 = options.upper_m, l2 = options.lower_m;
  const double along = -p.x(), down = std::hypot(p.y(), p.z()) - options.hip_m;
  const double length = std::hypot(along, down);
  const double cosine = (length * length - l1 * l1 - l2 * l2) / (2.0 * l1 * l2);
  LegJoints found;
  found.missed_m = std::max({0.0, length - (l1 + l2), std::abs(l1 - l2) - length});
  const double knee = std::acos(std::clamp(cosine, -1.0, 1.0)) * (is_front(leg) ? -1.0 : 1.0);
  found.joints_rad << std::atan2(-side_of(leg) * p.y(), -p.z()),
      std::atan2(along, down) - std::atan2(l2 * std::sin(knee), l1 + l2 * std::cos(knee)), knee;
  // The hip swings over its top only for feet above it, which limits forbid anyway.
  found.joints_rad.y() = std::remainder(found.joints_rad.y(), 2.0 * std::numbers::pi);
  found.within_limits = found.joints_rad.allFinite();
  for (int joint = 0; joint < 3; ++joint) {
    constexpr double kRounding = 1e-9;
    const auto [low, high] = joint_limits(options, leg, joint);
    const double q = found.joints_rad(joint);
    found.within_limits &= q >= low - kRounding && q <= high + kRounding;
  }
  return found;
}

double walker_mass_kg(const WalkerModelOptions& options) {
  return options.trunk_kg + kLegs * (options.hip_kg + options.upper_kg + options.lower_kg);
}

Eigen::Vector3d walker_centre_of_mass(const WalkerModelOptions& options,
                                      const std::array<double, kLegJoints>& joints_rad) {
  Eigen::Vector3d sum = options.trunk_kg * options.trunk_centre_m;
  for (int leg = 0; leg < kLegs; ++leg) {
    for (const LinkMass& link : link_masses(options)) {
      sum += link.mass_kg * point(options, leg, link.middle, joints_of_leg(joints_rad, leg));
    }
  }
  return sum / walker_mass_kg(options);
}

JointCommand stand_command(const WalkerModelOptions& options,
                           const std::array<double, kLegJoints>& joints_rad,
                           const Eigen::Vector3d& up_body, const StandOptions& stand) {
  JointCommand command;
  command.position_rad = joints_rad;
  command.stiffness_nm_per_rad.fill(stand.stiffness_nm_per_rad);
  command.damping_nm_s_per_rad.fill(stand.damping_nm_s_per_rad);
  const auto forces = bearing_forces(options, joints_rad, up_body);
  for (int leg = 0; leg < kLegs; ++leg) {
    const Eigen::Vector3d q = joints_of_leg(joints_rad, leg);
    Eigen::Vector3d torque =
        -foot_jacobian(options, leg, q).transpose() * forces[static_cast<std::size_t>(leg)];
    for (const LinkMass& link : link_masses(options)) {
      torque += link.mass_kg * kGravity * point_jacobian(leg, link.middle, q).transpose() * up_body;
    }
    for (int joint = 0; joint < 3; ++joint) {
      command.torque_nm[static_cast<std::size_t>(3 * leg + joint)] = torque(joint);
    }
  }
  return command;
}

}  // namespace tread
