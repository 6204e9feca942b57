#include "tread/sim/physics_model.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>

#include "physics_worlds.hpp"

namespace tread {
namespace {

// A ball of 1 cm on a free joint, first 5 m up.
RobotMjcf ball() {
  return {"", R"(<body pos="0 0 5"><freejoint/><geom name="ball" type="sphere" size="0.01" mass="1"
 contype="0" conaffinity="1" friction="0 0 0"/></body>)",
          ""};
}

PhysicsModel physics_of(const World& world) {
  auto physics = PhysicsModel::make(world, ball(), {}, {"ball"});
  if (!physics) throw std::runtime_error(physics.error().message());
  return std::move(*physics);
}

TEST(PhysicsModel, RaysFindWhatTheWorldSays) {
  World world = test::ground_world(20.0, 0.1, Surface::kSoil, [](double x, double y) {
    return test::rough_height(x, y) +
           0.03 * Random(static_cast<std::uint64_t>((x + 50.0) * 1e4 + (y + 50.0) * 1e7)).uniform();
  });
  world.ground.geometry.origin += Eigen::Vector2d(100.03, -41.7);  // no symmetry helps
  world.ground_surface.geometry = world.ground.geometry;
  const Eigen::Vector2d middle(100.03, -41.7);
  test::strew(world, 160, 9.0, 3);
  for (Solid& solid : world.solids) solid.T_world_solid.translation().head<2>() += middle;
  for (Solid& solid : world.solids) {
    solid.T_world_solid.translation().z() =
        ground_height(world, solid.T_world_solid.translation().head<2>());
  }
  const PhysicsModel physics = physics_of(world);
  Random dice(17);
  double worst = 0.0;
  int on_solids = 0;
  for (int i = 0; i < 20'000; ++i) {
    const Eigen::Vector2d place =
        middle + Eigen::Vector2d(dice.uniform(-9.9, 9.9), dice.uniform(-9.9, 9.9));
    const Eigen::Vector3d from(place.x(), place.y(), 4.0);
    const auto hit = physics.cast_ray(from, -Eigen::Vector3d::UnitZ());
    ASSERT_TRUE(hit) << place.transpose();
    const double error = std::abs(from.z() - hit->distance_m - top_height(world, place));
    worst = std::max(worst, error);
    on_solids += physics.is_solid(hit->part) ? 1 : 0;
    ASSERT_LT(error, 1e-4) << place.transpose() << " on " << physics.name_of(hit->part);
  }
  EXPECT_LT(worst, 1e-6) << "what floats allow";
  EXPECT_GT(on_solids, 2000);
  EXPECT_LT(on_solids, 18'000);
}

// Rays and contacts are computed by different code of MuJoCo.
TEST(PhysicsModel, ABallTouchesWhereTheWorldSays) {
  World world = test::ground_world(4.0, 0.2, Surface::kSoil, [](double x, double y) {
    return 0.1 * Random(static_cast<std::uint64_t>((x + 50.0) * 1e4 + (y + 50.0) * 1e7)).uniform();
  });
  world.solids.push_back(
      test::solid_at(Solid::Shape::kBox, {0.5, 0.5, 0.1}, {0.3, 0.2, 0.2}, {0.3, 0.2, 0.7}, "box"));
  PhysicsModel physics = physics_of(world);
  Random dice(5);
  constexpr double kRadius = 0.01;
  const auto touches_at = [&](const Eigen::Vector3d& p) {
    Isometry3d T = Isometry3d::Identity();
    T.translation() = p;
    EXPECT_TRUE(physics.set_robot_pose(T));
    return !physics.touches().empty();
  };
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector2d place(dice.uniform(-1.9, 1.9), dice.uniform(-1.9, 1.9));
    // The ball's middle over the dilated world: the highest of all spheres about what it may touch.
    double expected = -1.0;
    for (int ring = 0; ring <= 10; ++ring) {
      for (int k = 0; k < 48; ++k) {
        const double r = kRadius * ring / 10.0, angle = k * 0.1309;
        const double top =
            top_height(world, place + r * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
        expected = std::max(expected, top + std::sqrt(kRadius * kRadius - r * r));
      }
    }
    EXPECT_FALSE(touches_at({place.x(), place.y(), expected + 3e-4})) << place.transpose();
    EXPECT_TRUE(touches_at({place.x(), place.y(), expected - 3e-4})) << place.transpose();
  }
}

TEST(PhysicsModel, WhatIsUnderATreadDecidesItsFriction) {
  World world = test::flat_world(Surface::kSand);
  world.ground_materials.push_back(material_of(Surface::kConcrete, Season::kSummer, 0));
  const GridGeometry& cells = world.ground_surface.geometry;
  for (int y = 0; y < cells.rows; ++y) {
    for (int x = cells.columns / 2; x < cells.columns; ++x) world.ground_surface[{x, y}] = 1;
  }
  world.solids.push_back(test::block(3.0, 3.0, 0.5, 0.5, 0.2, "slab"));
  world.solids.back().material = material_of(Surface::kBark, Season::kSummer, 0);
  PhysicsModel physics = physics_of(world);
  const auto friction_at = [&](double x, double y, double z) {
    Isometry3d T = Isometry3d::Identity();
    T.translation() << x, y, z;
    EXPECT_TRUE(physics.set_robot_pose(T));
    return physics.treads().front().footing.friction;
  };
  EXPECT_EQ(friction_at(-3.0, 0.0, 0.0099), footing_of(Surface::kSand).friction);
  EXPECT_EQ(friction_at(3.0, 0.0, 0.0099), footing_of(Surface::kConcrete).friction);
  EXPECT_EQ(friction_at(3.0, 3.0, 0.2099), footing_of(Surface::kBark).friction);
  EXPECT_EQ(friction_at(-3.0, 0.0, 1.0), footing_of(Surface::kSand).friction) << "in the air";
}

TEST(PhysicsModel, ABallFallsAndLiesWithItsWeight) {
  const World world = test::flat_world();
  PhysicsModel physics = physics_of(world);
  Isometry3d T = Isometry3d::Identity();
  T.translation() << 0.1, 0.2, 1.0;
  ASSERT_TRUE(physics.set_robot_pose(T));
  ASSERT_TRUE(physics.set_time(0.0));
  for (int i = 0; i < 1000; ++i) ASSERT_TRUE(physics.begin_step() && physics.end_step());
  EXPECT_NEAR(physics.time_s(), 2.0, 1e-9);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Touch& touch : physics.touches()) {
    sum += touch.force_n;
    EXPECT_EQ(physics.name_of(touch.other), "the ground");
    EXPECT_EQ(physics.name_of(touch.part), "ball");
    EXPECT_GT(touch.normal.z(), 0.999);
  }
  EXPECT_NEAR(sum.z(), 9.81, 0.001 * 9.81);
  EXPECT_LT(sum.head<2>().norm(), 0.001 * 9.81);
  EXPECT_NEAR(physics.treads().front().load_n, 9.81, 0.01);
}

TEST(PhysicsModel, PeopleAreWhereTheyWalk) {
  World world = test::flat_world();
  Person person;
  person.name = "walker";
  person.path_m = {{-3.0, 0.0}, {3.0, 0.0}};
  world.people = {person};
  PhysicsModel physics = physics_of(world);
  for (const double time_s : {0.0, 1.0, 2.5, 7.0}) {
    ASSERT_TRUE(physics.set_time(time_s));
    const std::vector<Isometry3d> parts = person_pose(world, person, time_s);
    const Eigen::Vector3d head = parts.back().translation();
    const auto hit = physics.cast_ray(head + Eigen::Vector3d(0, 0, 1), -Eigen::Vector3d::UnitZ());
    ASSERT_TRUE(hit);
    EXPECT_EQ(physics.name_of(hit->part), "walker head");
    EXPECT_FALSE(physics.is_solid(hit->part));
    EXPECT_NEAR(hit->distance_m, 1.0 - 0.065 * person.height_m, 1e-6);
  }
}

void expect_refused(const World& world, const std::string& where, const std::string& what) {
  const auto physics = PhysicsModel::make(world, ball(), {}, {});
  ASSERT_FALSE(physics) << what;
  EXPECT_NE(physics.error().message().find(where), std::string::npos) << physics.error().message();
  EXPECT_NE(physics.error().message().find(what), std::string::npos) << physics.error().message();
}

TEST(PhysicsModel, BadGroundIsNamed) {
  World world = test::flat_world();
  world.ground[{3, 3}] = std::numeric_limits<float>::quiet_NaN();
  expect_refused(world, "ground", "not finite");
  world = test::flat_world();
  world.ground_surface[{1, 1}] = 7;
  expect_refused(world, "ground", "material 7");
  world = test::flat_world();
  world.ground_materials.clear();
  expect_refused(world, "ground", "material 0");
  world.ground = Grid<float>({0.1, Eigen::Vector2d::Zero(), 1, 5});
  expect_refused(world, "ground", "1 x 5");
  world = test::flat_world();
  world.ground_surface = Grid<std::uint8_t>({0.1, Eigen::Vector2d::Zero(), 5, 5});
  expect_refused(world, "ground", "different cells");
  world = test::flat_world();
  world.ground.geometry.resolution_m = 0.0;
  world.ground_surface.geometry = world.ground.geometry;
  expect_refused(world, "ground", "no size");
  expect_refused(World{}, "ground", "0 x 0");
}

TEST(PhysicsModel, BadThingsAreNamed) {
  const auto with = [](const auto& change) {
    World world = test::flat_world();
    world.solids = {test::block(1.0, 0.0, 0.2, 0.2, 0.3, "pallets[0]"),
                    test::block(2.0, 0.0, 0.2, 0.2, 0.3, R"(<odd "name"> & more)")};
    change(world);
    return world;
  };
  EXPECT_TRUE(PhysicsModel::make(with([](World&) {}), ball(), {}, {})) << "odd names do not matter";
  expect_refused(with([](World& w) { w.solids[1].half_m.y() = 0.0; }), R"(<odd "name"> & more)",
                 "no size");
  expect_refused(with([](World& w) { w.solids[0].half_m.x() = std::nan(""); }), "pallets[0]",
                 "no size");
  expect_refused(with([](World& w) { w.solids[0].T_world_solid.linear() *= 2.0; }), "pallets[0]",
                 "pose");
  expect_refused(with([](World& w) { w.solids[0].T_world_solid.translation().z() = std::nan(""); }),
                 "pallets[0]", "pose");
  expect_refused(with([](World& w) {
                   w.solids[0].shape = Solid::Shape::kCylinder;
                   w.solids[0].half_m.x() = 0.1;
                 }),
                 "pallets[0]", "radii");
  expect_refused(with([](World& w) {
                   w.solids[1].shape = Solid::Shape::kHull;
                   w.solids[1].hull = 2;
                 }),
                 "odd", "no hull 2");
  expect_refused(with([](World& w) {
                   w.solids[0].shape = Solid::Shape::kHull;
                   Mesh flat = test::rock_hull(1);
                   for (Eigen::Vector3f& v : flat.vertices) v.z() = 0.0F;
                   w.hulls = {flat};
                 }),
                 "pallets[0]", "no volume");
  expect_refused(with([](World& w) {
                   w.people.push_back({"someone", {}, 1.0, 1.7, 0.0, w.solids[0].material});
                 }),
                 "someone", "no way");
}

TEST(PhysicsModel, WhatMuJoCoCannotDoIsAnError) {
  const World world = test::flat_world();
  RobotMjcf robot = ball();
  // Memory for a ball in the air, but not for its contacts: MuJoCo would end the program.
  bool stopped = false;
  for (int words = 100; words < 1'000'000 && !stopped; words += words / 4) {
    robot.settings = "<size nstack=\"" + std::to_string(words) + "\"/>";
    auto starved = PhysicsModel::make(world, robot, {}, {});
    if (!starved) continue;
    Isometry3d T = Isometry3d::Identity();
    T.translation().z() = 0.009;
    const Status lying = starved->set_robot_pose(T);
    if (lying) break;
    stopped = lying.error().message().find("MuJoCo stopped") != std::string::npos;
  }
  EXPECT_TRUE(stopped);
  robot.settings = "<no such thing";
  EXPECT_FALSE(PhysicsModel::make(world, robot, {}, {}));
  EXPECT_FALSE(PhysicsModel::make(world, ball(), {}, {"wheel"})) << "no such tread";
  PhysicsOptions options;
  options.contact_s = options.step_s;
  const auto stiff = PhysicsModel::make(world, ball(), options, {});
  ASSERT_FALSE(stiff);
  EXPECT_NE(stiff.error().message().find("contact_s"), std::string::npos);
  PhysicsModel physics = physics_of(world);
  Isometry3d T = Isometry3d::Identity();
  T.translation() << 0.0, 0.0, std::nan("");
  EXPECT_FALSE(physics.set_robot_pose(T) && physics.begin_step() && physics.end_step());
}

}  // namespace
}  // namespace tread
