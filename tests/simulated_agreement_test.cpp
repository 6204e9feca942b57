// Physics and pictures are made from one description: the same ray meets the same thing at the same
// place in both, and where the formulas of the world say, on the courses as they are shipped.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <optional>
#include <string>

#include "tread/sim/named_courses.hpp"
#include "tread/sim/random.hpp"
#include "tread/sim/rover_body.hpp"
#include "tread/sim/scene.hpp"

namespace tread {
namespace {

using Eigen::Vector3d;

class SimulatedAgreement : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    course_ = find_course(GetParam()).value();
    scene_.emplace(Scene::make(course_.world).value());
    rover_ = RoverBody::place(*course_.world, {}, course_.world->start).value();
  }
  [[nodiscard]] Eigen::Vector2d place(Random& random) const {
    const GridGeometry& g = course_.world->ground.geometry;
    const Eigen::Vector2d low = g.centre({0, 0}), high = g.centre({g.columns - 1, g.rows - 1});
    return {random.uniform(low.x(), high.x()), random.uniform(low.y(), high.y())};
  }

  Course course_;
  std::optional<Scene> scene_;
  std::unique_ptr<RoverBody> rover_;
};

TEST_P(SimulatedAgreement, FromAboveAllFindTheSameHeight) {
  constexpr double kUp_m = 30.0;
  Random random(11);
  int compared = 0;
  for (int i = 0; i < 600; ++i) {
    const Eigen::Vector2d p = place(random);
    const Vector3d from(p.x(), p.y(), kUp_m);
    const auto touched = rover_->physics().cast_ray(from, -Vector3d::UnitZ());
    ASSERT_TRUE(touched) << p.transpose();
    if (rover_->physics().is_robot(touched->part)) continue;
    const RayHit seen = scene_->cast(from, -Vector3d::UnitZ(), RaysMeet::kWhatBears);
    const double top = top_height(*course_.world, p);
    EXPECT_NEAR(kUp_m - seen.distance_m, top, 1e-5) << p.transpose();
    EXPECT_NEAR(kUp_m - touched->distance_m, top, 1e-5) << p.transpose();
    ++compared;
  }
  EXPECT_GT(compared, 550);
}

// Rays as a camera on the robot has them, level and a little down.
TEST_P(SimulatedAgreement, FromTheSideBothFindTheSameDistance) {
  Random random(12);
  int compared = 0, differing = 0;
  for (int i = 0; i < 600; ++i) {
    const Eigen::Vector2d p = place(random);
    const Vector3d from(p.x(), p.y(), top_height(*course_.world, p) + 1.0);
    const double yaw = random.uniform(-3.1, 3.1), down = random.uniform(0.1, 0.8);
    const Vector3d ray(std::cos(yaw) * std::cos(down), std::sin(yaw) * std::cos(down),
                       -std::sin(down));
    const auto touched = rover_->physics().cast_ray(from, ray);
    const RayHit seen = scene_->cast(from, ray, RaysMeet::kWhatBears);
    if (!touched || !std::isfinite(seen.distance_m)) continue;
    if (rover_->physics().is_robot(touched->part)) continue;
    ++compared;
    // A ray that grazes an edge may pass it in one and not in the other.
    if (std::abs(touched->distance_m - seen.distance_m) > 1e-4) ++differing;
  }
  EXPECT_GT(compared, 250);  // the others leave the course
  EXPECT_LE(differing, 1);
}

INSTANTIATE_TEST_SUITE_P(Courses, SimulatedAgreement,
                         ::testing::Values("rough", "stairs", "stepping_stones", "pallets"),
                         [](const auto& course) { return std::string(course.param); });

}  // namespace
}  // namespace tread
