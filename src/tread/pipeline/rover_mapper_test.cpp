#include "tread/pipeline/rover_mapper.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

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
  EXPECT_DOUBLE_EQ(far_sighted->options().local.range_m, 10.0);
  RoverMapOptions fixed;
  fixed.extend_range = false;
  EXPECT_DOUBLE_EQ(RoverMapper::make(wide, fixed)->options().depth.max_depth_m, 6.0);
}

TEST(RoverMapper, LooksBehindOnlyIfTheCameraDoes) {
  StereoRig rig = rover_rig();
  EXPECT_EQ(RoverMapper::make(rig, {})->options().local.behind_m, 0.0);
  rig.mount = level_mount(2.0, 1.5708, true);
  EXPECT_EQ(RoverMapper::make(rig, {})->options().local.behind_m, 6.0);
}

TEST(RoverMapper, ShrunkImagesGiveTheSameGround) {
  RoverMapOptions options;
  options.shrink = 2;
  auto mapper = RoverMapper::make(rover_rig(), options);
  ASSERT_TRUE(mapper);
  const auto frame = mapper->add(drive()[0]);
  ASSERT_TRUE(frame) << frame.error().message();
  EXPECT_EQ(frame->left.width, 160);
  int known = 0;
  for (float h : frame->height->values) {
    if (std::isnan(h)) continue;
    ++known;
    EXPECT_LT(std::abs(h), 0.7F);
  }
  EXPECT_GT(known, 200);
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

// A rig that does not come rectified: the right camera is turned, both have distortion.
TEST(RoverMapper, RectifiesWhereNeedBe) {
  StereoRig rig = rover_rig();
  rig.rectified = false;
  BrownCamera lens;
  lens.pinhole = {250.0, 250.0, 159.5, 119.5, 0.0};
  rig.left = rig.right = lens;  // no distortion terms: the images stay those of the pinhole
  auto mapper = RoverMapper::make(rig, {});
  ASSERT_TRUE(mapper);
  const auto frame = mapper->add(drive()[0]);
  ASSERT_TRUE(frame);
  int known = 0;
  for (float h : frame->height->values) known += std::isnan(h) ? 0 : 1;
  EXPECT_GT(known, 300);
}

}  // namespace
}  // namespace tread
