#include "tread/sim/course.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "test_data.hpp"
#include "tread/io/image_file.hpp"
#include "tread/io/raster_file.hpp"
#include "tread/sim/named_courses.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector2d;

World made(const std::string& body) {
  const auto course =
      parse_course("tread_course: 1\nsize_m: [10, 8]\norigin_m: [-2, -4]\n" + body, "made.yaml");
  EXPECT_TRUE(course) << course.error().message();
  return course ? *course->world : World{};
}

std::string refusal(const std::string& text) {
  const auto course = parse_course(text, "made.yaml");
  return course ? "no error" : course.error().message();
}

std::string refusal_of(const std::string& body) {
  return refusal("tread_course: 1\nsize_m: [10, 8]\n" + body);
}

TEST(Course, GroundReachesFromCornerToCorner) {
  const World world = made("");
  EXPECT_EQ(world.name, "made");
  EXPECT_EQ(world.ground.geometry.columns, 201);
  for (const Vector2d& corner : {Vector2d(-2, -4), Vector2d(8, 4), Vector2d(-2, 4)}) {
    EXPECT_NEAR(ground_height(world, corner * (1.0 - 1e-9)), 0.0, 1e-9) << corner.transpose();
  }
  EXPECT_TRUE(std::isnan(ground_height(world, {-2.01, 0})));
  EXPECT_TRUE(std::isnan(ground_height(world, {0, 4.01})));
}

TEST(Course, OneNameAndSeedIsOneWorld) {
  const std::string body =
      "seed: 5\nground: {relief: [{noise: {rms_m: 0.1}}]}\nobjects: [{rocks: {count: 9}}, "
      "{trees: {count: 2}}]\n";
  const World a = made(body), b = made(body), c = made("seed: 6" + body.substr(7));
  EXPECT_EQ(a.ground.values, b.ground.values);
  EXPECT_NE(a.ground.values, c.ground.values);
  ASSERT_EQ(a.solids.size(), b.solids.size());
  for (std::size_t i = 0; i < a.solids.size(); ++i) {
    EXPECT_EQ(a.solids[i].T_world_solid.matrix(), b.solids[i].T_world_solid.matrix());
    EXPECT_EQ(a.solids[i].material.seed, b.solids[i].material.seed);
  }
  ASSERT_FALSE(a.foliage.empty());
  EXPECT_EQ(a.foliage[0].mesh.vertices, b.foliage[0].mesh.vertices);
}

// A course of a name and seed is the same world in every build: heights come through sums whose
// last bits the processor decides, places and counts do not.
TEST(Course, RoughIsTheWorldItHasAlwaysBeen) {
  const auto course = find_course("rough");
  ASSERT_TRUE(course) << course.error().message();
  const World& world = *course->world;
  EXPECT_NEAR(ground_height(world, {3.3, 1.7}), -0.0023875, 1e-5);
  EXPECT_NEAR(ground_height(world, {10.2, -4.4}), 0.2851363, 1e-5);
  EXPECT_NEAR(ground_height(world, {17.0, 0.5}), -0.0809440, 1e-5);
  ASSERT_EQ(world.solids.size(), 100U);
  const Solid& rock = world.solids[50];
  EXPECT_NEAR(rock.T_world_solid.translation().x(), 8.5121320, 1e-6);
  EXPECT_NEAR(rock.T_world_solid.translation().y(), -4.9487119, 1e-6);
  EXPECT_NEAR(rock.half_m.x(), 0.2038781, 1e-6);
  const auto grass = std::count(world.ground_surface.values.begin(),
                                world.ground_surface.values.end(), std::uint8_t{1});
  EXPECT_NEAR(static_cast<double>(grass), 59560.0, 5.0);
}

TEST(Course, MovingAnEntryDownTheFileChangesNothing) {
  const World a = made("ground: {relief: [{noise: {rms_m: 0.1}}]}\n"),
              b = made("\n# a remark\n\nground:\n  relief:\n    - noise: {rms_m: 0.1}\n");
  EXPECT_EQ(a.ground.values, b.ground.values);
}

TEST(Course, EveryShippedCourseIsSoundAndStartsOnFreeGround) {
  ASSERT_GE(course_names().size(), 10U);
  for (const std::string& name : course_names()) {
    const auto course = find_course(name);
    ASSERT_TRUE(course) << course.error().message();
    const World* world = course->world.get();
    EXPECT_FALSE(world->route_m.empty()) << name;
    for (const Solid& solid : world->solids) {
      const double away =
          (solid.T_world_solid.translation().head<2>() - world->start.position_m).norm();
      EXPECT_GT(away, 0.6) << name << ": " << solid.name;
    }
  }
}

TEST(Course, PalletsStackWithTheirOffset) {
  const World world = made("objects: [{pallet: {at_m: [2, 1], stack: 2, offset_m: 0.4}}]\n");
  EXPECT_NEAR(top_height(world, {1.5, 1.0}), 0.15, 1e-12);
  EXPECT_NEAR(top_height(world, {1.9, 1.0}), 0.30, 1e-12);
  EXPECT_NEAR(top_height(world, {2.9, 1.3}), 0.30, 1e-12);
  EXPECT_NEAR(top_height(world, {3.1, 1.0}), 0.0, 1e-12);
  EXPECT_EQ(world.solids[0].name, "objects[0].pallet (line 4) (1)");
}

TEST(Course, StairsRiseByEqualSteps) {
  const World world =
      made("objects: [{stairs: {at_m: [1, 0], steps: 4, rise_m: 0.12, tread_m: 0.3}}]\n");
  for (int i = 0; i < 4; ++i) {
    EXPECT_NEAR(top_height(world, {1.15 + 0.3 * i, 0.3}), 0.12 * (i + 1), 1e-12) << i;
  }
  EXPECT_NEAR(top_height(world, {0.99, 0.0}), 0.0, 1e-12);
}

TEST(Course, SteppingStonesAreLowerThanThePallets) {
  const World world = made("objects: [{stepping_stones: {at_m: [0, 0], sway_m: 0}}]\n");
  EXPECT_NEAR(top_height(world, {0.6, 0.0}), 0.15, 1e-12);
  EXPECT_NEAR(top_height(world, {1.35, 0.0}), 0.07, 1e-12);
  EXPECT_NEAR(top_height(world, {3.0, 0.0}), 0.15, 1e-12);
  EXPECT_NEAR(top_height(world, {1.35, 0.5}), 0.0, 1e-12);
}

TEST(Course, BoxesReachDownToTheGroundOnASlope) {
  const World world = made(
      "ground: {relief: [{ramp: {from_m: [-2, 0], to_m: [6, 0], width_m: 20, rise_m: 2}}]}\n"
      "objects: [{box: {at_m: [2, 0], size_m: [1, 1, 0.3]}}]\n");
  EXPECT_NEAR(top_height(world, {2, 0}), 1.3, 1e-6);
  const Solid& box = world.solids.at(0);
  const double bottom = box.T_world_solid.translation().z() - box.half_m.z();
  EXPECT_LE(bottom, ground_height(world, {1.5, 0.0}) + 1e-9);
}

TEST(Course, PatchesLieWhereTheyAreTold) {
  const World world = made(
      "ground:\n  surface: grass\n  patches:\n"
      "    - {surface: sand, polygon_m: [[0, 0], [2, 0], [2, 2], [0, 2]]}\n"
      "    - {surface: gravel, line_m: [[-2, -3], [8, -3]], width_m: 1}\n");
  EXPECT_EQ(ground_material(world, {1, 1}).surface, Surface::kSand);
  EXPECT_EQ(ground_material(world, {3, -2.6}).surface, Surface::kGravel);
  EXPECT_EQ(ground_material(world, {3, 1}).surface, Surface::kGrass);
  const World blots = made("ground: {patches: [{surface: sand, share: 0.3, blot_m: 0.5}]}\n");
  const auto sand = std::count(blots.ground_surface.values.begin(),
                               blots.ground_surface.values.end(), std::uint8_t{1});
  EXPECT_NEAR(static_cast<double>(sand), 0.3 * static_cast<double>(blots.ground.values.size()),
              0.005 * static_cast<double>(blots.ground.values.size()));
}

TEST(Course, ScatteredThingsKeepClearOfTheWay) {
  const World world =
      made("route_m: [[3, 0], [6, 2]]\nobjects: [{rocks: {count: 200, clear_m: 0.7}}]\n");
  EXPECT_GT(world.solids.size(), 50U);
  for (const Solid& rock : world.solids) {
    const Vector2d p = rock.T_world_solid.translation().head<2>();
    EXPECT_GT((p - Vector2d(0, 0)).norm(), 0.7);
    EXPECT_GT(p.x() >= 0 && p.x() <= 3 ? std::abs(p.y()) : 1.0, 0.7);
  }
}

TEST(Course, HeightMapsFromGeoTiffAndPng) {
  const testing::ScratchFolder scratch;
  const fs::path folder = scratch.path();
  Grid<float> hill({0.5, Vector2d(100, 200), 21, 17});
  for (int y = 0; y < 17; ++y) {
    for (int x = 0; x < 21; ++x) hill[{x, y}] = static_cast<float>(0.1 * x + 0.02 * y);
  }
  ASSERT_TRUE(write_geotiff(folder / "hill.tif", hill));
  Image<std::uint16_t> grey(21, 17);
  for (int y = 0; y < 17; ++y) {
    for (int x = 0; x < 21; ++x) grey(x, 16 - y) = static_cast<std::uint16_t>(1000 * x);
  }
  ASSERT_TRUE(write_png(folder / "hill.png", grey.view()));
  const auto with = [&](const std::string& map) {
    return parse_course(
        "tread_course: 1\nsize_m: [10, 8]\norigin_m: [-2, -4]\nground: {height_map: {" + map +
            "}}\n",
        folder / "made.yaml");
  };
  const auto tif = with("file: hill.tif");
  ASSERT_TRUE(tif) << tif.error().message();
  // The map's corner lies on the course's: its first centre is a quarter of a metre in.
  EXPECT_NEAR(ground_height(*tif->world, {1.75, -0.75}), 0.1 * 7 + 0.02 * 6, 1e-5);
  EXPECT_NEAR(ground_height(*tif->world, {2.0, -0.75}), 0.1 * 7.5 + 0.02 * 6, 1e-5);
  const auto png = with("file: hill.png, resolution_m: 0.5, low_m: 0, high_m: 65.535");
  ASSERT_TRUE(png) << png.error().message();
  EXPECT_NEAR(ground_height(*png->world, {1.75, 0.0}), 7.0, 2e-3);

  const auto missing = with("file: nowhere.tif");
  ASSERT_FALSE(missing);
  EXPECT_NE(missing.error().message().find("made.yaml:4"), std::string::npos);
  EXPECT_NE(missing.error().message().find("nowhere.tif"), std::string::npos);
}

TEST(Course, TellsWhichSensorsBreak) {
  const auto course = parse_course(
      "tread_course: 1\nsize_m: [3, 3]\nfaults:\n  - {sensor: gnss, kind: dead, from_s: 2, "
      "until_s: 5}\n"
      "  - {sensor: camera0, kind: frozen, from_s: 7}\n",
      "made.yaml");
  ASSERT_TRUE(course) << course.error().message();
  ASSERT_EQ(course->faults.size(), 2U);
  EXPECT_EQ(course->faults[0].kind, FaultKind::kDead);
  EXPECT_EQ(course->faults[0].until_s, 5.0);
  EXPECT_EQ(course->faults[1].sensor, "camera0");
  EXPECT_TRUE(std::isinf(course->faults[1].until_s));
}

TEST(Course, RefusesAndSaysWhereAndWhatToDo) {
  struct Case {
    std::string text, place, says;
  };
  const std::vector<Case> cases = {
      {"objects: [{palet: {at_m: [1, 1]}}]\n", "made.yaml:3", "'pallet'"},
      {"objects: [{pallet: {at_m: [1, 1], stak: 2}}]\n", "made.yaml:3", "'stack'"},
      {"objects:\n  - rock: {at_m: [1, 1]}\n  - rock: {}\n", "made.yaml:5", "'at_m' is missing"},
      {"ground: {surface: gravle}\n", "made.yaml:3", "'gravel'"},
      {"ground: {relief: [{noise: {rms_m: -1}}]}\n", "made.yaml:3", "from 0 to 1000"},
      {"ground: {relief: [{noise: {shortest_m: 0.01}}]}\n", "made.yaml:3", "out of range"},
      {"ground: {relief: [{ditch: {from_m: [0, 0], to_m: [0, 0], depth_m: 1}}]}\n", "made.yaml:3",
       "where the line starts"},
      {"start: {at_m: [99, 0]}\n", "made.yaml:3", "off the ground"},
      {"route_m: [[1, 1], [0, 77]]\n", "made.yaml:3", "off the ground"},
      {"season: monsoon\n", "made.yaml:3", "spring, summer, autumn, winter"},
      {"sun: {azimuth: 3}\n", "made.yaml:3", "Known are: azimuth_deg"},
      {"objects: [{rocks: {in_m: [[50, 50], [60, 60]]}}]\n", "made.yaml:3", "off the ground"},
      {"objects: [{grass: {tufts_per_m2: 9999}}]\n", "made.yaml:3", "too many"},
      {"objects: [{stepping_stones: {at_m: [0, 0], drop_m: 0.2}}]\n", "made.yaml:3",
       "below the ground"},
      {"objects: [{pallet: {at_m: [0, 0]}, rock: {at_m: [1, 1]}}]\n", "made.yaml:3", "one kind"},
      {"faults: [{sensor: gps, kind: dead}]\n", "made.yaml:3", "'gnss'"},
      {"objects: [{box: {at_m: [50, 0]}}]\n", "made.yaml:3", "off the ground"},
      {"objects:\n  - person: {path_m: [[0, 0], [0, 9]]}\n", "made.yaml:4", "leaves the ground"},
      {"faults: [{sensor: imu, kind: dead, from_s: 9, until_s: 3}]\n", "made.yaml:3", "faults[0]"},
      {"resolution_m: 0.006\nsize_m: [90, 90]\n", "made.yaml", "size_m"},
  };
  for (const Case& c : cases) {
    const std::string message = refusal_of(c.text);
    EXPECT_NE(message.find(c.place), std::string::npos) << c.text << message;
    EXPECT_NE(message.find(c.says), std::string::npos) << c.text << message;
  }
  EXPECT_NE(refusal("size_m: [3, 3]\n").find("not a course"), std::string::npos);
  EXPECT_NE(refusal("tread_course: 2\nsize_m: [3, 3]\n").find("version 2"), std::string::npos);
  EXPECT_NE(refusal("tread_course: 1\nsize_m: [9000, 9000]\n").find("too many"), std::string::npos);
  EXPECT_NE(find_course("medow").error().message().find("'meadow'"), std::string::npos);
}

// Every shipped course, cut off and with single bytes changed: an error or a world, never worse.
TEST(Course, DamagedFilesDoNoHarm) {
  const std::string text(named_course_text("stairs").value());
  for (std::size_t cut = 0; cut < text.size(); cut += 17) {
    (void)parse_course(text.substr(0, cut), "cut.yaml");
  }
  for (std::size_t at = 0; at < text.size(); at += 13) {
    for (const char byte : {'\0', '{', '-', '9', ':'}) {
      std::string changed = text;
      changed[at] = byte;
      if (const auto course = parse_course(changed, "changed.yaml")) {
        EXPECT_LE(course->world->ground.values.size(), 25'000'000U);
      }
    }
  }
}

}  // namespace
}  // namespace tread
