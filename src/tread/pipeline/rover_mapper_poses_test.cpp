// Poses that cannot be, and maps that would outgrow the memory: the maps remain.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "synthetic_drive.hpp"
#include "tread/pipeline/rover_mapper.hpp"

namespace tread {
namespace {

// One view of flat ground, put at places along a drive: the maps do not know that it is the same.
StereoFrame frame_at(int number, double x, double y = 0.0) {
  static const StereoFrame seen = [] {
    const StereoRig rig = testing::small_rig();
    const auto flat = [](double, double) { return 0.0; };
    return testing::render_frame(rig, rig.mount->T_body_left, flat, 8.0);
  }();
  StereoFrame frame = seen;
  frame.name = std::to_string(number);
  frame.stamp_ns = 100'000'000LL * number;
  frame.T_world_left->translation() += Eigen::Vector3d(x, y, 0.0);
  return frame;
}

RoverMapper make_mapper(const RoverMapOptions& options = {}) {
  auto mapper = RoverMapper::make(testing::small_rig(), options);
  EXPECT_TRUE(mapper) << mapper.error().message();
  return std::move(*mapper);
}

int explored_cells(const MapLayers& map) {
  int explored = 0;
  for (float e : map.find("explored")->grid.values) explored += e > 0.0F ? 1 : 0;
  return explored;
}

TEST(RoverMapperPoses, AnOutlierIsRefusedByNameAndTheMapsAreAsWithoutIt) {
  RoverMapper with = make_mapper(), without = make_mapper();
  for (int i = 0; i < 5; ++i) {
    if (i == 2) {
      const auto refused = with.add(frame_at(2, 1e7));
      ASSERT_FALSE(refused);
      EXPECT_EQ(refused.error().where, "frame 2");
      EXPECT_EQ(refused.error().what,
                "its pose is 1e+07 m from that of the last frame taken, 55 m are allowed");
      EXPECT_NE(refused.error().remedy.find("pose.max_step_m"), std::string::npos);
      continue;
    }
    ASSERT_TRUE(with.add(frame_at(i, 0.25 * i)));
    ASSERT_TRUE(without.add(frame_at(i, 0.25 * i)));
  }
  EXPECT_EQ(with.refused_poses(), 1U);
  EXPECT_EQ(without.refused_poses(), 0U);
  const auto a = with.layers(), b = without.layers();
  ASSERT_TRUE(a && b);
  EXPECT_GT(explored_cells(*a), 300);
  for (const MapLayer& layer : a->layers) {
    const Grid<float>& other = b->find(layer.name)->grid;
    ASSERT_EQ(layer.grid.geometry, other.geometry);
    for (std::size_t i = 0; i < layer.grid.values.size(); ++i) {
      const float u = layer.grid.values[i], v = other.values[i];
      ASSERT_TRUE(u == v || (std::isnan(u) && std::isnan(v))) << layer.name << " " << i;
    }
  }
}

TEST(RoverMapperPoses, AnOutlierAtTheStartIsDroppedAndTheMapSaysSo) {
  RoverMapper mapper = make_mapper();
  const std::vector<Obstacle> post = {{{0.0, 0.0}, 0.3, 700.0}};
  ASSERT_TRUE(mapper.cost().set_obstacles(ObstacleList::kForbidden, post));
  // 8000 km east of the origin there is no room for both the post and the frame.
  const auto first = mapper.add(frame_at(0, 8e6, 8e6));
  ASSERT_FALSE(first);
  EXPECT_EQ(first.error().code, ErrorCode::kTooLarge);
  EXPECT_EQ(first.error().where, "frame 0");
  EXPECT_FALSE(mapper.add(frame_at(1, 0.0)));
  EXPECT_FALSE(mapper.add(frame_at(2, 0.25)));
  const auto third = mapper.add(frame_at(3, 0.5));
  ASSERT_TRUE(third) << third.error().message();
  ASSERT_TRUE(third->began_anew);
  EXPECT_EQ(third->began_anew->where, "frame 3");
  const auto fourth = mapper.add(frame_at(4, 0.75));
  ASSERT_TRUE(fourth);
  EXPECT_FALSE(fourth->began_anew);
  const auto map = mapper.layers();
  ASSERT_TRUE(map);
  EXPECT_LT(map->find("height")->grid.geometry.columns, 200);
  EXPECT_EQ(mapper.cost().at({0, 0}), 700.0F) << "what other senses know is kept";
}

TEST(RoverMapperPoses, WithoutObstaclesTheMapOfAnOutlierAtTheStartIsForgotten) {
  RoverMapper mapper = make_mapper();
  ASSERT_TRUE(mapper.add(frame_at(0, 1e7)));
  EXPECT_FALSE(mapper.add(frame_at(1, 0.0)));
  EXPECT_FALSE(mapper.add(frame_at(2, 0.25)));
  ASSERT_TRUE(mapper.add(frame_at(3, 0.5)));
  EXPECT_LT(mapper.ground().bounds().last.x, 200);
  EXPECT_LT(mapper.cost().grid().geometry.columns, 100);
  EXPECT_GT(explored_cells(mapper.layers().value()), 300);
}

TEST(RoverMapperPoses, ThatTheMapBeganAnewIsToldWithTheNextFrameThatIsTaken) {
  RoverMapOptions options;
  options.global.max_map_mib = 1;
  RoverMapper mapper = make_mapper(options);
  ASSERT_TRUE(mapper.add(frame_at(0, 1e7)));
  ASSERT_TRUE(mapper.cost().set_obstacles(ObstacleList::kBump, {{{1e7, 0.0}, 0.3, 700.0}}));
  for (int i = 1; i < 4; ++i) EXPECT_FALSE(mapper.add(frame_at(i, 0.25 * i)));
  ASSERT_TRUE(mapper.cost().set_obstacles(ObstacleList::kBump, {}));
  mapper.cost().clear();
  const auto taken = mapper.add(frame_at(4, 1.0));
  ASSERT_TRUE(taken) << taken.error().message();
  ASSERT_TRUE(taken->began_anew);
  EXPECT_EQ(taken->began_anew->where, "frame 3");
}

TEST(RoverMapperPoses, AJumpThatLastsGoesIntoTheSameMapWhereThereIsRoom) {
  RoverMapper mapper = make_mapper();
  std::string taken;
  for (int i = 0; i < 8; ++i) {
    taken += mapper.add(frame_at(i, i < 4 ? 0.25 * i : 300.0 + 0.25 * i)) ? 'x' : '-';
  }
  EXPECT_EQ(taken, "xxxx--xx");
  EXPECT_GT(mapper.ground().bounds().columns(), 3000);
  EXPECT_EQ(mapper.refused_poses(), 2U);
}

TEST(RoverMapperPoses, AMapThatWouldOutgrowItsLimitStaysAsItIs) {
  RoverMapOptions options;
  options.global.max_map_mib = 1;  // 87381 cells
  RoverMapper mapper = make_mapper(options);
  ASSERT_TRUE(mapper.add(frame_at(0, 0.0)));
  ASSERT_TRUE(mapper.add(frame_at(1, 40.0)));
  const CellRect before = mapper.ground().bounds();
  const auto refused = mapper.add(frame_at(2, 70.0, 40.0));  // some 770 x 520 cells
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kTooLarge);
  EXPECT_TRUE(refused.error().where.starts_with("frame 2"));
  EXPECT_NE(refused.error().what.find("global.max_map_mib is 1"), std::string::npos)
      << refused.error().message();
  EXPECT_EQ(mapper.ground().bounds(), before);
  EXPECT_TRUE(mapper.layers());
  EXPECT_TRUE(mapper.add(frame_at(3, 41.0))) << "frames on the map are still taken";
}

// No view, so no ground: only the place of the robot would stretch the grid of costs.
TEST(RoverMapperPoses, BlindFramesFarAwayDoNotStretchTheMap) {
  RoverMapOptions options;
  options.pose.check_jumps = false;
  RoverMapper mapper = make_mapper(options);
  ASSERT_TRUE(mapper.add(frame_at(0, 0.0)));
  StereoFrame blind = frame_at(1, 1e7, 1e7);
  blind.left = blind.right = Image<std::uint8_t>(320, 240, 0);
  const auto refused = mapper.add(blind);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kTooLarge);
  EXPECT_LT(mapper.cost().grid().geometry.columns, 100);
  StereoFrame beyond = frame_at(2, 1e12);
  EXPECT_FALSE(mapper.add(beyond));
}

TEST(RoverMapperPoses, ADriveInUtmCoordinatesGivesTheSameHeights) {
  // Both places are whole numbers of ground and cost cells from the origin.
  constexpr double kEast = 448'260.0, kNorth = 5'411'931.0;
  RoverMapper here = make_mapper(), there = make_mapper();
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(here.add(frame_at(i, 0.02 + 0.3 * i, 0.02)));
    const auto taken = there.add(frame_at(i, kEast + 0.02 + 0.3 * i, kNorth + 0.02));
    ASSERT_TRUE(taken) << taken.error().message();
  }
  const CellRect& a = here.ground().bounds();
  const CellRect& b = there.ground().bounds();
  const Cell shift{4'482'600, 54'119'310};
  EXPECT_EQ(b.first, (Cell{a.first.x + shift.x, a.first.y + shift.y}));
  int known = 0;
  for (int y = a.first.y; y < a.last.y; ++y) {
    for (int x = a.first.x; x < a.last.x; ++x) {
      const GroundCell* u = here.ground().find({x, y});
      const GroundCell* v = there.ground().find({x + shift.x, y + shift.y});
      if (u == nullptr || v == nullptr || std::isnan(u->height_m)) continue;
      ++known;
      EXPECT_NEAR(u->height_m, v->height_m, 1e-4) << x << " " << y;
    }
  }
  EXPECT_GT(known, 300);
}

TEST(RoverMapperPoses, PosesThatAreNoRigidMotionAreRefusedAndDoNotMoveTheGate) {
  RoverMapper mapper = make_mapper();
  ASSERT_TRUE(mapper.add(frame_at(0, 0.0)));
  const double nan = std::nan(""), infinite = std::numeric_limits<double>::infinity();
  std::vector<Isometry3d> bad(6, *frame_at(1, 0.25).T_world_left);
  bad[0].translation().y() = nan;
  bad[1].translation().z() = infinite;
  bad[2].matrix()(0, 0) = nan;
  bad[3].linear() *= 1.01;                                  // a scale
  bad[4].linear().col(0) = -bad[4].linear().col(0);         // a mirror
  bad[5].linear().col(0) += 0.01 * bad[5].linear().col(1);  // a shear
  for (const Isometry3d& pose : bad) {
    StereoFrame frame = frame_at(1, 0.0);
    frame.T_world_left = pose;
    const auto refused = mapper.add(frame);
    ASSERT_FALSE(refused) << pose.matrix();
    EXPECT_EQ(refused.error().what, "its pose is not finite or not a rigid motion");
    EXPECT_EQ(refused.error().where, "frame 1");
  }
  EXPECT_TRUE(mapper.add(frame_at(2, 0.5)));
}

TEST(RoverMapperOptions, ContradictionsAreRefusedWithAllTheirNames) {
  const auto refused = [](const std::vector<std::pair<std::string, std::string>>& settings) {
    RoverMapOptions options;
    for (const auto& [name, text] : settings) {
      const Status set = describe(options).set(name, text);
      EXPECT_TRUE(set) << set.error().message();
    }
    const auto mapper = RoverMapper::make(testing::small_rig(), options);
    return mapper ? "accepted" : mapper.error().where;
  };
  EXPECT_EQ(refused({}), "accepted");
  EXPECT_EQ(refused({{"depth.min_depth_m", "7"}}), "depth.min_depth_m, depth.max_depth_m");
  EXPECT_EQ(refused({{"depth.min_depth_m", "6"}}), "depth.min_depth_m, depth.max_depth_m");
  EXPECT_EQ(refused({{"local.min_height_m", "3"}}), "local.min_height_m, local.max_height_m");
  EXPECT_EQ(refused({{"depth.max_depth_m", "5000"}}), "depth.max_depth_m, local.resolution_m");
  EXPECT_EQ(refused({{"cost.window_m", "0.2"}}),
            "cost.window_m, cost.cells_per_side, local.resolution_m");
  EXPECT_EQ(refused({{"cost.window_m", "51"}}),
            "cost.window_m, cost.cells_per_side, local.resolution_m");
  EXPECT_EQ(refused({{"cost.knots", "0:1 1:20 2:10"}}), "cost.knots");
  EXPECT_EQ(refused({{"cost.knots", "0:-1 1:20"}}), "cost.knots");
  EXPECT_EQ(refused({{"cost.unexplored_cost", "0.5"}}), "cost.unexplored_cost, cost.knots");
  EXPECT_EQ(refused({{"stereo.sad.min_texture", "3"}, {"stereo.edges.kind", "none"}}),
            "stereo.sad.min_texture, stereo.edges.kind");
  const std::string both = "stereo.sad.min_disparity_px, stereo.sad.num_disparities";
  EXPECT_EQ(refused({{"stereo.sad.min_disparity_px", "1000"}}), both);
  // What the images, 320 px wide, cannot hold.
  EXPECT_EQ(refused({{"stereo.sad.min_disparity_px", "320"}}), both);
  EXPECT_EQ(refused({{"stereo.sad.num_disparities", "321"}, {"auto_num_disparities", "no"}}), both);
  EXPECT_EQ(
      refused(
          {{"stereo.sad.num_disparities", "96"}, {"auto_num_disparities", "no"}, {"shrink", "4"}}),
      both);
}

TEST(RoverMapperOptions, TheSearchBeginsWhereItIsSetToAndEndsInTheImage) {
  RoverMapOptions options;
  options.stereo.sad.min_disparity_px = 300;
  RoverMapper mapper = make_mapper(options);
  const auto taken = mapper.add(frame_at(0, 0.0));
  ASSERT_TRUE(taken) << taken.error().message();
  EXPECT_EQ(mapper.options().stereo.sad.num_disparities, 20);
}

TEST(RoverMapperTimings, TheFirstFramesEstimateIsAStageOfItsOwn) {
  Timings timings;
  Context context;
  context.timings = &timings;
  RoverMapper mapper = make_mapper();
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(mapper.add(frame_at(i, 0.25 * i), context));
  const auto calls = [&](std::string_view stage) {
    const auto found = timings.entries().find(stage);
    return found == timings.entries().end() ? 0 : found->second.calls;
  };
  EXPECT_EQ(calls("stereo/range"), 1);
  EXPECT_EQ(calls("stereo/match"), 3);
  EXPECT_EQ(calls("stereo/holes"), 3);
  EXPECT_EQ(calls("stereo/speckle"), 3);
  EXPECT_EQ(calls("stereo/edges"), 6);
}

}  // namespace
}  // namespace tread
