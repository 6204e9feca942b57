#include "tread/sim/world.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tread/sim/hull.hpp"
#include "tread/sim/random.hpp"
#include "tread/sim/true_maps.hpp"

namespace tread {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Ground of 8 x 6 m whose heights are a function of the place.
template <class Height>
World world_of(const Height& height, double resolution = 0.1) {
  World world;
  const GridGeometry geometry{resolution, Vector2d(-4, -3) - Vector2d::Constant(0.5 * resolution),
                              static_cast<int>(std::lround(8.0 / resolution)) + 1,
                              static_cast<int>(std::lround(6.0 / resolution)) + 1};
  world.ground = Grid<float>(geometry);
  world.ground_surface = Grid<std::uint8_t>(geometry);
  world.ground_materials = {material_of(Surface::kSoil, Season::kSummer, 1)};
  for (int y = 0; y < geometry.rows; ++y) {
    for (int x = 0; x < geometry.columns; ++x) {
      const Vector2d p = geometry.centre({x, y});
      world.ground[{x, y}] = static_cast<float>(height(p.x(), p.y()));
    }
  }
  return world;
}

World level() {
  return world_of([](double, double) { return 0.0; });
}

Solid solid(Solid::Shape shape, const Vector3d& half, const Isometry3d& T) {
  Solid s;
  s.name = "thing";
  s.shape = shape;
  s.half_m = half;
  s.T_world_solid = T;
  return s;
}

Isometry3d at(double x, double y, double z, double yaw = 0.0, double pitch = 0.0,
              double roll = 0.0) {
  Isometry3d T = Isometry3d::Identity();
  T.linear() = rotation_from_yaw_pitch_roll(yaw, pitch, roll);
  T.translation() << x, y, z;
  return T;
}

TEST(World, GroundIsExactOnPlanesAndItsNormalStandsOnThem) {
  const World world = world_of([](double x, double y) { return 0.3 * x - 0.2 * y + 1.0; });
  Random random(3);
  for (int i = 0; i < 200; ++i) {
    const Vector2d p(random.uniform(-4, 4), random.uniform(-3, 3));
    EXPECT_NEAR(ground_height(world, p), 0.3 * p.x() - 0.2 * p.y() + 1.0, 1e-6);
    const Vector3d n = ground_normal(world, p);
    EXPECT_NEAR((n - Vector3d(-0.3, 0.2, 1.0).normalized()).norm(), 0.0, 1e-5);
  }
}

// One corner up: the cut from (x+1, y) to (x, y+1) leaves the opposite triangle level.
TEST(World, SquaresAreCutTheWayTheHeaderSays) {
  World world = level();
  world.ground[{0, 0}] = 1.0F;
  EXPECT_NEAR(ground_height(world, {-4.0 + 0.04, -3.0 + 0.04}), 0.2, 1e-6);
  EXPECT_NEAR(ground_height(world, {-4.0 + 0.05, -3.0 + 0.05}), 0.0, 1e-6);
  EXPECT_NEAR(ground_height(world, {-4.0 + 0.08, -3.0 + 0.08}), 0.0, 1e-6);
}

TEST(World, TopsOfSolidsByTheirFormulas) {
  World world = level();
  world.solids.push_back(solid(Solid::Shape::kBox, {0.5, 0.2, 0.1}, at(0, 0, 0.3, 0.0, 0.2)));
  world.solids.push_back(solid(Solid::Shape::kEllipsoid, {0.3, 0.2, 0.5}, at(2, 0, 0.1)));
  world.solids.push_back(solid(Solid::Shape::kCylinder, {0.2, 0.2, 1.0}, at(-2, 0, 0, 0, M_PI_2)));
  // The upper side of a box with its nose 0.2 rad down, 0.2 m ahead of its middle.
  EXPECT_NEAR(top_height(world, {0.2, 0.0}), 0.3 + 0.1 / std::cos(0.2) - 0.2 * std::tan(0.2), 1e-9);
  EXPECT_NEAR(top_height(world, {2.15, 0.0}), 0.1 + 0.5 * std::sqrt(1.0 - 0.25), 1e-9);
  EXPECT_NEAR(top_height(world, {2.31, 0.0}), 0.0, 1e-9);
  // A lying cylinder, off its middle.
  EXPECT_NEAR(top_height(world, {-2.9, 0.1}), std::sqrt(0.04 - 0.01), 1e-9);
  EXPECT_NEAR(top_height(world, {-3.05, 0.1}), 0.0, 1e-9);
  EXPECT_EQ(&top_material(world, {2.0, 0.0}), &world.solids[1].material);
  EXPECT_TRUE(std::isnan(top_height(world, {4.2, 0.0})));
}

TEST(World, TopOfAHullIsThatOfItsCorners) {
  World world = level();
  world.hulls.push_back(stone_hull(24, 5));
  world.solids.push_back(
      solid(Solid::Shape::kHull, {0.6, 0.4, 0.3}, at(1, 1, 0.4, 0.7, 0.2, -0.4)));
  const Solid& stone = world.solids[0];
  double highest = 0.0;
  for (const Eigen::Vector3f& v : world.hulls[0].vertices) {
    const Vector3d corner =
        stone.T_world_solid * (0.999 * v.cast<double>().cwiseProduct(stone.half_m)).eval();
    highest = std::max(highest, corner.z());
    if (corner.z() > 0.0) {
      EXPECT_GE(top_height(world, corner.head<2>()), corner.z() - 1e-9);
    }
  }
  double found = 0.0;
  for (double x = 0.4; x < 1.6; x += 0.005) {
    for (double y = 0.4; y < 1.6; y += 0.005) found = std::max(found, top_height(world, {x, y}));
  }
  EXPECT_LE(found, highest + 1e-9);
  EXPECT_GT(found, highest - 0.01);
}

TEST(Hull, IsConvexAndClosed) {
  for (std::uint64_t seed = 1; seed < 30; ++seed) {
    const Mesh mesh = stone_hull(12 + static_cast<int>(seed), seed);
    std::vector<bool> used(mesh.vertices.size());
    for (const auto& [a, b, c] : mesh.triangles) {
      for (const auto i : {a, b, c}) used[static_cast<std::size_t>(i)] = true;
      const auto v = [&](std::int32_t i) -> Vector3d {
        return mesh.vertices[static_cast<std::size_t>(i)].cast<double>();
      };
      const Vector3d n = (v(b) - v(a)).cross(v(c) - v(a)).normalized();
      EXPECT_GT(n.dot(v(a)), 0.0);
      for (const Eigen::Vector3f& p : mesh.vertices) {
        EXPECT_LT(n.dot(p.cast<double>() - v(a)), 1e-4) << seed;
      }
    }
    // Euler: a closed surface of triangles without holes.
    const auto corners = std::count(used.begin(), used.end(), true);
    EXPECT_EQ(static_cast<long>(mesh.triangles.size()), 2 * corners - 4) << seed;
  }
}

TEST(Person, WalksToAndFroWithTheFeetOnTheGround) {
  World world = world_of([](double x, double) { return 0.1 * x; });
  Person person;
  person.path_m = {{-1, 0}, {1, 0}, {1, 2}};
  person.speed_m_per_s = 1.0;
  const auto foot = [&](double t) {
    // The middle between the soles.
    const auto poses = person_pose(world, person, t);
    const auto parts = person_parts(person);
    EXPECT_EQ(poses.size(), parts.size());
    Vector3d sole = Vector3d::Zero();
    for (std::size_t i : {0U, 1U}) {
      sole += 0.5 * (poses[i] * Vector3d(0, 0, -parts[i].half_m.z()));
    }
    return sole;
  };
  for (const auto& [t, x, y] : {std::tuple(0.0, -1.0, 0.0),
                                {1.5, 0.5, 0.0},
                                {3.0, 1.0, 1.0},
                                {4.5, 1.0, 1.5},
                                {7.0, 0.0, 0.0},
                                {8.5, -0.5, 0.0}}) {
    EXPECT_NEAR(foot(t).x(), x, 0.02) << t;
    EXPECT_NEAR(foot(t).y(), y, 0.02) << t;
    EXPECT_NEAR(foot(t).z(), 0.1 * x, 0.09) << t;  // legs swing
  }
  EXPECT_NEAR(foot(0.0).z(), -0.1, 1e-6);  // and here they do not
}

TEST(TrueMaps, HeightIsTheTopAndBoughsAreNot) {
  World world = world_of([](double x, double y) { return 0.05 * x + 0.02 * y; });
  world.solids.push_back(solid(Solid::Shape::kBox, {0.4, 0.3, 0.2}, at(1, 1, 0.1, 0.5)));
  world.solids.push_back(solid(Solid::Shape::kBox, {1.0, 0.1, 0.05}, at(-1, 0, 2.0)));
  const GridGeometry geometry = map_geometry(world, 0.05);
  const Grid<float> height = true_height(world, geometry);
  Random random(1);
  for (int i = 0; i < 500; ++i) {
    const Cell c{static_cast<int>(random.uniform() * geometry.columns),
                 static_cast<int>(random.uniform() * geometry.rows)};
    const Vector2d p = geometry.centre(c);
    const double top = top_height(world, p);
    EXPECT_NEAR((height[c]), top > 1.0 ? ground_height(world, p) : top, 1e-5);
  }
}

TEST(TrueMaps, TraversableIsOneRadiusAwayFromStepsAndSteepGround) {
  World world = world_of([](double x, double) { return x > 0.0 ? std::tan(0.6) * x : 0.0; }, 0.05);
  world.solids.push_back(solid(Solid::Shape::kBox, {0.2, 0.2, 0.2}, at(-2, 0, 0)));
  const GridGeometry geometry = map_geometry(world, 0.05);
  const TraverseOptions options;
  const Grid<float> free = true_traversable(true_height(world, geometry), options);
  const auto value = [&](double x, double y) { return free[geometry.cell_at({x, y})]; };
  const double near = 0.2 + options.step_length_m + options.radius_m;
  EXPECT_EQ(value(-2.0 + near + 0.11, 0.0), 1.0F);
  EXPECT_EQ(value(-2.0 + near - 0.11, 0.0), 0.0F);
  EXPECT_EQ(value(-2.0, near + 0.11), 1.0F);
  EXPECT_EQ(value(1.5, 1.0), 0.0F);   // 34 degrees
  EXPECT_EQ(value(-3.9, 2.0), 0.0F);  // half of the robot over the edge of the world
}

}  // namespace
}  // namespace tread
