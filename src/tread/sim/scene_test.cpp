// Rays against what is known without casting any: heights of the ground, planes, quadrics.
#include "tread/sim/scene.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "sim_worlds.hpp"

namespace tread {
namespace {

using Eigen::Vector3d;
using Shape = Solid::Shape;
using testing::make_solid;
using testing::octahedron;
using testing::shared;
using testing::world_with_ground;

Scene scene_of(World world) {
  Result<Scene> scene = Scene::make(shared(std::move(world)));
  EXPECT_TRUE(scene) << scene.error().message();
  return std::move(*scene);
}

// Raw 32 bits as a number from -1 to 1: the same in every standard library.
double any(std::mt19937& random) {
  return static_cast<double>(random()) / 2147483648.0 - 1.0;
}
Vector3d any_direction(std::mt19937& random) {
  Vector3d d;
  do d = Vector3d(any(random), any(random), any(random));
  while (d.norm() > 1.0 || d.norm() < 0.1);
  return d.normalized();
}

// Every point that a ray meets on rough ground lies on the surface that world.hpp describes, over a
// world of 120 m that lies half a thousand kilometres from its origin.
TEST(Scene, RaysMeetTheGroundOfTheWorld) {
  World world = world_with_ground(Surface::kSoil, 120.0, 0.2, [](double x, double y) {
    return std::sin(0.7 * x) * std::cos(0.9 * y) + 0.3 * std::sin(3.0 * x + y);
  });
  const Eigen::Vector2d away(450000.0, -320000.0);
  world.ground.geometry.origin += away;
  world.ground_surface.geometry.origin += away;
  const World copy = world;
  const Scene scene = scene_of(std::move(world));
  std::mt19937 random(1);
  int met = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vector3d from(away.x() + 55.0 * any(random), away.y() + 55.0 * any(random), 3.0);
    Vector3d d = any_direction(random);
    d.z() = -std::abs(d.z());
    const RayHit hit = scene.cast(from, d);
    if (hit.kind != HitKind::kGround) continue;
    ++met;
    const Vector3d p = from + hit.distance_m * d;
    // Across the surface, not upwards: at a grazing ray what is far along is near across.
    EXPECT_LT(std::abs(p.z() - ground_height(copy, p.head<2>())) * hit.normal.z(), 1e-6);
    EXPECT_LT((hit.normal - ground_normal(copy, p.head<2>())).norm(), 1e-6) << p.transpose();
  }
  EXPECT_GT(met, 1800);
}

TEST(Scene, GroundEndsAtTheCentresOfItsOutermostCells) {
  const Scene scene = scene_of(world_with_ground(Surface::kSoil, 4.0, 0.5));
  for (const double x : {-1.7499, 0.0, 1.7499}) {
    EXPECT_EQ(scene.cast({x, 0.1, 1.0}, {0.0, 0.0, -2.0}).kind, HitKind::kGround) << x;
  }
  for (const double x : {-1.7501, 1.7501, 5.0}) {
    EXPECT_EQ(scene.cast({x, 0.1, 1.0}, {0.0, 0.0, -1.0}).kind, HitKind::kNothing) << x;
  }
  // From below, too; and a distance in metres whatever the length of the direction.
  const RayHit hit = scene.cast({0.3, 0.2, -2.0}, {0.0, 0.0, 10.0});
  EXPECT_EQ(hit.kind, HitKind::kGround);
  EXPECT_NEAR(hit.distance_m, 2.0, 1e-9);
}

// What a point in the solid's own axes is of its surface: 0 on it.
double off_surface(const Solid& solid, const Vector3d& p) {
  const Vector3d q = p.cwiseQuotient(solid.half_m);
  switch (solid.shape) {
    case Shape::kBox:
      return (q.cwiseAbs().maxCoeff() - 1.0) * solid.half_m.minCoeff();
    case Shape::kCylinder:
      return (std::max(q.head<2>().norm(), std::abs(q.z())) - 1.0) * solid.half_m.minCoeff();
    case Shape::kEllipsoid:
      return (q.norm() - 1.0) * solid.half_m.minCoeff();
    case Shape::kHull:
      return (q.lpNorm<1>() - 1.0) * solid.half_m.minCoeff();
  }
  return 1.0;
}

TEST(Scene, RaysMeetEveryShapeWhereItsEquationSays) {
  for (const Shape shape : {Shape::kBox, Shape::kCylinder, Shape::kEllipsoid, Shape::kHull}) {
    World world = world_with_ground(Surface::kSoil, 2.0, 0.5);
    world.hulls = {octahedron()};
    Solid solid = make_solid(shape, {40.0, -31.0, 4.0}, {0.7, 0.7, 1.9});
    if (shape == Shape::kBox || shape == Shape::kEllipsoid) solid.half_m.y() = 0.3;
    solid.T_world_solid.linear() = rotation_from_yaw_pitch_roll(0.5, -0.8, 0.3);
    world.solids = {solid};
    const Scene scene = scene_of(std::move(world));
    std::mt19937 random(2);
    int met = 0;
    for (int i = 0; i < 1000; ++i) {
      const Vector3d at(any(random), any(random), any(random));
      const Vector3d target = solid.T_world_solid * (0.9 * at.cwiseProduct(solid.half_m));
      const Vector3d d = any_direction(random);
      const RayHit hit = scene.cast(target - 12.0 * d, d);
      if (hit.kind != HitKind::kSolid) continue;
      ++met;
      EXPECT_EQ(hit.index, 0);
      const Vector3d p = target + (hit.distance_m - 12.0) * d;
      const Vector3d local = solid.T_world_solid.inverse() * p;
      EXPECT_LT(std::abs(off_surface(solid, local)), 1e-6);
      EXPECT_LT(hit.normal.dot(d), 1e-6) << "the near side";
      EXPECT_NEAR(hit.normal.norm(), 1.0, 1e-9);
      // Just outside along the normal, just inside against it.
      EXPECT_GT(off_surface(solid, solid.T_world_solid.inverse() * (p + 1e-3 * hit.normal)), 0.0);
      EXPECT_LT(off_surface(solid, solid.T_world_solid.inverse() * (p - 1e-3 * hit.normal)), 0.0);
    }
    // Of a hull half of the box around it is empty.
    EXPECT_GT(met, shape == Shape::kHull ? 300 : 850);
  }
}

// A ray from inside a solid leaves through its wall.
TEST(Scene, SeesTheWallFromInside) {
  World world = world_with_ground(Surface::kSoil);
  world.solids = {make_solid(Shape::kEllipsoid, {0.0, 0.0, 3.0}, {0.5, 0.5, 0.5}),
                  make_solid(Shape::kCylinder, {5.0, 0.0, 3.0}, {0.5, 0.5, 0.5}),
                  make_solid(Shape::kBox, {-5.0, 0.0, 3.0}, {0.5, 0.5, 0.5})};
  const Scene scene = scene_of(std::move(world));
  for (const double x : {0.0, 5.0, -5.0}) {
    EXPECT_NEAR(scene.cast({x, 0.0, 3.0}, Vector3d::UnitX()).distance_m, 0.5, 1e-6) << x;
  }
}

TEST(Scene, FoliageIsSeenAndBearsNothing) {
  World world = world_with_ground(Surface::kGrass);
  Foliage leaf;
  leaf.name = "leaf";
  leaf.mesh.vertices = {{-1.0F, -1.0F, 1.0F}, {1.0F, -1.0F, 1.0F}, {0.0F, 1.0F, 1.0F}};
  leaf.mesh.triangles = {{0, 1, 2}};
  world.foliage = {Foliage{}, leaf};  // one without triangles before it
  const Scene scene = scene_of(std::move(world));
  const Vector3d above(0.0, 0.0, 3.0), down = -Vector3d::UnitZ();
  const RayHit seen = scene.cast(above, down);
  EXPECT_EQ(seen.kind, HitKind::kFoliage);
  EXPECT_EQ(seen.index, 1);
  EXPECT_NEAR(seen.distance_m, 2.0, 1e-9);
  EXPECT_GT(seen.normal.z(), 0.99);
  const RayHit bears = scene.cast(above, down, RaysMeet::kWhatBears);
  EXPECT_EQ(bears.kind, HitKind::kGround);
  EXPECT_NEAR(bears.distance_m, 3.0, 1e-9);
  // From below the same leaf, its other side.
  EXPECT_LT(scene.cast({0.0, 0.0, 0.5}, Vector3d::UnitZ()).normal.z(), -0.99);
  EXPECT_TRUE(scene.blocked(above, {0.0, 0.0, 0.5}));
  EXPECT_FALSE(scene.blocked(above, {0.0, 0.0, 0.5}, RaysMeet::kWhatBears));
  EXPECT_FALSE(scene.blocked(above, {0.0, 0.0, 1.5}));
  EXPECT_TRUE(scene.blocked(above, {0.0, 0.0, -0.5}, RaysMeet::kWhatBears));
}

TEST(Scene, PeopleWalk) {
  World world = world_with_ground(Surface::kSoil);
  Person person;
  person.path_m = {{-3.0, 0.0}, {3.0, 0.0}};
  person.speed_m_per_s = 1.0;
  world.people = {person};
  Scene scene = scene_of(std::move(world));
  const auto at = [&](double x) {
    return scene.cast({x, -8.0, 1.2}, Vector3d::UnitY()).kind == HitKind::kPerson;
  };
  EXPECT_TRUE(at(-3.0));
  EXPECT_FALSE(at(0.0));
  scene.set_time(3.0);
  EXPECT_FALSE(at(-3.0));
  EXPECT_TRUE(at(0.0));
  scene.set_time(9.0);  // and back
  EXPECT_TRUE(at(0.0));
  scene.set_time(0.0);
  EXPECT_TRUE(at(-3.0));
  EXPECT_EQ(scene.cast({-3.0, -8.0, 1.2}, Vector3d::UnitY()).index, 0);
}

// The steps of stairs, exactly at their edges and far from the origin of the world.
TEST(Scene, StairsAreExactSixtyMetresAway) {
  World world = world_with_ground(Surface::kConcrete, 160.0, 1.0);
  constexpr double kRise = 0.17, kTread = 0.29;
  for (int i = 0; i < 6; ++i) {
    const double z = 0.5 * kRise * (i + 1);
    world.solids.push_back(
        make_solid(Shape::kBox, {60.0 + 5.0 + kTread * i, 60.0, z}, {5.0, 2.0, z}));
  }
  const Scene scene = scene_of(std::move(world));
  for (int i = 0; i < 6; ++i) {
    const double x = 60.0 + kTread * (i + 0.5);
    const RayHit tread = scene.cast({x, 60.3, 4.0}, -Vector3d::UnitZ());
    EXPECT_NEAR(tread.distance_m, 4.0 - kRise * (i + 1), 1e-6);
    const RayHit riser = scene.cast({50.0, 60.3, kRise * (i + 0.5)}, Vector3d::UnitX());
    EXPECT_NEAR(riser.distance_m, 10.0 + kTread * i, 1e-6);
    EXPECT_NEAR(riser.normal.x(), -1.0, 1e-9);
  }
}

TEST(Scene, RefusesWorldsThatAreNotSound) {
  const auto error = [](const std::function<void(World&)>& spoil) {
    World world = world_with_ground(Surface::kSoil, 4.0, 0.5);
    world.solids = {make_solid(Shape::kBox, {0.0, 0.0, 1.0}, {0.1, 0.1, 0.1})};
    world.hulls = {octahedron()};
    world.foliage = {Foliage{"bush", octahedron(), {}}};
    Person person;
    person.name = "Ann";
    person.path_m = {{0.0, 0.0}, {1.0, 0.0}};
    world.people = {person};
    spoil(world);
    const Result<Scene> scene = Scene::make(shared(std::move(world)));
    return scene ? std::string() : scene.error().message();
  };
  const auto says = [](const std::string& message, const std::string& word) {
    return message.find(word) != std::string::npos ? ::testing::AssertionSuccess()
                                                   : ::testing::AssertionFailure() << message;
  };
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(error([](World&) {}), "");
  EXPECT_TRUE(says(error([](World& w) { w.ground = {}; }), "ground"));
  EXPECT_TRUE(says(error([](World& w) { w.ground.geometry.resolution_m = 0.0; }), "ground"));
  EXPECT_TRUE(says(error([](World& w) { w.ground.values.pop_back(); }), "ground"));
  EXPECT_TRUE(says(error([](World& w) { w.ground[{3, 2}] = std::nanf(""); }), "cell (3, 2)"));
  EXPECT_TRUE(says(error([](World& w) { w.ground_surface = {}; }), "ground_surface"));
  EXPECT_TRUE(says(error([](World& w) { w.ground_surface[{0, 0}] = 1; }), "ground_surface"));
  EXPECT_TRUE(says(error([](World& w) { w.ground_materials[0].albedo.x() = 2.0F; }),
                   "ground_materials[0]"));
  EXPECT_TRUE(says(error([](World& w) { w.solids[0].half_m.y() = 0.0; }), "solids[0] (thing)"));
  EXPECT_TRUE(says(error([=](World& w) { w.solids[0].half_m.y() = kNan; }), "half_m"));
  EXPECT_TRUE(
      says(error([](World& w) { w.solids[0].T_world_solid.linear() *= 2.0; }), "T_world_solid"));
  EXPECT_TRUE(says(error([](World& w) {
                     w.solids[0].shape = Shape::kHull;
                     w.solids[0].hull = 1;
                   }),
                   "hull 1 of 1"));
  EXPECT_TRUE(says(error([](World& w) { w.hulls[0].triangles[0][1] = 6; }), "hulls[0]"));
  EXPECT_TRUE(says(error([](World& w) { w.foliage[0].mesh.triangles[0][1] = -1; }), "bush"));
  EXPECT_TRUE(
      says(error([](World& w) { w.foliage[0].mesh.vertices[0].z() = std::nanf(""); }), "bush"));
  EXPECT_TRUE(says(error([](World& w) { w.people[0].path_m.pop_back(); }), "Ann"));
  EXPECT_TRUE(says(error([](World& w) { w.people[0].height_m = -1.0; }), "height_m"));
  EXPECT_TRUE(says(error([=](World& w) { w.sun.azimuth_rad = kNan; }), "sun"));
  EXPECT_FALSE(Scene::make(nullptr));
}

TEST(Scene, RaysThatAreNoneMeetNothing) {
  const Scene scene = scene_of(world_with_ground(Surface::kSoil));
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(scene.cast({0, 0, 1}, {0, 0, 0}).kind, HitKind::kNothing);
  EXPECT_EQ(scene.cast({0, 0, 1}, {0, 0, kNan}).kind, HitKind::kNothing);
  EXPECT_EQ(scene.cast({0, kNan, 1}, {0, 0, -1}).kind, HitKind::kNothing);
  EXPECT_FALSE(scene.blocked({0, 0, 1}, {0, 0, 1}));
}

}  // namespace
}  // namespace tread
