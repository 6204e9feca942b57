#include "tread/geometry/rectification.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "instruction_sets.hpp"

namespace tread {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

StereoRig rig_of(const CameraModel& left, const CameraModel& right, const Vector3d& turn,
                 const Vector3d& baseline) {
  StereoRig rig;
  rig.name = "test";
  rig.size = {320, 240};
  rig.left = left;
  rig.right = right;
  rig.T_left_right.linear() = so3_exp(turn);
  rig.T_left_right.translation() = baseline;
  return rig;
}

BrownCamera brown(double f, double cx, double cy, double k1) {
  BrownCamera camera;
  camera.pinhole = {f, 1.01 * f, cx, cy, 0.3};
  camera.K = {k1, 0.06, -0.01, 0.0, 0.0};
  camera.P = {1e-3, -5e-4, 0.0, 0.0, 0.0};
  return camera;
}

StereoRig brown_rig() {
  return rig_of(brown(205.0, 163.0, 117.0, -0.25), brown(209.0, 158.0, 121.0, -0.22),
                {0.02, -0.04, 0.03}, {0.119, 0.006, -0.011});
}

StereoRig wide_rig() {
  return rig_of(KannalaBrandtCamera{150.0, 151.0, 160.0, 118.0, {0.01, -0.004, 0.002, -0.0003}},
                KannalaBrandtCamera{149.0, 149.5, 157.0, 122.0, {0.012, -0.005, 0.001, 0.0}},
                {-0.03, 0.02, 0.05}, {0.08, -0.004, 0.005});
}

Vector2d rectified_pixel(const Rectification& made, const Eigen::Matrix3d& R,
                         const Vector3d& bearing, double cx_px) {
  const Vector3d ray = R * bearing;
  return {made.rig.fx_px * ray.x() / ray.z() + cx_px,
          made.rig.fy_px * ray.y() / ray.z() + made.rig.cy_px};
}

class RectifiedScene : public ::testing::TestWithParam<bool> {
 protected:
  StereoRig rig_ = GetParam() ? wide_rig() : brown_rig();
};

TEST_P(RectifiedScene, RowsAgreeAndDisparityIsBaselineTimesFocalLengthOverDepth) {
  const Rectification made = make_rectification(rig_).value();
  EXPECT_NEAR(made.rig.baseline_m, rig_.T_left_right.translation().norm(), 1e-15);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> side(-1.0, 1.0), depth(0.5, 8.0);
  int seen = 0;
  for (int i = 0; i < 2000; ++i) {
    const double z = depth(random);
    const Vector3d p_left(0.8 * z * side(random), 0.6 * z * side(random), z);
    const Vector3d p_right = rig_.T_left_right.inverse() * p_left;
    const Projection left = project(rig_.left, p_left), right = project(rig_.right, p_right);
    if (!left.valid || !right.valid) continue;
    ++seen;
    // From the images alone: pixel, bearing, turned bearing.
    const Vector2d a = rectified_pixel(made, made.R_rectified_left,
                                       unproject(rig_.left, left.pixel).bearing, made.rig.cx_px);
    const Vector2d b =
        rectified_pixel(made, made.R_rectified_right, unproject(rig_.right, right.pixel).bearing,
                        made.rig.cx_px + made.rig.cx_offset_px);
    EXPECT_NEAR(a.y(), b.y(), 1e-6);
    const Vector3d p_rectified = made.R_rectified_left * p_left;
    EXPECT_NEAR(a.x() - b.x(), made.rig.disparity_px(p_rectified.z()), 1e-6);
    EXPECT_LT((made.rig.pixel_and_disparity(p_rectified).head<2>() - a).norm(), 1e-6);
  }
  EXPECT_GT(seen, 1000);
}

TEST_P(RectifiedScene, TableHoldsWhereTheRectifiedPixelWas) {
  const Rectification made = make_rectification(rig_).value();
  int inside = 0;
  const auto check = [&](const RemapTable& table, const CameraModel& camera,
                         const Eigen::Matrix3d& R) {
    ASSERT_EQ(table.entries.width, 320);
    ASSERT_EQ(table.entries.height, 240);
    for (int v = 0; v < 240; ++v) {
      for (int u = 0; u < 320; ++u) {
        const Projection at = project(camera, R.transpose() * made.rig.point(u, v, 2.0));
        const RemapTable::Entry entry = table.entries(u, v);
        const Vector2d margin(std::min(at.pixel.x(), 319.0 - at.pixel.x()),
                              std::min(at.pixel.y(), 239.0 - at.pixel.y()));
        if (entry.u == RemapTable::kOutside) {
          EXPECT_TRUE(!at.valid || margin.minCoeff() < 1.0 / 64.0) << u << ' ' << v;
          continue;
        }
        ++inside;
        EXPECT_TRUE(at.valid);
        EXPECT_GE(margin.minCoeff(), -1.0 / 64.0) << u << ' ' << v;
        EXPECT_NEAR(entry.u / 32.0, at.pixel.x(), 1.0 / 64.0 + 1e-9);
        EXPECT_NEAR(entry.v / 32.0, at.pixel.y(), 1.0 / 64.0 + 1e-9);
      }
    }
  };
  check(made.left, rig_.left, made.R_rectified_left);
  check(made.right, rig_.right, made.R_rectified_right);
  EXPECT_GT(inside, 90000);
}

TEST_P(RectifiedScene, ImageCentresLieAroundTheMiddle) {
  const Rectification made = make_rectification(rig_).value();
  const Vector2d middle(159.5, 119.5);
  const Vector2d a = rectified_pixel(made, made.R_rectified_left,
                                     unproject(rig_.left, middle).bearing, made.rig.cx_px);
  const Vector2d b = rectified_pixel(made, made.R_rectified_right,
                                     unproject(rig_.right, middle).bearing, made.rig.cx_px);
  EXPECT_LT((0.5 * (a + b) - middle).norm(), 1e-9);
  // The rectified pair looks where both cameras look on average, as far as the baseline lets it:
  // its viewing direction, the third row, lies in the plane of that mean and the baseline.
  const Vector3d mean = Vector3d::UnitZ() + rig_.T_left_right.linear().col(2);
  const Vector3d viewing = made.R_rectified_left.row(2);
  EXPECT_NEAR(viewing.dot(mean.cross(rig_.T_left_right.translation()).normalized()), 0.0, 1e-12);
  EXPECT_GT(viewing.dot(mean), 0.0);
  EXPECT_EQ(made.rig.cx_offset_px, 0.0);
}

INSTANTIATE_TEST_SUITE_P(Rectification, RectifiedScene, ::testing::Bool(), [](const auto& which) {
  return which.param ? std::string("KannalaBrandt") : std::string("Brown");
});

TEST(Rectification, FocalScaleScales) {
  RectificationOptions options;
  options.focal_scale = 0.6;
  const double usual = make_rectification(brown_rig())->rig.fx_px;
  EXPECT_NEAR(usual, (205.0 * 2.01 + 209.0 * 2.01) / 4.0, 1e-9);
  EXPECT_NEAR(make_rectification(brown_rig(), options)->rig.fx_px, 0.6 * usual, 1e-9);
  // A rig that comes rectified can be zoomed too; then it is resampled.
  options.focal_scale = 2.0;
  const auto zoomed = make_rectification(bumblebee2(640), options);
  ASSERT_TRUE(zoomed);
  EXPECT_NEAR(zoomed->rig.fx_px, 2.0 * bumblebee2(640).size.width * 2.5 / 4.8, 1e-9);
  EXPECT_EQ(zoomed->left.entries(320, 240).u, std::lround(32 * 319.75));
  for (double bad : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    options.focal_scale = bad;
    const auto refused = make_rectification(brown_rig(), options);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().where, "focal_scale");
  }
}

TEST(Rectification, RectifiedRigGivesTheImagesAsTheyAre) {
  StereoRig rig = bumblebee2(640);
  std::get<PinholeCamera>(rig.right).cx += 31.0;
  const Rectification made = make_rectification(rig).value();
  EXPECT_EQ(made.rig.cx_offset_px, 31.0);
  EXPECT_EQ(made.R_rectified_left, Eigen::Matrix3d::Identity());
  Image<std::uint8_t> input(640, 480), output(640, 480, 99);
  std::mt19937 random(1);
  for (int v = 0; v < 480; ++v) {
    for (int u = 0; u < 640; ++u) input(u, v) = static_cast<std::uint8_t>(random());
  }
  remap(input, made.left, output);
  EXPECT_TRUE(input == output);
  remap(input, made.right, output);
  EXPECT_TRUE(input == output);
  // Not known to be rectified, the same cameras give the same, through the general way.
  rig = bumblebee2(640);
  rig.rectified = false;
  const Rectification general = make_rectification(rig).value();
  EXPECT_EQ(general.left.entries(17, 400).u, 17 * 32);
  EXPECT_EQ(general.right.entries(17, 400).v, 400 * 32);
  remap(input, general.right, output);
  EXPECT_TRUE(input == output);
}

TEST(Rectification, OnlyCamerasSideBySideAreHandled) {
  const auto error_of = [](const Vector3d& turn, const Vector3d& baseline) {
    StereoRig rig = brown_rig();
    rig.T_left_right.linear() = so3_exp(turn);
    rig.T_left_right.translation() = baseline;
    const auto made = make_rectification(rig);
    return made ? std::string("made") : made.error().message();
  };
  EXPECT_EQ(error_of({0, 0, 0}, {0.1, 0.05, -0.05}), "made");
  // What counts is the direction seen halfway between the two: cameras that look 80 degrees apart
  // are side by side along the x axis turned by 40, and behind each other along the one turned by
  // -40.
  const Vector3d apart(0.0, 1.396, 0.0);
  const Vector3d beside = so3_exp(0.5 * apart) * Vector3d(0.1, 0.0, 0.0);
  const Vector3d behind = so3_exp(-0.5 * apart) * Vector3d(0.1, 0.0, 0.0);
  EXPECT_EQ(error_of(apart, beside), "made");
  EXPECT_NE(error_of(apart, behind).find("viewing direction"), std::string::npos);
  EXPECT_NE(error_of({0, 0, 0}, {0.01, 0.1, 0.0}).find("above or below"), std::string::npos);
  EXPECT_NE(error_of({0, 0, 0}, {0.01, -0.1, 0.0}).find("above or below"), std::string::npos);
  EXPECT_NE(error_of({0, 0, 0}, {0.0, 0.01, 0.1}).find("viewing direction"), std::string::npos);
  EXPECT_NE(error_of({0, 0, 0}, {-0.1, 0.0, 0.0}).find("to the left"), std::string::npos);
  EXPECT_NE(error_of({0, 2.0, 0}, {0.1, 0.0, 0.0}).find("90 degrees"), std::string::npos);
  EXPECT_NE(error_of({0, 0, 0}, {0.0, 0.0, 0.0}).find("baseline is 0"), std::string::npos);
  StereoRig rig = bumblebee2(640);
  rig.T_left_right.translation() = Vector3d(0.0, 0.1, 0.0);
  EXPECT_FALSE(make_rectification(rig));
}

TEST(Rectification, PrincipalPointFarOutsideTheImageIsRefused) {
  StereoRig rig = brown_rig();
  std::get<BrownCamera>(rig.right).pinhole.cx = 5000.0;
  const auto made = make_rectification(rig);
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().where, "right");
}

// A table that shifts by fractions and leaves the image at the borders.
RemapTable shifting_table(int width, int height, int du, int dv) {
  RemapTable table;
  table.entries = Image<RemapTable::Entry>(width, height);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const int column = 32 * u + du + (3 * v) % 32, row = 32 * v + dv;
      const bool inside =
          column >= 0 && column <= 32 * (width - 1) && row >= 0 && row <= 32 * (height - 1);
      if (inside) table.entries(u, v) = {column, row};
    }
  }
  return table;
}

TEST(Remap, ARampStaysARamp) {
  constexpr int kWidth = 90, kHeight = 35;
  Image<std::uint8_t> input(kWidth, kHeight), output(kWidth, kHeight, 7);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) input(u, v) = static_cast<std::uint8_t>(u + 4 * v);
  }
  for (int du : {-40, 0, 5, 31}) {
    for (int dv : {-7, 0, 18}) {
      const RemapTable table = shifting_table(kWidth, kHeight, du, dv);
      remap(input, table, output);
      for (int v = 0; v < kHeight; ++v) {
        for (int u = 0; u < kWidth; ++u) {
          const RemapTable::Entry at = table.entries(u, v);
          const int expected = at.u == RemapTable::kOutside
                                   ? 0
                                   : static_cast<int>(std::floor((at.u + 4 * at.v) / 32.0 + 0.5));
          ASSERT_EQ(output(u, v), expected) << u << ' ' << v;
        }
      }
    }
  }
}

TEST(Remap, LastRowAndColumnAreReached) {
  Image<std::uint8_t> input(2, 2), output(2, 2);
  input(0, 0) = 10, input(1, 0) = 20, input(0, 1) = 30, input(1, 1) = 250;
  RemapTable table;
  table.entries = Image<RemapTable::Entry>(2, 2);
  table.entries(0, 0) = {32, 32};
  table.entries(1, 0) = {16, 16};
  table.entries(0, 1) = {16, 32};
  remap(input, table, output);
  EXPECT_EQ(output(0, 0), 250);
  EXPECT_EQ(output(1, 0), 78);  // (10 + 20 + 30 + 250) / 4 = 77.5
  EXPECT_EQ(output(0, 1), 140);
  EXPECT_EQ(output(1, 1), 0);
}

// Grey rows are vectorised, coloured ones are not.
TEST(Remap, GreyIsOneOfThreeColoursOnEveryInstructionSet) {
  const Rectification made = make_rectification(brown_rig()).value();
  Image<Rgb> colour(320, 240), colour_out(320, 240);
  Image<std::uint8_t> grey[3], grey_out(320, 240);
  std::mt19937 random(9);
  for (auto& channel : grey) channel = Image<std::uint8_t>(320, 240);
  for (int v = 0; v < 240; ++v) {
    for (int u = 0; u < 320; ++u) {
      for (auto& channel : grey) channel(u, v) = static_cast<std::uint8_t>(random());
      colour(u, v) = {grey[0](u, v), grey[1](u, v), grey[2](u, v)};
    }
  }
  remap(colour, made.left, colour_out);
  testing::on_every_target([&] {
    for (int c = 0; c < 3; ++c) {
      remap(grey[c], made.left, grey_out);
      for (int v = 0; v < 240; ++v) {
        for (int u = 0; u < 320; ++u) {
          const Rgb at = colour_out(u, v);
          ASSERT_EQ(grey_out(u, v), (c == 0 ? at.r : c == 1 ? at.g : at.b));
        }
      }
    }
  });
}

// Images of exactly their pixels, so that a sanitizer sees a read behind them; widths that end
// within a vector; entries anywhere, also outside.
TEST(Remap, AnySizeWithoutAByteToSpare) {
  testing::on_every_target([] {
    std::mt19937 random(11);
    for (int round = 0; round < 300; ++round) {
      const int width = 1 + static_cast<int>(random() % 40);
      const int height = 1 + static_cast<int>(random() % 6);
      std::vector<std::uint8_t> pixels(static_cast<std::size_t>(width * height));
      for (auto& p : pixels) p = static_cast<std::uint8_t>(random());
      const ImageView<const std::uint8_t> input{pixels.data(), width, height, width};
      RemapTable table;
      table.entries = Image<RemapTable::Entry>(width, height);
      Image<Rgb> coloured(width, height), expected(width, height);
      for (int v = 0; v < height; ++v) {
        for (int u = 0; u < width; ++u) {
          coloured(u, v) = {input(u, v), 0, 0};
          if (random() % 4 == 0) continue;
          table.entries(u, v) = {static_cast<std::int32_t>(random() % (32U * (width - 1) + 1)),
                                 static_cast<std::int32_t>(random() % (32U * (height - 1) + 1))};
        }
      }
      Image<std::uint8_t> output(width, height, 1);
      remap(input, table, output);
      remap(coloured, table, expected);
      for (int v = 0; v < height; ++v) {
        for (int u = 0; u < width; ++u) ASSERT_EQ(output(u, v), expected(u, v).r);
      }
    }
  });
}

TEST(Remap, ThreadsDoNotChangeTheResult) {
  const Rectification made = make_rectification(wide_rig()).value();
  Image<std::uint8_t> input(320, 240), one(320, 240, 1), two(320, 240, 2);
  std::mt19937 random(4);
  for (int v = 0; v < 240; ++v) {
    for (int u = 0; u < 320; ++u) input(u, v) = static_cast<std::uint8_t>(random());
  }
  Timings timings;
  remap(input, made.right, one, {1, nullptr});
  remap(input, made.right, two, {2, &timings});
  EXPECT_TRUE(one == two);
  EXPECT_EQ(timings.entries().at("rectify/remap").calls, 1);
}

}  // namespace
}  // namespace tread
