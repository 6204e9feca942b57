#include "tread/geometry/stereo_rig.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace tread {
namespace {

using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kDegree = std::numbers::pi / 180.0;

RectifiedRig rig_of(int width) {
  return rectified_rig(bumblebee2(width)).value();
}

// The numbers that paper Q prints about its camera, recomputed. Where the paper's figure holds for
// one of the two image widths only, the test says which.

TEST(PaperQCamera, FocalLengthAndBaseline) {
  EXPECT_NEAR(rig_of(1024).fx_px, 533.33, 0.005);
  EXPECT_NEAR(rig_of(640).fx_px, 333.33, 0.005);
  EXPECT_NEAR(rig_of(1024).baseline_m * rig_of(1024).fx_px, 64.0, 1e-9);
  EXPECT_NEAR(rig_of(640).baseline_m * rig_of(640).fx_px, 40.0, 1e-9);
  EXPECT_EQ(rig_of(1024).size, (ImageSize{1024, 768}));
  EXPECT_EQ(rig_of(640).size, (ImageSize{640, 480}));
}

// At a depth of 2.5 mm, the focal length, the rays of the image's borders are as far apart as on
// the sensor: 4.8 x 3.6 mm, and a pixel of it is 4.69 um wide and high at 1024 columns.
TEST(PaperQCamera, SquarePixelsFillTheSensor) {
  for (const auto& [width, pixel_um] : {std::pair(1024, 4.6875), std::pair(640, 7.5)}) {
    const RectifiedRig rig = rig_of(width);
    const Vector3d first = rig.point(-0.5, -0.5, 2.5e-3);
    const Vector3d last = rig.point(rig.size.width - 0.5, rig.size.height - 0.5, 2.5e-3);
    EXPECT_NEAR(1e3 * (last.x() - first.x()), 4.8, 1e-9);
    EXPECT_NEAR(1e3 * (last.y() - first.y()), 3.6, 1e-9);
    const Vector3d next = rig.point(0.5, 0.5, 2.5e-3);
    EXPECT_NEAR(1e6 * (next.x() - first.x()), pixel_um, 1e-9);
    EXPECT_NEAR(1e6 * (next.y() - first.y()), pixel_um, 1e-9);
  }
}

TEST(PaperQCamera, SmallestDepth) {
  EXPECT_NEAR(rig_of(1024).depth_m(100.0), 0.64, 1e-12);
  EXPECT_NEAR(rig_of(1024).depth_m(100.0), 0.65, 0.015);  // "0.65 m", "over 100 pixels"
  EXPECT_NEAR(rig_of(1024).disparity_px(0.65), 98.46, 0.005);
  EXPECT_NEAR(rig_of(640).depth_m(100.0), 0.40, 1e-12);
}

TEST(PaperQCamera, LargestDepthIsAbove40Metres) {
  EXPECT_NEAR(rig_of(1024).depth_m(1.0), 64.0, 1e-9);
  EXPECT_NEAR(rig_of(640).depth_m(1.0), 40.0, 1e-9);
}

TEST(PaperQCamera, DepthResolutionOfAQuarterPixel) {
  const double expected_mm[][3] = {{1.0, 3.91, 6.25}, {2.0, 15.63, 25.0}, {3.0, 35.16, 56.25}};
  const double printed_mm[] = {4.0, 15.0, 35.0};
  for (int i = 0; i < 3; ++i) {
    const double z = expected_mm[i][0];
    EXPECT_NEAR(1e3 * rig_of(1024).depth_resolution_m(z), expected_mm[i][1], 0.006);
    EXPECT_NEAR(1e3 * rig_of(640).depth_resolution_m(z), expected_mm[i][2], 0.006);
    EXPECT_NEAR(1e3 * rig_of(1024).depth_resolution_m(z), printed_mm[i], 0.7);
  }
  // It is the difference that a quarter pixel makes: the derivative of Eq. 1.
  const RectifiedRig rig = rig_of(1024);
  const double d = rig.disparity_px(2.0);
  EXPECT_NEAR(rig.depth_m(d - 0.125) - rig.depth_m(d + 0.125), rig.depth_resolution_m(2.0), 1e-6);
}

// What step of the disparity the printed 4, 15, 35 mm stand for: a quarter pixel at 1024 columns,
// at 640 some 0.15, which nobody claims.
TEST(PaperQCamera, PrintedDepthResolutionsAreAQuarterPixelAt1024Columns) {
  const double printed_mm[] = {4.0, 15.0, 35.0};
  const double step_1024[] = {0.256, 0.240, 0.249};
  const double step_640[] = {0.160, 0.150, 0.156};
  for (int i = 0; i < 3; ++i) {
    const double z = i + 1.0;
    EXPECT_NEAR(1e-3 * printed_mm[i] / rig_of(1024).depth_resolution_m(z, 1.0), step_1024[i], 5e-4);
    EXPECT_NEAR(1e-3 * printed_mm[i] / rig_of(640).depth_resolution_m(z, 1.0), step_640[i], 5e-4);
  }
}

// Eq. 2 as printed has the disparity where its step belongs: r would be the depth itself.
TEST(PaperQCamera, EquationTwoAsPrintedGivesTheDepth) {
  for (double z : {0.8, 1.0, 4.0}) {
    const RectifiedRig rig = rig_of(1024);
    EXPECT_NEAR(rig.depth_resolution_m(z, rig.disparity_px(z)), z, 1e-12);
  }
}

// "calibrated to 0.11 pixels": what such an error of the disparity does at one metre.
TEST(PaperQCamera, CalibrationErrorAtOneMetre) {
  for (const auto& [width, printed_mm] : {std::pair(1024, 1.7), std::pair(640, 2.8)}) {
    const RectifiedRig rig = rig_of(width);
    EXPECT_NEAR(1e3 * rig.depth_resolution_m(1.0, 0.11), printed_mm, 0.051);
    const double d = rig.disparity_px(1.0);
    EXPECT_NEAR(rig.depth_m(d - 0.055) - rig.depth_m(d + 0.055), rig.depth_resolution_m(1.0, 0.11),
                1e-8);
  }
}

// Paper R's six metres: a quarter pixel is there about a cell of 0.1 m with 1024 columns and lenses
// of 3.8 or 2.5 mm, and not with 640.
TEST(PaperRCamera, QuarterPixelAtSixMetresIsAboutACell) {
  RectifiedRig longer = rig_of(1024);
  longer.fx_px *= 3.8 / 2.5;
  EXPECT_NEAR(longer.depth_resolution_m(6.0), 0.0925, 5e-5);
  EXPECT_NEAR(longer.depth_resolution_m(6.0), 0.10, 0.01);
  EXPECT_NEAR(rig_of(1024).depth_resolution_m(6.0), 0.14, 0.001);
  EXPECT_NEAR(rig_of(640).depth_resolution_m(6.0), 0.225, 1e-9);
}

TEST(PaperQCamera, SearchWindowOf10To74Pixels) {
  EXPECT_NEAR(rig_of(640).depth_m(10.0), 4.0, 1e-12);
  EXPECT_NEAR(rig_of(640).depth_m(74.0), 0.541, 5e-4);
  EXPECT_NEAR(rig_of(1024).depth_m(10.0), 6.40, 1e-12);
  EXPECT_NEAR(rig_of(1024).depth_m(74.0), 0.865, 5e-4);
  // The paper's 0.8 m is inside the window at 640 pixels only.
  EXPECT_NEAR(rig_of(640).disparity_px(0.8), 50.0, 1e-9);
  EXPECT_NEAR(rig_of(1024).disparity_px(0.8), 80.0, 1e-9);
}

double field_of_view_deg(double f_px, int width) {
  return 2.0 * std::atan(0.5 * width / f_px) / kDegree;
}

TEST(PaperQCamera, FieldOfView) {
  EXPECT_NEAR(field_of_view_deg(rig_of(1024).fx_px, 1024), 87.7, 0.05);
  EXPECT_NEAR(field_of_view_deg(rig_of(640).fx_px, 640), 87.7, 0.05);
  // The paper's 97 degrees would need a shorter focal length than its 2.5 mm.
  EXPECT_NEAR(field_of_view_deg(453.0, 1024), 97.0, 0.05);
  EXPECT_NEAR(field_of_view_deg(283.0, 640), 97.0, 0.05);
}

TEST(PaperQCamera, FootprintAtOneMetre) {
  for (int width : {1024, 640}) {
    const RectifiedRig rig = rig_of(width);
    // Outer borders of the outermost pixels.
    const Vector3d first = rig.point(-0.5, -0.5, 1.0);
    const Vector3d last = rig.point(rig.size.width - 0.5, rig.size.height - 0.5, 1.0);
    EXPECT_NEAR(last.x() - first.x(), 1.92, 1e-9);
    EXPECT_NEAR(last.y() - first.y(), 1.44, 1e-9);
    EXPECT_GT((last.x() - first.x()) * (last.y() - first.y()), 2.0);  // "2 square metres"
  }
}

TEST(PaperQCamera, MillimetresPerPixelAtOneMetre) {
  EXPECT_NEAR(1e3 / rig_of(1024).fx_px, 1.9, 0.03);
  EXPECT_NEAR(1e3 / rig_of(640).fx_px, 3.0, 0.1);
  // Both are finer than the 3 cm foot.
  EXPECT_LT(rig_of(640).depth_resolution_m(1.0), 0.03);
}

TEST(PaperQCamera, GroundSeenFromOneMetreAt55DegreesDown) {
  const RectifiedRig rig = rig_of(640);
  const CameraMount mount = level_mount(1.0, 55.0 * kDegree, false);
  const Eigen::Matrix3d R = mount.T_body_left.linear();
  // Angle below the horizon of the middle of the upper and of the lower border.
  const double u = rig.cx_px;
  const Vector3d upper = R * rig.point(u, -0.5, 1.0);
  const Vector3d lower = R * rig.point(u, rig.size.height - 0.5, 1.0);
  const auto below_horizon_deg = [](const Vector3d& ray) {
    return std::atan2(-ray.z(), ray.x()) / kDegree;
  };
  EXPECT_NEAR(below_horizon_deg(upper), 19.2, 0.05);
  EXPECT_NEAR(below_horizon_deg(lower), 90.8, 0.05);
  // The ground is hit where the ray has gone down by one metre; `depth` is along the axis.
  const auto ground = [&mount](const Vector3d& ray) {
    const double depth = mount.T_body_left.translation().z() / -ray.z();
    return std::pair(depth, depth * ray.x());
  };
  EXPECT_NEAR(ground(upper).second, 2.86, 0.02);
  EXPECT_NEAR(ground(lower).second, 0.0, 0.02);
  EXPECT_NEAR(ground(upper).first, 2.46, 0.01);
  EXPECT_NEAR(ground(lower).first, 0.81, 0.005);
  EXPECT_NEAR(ground(R.col(2)).second, 0.70, 0.005);
}

TEST(PaperQCamera, EquationOneGoesThereAndBack) {
  RectifiedRig rig = rig_of(640);
  rig.cx_offset_px = 31.0;
  for (const Vector3d& p : {Vector3d(0.3, -0.2, 1.4), Vector3d(-2.0, 1.0, 9.0)}) {
    const Vector3d seen = rig.pixel_and_disparity(p);
    // The right camera sees the point from b further right, about its own principal point.
    const double u_right =
        rig.fx_px * (p.x() - rig.baseline_m) / p.z() + rig.cx_px + rig.cx_offset_px;
    EXPECT_NEAR(seen.z(), seen.x() - u_right, 1e-12);
    EXPECT_NEAR(rig.depth_m(seen.z()), p.z(), 1e-12);
    EXPECT_LT((rig.point(seen.x(), seen.y(), p.z()) - p).norm(), 1e-12);
  }
  EXPECT_EQ(rig.depth_m(-31.0), kInfinity);
  EXPECT_EQ(rig.depth_m(-40.0), kInfinity);
  EXPECT_TRUE(std::isfinite(rig.depth_m(-30.9)));
  EXPECT_TRUE(std::isnan(rig.depth_m(std::nan(""))));
}

TEST(StereoRig, LevelMountLooksForwardAndDown) {
  const CameraMount ahead = level_mount(1.65, 0.0, true);
  EXPECT_TRUE(ahead.assumed);
  EXPECT_LT((ahead.T_body_left * Vector3d(0, 0, 2) - Vector3d(2, 0, 1.65)).norm(), 1e-12);
  EXPECT_LT((ahead.T_body_left * Vector3d(1, 0, 0) - Vector3d(0, -1, 1.65)).norm(), 1e-12);
  const CameraMount down = level_mount(2.0, 90.0 * kDegree, false);
  EXPECT_FALSE(down.assumed);
  EXPECT_LT((down.T_body_left * Vector3d(0, 0, 2)).norm(), 1e-12);
}

TEST(StereoRig, NamedRigs) {
  EXPECT_EQ(named_rig("bumblebee2-1024")->size.width, 1024);
  EXPECT_EQ(named_rig("bumblebee2-640")->size.height, 480);
  EXPECT_FALSE(named_rig("bumblebee2"));
  EXPECT_FALSE(named_rig(""));
}

TEST(StereoRig, CheckNamesWhatIsUnsound) {
  const StereoRig good = bumblebee2(640);
  EXPECT_TRUE(check_rig(good));
  const auto where = [&good](const auto& spoil) {
    StereoRig rig = good;
    spoil(rig);
    const Status status = check_rig(rig);
    return status ? std::string("sound") : status.error().where;
  };
  EXPECT_EQ(where([](StereoRig& rig) { rig.size.width = 0; }), "size");
  EXPECT_EQ(where([](StereoRig& rig) { rig.size.height = -480; }), "size");
  EXPECT_EQ(where([](StereoRig& rig) { rig.size = {16385, 10}; }), "size");
  EXPECT_EQ(where([](StereoRig& rig) { rig.size = {16384, 16384}; }), "size");
  EXPECT_EQ(where([](StereoRig& rig) { rig.size = {8192, 8193}; }), "size");
  EXPECT_EQ(where([](StereoRig& rig) { rig.size = {8192, 8192}; }), "sound");
  EXPECT_EQ(where([](StereoRig& rig) { std::get<PinholeCamera>(rig.left).fx = 0; }), "left.fx");
  EXPECT_EQ(where([](StereoRig& rig) { std::get<PinholeCamera>(rig.right).cy = kInfinity; }),
            "right.cy");
  EXPECT_EQ(where([](StereoRig& rig) { rig.T_left_right.linear() *= 1.1; }), "T_left_right");
  EXPECT_EQ(where([](StereoRig& rig) { rig.T_left_right.linear().col(0) *= -1.0; }),
            "T_left_right");
  EXPECT_EQ(where([](StereoRig& rig) { rig.T_left_right.translation().setZero(); }),
            "T_left_right");
  EXPECT_EQ(where([](StereoRig& rig) { rig.T_left_right.translation().x() = std::nan(""); }),
            "T_left_right");
  EXPECT_EQ(where([](StereoRig& rig) {
              rig.mount = level_mount(1, 0, false);
              rig.mount->T_body_left.linear() *= 2.0;
            }),
            "mount");
  StereoRig with_imu = good;
  with_imu.imu.emplace();
  EXPECT_TRUE(check_rig(with_imu)) << "the defaults are those of a sensor";
  const auto where_in_imu = [&where](const auto& spoil) {
    return where([&spoil](StereoRig& rig) { spoil(rig.imu.emplace()); });
  };
  EXPECT_EQ(where_in_imu([](Imu& imu) { imu.T_imu_left.linear() *= 2.0; }), "imu.T_imu_left");
  EXPECT_EQ(where_in_imu([](Imu& imu) { imu.T_imu_left.translation().y() = kInfinity; }),
            "imu.T_imu_left");
  for (const double bad : {0.0, -1.0, kInfinity, std::nan("")}) {
    EXPECT_EQ(where_in_imu([bad](Imu& imu) { imu.gyro_noise = bad; }), "imu.gyro_noise");
    EXPECT_EQ(where_in_imu([bad](Imu& imu) { imu.accel_noise = bad; }), "imu.accel_noise");
    EXPECT_EQ(where_in_imu([bad](Imu& imu) { imu.gyro_walk = bad; }), "imu.gyro_walk");
    EXPECT_EQ(where_in_imu([bad](Imu& imu) { imu.accel_walk = bad; }), "imu.accel_walk");
    EXPECT_EQ(where_in_imu([bad](Imu& imu) { imu.rate_hz = bad; }), "imu.rate_hz");
  }
}

TEST(StereoRig, ARigThatComesRectifiedMustLookLikeIt) {
  const StereoRig good = bumblebee2(640);
  const auto where = [&good](const auto& spoil) {
    StereoRig rig = good;
    spoil(rig);
    const auto result = rectified_rig(rig);
    return result ? std::string("sound") : result.error().where;
  };
  EXPECT_EQ(where([](StereoRig& rig) { rig.rectified = false; }), "rectified");
  EXPECT_EQ(where([](StereoRig& rig) { rig.size.width = 0; }), "size");
  BrownCamera straight;
  straight.pinhole = std::get<PinholeCamera>(good.left);
  EXPECT_EQ(where([&](StereoRig& rig) { rig.left = straight; }), "sound");
  BrownCamera bent = straight;
  bent.D[2] = 1e-3;
  EXPECT_EQ(where([&](StereoRig& rig) { rig.left = bent; }), "left");
  const PinholeCamera& k = straight.pinhole;
  const KannalaBrandtCamera wide{k.fx, k.fy, k.cx, k.cy, {}};
  EXPECT_EQ(where([&](StereoRig& rig) { rig.right = wide; }), "right");
  EXPECT_EQ(where([](StereoRig& rig) { std::get<PinholeCamera>(rig.right).fx += 0.1; }),
            "right.fx");
  EXPECT_EQ(where([](StereoRig& rig) { std::get<PinholeCamera>(rig.right).fy += 0.1; }),
            "right.fx");
  EXPECT_EQ(where([](StereoRig& rig) { std::get<PinholeCamera>(rig.right).cy += 0.1; }),
            "right.cy");
  EXPECT_EQ(where([](StereoRig& rig) { std::get<PinholeCamera>(rig.left).skew = 0.1; }), "skew");
  EXPECT_EQ(where([](StereoRig& rig) {
              rig.T_left_right.linear() = so3_exp({0, 1e-3, 0});
            }),
            "T_left_right");
  EXPECT_EQ(where([](StereoRig& rig) { rig.T_left_right.translation().y() = 1e-3; }),
            "T_left_right");
  EXPECT_EQ(where([](StereoRig& rig) { rig.T_left_right.translation().z() = 1e-3; }),
            "T_left_right");
  EXPECT_EQ(where([](StereoRig& rig) { rig.T_left_right.translation() *= -1.0; }), "T_left_right");
}

TEST(StereoRig, PrincipalPointsMayDiffer) {
  StereoRig rig = bumblebee2(640);
  std::get<PinholeCamera>(rig.right).cx += 31.0;
  const RectifiedRig rectified = rectified_rig(rig).value();
  EXPECT_EQ(rectified.cx_offset_px, 31.0);
  EXPECT_NEAR(rectified.disparity_px(4.0), 10.0 - 31.0, 1e-9);
}

TEST(ShrunkRig, SeesTheSameDepths) {
  const StereoRig full = bumblebee2(1024);
  const auto small = rectified_rig(shrunk(full, 2));
  const auto large = rectified_rig(full);
  ASSERT_TRUE(small && large);
  EXPECT_EQ(small->size, (ImageSize{512, 384}));
  EXPECT_NEAR(small->depth_m(10.0), large->depth_m(20.0), 1e-9);
  // The corner of four pixels is a pixel's centre afterwards.
  EXPECT_LT((small->point(100, 50, 2.0) - large->point(200.5, 100.5, 2.0)).norm(), 1e-9);
}

TEST(ShrunkRig, KeepsTheImu) {
  StereoRig rig = bumblebee2(640);
  EXPECT_FALSE(shrunk(rig, 2).imu);
  rig.imu.emplace().rate_hz = 500.0;
  rig.imu->T_imu_left.translation() = Vector3d(0.1, 0.2, 0.3);
  const StereoRig small = shrunk(rig, 2);
  ASSERT_TRUE(small.imu);
  EXPECT_EQ(small.imu->rate_hz, 500.0);
  EXPECT_EQ(small.imu->T_imu_left.matrix(), rig.imu->T_imu_left.matrix());
}

}  // namespace
}  // namespace tread
