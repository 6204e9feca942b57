// The walking robot: a hydraulic quadruped of 1 m and 85 kg with three joints a leg (HyQ: Semini
// and others 2011 and 2017; numbers of its published description, hyq-description). Legs are
// counted left front, right front, left hind, right hind; joints of a leg are HAA (swings the leg
// out), HFE (swings it forward) and KFE (the knee; knees of front and hind legs point at each
// other). Body axes: x forward, y left, z up, from the middle between the four HAA axes, which lie
// along x.
//
// With s = 1 on the left and -1 on the right, lengths l0 (HAA to HFE), l1, l2 (to the middle of the
// ball of the foot):
//   r = l0 + l1 cos q1 + l2 cos(q1 + q2)        how far the foot is from the axis of HAA
//   p = hip + (-l1 sin q1 - l2 sin(q1 + q2), -s r sin q0, -r cos q0)
#pragma once

#include <Eigen/Core>
#include <array>

#include "tread/core/options.hpp"
#include "tread/robot/robot.hpp"

namespace tread {

struct JointLimits {
  double low_rad = 0.0;
  double high_rad = 0.0;
  [[nodiscard]] bool operator==(const JointLimits&) const = default;
};

struct WalkerModelOptions {
  // Lengths.
  double hip_spacing_m = 0.747;    // of the HFE axes of front and hind legs
  double hip_width_m = 0.414;      // of the HAA axes of left and right legs
  double hip_m = 0.08;             // l0
  double upper_m = 0.35;           // l1
  double lower_m = 0.341;          // l2
  double foot_radius_m = 0.02175;  // of the ball
  // The trunk narrows downwards. Its underside is `trunk_below_m` under the HAA axes: so we read
  // the description, since its centre of mass then lies inside.
  double trunk_length_m = 1.0;
  double trunk_top_width_m = 0.34;
  double trunk_bottom_width_m = 0.18;
  double trunk_height_m = 0.18;
  double trunk_below_m = 0.085;
  // Masses, 84.8 kg together. Links are even rods: the description has no better.
  double trunk_kg = 58.96;
  Eigen::Vector3d trunk_centre_m{0.01, 0.0, 0.0036};  // of its mass
  Eigen::Vector3d trunk_inertia_kg_m2{1.573, 8.502, 9.195};
  double hip_kg = 2.93;
  double upper_kg = 2.638;
  double lower_kg = 0.881;
  // Of hind legs; HFE and KFE of front legs are mirrored.
  JointLimits haa{-1.2217, 0.4363};  // -70 to 25 degrees
  JointLimits hfe{-1.2217, 0.8727};  // -70 to 50
  JointLimits kfe{0.3491, 2.4435};   // 20 to 140
  // Peaks of the machine of 2015 (the description allows 150 Nm everywhere).
  double haa_torque_nm = 120.0;
  double hfe_torque_nm = 181.0;
  double kfe_torque_nm = 181.0;
  double joint_speed_rad_per_s = 12.0;  // beyond it there is no oil to push on with
  double joint_inertia_kg_m2 = 0.02;    // of what moves in a cylinder, on its joint
  [[nodiscard]] bool operator==(const WalkerModelOptions&) const = default;
};
[[nodiscard]] OptionSet describe(WalkerModelOptions& options);

[[nodiscard]] constexpr bool is_left(int leg) {
  return leg % 2 == 0;
}
[[nodiscard]] constexpr bool is_front(int leg) {
  return leg < 2;
}
// "left front", "HAA"
[[nodiscard]] const char* leg_name(int leg);
[[nodiscard]] const char* joint_name(int joint);

// `joint` is 0 to 2 within the leg.
[[nodiscard]] JointLimits joint_limits(const WalkerModelOptions& options, int leg, int joint);
[[nodiscard]] double joint_torque_limit_nm(const WalkerModelOptions& options, int joint);
// All twelve, standing at ease: feet 0.574 m below the HAA axes.
[[nodiscard]] std::array<double, kLegJoints> home_joints();
[[nodiscard]] Eigen::Vector3d joints_of_leg(const std::array<double, kLegJoints>& joints, int leg);

// Where the HAA axis of a leg carries it, body axes.
[[nodiscard]] Eigen::Vector3d hip_position(const WalkerModelOptions& options, int leg);
// The middle of the ball of the foot, body axes.
[[nodiscard]] Eigen::Vector3d foot_position(const WalkerModelOptions& options, int leg,
                                            const Eigen::Vector3d& joints_rad);
// Its derivative by the three joints.
[[nodiscard]] Eigen::Matrix3d foot_jacobian(const WalkerModelOptions& options, int leg,
                                            const Eigen::Vector3d& joints_rad);

struct LegJoints {
  Eigen::Vector3d joints_rad = Eigen::Vector3d::Zero();  // nearest that the lengths allow
  double missed_m = 0.0;  // how far from the wanted place they leave the foot
  bool within_limits = false;
  [[nodiscard]] bool reached() const { return missed_m < 1e-9 && within_limits; }
};
// The joints that put a foot to a place in body axes, the leg hanging down from its hip and the
// knee bent to its side. Straight below the hip legs reach from 0.317 to 0.760 m.
[[nodiscard]] LegJoints joints_for_foot(const WalkerModelOptions& options, int leg,
                                        const Eigen::Vector3d& p_body_foot);

[[nodiscard]] double walker_mass_kg(const WalkerModelOptions& options);
// Of the whole robot, body axes.
[[nodiscard]] Eigen::Vector3d walker_centre_of_mass(
    const WalkerModelOptions& options, const std::array<double, kLegJoints>& joints_rad);

struct StandOptions {
  double stiffness_nm_per_rad = 600.0;
  double damping_nm_s_per_rad = 15.0;
  [[nodiscard]] bool operator==(const StandOptions&) const = default;
};
[[nodiscard]] OptionSet describe(StandOptions& options);

// Holds the joints where they are given: springs about them, beside torques that bear the weight.
// Of all forces of the ground on the four feet that carry it the smallest are taken, f = A+ W; the
// torques are -J' f and what the links weigh themselves. `up_body` is the vertical in body axes.
[[nodiscard]] JointCommand stand_command(const WalkerModelOptions& options,
                                         const std::array<double, kLegJoints>& joints_rad,
                                         const Eigen::Vector3d& up_body,
                                         const StandOptions& stand = {});

}  // namespace tread
