#include "tread/pipeline/rover_mapper.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "synthetic_drive.hpp"
#include "tread/plan/planner.hpp"

namespace tread {
namespace {

using testing::block_and_kerb;

StereoRig rover_rig() {
  return testing::small_rig();
}

StereoFrame frame_at(const StereoRig& rig, double x, double yaw = 0.0, double pitch = 0.0) {
  Isometry3d T_world_body = Isometry3d::Identity();
  T_world_body.translation().x() = x;
  T_world_body.linear() = rotation_from_yaw_pitch_roll(yaw, pitch, 0.0);
  StereoFrame frame =
      testing::render_frame(rig, T_world_body * rig.mount->T_body_left, block_and_kerb, 8.0);
  frame.name = "at " + std::to_string(x);
  return frame;
}

// Five frames on the way towards the block; rendered once.
const std::vector<StereoFrame>& drive() {
  static const std::vector<StereoFrame> frames = [] {
    std::vector<StereoFrame> made;
    const double yaw[] = {0.0, 0.1, -0.15, 0.05, 0.0};
    for (int i = 0; i < 5; ++i)
      made.push_back(frame_at(rover_rig(), 0.25 * i, yaw[i], 0.03 * (i % 3)));
    return made;
  }();
  return frames;
}

RoverMapper mapped(const Context& context = {}) {
  auto mapper = RoverMapper::make(rover_rig(), {});
  EXPECT_TRUE(mapper);
  for (const StereoFrame& frame : drive()) EXPECT_TRUE(mapper->add(frame, context));
  return std::move(*mapper);
}

TEST(RoverMapper, HeightsAreTrueToOneCentimetreWhereTheGroundIsEven) {
  const RoverMapper mapper = mapped();
  int known = 0;
  double squares = 0.0;
  for (double x = 1.5; x < 2.8; x += 0.1) {
    for (double y = -1.0; y < 1.4; y += 0.1) {
      const GroundCell* cell = mapper.ground().find(mapper.ground().cell_at({x + 0.05, y + 0.05}));
      if (cell == nullptr || std::isnan(cell->height_m)) continue;
      ++known;
      squares += cell->height_m * cell->height_m;
    }
  }
  EXPECT_GT(known, 13 * 24 * 8 / 10);
  EXPECT_LT(std::sqrt(squares / known), 0.01);
}

TEST(RoverMapper, FlatGroundIsCheapTheBlockIsLethalTheKerbIsDear) {
  const RoverMapper mapper = mapped();
  const auto cost = [&](double x, double y) {
    return mapper.cost().at(GridGeometry{0.3, {0, 0}, 0, 0}.cell_at({x, y}));
  };
  EXPECT_LT(cost(1.95, 0.0), 5.0);
  EXPECT_GT(cost(3.0, -0.3), 50.0);
  const auto derivative = [&](double x, double y) {
    const GroundCell* cell = mapper.ground().find(mapper.ground().cell_at({x, y}));
    return cell != nullptr && cell->explored() ? cell->derivative : std::nanf("");
  };
  // The kerb of 10 cm: 16 h^2 = 0.16, somewhat less after smoothing by the window.
  float dearest = 0.0F;
  for (double y = 1.35; y < 1.9; y += 0.1) dearest = std::max(dearest, derivative(4.35, y));
  EXPECT_GT(dearest, 0.04F);
  EXPECT_LT(dearest, 0.4F);
  EXPECT_LT(derivative(2.05, 0.05), 0.02F);
}

TEST(RoverMapper, PlanGoesRoundTheBlock) {
  const RoverMapper mapper = mapped();
  const Plan plan = plan_waypoints(mapper.cost().grid(), {1.0, 0.0}, {20.0, 0.0}, {});
  ASSERT_EQ(plan.status, PlanStatus::kFound) << plan.reason;
  EXPECT_TRUE(plan.goal_beyond_map);
  for (std::size_t i = 1; i < plan.waypoints.size(); ++i) {
    for (double s = 0.0; s <= 1.0; s += 0.01) {
      const Eigen::Vector2d p =
          plan.waypoints[i - 1] + s * (plan.waypoints[i] - plan.waypoints[i - 1]);
      EXPECT_FALSE(p.x() > 3.0 && p.x() < 3.6 && p.y() > -1.2 && p.y() < 0.6) << p.transpose();
    }
  }
}

// Where the robot stands is on the map, though its camera sees the ground from 0.6 m ahead on only.
TEST(RoverMapper, TheCostMapReachesToTheRobot) {
  auto mapper = RoverMapper::make(rover_rig(), {});
  ASSERT_TRUE(mapper);
  ASSERT_TRUE(mapper->add(drive()[0]));
  const Grid<float> grid = mapper->cost().grid();
  EXPECT_TRUE(grid.geometry.contains(grid.geometry.cell_at({0.0, 0.0})));
  const Plan plan = plan_waypoints(grid, {0.0, 0.0}, {2.0, 0.0}, {});
  EXPECT_EQ(plan.status, PlanStatus::kFound) << plan.reason;
}

TEST(RoverMapper, SameForAnyThreadCount) {
  Context two;
  two.threads = 2;
  const MapLayers a = mapped().layers().value(), b = mapped(two).layers().value();
  for (const MapLayer& layer : a.layers) {
    const MapLayer* other = b.find(layer.name);
    ASSERT_NE(other, nullptr);
    ASSERT_EQ(layer.grid.geometry, other->grid.geometry);
    for (std::size_t i = 0; i < layer.grid.values.size(); ++i) {
      const float u = layer.grid.values[i], v = other->grid.values[i];
      ASSERT_TRUE(u == v || (std::isnan(u) && std::isnan(v))) << layer.name << " " << i;
    }
  }
}

TEST(RoverMapper, StagesAreTimedByTheirPaths) {
  Timings timings;
  Context context;
  context.timings = &timings;
  (void)mapped(context);
  for (const char* stage :
       {"stereo/edges", "stereo/match", "stereo/holes", "stereo/speckle", "stereo/depth",
        "stereo/cloud", "terrain/local", "terrain/derivative", "terrain/global", "terrain/cost"}) {
    EXPECT_TRUE(timings.entries().contains(stage)) << stage;
  }
}

TEST(RoverMapper, RangeIsSixMetresOrWhereAQuarterPixelIsACell) {
  auto near_sighted = RoverMapper::make(rover_rig(), {});
  ASSERT_TRUE(near_sighted);
  EXPECT_DOUBLE_EQ(near_sighted->options().depth.max_depth_m, 6.0);  // the rig could do 4.5 m
  StereoRig wide = rover_rig();
  wide.T_left_right.translation().x() = 1.0;
  auto far_sighted = RoverMapper::make(wide, {});
  ASSERT_TRUE(far_sighted);
  EXPECT_DOUBLE_EQ(far_sighted->options().depth.max_depth_m, 10.0);  // sqrt(0.1 * 250 / 0.25)
  RoverMapOptions fixed;
  fixed.extend_range = false;
  EXPECT_DOUBLE_EQ(RoverMapper::make(wide, fixed)->options().depth.max_depth_m, 6.0);
}

// A frame all of whose pixels have the same disparity.
StereoFrame shifted_frame(int disparity_px) {
  StereoFrame frame = drive()[0];
  for (int y = 0; y < frame.left.height; ++y) {
    for (int x = 0; x < frame.left.width; ++x) {
      const auto texture = [y](int u) {
        return static_cast<std::uint8_t>(255.0 * testing::lattice_noise(u / 4, y / 4, 0));
      };
      frame.left(x, y) = texture(x - disparity_px + 1000);
      frame.right(x, y) = texture(x + 1000);
    }
  }
  return frame;
}

TEST(RoverMapper, TheFirstFrameAloneWidensTheSearchAndNoneNarrowsIt) {
  const auto after = [](const RoverMapOptions& options, const std::vector<StereoFrame>& frames) {
    auto mapper = RoverMapper::make(rover_rig(), options);
    EXPECT_TRUE(mapper);
    for (const StereoFrame& frame : frames) EXPECT_TRUE(mapper->add(frame));
    return mapper->options().stereo.sad.num_disparities;
  };
  RoverMapOptions options;
  options.stereo.sad.num_disparities = 64;
  EXPECT_EQ(after(options, {shifted_frame(20)}), 64);
  const int wide = after(options, {shifted_frame(100)});
  EXPECT_GT(wide, 100);
  EXPECT_LE(wide, 144);
  EXPECT_EQ(after(options, {shifted_frame(20), shifted_frame(100)}), 64);
  options.stereo.sad.num_disparities = 200;
  EXPECT_EQ(after(options, {shifted_frame(20)}), 200);
  options.stereo.sad.num_disparities = 64;
  options.auto_num_disparities = false;
  EXPECT_EQ(after(options, {shifted_frame(100)}), 64);
}

// Where on the robot the camera sits, and where it looks, is nothing to the ground.
TEST(RoverMapper, OneGroundWhateverTheMount) {
  const auto ground = [](const Isometry3d& T_body_forward) {
    StereoRig rig = rover_rig();
    rig.mount->T_body_left = T_body_forward * rig.mount->T_body_left;
    auto mapper = RoverMapper::make(rig, {});
    EXPECT_TRUE(mapper);
    for (const StereoFrame& frame : drive()) EXPECT_TRUE(mapper->add(frame));
    std::map<std::pair<int, int>, float> heights;
    const CellRect& bounds = mapper->ground().bounds();
    for (int y = bounds.first.y; y < bounds.last.y; ++y) {
      for (int x = bounds.first.x; x < bounds.last.x; ++x) {
        const GroundCell* cell = mapper->ground().find({x, y});
        if (cell != nullptr && cell->explored()) heights[{x, y}] = cell->height_m;
      }
    }
    return heights;
  };
  const auto expected = ground(Isometry3d::Identity());
  ASSERT_GT(expected.size(), 500U);
  for (const double yaw : {0.0, 0.8, 1.5708, 3.1416}) {
    for (const double ahead : {0.0, 4.0, -8.0}) {
      Isometry3d T = Isometry3d(rotation_from_yaw_pitch_roll(yaw, 0.0, 0.0));
      T.translation().x() = ahead;
      const auto heights = ground(T);
      // The cells of the two local maps lie differently.
      EXPECT_NEAR(static_cast<double>(heights.size()), static_cast<double>(expected.size()),
                  0.03 * static_cast<double>(expected.size()))
          << yaw << " " << ahead;
    }
  }
}

class RoverMapperGround : public ::testing::TestWithParam<bool> {};

// Half the pixels, or points weighed by how sure they are.
TEST_P(RoverMapperGround, IsTheSame) {
  RoverMapOptions options;
  options.shrink = GetParam() ? 2 : 1;
  options.weigh_points = !GetParam();
  auto mapper = RoverMapper::make(rover_rig(), options);
  ASSERT_TRUE(mapper);
  EXPECT_EQ(mapper->options().stereo.rate, options.weigh_points);
  const auto frame = mapper->add(drive()[0]);
  ASSERT_TRUE(frame) << frame.error().message();
  EXPECT_EQ(frame->left.width, 320 / options.shrink);
  // The even ground to 3 cm, and the block where it stands.
  const Grid<float>& height = *frame->height;
  int known = 0, high = 0, on_block = 0;
  double squares = 0.0;
  for (int y = 0; y < height.geometry.rows; ++y) {
    for (int x = 0; x < height.geometry.columns; ++x) {
      const float h = height[{x, y}];
      const Eigen::Vector2d p = height.geometry.centre({x, y});
      if (std::isnan(h)) continue;
      if (p.x() > 1.2 && p.x() < 2.7 && p.y() > -1.0 && p.y() < 1.4) {
        ++known;
        squares += h * h;
      }
      if (h < 0.35F) continue;
      ++high;
      on_block += p.x() > 2.8 && p.x() < 3.8 && p.y() > -1.4 && p.y() < 0.8 ? 1 : 0;
    }
  }
  EXPECT_GT(known, 15 * 24 * 7 / 10);
  EXPECT_LT(std::sqrt(squares / known), 0.03);
  EXPECT_GT(high, 20);
  EXPECT_GE(on_block, high * 9 / 10);
}
INSTANTIATE_TEST_SUITE_P(Ways, RoverMapperGround, ::testing::Bool(),
                         [](const auto& way) { return way.param ? "shrunk" : "weighed"; });

// Which image the disparities belong to does not move the ground: the block's left side stays where
// it is, y = 0.6 m. A cloud in the wrong camera's axes is a baseline, 0.2 m, beside it.
TEST(RoverMapper, SameGroundWithEitherReference) {
  for (const Reference reference : {Reference::kLeft, Reference::kRight}) {
    RoverMapOptions options;
    options.stereo.sad.reference = reference;
    auto mapper = RoverMapper::make(rover_rig(), options);
    ASSERT_TRUE(mapper);
    for (const StereoFrame& frame : drive()) ASSERT_TRUE(mapper->add(frame));
    const auto mean_height = [&](double y) {
      double sum = 0.0;
      int known = 0;
      for (double x = 3.05; x < 3.5; x += 0.1) {
        const GroundCell* cell = mapper->ground().find(mapper->ground().cell_at({x, y}));
        if (cell == nullptr || std::isnan(cell->height_m)) continue;
        sum += cell->height_m;
        ++known;
      }
      EXPECT_GT(known, 0) << y;
      return sum / known;
    };
    EXPECT_GT(mean_height(0.45), 0.3);
    EXPECT_LT(mean_height(0.75), 0.2);
    EXPECT_GT(mean_height(-1.05), 0.3);
    EXPECT_LT(mean_height(-1.35), 0.2);
  }
}

// Without a mount the camera is the body: heights are measured from it.
TEST(RoverMapper, WithoutMountHeightsCountFromTheCamera) {
  StereoRig rig = rover_rig();
  rig.mount.reset();
  auto mapper = RoverMapper::make(rig, {});
  ASSERT_TRUE(mapper);
  const auto frame = mapper->add(drive()[0]);
  ASSERT_TRUE(frame);
  const Grid<float>& height = *frame->height;
  const float ground = height[height.geometry.cell_at({2.05, 0.05})];
  EXPECT_NEAR(ground, -0.8, 0.03);
  const GroundCell* cell = mapper->ground().find(mapper->ground().cell_at({2.05, 0.05}));
  ASSERT_NE(cell, nullptr);
  EXPECT_NEAR(cell->height_m, 0.0, 0.03);
}

TEST(RoverMapper, BadFramesAreNamedAndLeaveTheMapsAlone) {
  RoverMapper mapper = mapped();
  const CellRect before = mapper.ground().bounds();
  const auto refused = [&](StereoFrame frame) {
    frame.name = "000012";
    const auto result = mapper.add(frame);
    if (result) return std::string("accepted");
    EXPECT_NE(result.error().message().find("frame 000012"), std::string::npos);
    return result.error().what;
  };
  StereoFrame frame = drive()[0];
  frame.T_world_left.reset();
  EXPECT_EQ(refused(frame), "it has no pose");
  frame = drive()[0];
  frame.T_world_left->translation().x() = std::nan("");
  EXPECT_NE(refused(frame), "accepted");
  frame = drive()[0];
  frame.right = Image<std::uint8_t>(319, 240);
  EXPECT_EQ(refused(frame), "an image is 319x240, the rig says 320x240");
  frame = drive()[0];
  frame.left = {};
  EXPECT_NE(refused(frame), "accepted");
  EXPECT_EQ(mapper.ground().bounds(), before);
}

TEST(RoverMapper, BlackAndBlindFramesAddNothing) {
  auto mapper = RoverMapper::make(rover_rig(), {});
  ASSERT_TRUE(mapper);
  StereoFrame black = drive()[0];
  black.left = black.right = Image<std::uint8_t>(320, 240, 0);
  const auto result = mapper->add(black);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->changed_cells, 0U);
  EXPECT_TRUE(mapper->ground().bounds().empty());
}

TEST(RoverMapper, RefusesUnsoundRigsAndOptions) {
  StereoRig rig = rover_rig();
  rig.T_left_right.translation().x() = 0.0;
  EXPECT_FALSE(RoverMapper::make(rig, {}));
  RoverMapOptions options;
  options.cost.cells_per_side = 0;
  const auto refused = RoverMapper::make(rover_rig(), options);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().where, "cost.cells_per_side");
}

// A rig that does not come rectified: the cameras are turned against each other and not quite side
// by side. The ground is found where it is, which a wrong rotation of either camera would tilt.
TEST(RoverMapper, RectifiesWhereNeedBe) {
  StereoRig rig = rover_rig();
  rig.rectified = false;
  BrownCamera lens;  // no distortion terms: the images stay those of the pinhole
  lens.pinhole = {250.0, 250.0, 159.5, 119.5, 0.0};
  rig.left = rig.right = lens;
  rig.T_left_right.linear() = so3_exp({0.04, -0.06, 0.05});
  rig.T_left_right.translation() = Eigen::Vector3d(0.2, 0.015, -0.02);
  auto mapper = RoverMapper::make(rig, {});
  ASSERT_TRUE(mapper);
  const auto frame = mapper->add(frame_at(rig, 0.0));
  ASSERT_TRUE(frame);
  const Grid<float>& height = *frame->height;
  int known = 0;
  double squares = 0.0;
  for (double x = 1.55; x < 2.8; x += 0.1) {
    for (double y = -0.95; y < 1.4; y += 0.1) {
      const float h = height[height.geometry.cell_at({x, y})];
      if (std::isnan(h)) continue;
      ++known;
      squares += h * h;
    }
  }
  EXPECT_GT(known, 13 * 24 * 7 / 10);
  EXPECT_LT(std::sqrt(squares / known), 0.015);
}

}  // namespace
}  // namespace tread
