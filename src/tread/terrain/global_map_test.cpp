#include "tread/terrain/global_map.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <set>
#include <vector>

#include "tread/geometry/pose.hpp"
#include "tread/terrain/local_map.hpp"

namespace tread {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// A local map of one height and one derivative everywhere, 6 m ahead and to the sides.
struct Local {
  Grid<float> height, derivative;
};
Local uniform(float height, float derivative) {
  const GridGeometry geometry{0.1, {0.0, -6.0}, 60, 120};
  return {Grid<float>(geometry, height), Grid<float>(geometry, derivative)};
}

GroundCell ground(const GlobalMap& map, double x, double y) {
  const GroundCell* cell = map.find(map.cell_at({x, y}));
  return cell == nullptr ? GroundCell{} : *cell;
}

// METHODS 10.3: after n equal measurements 1 - 0.5^n: 0.5, 0.75, 0.875.
TEST(PaperR, LowPassReachesHalfThreeQuartersSevenEighths) {
  GlobalMap map;
  const Local local = uniform(0.0F, 1.0F);
  for (double expected : {0.5, 0.75, 0.875}) {
    ASSERT_TRUE(map.integrate(local.height, local.derivative, {}, {}));
    EXPECT_FLOAT_EQ(ground(map, 3.05, 0.05).derivative, static_cast<float>(expected));
  }
}

// A single spurious hit is at most 12.5 % after two clean looks.
TEST(PaperR, SpuriousHitDecays) {
  GlobalMap map;
  ASSERT_TRUE(map.integrate(uniform(0, 1).height, uniform(0, 1).derivative, {}, {}));
  for (int i = 0; i < 2; ++i) {
    ASSERT_TRUE(map.integrate(uniform(0, 0).height, uniform(0, 0).derivative, {}, {}));
  }
  EXPECT_FLOAT_EQ(ground(map, 3.05, 0.05).derivative, 0.125F);
}

TEST(GlobalMap, FirstValueCanBeCopied) {
  GlobalMap map;
  GlobalMapOptions options;
  options.first = GlobalMapOptions::First::kCopy;
  const Local local = uniform(0.0F, 1.0F);
  ASSERT_TRUE(map.integrate(local.height, local.derivative, {}, options));
  EXPECT_FLOAT_EQ(ground(map, 3.05, 0.05).derivative, 1.0F);
  options.alpha = 0.25;
  ASSERT_TRUE(map.integrate(uniform(0, 0).height, uniform(0, 0).derivative, {}, options));
  EXPECT_FLOAT_EQ(ground(map, 3.05, 0.05).derivative, 0.75F);
}

TEST(GlobalMap, HeightsAreOverwrittenAndRaisedToTheWorld) {
  GlobalMap map;
  ASSERT_TRUE(
      map.integrate(uniform(0.2F, 0).height, uniform(0.2F, 0).derivative, {{0, 0, 1.0}, 0.0}, {}));
  EXPECT_FLOAT_EQ(ground(map, 3.05, 0.05).height_m, 1.2F);
  ASSERT_TRUE(map.integrate(uniform(0.5F, 0).height, uniform(0.5F, 0).derivative, {}, {}));
  EXPECT_FLOAT_EQ(ground(map, 3.05, 0.05).height_m, 0.5F);
}

TEST(GlobalMap, TurnsAndShiftsWithoutGaps) {
  // A ridge along the levelled frame's x axis must lie along the heading in the world.
  Local local = uniform(0.0F, 0.0F);
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 60; ++x) local.height[{x, y}] = std::abs(y - 60) <= 2 ? 1.0F : 0.0F;
  }
  for (double yaw : {0.0, 0.5, 2.1, -2.9, std::numbers::pi / 2}) {
    GlobalMap map;
    const LevelPose pose{{103.3, -57.7, 0.0}, yaw};
    ASSERT_TRUE(map.integrate(local.height, local.derivative, pose, {}));
    for (double ahead = 0.4; ahead < 5.6; ahead += 0.05) {
      for (double left = -5.6; left < 5.6; left += 0.3) {
        const double x = pose.position.x() + std::cos(yaw) * ahead - std::sin(yaw) * left;
        const double y = pose.position.y() + std::sin(yaw) * ahead + std::cos(yaw) * left;
        const GroundCell cell = ground(map, x, y);
        ASSERT_FALSE(std::isnan(cell.height_m)) << yaw << " " << ahead << " " << left;
        if (std::abs(left - 0.05) < 0.12) {
          EXPECT_EQ(cell.height_m, 1.0F);
        }
        if (std::abs(left) > 0.45) {
          EXPECT_EQ(cell.height_m, 0.0F);
        }
      }
    }
  }
}

// Every world cell whose centre lies below the local map is taken in, the outermost too, on either
// side of the origin.
TEST(GlobalMap, TakesInExactlyTheCellsWithTheirCentreInside) {
  const Local local = uniform(0.0F, 1.0F);
  for (double sign : {1.0, -1.0}) {
    GlobalMap map;
    // x from +-33.08 to 6 m further, y from +-47.08 - 6 to +-47.08 + 6.
    const Vector3d place(sign * 33.08, sign * 47.08, 0.0);
    ASSERT_TRUE(map.integrate(local.height, local.derivative, {place, 0.0}, {}));
    const double low = place.x() / 0.1 - 0.5, left = place.y() / 0.1 - 60.5;
    const Cell first{static_cast<int>(std::ceil(low)), static_cast<int>(std::ceil(left))};
    EXPECT_EQ(map.bounds(), (CellRect{first, {first.x + 60, first.y + 120}})) << sign;
  }
}

TEST(GlobalMap, UnknownLocalCellsChangeNothing) {
  GlobalMap map;
  ASSERT_TRUE(map.integrate(uniform(1, 1).height, uniform(1, 1).derivative, {}, {}));
  ASSERT_TRUE(map.integrate(uniform(kNan, kNan).height, uniform(kNan, kNan).derivative, {}, {}));
  EXPECT_EQ(ground(map, 3.05, 0.05).height_m, 1.0F);
  EXPECT_FLOAT_EQ(ground(map, 3.05, 0.05).derivative, 0.5F);
  // Height without derivative: terrain, but not explored.
  ASSERT_TRUE(
      map.integrate(uniform(2, 2).height, uniform(kNan, kNan).derivative, {{50, 0, 0}, 0.0}, {}));
  EXPECT_EQ(ground(map, 53.05, 0.05).height_m, 2.0F);
  EXPECT_FALSE(ground(map, 53.05, 0.05).explored());
}

TEST(GlobalMap, ListsEachChangedCellOnce) {
  GlobalMap map;
  const Local local = uniform(0.0F, 1.0F);
  ASSERT_TRUE(map.integrate(local.height, local.derivative, {}, {}));
  ASSERT_TRUE(map.integrate(local.height, local.derivative, {}, {}));
  const std::vector<Cell> changes = map.take_changes();
  EXPECT_EQ(changes.size(), 60U * 120U);
  EXPECT_EQ(std::set<Cell>(changes.begin(), changes.end()).size(), changes.size());
  EXPECT_TRUE(map.take_changes().empty());
  // What stays the same is not listed: flat ground seen again.
  GlobalMap flat;
  ASSERT_TRUE(flat.integrate(uniform(0, 0).height, uniform(0, 0).derivative, {}, {}));
  EXPECT_EQ(flat.take_changes().size(), 60U * 120U);  // newly explored
  ASSERT_TRUE(flat.integrate(uniform(0, 0).height, uniform(0, 0).derivative, {}, {}));
  EXPECT_TRUE(flat.take_changes().empty());
}

TEST(GlobalMap, RefusesWildPosesAndForeignGrids) {
  GlobalMap map;
  const Local local = uniform(0.0F, 1.0F);
  const double nan = std::nan("");
  EXPECT_FALSE(map.integrate(local.height, local.derivative, {{nan, 0, 0}, 0}, {}));
  EXPECT_FALSE(map.integrate(local.height, local.derivative, {{1e300, 0, 0}, 0}, {}));
  EXPECT_FALSE(map.integrate(local.height, local.derivative, {{0, -1e10, 0}, 0}, {}));
  EXPECT_FALSE(map.integrate(local.height, local.derivative, {{0, 0, 0}, nan}, {}));
  EXPECT_FALSE(map.integrate(local.height, Grid<float>(GridGeometry{0.1, {0, 0}, 2, 2}), {}, {}));
  const Grid<float> fine(GridGeometry{0.05, {0, 0}, 2, 2}, 0.0F);
  EXPECT_FALSE(map.integrate(fine, fine, {}, {}));
  EXPECT_TRUE(map.bounds().empty());
  // Far away is fine.
  EXPECT_TRUE(map.integrate(local.height, local.derivative, {{5e6, -5e6, 0}, 1.0}, {}));
}

// A place looked at all day long stays explored: its count stops at the largest number.
TEST(GlobalMap, TheCountOfMeasurementsStopsAtItsLargest) {
  GlobalMap map;
  const Grid<float> one(GridGeometry{0.1, {0.0, 0.0}, 1, 1}, 1.0F);
  for (int i = 0; i < 65536; ++i) ASSERT_TRUE(map.integrate(one, one, {}, {}));
  EXPECT_TRUE(ground(map, 0.05, 0.05).explored());
  EXPECT_EQ(ground(map, 0.05, 0.05).measurements, 65535);
}

TEST(GlobalMap, LayersRoundTrip) {
  GlobalMap map;
  Local local = uniform(0.0F, 0.25F);
  local.height[{5, 7}] = kNan;
  local.derivative[{5, 7}] = kNan;
  local.derivative[{9, 9}] = kNan;
  ASSERT_TRUE(map.integrate(local.height, local.derivative, {{-20.0, 3.0, 0.5}, 0.4}, {}));
  const MapLayers layers = map.layers();
  ASSERT_EQ(layers.layers.size(), 3U);
  const auto back = GlobalMap::from_layers(layers);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->bounds(), map.bounds());
  for (int y = map.bounds().first.y; y < map.bounds().last.y; ++y) {
    for (int x = map.bounds().first.x; x < map.bounds().last.x; ++x) {
      const GroundCell* a = map.find({x, y});
      const GroundCell* b = back->find({x, y});
      const bool known_a = a != nullptr && !std::isnan(a->height_m);
      const bool known_b = b != nullptr && !std::isnan(b->height_m);
      ASSERT_EQ(known_a, known_b);
      if (!known_a) continue;
      EXPECT_EQ(a->height_m, b->height_m);
      EXPECT_EQ(a->explored(), b->explored());
      EXPECT_EQ(a->derivative, b->derivative);
    }
  }
  // Known ground without derivative is 0 in "explored", and NaN only in "derivative".
  int unexplored = 0;
  for (std::size_t i = 0; i < layers.layers[0].grid.values.size(); ++i) {
    const float explored = layers.find("explored")->grid.values[i];
    EXPECT_EQ(explored, std::isnan(layers.find("derivative")->grid.values[i]) ? 0.0F : 1.0F);
    unexplored += !std::isnan(layers.find("height")->grid.values[i]) && explored == 0.0F ? 1 : 0;
  }
  EXPECT_GT(unexplored, 0);
  MapLayers poorer = layers;
  poorer.layers.erase(poorer.layers.begin());
  const auto missing = GlobalMap::from_layers(poorer);
  ASSERT_FALSE(missing);
  EXPECT_NE(missing.error().message().find("'height'"), std::string::npos);
  MapLayers shifted = layers;
  shifted.layers[1].grid.geometry.origin.x() += 0.1;
  const auto unequal = GlobalMap::from_layers(shifted);
  ASSERT_FALSE(unequal);
  EXPECT_EQ(unequal.error().code, ErrorCode::kBadFormat);
}

// Origins of cells are no whole numbers of tenths: rounding finds the cell again.
TEST(GlobalMap, LayersRoundTripAtEveryPlace) {
  const Grid<float> one(GridGeometry{0.1, {0.0, 0.0}, 1, 1}, 1.0F);
  for (int i = -60; i <= 60; ++i) {
    GlobalMap map;
    ASSERT_TRUE(map.integrate(one, one, {{0.1 * i + 0.01, -0.1 * i + 0.01, 0.0}, 0.0}, {}));
    const auto back = GlobalMap::from_layers(map.layers());
    ASSERT_TRUE(back);
    EXPECT_EQ(back->bounds(), map.bounds()) << i;
  }
}

// METHODS 10.3: with +-1 degree of pitch error a frame, heights at 6 m shift by 10 cm. Stereo sees
// other patches in every frame, so the global heights mix frames. The derivative of each local map
// stays clean; the derivative of the global heights is full of false alarms.
TEST(PaperR, PitchErrorsGiveFalseDerivativesOnTheGlobalMapOnly) {
  GlobalMap map;
  LocalMapBuilder builder;
  Grid<float> derivative;
  std::mt19937 random(3);
  for (int frame = 0; frame < 12; ++frame) {
    std::vector<Vector3f> points;
    for (double patch_x = 0.5; patch_x < 6.0; patch_x += 0.5) {
      for (double patch_y = -3.0; patch_y < 3.0; patch_y += 0.5) {
        if (random() % 3 == 0) continue;  // no match here this time
        for (int i = 0; i < 100; ++i) {
          points.emplace_back(static_cast<float>(patch_x + 0.025 + 0.05 * (i % 10)),
                              static_cast<float>(patch_y + 0.025 + 0.05 * (i / 10)), 0.0F);
        }
      }
    }
    const double pitch = (frame % 2 == 0 ? 1.0 : -1.0) * std::numbers::pi / 180.0;
    Eigen::Isometry3d T_level_points = Eigen::Isometry3d::Identity();
    T_level_points.linear() = rotation_from_yaw_pitch_roll(0.0, pitch, 0.0);
    const Grid<float>& height = builder.build(
        points, T_level_points,
        local_cells({Eigen::Vector2d(0.0, -6.0), Eigen::Vector2d(6.0, 6.0)}, 0.1), {});
    sobel_squared(height, derivative);
    ASSERT_TRUE(map.integrate(height, derivative, {{0.2 * frame, 0.0, 0.0}, 0.0}, {}));
  }
  double worst_local = 0.0, worst_global = 0.0;
  int false_alarms = 0;
  const Grid<float> global = map.derivative_of_heights();
  for (int y = 0; y < global.geometry.rows; ++y) {
    for (int x = 0; x < global.geometry.columns; ++x) {
      const GroundCell* cell = map.find({map.bounds().first.x + x, map.bounds().first.y + y});
      if (cell == nullptr || !cell->explored() || std::isnan(global[{x, y}])) continue;
      worst_local = std::max(worst_local, static_cast<double>(cell->derivative));
      worst_global = std::max(worst_global, static_cast<double>(global[{x, y}]));
      false_alarms += global[{x, y}] > 0.04F ? 1 : 0;  // what costs more than flat ground
    }
  }
  EXPECT_LT(worst_local, 0.001);  // a slope of 1 degree: 0.0002
  EXPECT_GT(worst_global, 0.16);  // two frames apart by 2 degrees: a step of 20 cm at 6 m
  EXPECT_GT(false_alarms, 100);
}

TEST(GlobalMap, GrowsNoLargerThanItsLimitAndStaysAsItWasBeyond) {
  GlobalMap map;
  GlobalMapOptions options;
  options.max_map_mib = 1;  // 87381 cells of 12 bytes
  const Local local = uniform(0.1F, 0.0F);
  ASSERT_TRUE(map.integrate(local.height, local.derivative, {}, options));
  const CellRect before = map.bounds();
  const Status far = map.integrate(local.height, local.derivative, {{1e7, 0, 0}, 0.0}, options);
  ASSERT_FALSE(far);
  EXPECT_EQ(far.error().code, ErrorCode::kTooLarge);
  EXPECT_NE(far.error().what.find("global.max_map_mib is 1"), std::string::npos);
  EXPECT_EQ(map.bounds(), before);
  // 87381 / 121 rows: 722 columns; the local map has 60 of its own.
  EXPECT_TRUE(map.integrate(local.height, local.derivative, {{65.0, 0, 0}, 0.0}, options));
  EXPECT_FALSE(map.integrate(local.height, local.derivative, {{67.0, 0, 0}, 0.0}, options));
  EXPECT_LE(map.bounds().size() * 12, 1 << 20);
  // The corners of what cells can be numbered: the size of it fits no 32 bits.
  GlobalMap wide;
  ASSERT_TRUE(wide.integrate(local.height, local.derivative, {{-9e7, -9e7, 0}, 0.0}, {}));
  EXPECT_EQ(wide.integrate(local.height, local.derivative, {{9e7, 9e7, 0}, 0.0}, {}).error().code,
            ErrorCode::kTooLarge);
}

TEST(GlobalMap, LayersThatLieNowhereAreRefused) {
  MapLayers layers;
  for (const char* name : {"height", "derivative"}) {
    layers.layers.push_back({name, "", "", Grid<float>(GridGeometry{0.1, {0, 0}, 2, 2}, 0.0F)});
  }
  ASSERT_TRUE(GlobalMap::from_layers(layers));
  for (const GridGeometry& geometry :
       {GridGeometry{0.1, {1e300, 0}, 2, 2}, GridGeometry{0.1, {0, -2e8}, 2, 2},
        GridGeometry{0.1, {std::nan(""), 0}, 2, 2}, GridGeometry{0.0, {0, 0}, 2, 2},
        GridGeometry{1e-300, {1, 0}, 2, 2}}) {
    for (MapLayer& layer : layers.layers) layer.grid.geometry = geometry;
    EXPECT_FALSE(GlobalMap::from_layers(layers)) << geometry.origin.transpose();
  }
}

TEST(GlobalMapOptions, WhatNeverTakesAMeasurementInIsRefused) {
  GlobalMapOptions options;
  options.alpha = 0.0;
  EXPECT_EQ(check_options(options).error().where, "alpha");
}

}  // namespace
}  // namespace tread
