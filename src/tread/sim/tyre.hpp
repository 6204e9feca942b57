// How a wheel holds on to what it rolls on: bristles between the two that bend, slide and are
// rolled out (after the brush and LuGre models of tyres: Pacejka 2012, Canudas de Wit and others
// 1995).
//
// z is how far the tread has been moved over the ground since it took hold, in the plane of
// contact. Bristles pull back, F = -k z - c dz/dt, up to what friction gives, mu N; beyond it they
// slide. So a wheel at rest holds for good and never creeps. One that rolls lays down new bristles
// as it goes, so its tread slips over the ground while it pulls: with g the share of friction that
// is used, by the force and by the ground's rolling resistance together,
//   dz/dt = v + |rolling speed| s(|g|) g / |g|,   s(g) = slip log2(1 / (1 - g))
// which is the exponential law of shear of Janosi and Hanamoto (1961), g = 1 - exp(-s / K), with
// the surface's slip at g = 1/2. MuJoCo's own friction will not do: wheels that slide sideways
// while they turn hop over it, and it has no slip that grows with the pull.
#pragma once

#include <Eigen/Core>

#include "tread/sim/surface.hpp"

namespace tread {

struct TyreOptions {
  double stiffness_n_per_m = 2e4;
  double damping_n_s_per_m = 700.0;
};

// Where a wheel touches something, world axes.
struct TyreContact {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();           // out of the ground
  Eigen::Vector3d ahead = Eigen::Vector3d::UnitX();            // along which it rolls, in the plane
  Eigen::Vector3d velocity_m_per_s = Eigen::Vector3d::Zero();  // of the tread over the ground
  double rolling_m_per_s = 0.0;  // radius times turn, forward positive
  double load_n = 0.0;
  Footing footing;
};

// The slip of a rolling wheel by the share of friction that is used, 0 to 1.
[[nodiscard]] double slip_ratio(const Footing& footing, double used);

// The force of the ground on the wheel along the plane of contact, after a step of time.
// `bristle_m` is z, zero where the wheel has just come to.
[[nodiscard]] Eigen::Vector3d tyre_force(const TyreContact& contact, const TyreOptions& options,
                                         double step_s, Eigen::Vector3d& bristle_m);

}  // namespace tread
