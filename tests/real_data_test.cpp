// The main job on real data: figures that must not get worse. The data are not part of the project;
// without them these tests are skipped.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>

#include "stereo_pairs.hpp"
#include "stereo_score.hpp"
#include "test_data.hpp"
#include "tread/io/source.hpp"
#include "tread/pipeline/rover_mapper.hpp"
#include "tread/plan/planner.hpp"

namespace tread {
namespace {

// Density and share of pixels off by more than 2 px of the estimated, per cent, by set of pairs.
using Figures = std::map<std::string, bench::Score>;

// The scores of a method with its defaults on every pair; the mean of the sets as "mean".
Figures stereo_scores(const std::filesystem::path& data, StereoMethod method) {
  const auto pairs = bench::load_stereo_pairs(data);
  EXPECT_TRUE(pairs) << pairs.error().message();
  if (!pairs) return {};
  std::map<std::string, std::vector<bench::Score>> scores;
  StereoMatcher matcher;
  for (const bench::StereoPair& pair : *pairs) {
    StereoOptions options;
    options.method = method;
    options.sad.num_disparities = pair.num_disparities;
    const auto disparity = matcher.match(pair.left, pair.right, options);
    EXPECT_TRUE(disparity);
    if (!disparity) return {};
    Image<float> px(pair.left.width, pair.left.height, std::numeric_limits<float>::quiet_NaN());
    for (int y = 0; y < px.height; ++y) {
      for (int x = 0; x < px.width; ++x) {
        if ((*disparity)(x, y) != kNoMatch) px(x, y) = disparity_px((*disparity)(x, y));
      }
    }
    scores[pair.set].push_back(bench::score(px, pair.truth));
  }
  Figures figures;
  std::vector<bench::Score> all;
  for (const auto& [set, of_set] : scores) {
    figures[set] = bench::mean_of(of_set);
    all.push_back(figures[set]);
  }
  figures["mean"] = bench::mean_of(all);
  return figures;
}

// The rivals' figures are those of bench/stereo_accuracy with OpenCV 4.6.
TEST(StereoAccuracy, SadBeatsBlockMatchingInBothFiguresOnEverySetByTenPointsInTheMean) {
  TREAD_NEEDS_DATA(stereo, "stereo");
  Figures ours = stereo_scores(stereo.parent_path(), StereoMethod::kSad);
  const struct {
    const char* set;
    double density, bad2, missed2;  // window 9 with speckle filter
  } rival[] = {{"cones", 72.7, 3.22, 29.6},
               {"Cloth3", 75.4, 0.61, 25.1},
               {"Motorcycle", 72.5, 3.66, 30.1},
               {"kitti2012", 26.1, 1.91, 74.3}};
  for (const auto& r : rival) {
    ASSERT_TRUE(ours.contains(r.set)) << r.set;
    EXPECT_GE(ours[r.set].density, r.density) << r.set;
    EXPECT_LE(ours[r.set].bad2, r.bad2) << r.set;
    EXPECT_LE(ours[r.set].missed2, r.missed2 - 5.0) << r.set;
  }
  EXPECT_GE(ours["mean"].density, 61.7 + 10.0);
  EXPECT_LE(ours["mean"].bad2, 2.35);
}

TEST(StereoAccuracy, SgmBeatsThreeWaySgbmInBothFiguresOnEverySet) {
  TREAD_NEEDS_DATA(stereo, "stereo");
  Figures ours = stereo_scores(stereo.parent_path(), StereoMethod::kSgm);
  const struct {
    const char* set;
    double density, bad2;
  } rival[] = {{"cones", 81.3, 4.07},
               {"Cloth3", 83.3, 1.36},
               {"Motorcycle", 86.2, 5.43},
               {"kitti2012", 85.9, 5.82}};
  for (const auto& r : rival) {
    ASSERT_TRUE(ours.contains(r.set)) << r.set;
    EXPECT_GE(ours[r.set].density, r.density) << r.set;
    EXPECT_LE(ours[r.set].bad2, r.bad2) << r.set;
  }
}

// A street with parked cars, kerbs and hedges: the road is flat and cheap, the plan stays on it.
TEST(KittiDrive, RoadIsCheapCarsAreLethalAndThePlanStaysOnTheRoad) {
  TREAD_NEEDS_DATA(drive, "stereo_seq/kitti_seq_1");
  const auto source = open_stereo_source(drive);
  ASSERT_TRUE(source) << source.error().message();
  auto mapper = RoverMapper::make((*source)->rig(), {});
  ASSERT_TRUE(mapper);
  Context context;
  context.threads = 2;
  std::vector<Eigen::Vector2d> way;
  int frames = 0;
  for (auto frame = (*source)->next(); frame && *frame; frame = (*source)->next()) {
    if (++frames % 2 == 0) continue;  // every other one is enough and half the time
    const auto mapped = mapper->add(**frame, context);
    ASSERT_TRUE(mapped) << mapped.error().message();
    way.push_back(mapped->pose.position.head<2>());
  }
  EXPECT_EQ(frames, 30);

  const auto cost = [&](double x, double y) {
    return mapper->cost().at(GridGeometry{0.3, {0, 0}, 0, 0}.cell_at({x, y}));
  };
  // Where the car has driven, from where the road comes into sight.
  int on_the_way = 0, cheap = 0;
  for (const Eigen::Vector2d& p : way) {
    if (p.x() < 8.0) continue;
    ++on_the_way;
    cheap += cost(p.x(), p.y()) < 5.0F ? 1 : 0;
  }
  EXPECT_GT(on_the_way, 5);
  EXPECT_EQ(cheap, on_the_way);
  int lethal = 0;
  for (float c : mapper->cost().grid().values) lethal += c >= 50.0F ? 1 : 0;
  EXPECT_GT(lethal, 100);  // the cars and trees at the sides

  const Eigen::Vector2d goal = way.back() + Eigen::Vector2d(32.0, 0.0);
  const Plan plan = plan_waypoints(mapper->cost().grid(), way.front(), goal, {});
  ASSERT_EQ(plan.status, PlanStatus::kFound) << plan.reason;
  EXPECT_TRUE(plan.goal_beyond_map);
  for (const Eigen::Vector2d& p : plan.waypoints) {
    // The road: 4 m to the left of the driven lane to 3 m to its right, up to the edge of the map.
    if (p.x() > way.back().x() + 12.0) continue;
    EXPECT_LT(p.y(), 4.0);
    EXPECT_GT(p.y(), -3.0);
  }
}

}  // namespace
}  // namespace tread
