#include "tread/slam/refine_window.hpp"

#include <gtest/gtest.h>

#include <random>

namespace tread {
namespace {

RectifiedRig rig_of_test() {
  RectifiedRig rig;
  rig.size = {640, 480};
  rig.fx_px = rig.fy_px = 435.0;
  rig.cx_px = 319.5;
  rig.cy_px = 239.5;
  rig.baseline_m = 0.11;
  return rig;
}

// Keyframes along an arc that look at the same points, seen with noise.
struct Made {
  std::vector<Isometry3d> truth;
  std::vector<Eigen::Vector3d> places;
  std::vector<WindowFrame> frames;
  std::vector<WindowPoint> points;
  [[nodiscard]] std::vector<WindowPoint*> pointers() {
    std::vector<WindowPoint*> all;
    for (WindowPoint& p : points) all.push_back(&p);
    return all;
  }
};

Made make(int frames, double sigma_px, double pose_noise, double point_noise, unsigned seed) {
  const RectifiedRig rig = rig_of_test();
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> x(-2.0, 3.5), y(-1.5, 1.5), z(2.0, 6.0);
  Made made;
  for (int i = 0; i < 150; ++i) made.places.emplace_back(x(random), y(random), z(random));
  for (int i = 0; i < frames; ++i) {
    Vector6d twist;
    twist << 0.15 * i, 0.02 * i * i, 0.05 * i, 0.0, -0.03 * i, 0.01 * i;
    made.truth.push_back(se3_exp(twist));
    Vector6d off;
    for (int k = 0; k < 6; ++k) off(k) = pose_noise * normal(random);
    made.frames.push_back({10 + i, made.truth.back() * se3_exp(i == 0 ? Vector6d::Zero() : off)});
  }
  for (const Eigen::Vector3d& p : made.places) {
    WindowPoint point;
    point.p_world =
        p + point_noise * Eigen::Vector3d(normal(random), normal(random), normal(random));
    for (int i = 0; i < frames; ++i) {
      const Eigen::Vector3d q = made.truth[static_cast<std::size_t>(i)].inverse() * p;
      const Eigen::Vector3d s = stereo_projection(rig, q);
      if (s.x() < 0 || s.x() > 639 || s.y() < 0 || s.y() > 479) continue;
      point.seen.push_back({10 + i,
                            {s.x() + sigma_px * normal(random), s.y() + sigma_px * normal(random),
                             s.z() + sigma_px * normal(random)}});
    }
    if (!point.seen.empty()) made.points.push_back(point);
  }
  return made;
}

double largest_error_m(const Made& made) {
  double largest = 0.0;
  for (std::size_t i = 0; i < made.frames.size(); ++i) {
    largest = std::max(
        largest,
        (made.frames[i].T_world_camera.translation() - made.truth[i].translation()).norm());
  }
  return largest;
}

TEST(RefineWindow, FindsTheTruthWithoutNoise) {
  Made made = make(6, 0.0, 0.01, 0.03, 1);
  auto points = made.pointers();
  WindowOptions options;
  options.iterations = 30;
  ASSERT_GT(largest_error_m(made), 0.005);
  ASSERT_TRUE(refine_window(rig_of_test(), 0.4, options, made.frames, points, nullptr, {}));
  EXPECT_LT(largest_error_m(made), 1e-5);
  EXPECT_EQ(made.frames.front().T_world_camera.matrix(), made.truth.front().matrix());
}

TEST(RefineWindow, LessensNoise) {
  double before = 0.0, after = 0.0;
  for (unsigned seed = 0; seed < 10; ++seed) {
    Made made = make(8, 0.3, 0.005, 0.02, seed);
    auto points = made.pointers();
    before += largest_error_m(made);
    ASSERT_TRUE(refine_window(rig_of_test(), 0.4, {}, made.frames, points, nullptr, {}));
    after += largest_error_m(made);
  }
  EXPECT_GT(before / 10, 0.007);
  EXPECT_LT(after / 10, 0.004);
}

TEST(RefineWindow, OldKeyframesStayWhereTheyAre) {
  Made made = make(8, 0.3, 0.005, 0.0, 3);
  const Made as_it_was = made;
  WindowOptions options;
  options.free_keyframes = 3;
  auto points = made.pointers();
  ASSERT_TRUE(refine_window(rig_of_test(), 0.4, options, made.frames, points, nullptr, {}));
  for (std::size_t i = 0; i < made.frames.size(); ++i) {
    const bool same =
        made.frames[i].T_world_camera.matrix() == as_it_was.frames[i].T_world_camera.matrix();
    EXPECT_EQ(same, i < 5) << i;
  }
}

TEST(RefineWindow, SightsThatDoNotFitAreForgottenAndDoNotHurt) {
  Made made = make(6, 0.2, 0.003, 0.01, 4);
  std::size_t sights = 0;
  for (std::size_t k = 0; k < made.points.size(); ++k) {
    sights += made.points[k].seen.size();
    if (k % 10 == 0 && made.points[k].seen.size() > 3) made.points[k].seen[2].sight.u += 12.0;
  }
  auto points = made.pointers();
  ASSERT_TRUE(refine_window(rig_of_test(), 0.4, {}, made.frames, points, nullptr, {}));
  EXPECT_LT(largest_error_m(made), 0.004);
  std::size_t left = 0;
  for (const WindowPoint& point : made.points) left += point.seen.size();
  EXPECT_LT(left, sights - 5);
  EXPECT_GT(left, sights - sights / 10);
}

TEST(RefineWindow, ForgetsFramesThatAreGoneAndRefusesWhatIsTooLittle) {
  Made made = make(5, 0.2, 0.003, 0.01, 5);
  auto points = made.pointers();
  made.frames.erase(made.frames.begin());
  ASSERT_TRUE(refine_window(rig_of_test(), 0.4, {}, made.frames, points, nullptr, {}));
  for (const WindowPoint& point : made.points) {
    for (const auto& sighting : point.seen) EXPECT_GE(sighting.frame, 11);
  }
  std::vector<WindowFrame> one(made.frames.begin(), made.frames.begin() + 1);
  EXPECT_FALSE(refine_window(rig_of_test(), 0.4, {}, one, points, nullptr, {}));
  std::vector<WindowPoint*> none;
  EXPECT_FALSE(refine_window(rig_of_test(), 0.4, {}, made.frames, none, nullptr, {}));
}

}  // namespace
}  // namespace tread
