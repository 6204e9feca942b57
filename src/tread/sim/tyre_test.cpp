#include "tread/sim/tyre.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace tread {
namespace {

constexpr double kStep = 0.002;

TyreContact standing(double load_n, const Footing& footing) {
  TyreContact contact;
  contact.load_n = load_n;
  contact.footing = footing;
  return contact;
}

TEST(Tyre, SlipIsTheSurfacesAtHalfTheTraction) {
  const Footing sand = footing_of(Surface::kSand);
  EXPECT_EQ(slip_ratio(sand, 0.0), 0.0);
  EXPECT_NEAR(slip_ratio(sand, 0.5), sand.slip, 1e-12);
  EXPECT_NEAR(slip_ratio(sand, 0.75), 2.0 * sand.slip, 1e-12);
  EXPECT_LT(slip_ratio(sand, 1.0), 1.0) << "then it slides instead";
  EXPECT_GT(slip_ratio(sand, 0.5), 5.0 * slip_ratio(footing_of(Surface::kConcrete), 0.5));
}

TEST(Tyre, AtRestItIsASpringThatDoesNotCreep) {
  const Footing footing{0.8, 0.1, 0.2};
  const TyreOptions options;
  TyreContact contact = standing(100.0, footing);
  Eigen::Vector3d bristle = Eigen::Vector3d::Zero();
  contact.velocity_m_per_s << 0.1, -0.05, 0.3;  // a hop does not matter
  (void)tyre_force(contact, options, kStep, bristle);
  EXPECT_NEAR((bristle - Eigen::Vector3d(2e-4, -1e-4, 0.0)).norm(), 0.0, 1e-12);
  contact.velocity_m_per_s.setZero();
  Eigen::Vector3d first = tyre_force(contact, options, kStep, bristle);
  EXPECT_NEAR((first + options.stiffness_n_per_m * bristle).norm(), 0.0, 1e-9);
  for (int i = 0; i < 10'000; ++i) {
    ASSERT_EQ(tyre_force(contact, options, kStep, bristle), first);
  }
}

TEST(Tyre, SlidingItPullsBackWithFriction) {
  const Footing footing{0.6, 0.0, 0.1};
  TyreContact contact = standing(200.0, footing);
  contact.velocity_m_per_s << 0.3, -0.4, 0.0;
  Eigen::Vector3d bristle = Eigen::Vector3d::Zero(), force;
  for (int i = 0; i < 500; ++i) force = tyre_force(contact, {}, kStep, bristle);
  EXPECT_NEAR((force - Eigen::Vector3d(-72.0, 96.0, 0.0)).norm(), 0.0, 0.1);
  contact.load_n = 0.0;
  EXPECT_EQ(tyre_force(contact, {}, kStep, bristle), Eigen::Vector3d::Zero());
  EXPECT_EQ(bristle, Eigen::Vector3d::Zero()) << "in the air it lets go";
}

TEST(Tyre, ForcesStayInThePlaneOfContact) {
  TyreContact contact = standing(100.0, {0.7, 0.05, 0.1});
  contact.normal = Eigen::Vector3d(0.3, -0.2, 0.9).normalized();
  contact.velocity_m_per_s << 0.5, 0.2, -0.8;
  Eigen::Vector3d bristle(1.0, 1.0, 1.0);
  const Eigen::Vector3d force = tyre_force(contact, {}, kStep, bristle);
  EXPECT_NEAR(force.dot(contact.normal), 0.0, 1e-9);
  EXPECT_NEAR(bristle.dot(contact.normal), 0.0, 1e-9);
  EXPECT_LE(force.norm(), 70.0 + 1e-9);
}

// A cart of given mass pulled back by a given force, on a wheel that is turned at a given speed.
double settled_slip(double share, const Footing& footing) {
  const double load = 200.0, mass = 20.0, rolling = 0.5;
  TyreContact contact = standing(load, footing);
  contact.rolling_m_per_s = rolling;
  double speed = rolling;
  Eigen::Vector3d bristle = Eigen::Vector3d::Zero();
  for (int i = 0; i < 20'000; ++i) {
    contact.velocity_m_per_s.x() = speed - rolling;
    const double pull = tyre_force(contact, {}, kStep, bristle).x();
    speed += kStep / mass * (pull - share * footing.friction * load);
  }
  return 1.0 - speed / rolling;
}

TEST(Tyre, ARollingWheelSlipsAsItPulls) {
  const Footing loose{0.5, 0.0, 0.2};
  for (const double share : {0.1, 0.3, 0.5, 0.7, 0.85}) {
    EXPECT_NEAR(settled_slip(share, loose), slip_ratio(loose, share),
                0.02 * slip_ratio(loose, share))
        << share;
    EXPECT_NEAR(settled_slip(-share, loose), -slip_ratio(loose, share),
                0.02 * slip_ratio(loose, share))
        << "pushed " << share;
  }
  // Rolling resistance uses its part of what friction can give.
  const Footing resisting{0.5, 0.15, 0.2};
  EXPECT_NEAR(settled_slip(0.4, resisting), slip_ratio(resisting, 0.7), 0.01);
}

}  // namespace
}  // namespace tread
