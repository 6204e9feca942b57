// Our own format, writing, and what holds for all formats. Those of others: rig_formats_test.cpp,
// rig_format_pairs_test.cpp. Damaged files: rig_file_damaged_test.cpp.
#include "tread/io/rig_file.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <numbers>
#include <random>

#include "rig_file_fixture.hpp"
#include "rig_samples.hpp"
#include "tread/geometry/rectification.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using namespace tread::testing;

constexpr double kDegree = std::numbers::pi / 180.0;

class RigFile : public RigFiles {
 protected:
  // The message with which a changed sample is refused.
  std::string refusal(const std::string& sample, const std::string& from, const std::string& to) {
    const auto rig = read_text(changed(sample, from, to));
    EXPECT_FALSE(rig) << from << " -> " << to;
    return rig ? "" : rig.error().message();
  }
};

void expect_equal(const StereoRig& a, const StereoRig& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.size, b.size);
  EXPECT_EQ(a.rectified, b.rectified);
  const auto values = [](const CameraModel& camera) {
    return std::visit([](const auto& model) { return model.parameters(); }, camera);
  };
  EXPECT_EQ(a.left.index(), b.left.index());
  EXPECT_EQ(a.right.index(), b.right.index());
  EXPECT_EQ(values(a.left), values(b.left));
  EXPECT_EQ(values(a.right), values(b.right));
  EXPECT_EQ(a.T_left_right.matrix(), b.T_left_right.matrix());
  ASSERT_EQ(a.mount.has_value(), b.mount.has_value());
  if (!a.mount) return;
  EXPECT_EQ(a.mount->T_body_left.matrix(), b.mount->T_body_left.matrix());
  EXPECT_EQ(a.mount->assumed, b.mount->assumed);
}

void expect_equal_imus(const StereoRig& a, const StereoRig& b) {
  ASSERT_EQ(a.imu.has_value(), b.imu.has_value());
  if (!a.imu) return;
  EXPECT_EQ(a.imu->T_imu_left.matrix(), b.imu->T_imu_left.matrix());
  EXPECT_EQ(a.imu->gyro_noise, b.imu->gyro_noise);
  EXPECT_EQ(a.imu->accel_noise, b.imu->accel_noise);
  EXPECT_EQ(a.imu->gyro_walk, b.imu->gyro_walk);
  EXPECT_EQ(a.imu->accel_walk, b.imu->accel_walk);
  EXPECT_EQ(a.imu->rate_hz, b.imu->rate_hz);
}

TEST_F(RigFile, OwnFormatIsRead) {
  const auto rig = read_text(kOwnRig);
  ASSERT_TRUE(rig) << rig.error().message();
  EXPECT_EQ(rig->name, "bench");
  EXPECT_EQ(rig->size, (ImageSize{752, 480}));
  EXPECT_FALSE(rig->rectified);
  const auto& left = std::get<BrownCamera>(rig->left);
  EXPECT_EQ(left.pinhole.parameters(),
            (PinholeCamera{458.7, 457.3, 367.2, 248.4, 0.5}.parameters()));
  EXPECT_EQ(left.lx, 0.01);
  EXPECT_EQ(left.ly, -0.02);
  EXPECT_EQ(left.K, (std::array<double, 5>{-0.28, 0.07}));
  EXPECT_EQ(left.P, (std::array<double, 5>{1.8e-05, 1.9e-04, 0.1}));
  EXPECT_EQ(left.D, (std::array<double, 3>{0.01}));
  const auto& right = std::get<KannalaBrandtCamera>(rig->right);
  EXPECT_EQ(right.cx, 354.9);
  EXPECT_EQ(right.k, (std::array<double, 4>{0.0035, 0.0007, -0.0021, 0.0002}));
  EXPECT_EQ(rig->T_left_right.translation(), Vector3d(0.12, 0.001, -0.002));
  EXPECT_LT((rig->T_left_right.linear() -
             rotation_from_yaw_pitch_roll(3.0 * kDegree, -2.0 * kDegree, 1.0 * kDegree))
                .norm(),
            1e-15);
  ASSERT_TRUE(rig->mount);
  EXPECT_TRUE(rig->mount->assumed);
  EXPECT_LT((rig->mount->T_body_left.matrix() -
             level_mount(1.0, 55.0 * kDegree, true).T_body_left.matrix())
                .norm(),
            1e-15);
}

TEST_F(RigFile, OwnFormatWithAnImu) {
  EXPECT_FALSE(read_text(kOwnRig)->imu);
  const auto rig = read_text(kOwnRig + kOwnImu);
  ASSERT_TRUE(rig) << rig.error().message();
  ASSERT_TRUE(rig->imu);
  EXPECT_EQ(rig->imu->T_imu_left.translation(), Vector3d(-0.02, -0.06, 0.01));
  EXPECT_LT((rig->imu->T_imu_left.linear() * Vector3d::UnitX() - Vector3d::UnitY()).norm(), 1e-15);
  EXPECT_EQ(rig->imu->gyro_noise, 1.7e-4);
  EXPECT_EQ(rig->imu->accel_noise, 2.0e-3);
  EXPECT_EQ(rig->imu->gyro_walk, 2.0e-5);
  EXPECT_EQ(rig->imu->accel_walk, 3.0e-3);
  EXPECT_EQ(rig->imu->rate_hz, 400.0);
  const auto usual = read_text(kOwnRig + kOwnImu.substr(0, kOwnImu.find("  gyro_noise")));
  ASSERT_TRUE(usual) << usual.error().message();
  StereoRig expected = *rig;
  const Isometry3d T_imu_left = expected.imu->T_imu_left;
  expected.imu.emplace().T_imu_left = T_imu_left;
  expect_equal_imus(*usual, expected);
}

TEST_F(RigFile, ImusThatAreWrittenWrongAreNamed) {
  const std::string whole = kOwnRig + kOwnImu;
  EXPECT_SAYS(refusal(whole, "  T_imu_left", "  T_imu_lef"),
              "imu.T_imu_lef: unknown name. Did you mean 'T_imu_left'?");
  EXPECT_SAYS(refusal(whole, "  gyro_walk", "  gyro_wlk"), "Did you mean 'gyro_walk'?");
  EXPECT_SAYS(refusal(whole, "gyro_noise: 1.7e-4", "gyro_noise: 0"),
              "imu.gyro_noise: 0 is not a number above 0");
  EXPECT_SAYS(refusal(whole, "rate_hz: 400", "rate_hz: fast"), "imu.rate_hz: 'fast' is not");
  EXPECT_SAYS(refusal(whole, "[-0.02, -0.06, 0.01]", "[0.02]"), "T_imu_left.translation_m");
  EXPECT_SAYS(refusal(kOwnRig + kOwnImu, kOwnImu, "imu: 3\n"), "imu: expected entries");
  EXPECT_SAYS(refusal(kOwnRig + kOwnImu, kOwnImu, "imu: {rate_hz: 3}\n"),
              "imu: 'T_imu_left' is missing");
}

TEST_F(RigFile, OwnFormatOfARectifiedRig) {
  const auto rig = read_text(kOwnRectifiedRig);
  ASSERT_TRUE(rig) << rig.error().message();
  EXPECT_EQ(rig->name, "rig");  // the file's
  EXPECT_FALSE(rig->mount);
  const RectifiedRig rectified = rectified_rig(*rig).value();
  EXPECT_EQ(rectified.fx_px, 333.5);
  EXPECT_EQ(rectified.cx_offset_px, 31.0);
  EXPECT_EQ(rectified.baseline_m, 0.12);
}

TEST_F(RigFile, OwnFormatTakesOpenCvCoefficientsInTheirOrder) {
  std::string text = kOwnRig;
  const std::size_t first = text.find("  lens_centre"), last = text.find("right:");
  text.replace(first, last - first, "  opencv_distortion: [1, 2, 3, 4, 5, 6, 7, 8]\n");
  const auto rig = read_text(text);
  ASSERT_TRUE(rig) << rig.error().message();
  const auto& left = std::get<BrownCamera>(rig->left);
  EXPECT_EQ(left.K, (std::array<double, 5>{1, 2, 5}));
  EXPECT_EQ(left.P, (std::array<double, 5>{4, 3}));
  EXPECT_EQ(left.D, (std::array<double, 3>{6, 7, 8}));
  EXPECT_EQ(left.pinhole.skew, 0.5);
}

TEST_F(RigFile, OwnFormatTakesRadiansMatricesAndFullMounts) {
  std::string text = kOwnRig;
  text.replace(text.find("rpy_deg: [1.0, -2.0, 3.0]"), 25,
               "rotation:\n  - [1, 0, 0]\n  - [0, 0, -1]\n  - [0, 1, 0]");
  text.replace(text.find("  height_m"), std::string::npos,
               "  T_body_left:\n    translation_m: [1, 2, 3]\n    rpy_rad: [0.1, 0.2, 0.3]\n");
  const auto rig = read_text(text);
  ASSERT_TRUE(rig) << rig.error().message();
  EXPECT_EQ(rig->T_left_right.linear() * Vector3d::UnitY(), Vector3d::UnitZ());
  EXPECT_FALSE(rig->mount->assumed);
  EXPECT_EQ(rig->mount->T_body_left.translation(), Vector3d(1, 2, 3));
  EXPECT_LT((rig->mount->T_body_left.linear() - rotation_from_yaw_pitch_roll(0.3, 0.2, 0.1)).norm(),
            1e-15);
  text = kOwnRig;
  text.replace(text.find("pitch_deg: 55"), 13, "pitch_rad: 0.5");
  EXPECT_LT((read_text(text)->mount->T_body_left.matrix() -
             level_mount(1.0, 0.5, true).T_body_left.matrix())
                .norm(),
            1e-15);
}

TEST_F(RigFile, RotationsPrintedWithFewDigitsAreMadeOrthonormal) {
  std::string text = kOwnRig;
  text.replace(text.find("rpy_deg: [1.0, -2.0, 3.0]"), 25,
               "rotation: [0.9998, -0.02, 0, 0.02, 0.9998, 0, 0, 0, 1]");
  const auto rig = read_text(text);
  ASSERT_TRUE(rig) << rig.error().message();
  EXPECT_TRUE(is_rigid(rig->T_left_right, 1e-15));
  EXPECT_NEAR(so3_log(rig->T_left_right.linear()).z(), 0.02, 1e-5);
}

TEST_F(RigFile, EveryFieldThatIsMissingIsNamed) {
  for (const char* line :
       {"size: [752, 480]", "left:", "right:", "  model: brown", "  fx: 458.7", "  fy: 457.3",
        "  cx: 367.2", "  cy: 248.4", "  model: kannala_brandt", "  fx: 190.9",
        "  k: [0.0035, 0.0007, -0.0021, 0.0002]", "T_left_right:", "  height_m: 1.0",
        "  pitch_deg: 55", "  translation_m: [0.12, 0.001, -0.002]"}) {
    std::string text = line;
    const std::string name =
        text.substr(text.find_first_not_of(' '), text.find(':') - text.find_first_not_of(' '));
    // A section whose name is gone belongs to the one before; its entries are then unknown there.
    const bool section = text.back() == ':';
    const std::string message = refusal(kOwnRig, text + "\n", "");
    EXPECT_SAYS(message, "rig.yaml");
    if (!section) {
      EXPECT_SAYS(message, "'" + name + "' is missing");
    }
  }
  EXPECT_SAYS(refusal(kOwnRectifiedRig, "baseline_m: 0.12", ""), "'baseline_m' is missing");
  EXPECT_SAYS(refusal(kOwnRectifiedRig, "rectified: true", ""), "rectified: true");
  EXPECT_SAYS(refusal("tread_rig: 1\nsize: [640, 480]\nright: {}\n", "right", "left"),
              "'model' is missing");
}

TEST_F(RigFile, OptionalFieldsMayBeMissing) {
  for (const char* line : {"name: bench\n", "  skew: 0.5\n", "  lens_centre: [0.01, -0.02]\n",
                           "  K: [-0.28, 0.07]\n", "  P: [1.8e-05, 1.9e-04, 0.1]\n",
                           "  D: [0.01]\n", "  rpy_deg: [1.0, -2.0, 3.0]\n", "  assumed: true\n"}) {
    std::string text = kOwnRig;
    text.erase(text.find(line), std::string(line).size());
    const auto rig = read_text(text);
    EXPECT_TRUE(rig) << rig.error().message();
  }
}

TEST_F(RigFile, UnknownNamesAreRefusedWithTheNearest) {
  const std::string message = refusal(kOwnRig, "  lens_centre", "  lens_center");
  EXPECT_SAYS(message, "rig.yaml:12: left.lens_center: unknown name. Did you mean 'lens_centre'?");
  EXPECT_SAYS(refusal(kOwnRig, "mount:", "moutn:"), "Did you mean 'mount'?");
  EXPECT_SAYS(refusal(kOwnRig, "  height_m", "  height"), "Did you mean 'height_m'?");
  EXPECT_SAYS(refusal(kOwnRig, "  translation_m", "  translation"), "'translation_m'");
  EXPECT_SAYS(refusal(kOwnRig, "  k: [", "  skew: 0\n  k: ["), "right.skew: unknown name");
  EXPECT_SAYS(refusal(kOwnRectifiedRig, "cx: 319.5", "zzzzzzz: 319.5"), "Known are: model, fx");
}

TEST_F(RigFile, WrongTypesAndValuesAreNamed) {
  EXPECT_SAYS(refusal(kOwnRig, "fx: 458.7", "fx: wide"), "rig.yaml:7: left.fx: 'wide' is not a");
  EXPECT_SAYS(refusal(kOwnRig, "fx: 458.7", "fx: [458.7]"), "left.fx: expected a number");
  EXPECT_SAYS(refusal(kOwnRig, "fx: 458.7", "fx: 0"), "left.fx: focal length is 0");
  EXPECT_SAYS(refusal(kOwnRig, "fx: 190.9", "fx: -1"), "right.fx: focal length is negative");
  EXPECT_SAYS(refusal(kOwnRig, "cy: 248.4", "cy: .nan"), "left.cy: '.nan' is not a finite");
  EXPECT_SAYS(refusal(kOwnRig, "cy: 248.4", "cy: inf"), "left.cy: 'inf' is not a finite");
  EXPECT_SAYS(refusal(kOwnRig, "[752, 480]", "[752]"), "size: expected 2 numbers, found 1");
  EXPECT_SAYS(refusal(kOwnRig, "[752, 480]", "[752.5, 480]"), "size: 752.5 is not a size");
  EXPECT_SAYS(refusal(kOwnRig, "[752, 480]", "[1e300, 480]"), "is not a size");
  EXPECT_SAYS(refusal(kOwnRig, "[752, 480]", "[99999, 480]"), "size: image size 99999 x 480");
  EXPECT_SAYS(refusal(kOwnRig, "[752, 480]", "{w: 752}"), "size: expected a list of numbers");
  EXPECT_SAYS(refusal(kOwnRig, "model: brown", "model: fisheye"), "'fisheye' is not a camera");
  EXPECT_SAYS(refusal(kOwnRig, "model: brown", "model: []"), "left.model: expected a text");
  EXPECT_SAYS(refusal(kOwnRig, "0.01, -0.02", "0.01"), "lens_centre: expected 2 numbers");
  EXPECT_SAYS(refusal(kOwnRig, "[-0.28, 0.07]", "[1, 2, 3, 4, 5, 6]"), "left.K: at most 5 terms");
  EXPECT_SAYS(refusal(kOwnRig, "D: [0.01]", "D: [a]"), "left.D: 'a' is not a finite number");
  EXPECT_SAYS(refusal(kOwnRig, "D: [0.01]", "opencv_distortion: [0]"), "stands beside K");
  EXPECT_SAYS(refusal(kOwnRig, "-0.0021, 0.0002]", "-0.0021]"), "right.k: expected 4 numbers");
  EXPECT_SAYS(refusal(kOwnRig, "[1.0, -2.0, 3.0]", "[1.0, -2.0]"), "rpy_deg: expected 3 numbers");
  EXPECT_SAYS(refusal(kOwnRig, "  rpy_deg", "  rpy_rad: [0, 0, 0]\n  rpy_deg"),
              "T_left_right: more than one rotation");
  EXPECT_SAYS(refusal(kOwnRig, "rpy_deg: [1.0, -2.0, 3.0]", "rotation: [1, 0, 0, 0, 1]"),
              "rotation: expected 9 numbers, found 5");
  EXPECT_SAYS(
      refusal(kOwnRig, "rpy_deg: [1.0, -2.0, 3.0]", "rotation: [1, 0, 0, 0, 1, 0, 0, 0, -1]"),
      "rotation: not a rotation");
  EXPECT_SAYS(refusal(kOwnRig, "[0.12, 0.001, -0.002]", "[0, 0, 0]"), "the baseline is 0");
  EXPECT_SAYS(refusal(kOwnRig, "T_left_right:", "baseline_m: 1\nT_left_right:"),
              "baseline_m: stands beside T_left_right");
  EXPECT_SAYS(refusal(kOwnRig, "assumed: true", "assumed: perhaps"), "mount.assumed: expected");
  EXPECT_SAYS(refusal(kOwnRig, "pitch_deg: 55", "pitch_deg: 55\n  pitch_rad: 1"),
              "mount.pitch_deg: stands beside pitch_rad");
  EXPECT_SAYS(refusal(kOwnRig, "pitch_deg: 55", "T_body_left: {translation_m: [0, 0, 1]}"),
              "mount.height_m: stands beside T_body_left");
  EXPECT_SAYS(refusal(kOwnRig, "T_left_right:\n  translation_m", "T_left_right: 3\nx:\n  t"),
              "unknown name");
  EXPECT_SAYS(refusal(kOwnRig, "tread_rig: 1", "tread_rig: 2"), "version 2 is not known");
  EXPECT_SAYS(refusal(kOwnRig, "tread_rig: 1", "tread_rig: one"), "'one' is not a whole number");
  EXPECT_SAYS(refusal(kOwnRig, "tread_rig: 1", "tread_rig: []"), "expected a whole number");
  EXPECT_SAYS(refusal(kOwnRig, "name: bench", "name: [1]"), "name: expected a text");
  EXPECT_SAYS(refusal(kOwnRig, "mount:\n", "mount: 3\nx:\n"), "unknown name");
  EXPECT_SAYS(refusal(kOwnRectifiedRig, "0.12", "-0.12"), "the baseline is not above 0");
  EXPECT_SAYS(refusal(kOwnRectifiedRig, "rectified: true", "rectified: 1"), "true or false");
  EXPECT_SAYS(refusal(kOwnRectifiedRig, "{model: pinhole, fx: 333.5", "{model: pinhole, fx: 334"),
              "right.fx: the rig says its images come rectified, but the focal lengths");
}

TEST_F(RigFile, WrittenRigsAreReadBackEqual) {
  std::mt19937 random(17);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const auto fill = [&](auto camera) {
    Eigen::VectorXd values = 0.1 * camera.parameters();
    for (double& value : values) value = 0.1 * uniform(random);
    values[0] = 400.0 + uniform(random);
    values[1] = 400.0 + uniform(random);
    camera.set_parameters(values);
    return CameraModel(camera);
  };
  const std::vector<std::function<CameraModel()>> models = {
      [&] { return fill(PinholeCamera{}); }, [&] { return fill(BrownCamera{}); },
      [&] { return fill(KannalaBrandtCamera{}); }};
  const fs::path path = scratch_ / "written.yaml";
  int written = 0;
  for (const auto& left : models) {
    for (const auto& right : models) {
      StereoRig rig;
      rig.name = "a \"b\" \\ c: # \t\x01 d\xC3\xA9";
      rig.size = {640, 401};
      rig.left = left();
      rig.right = right();
      rig.T_left_right.linear() = so3_exp({uniform(random), uniform(random), uniform(random)});
      rig.T_left_right.translation() = Vector3d(0.1, 1e-7 * uniform(random), 1.0 / 3.0);
      if (++written % 2 == 0) {
        rig.mount = level_mount(uniform(random), uniform(random), written % 4 == 0);
      }
      if (written % 3 == 0) {
        Imu& imu = rig.imu.emplace();
        imu.T_imu_left.linear() = so3_exp({uniform(random), uniform(random), uniform(random)});
        imu.T_imu_left.translation() = Vector3d(1.0 / 3.0, uniform(random), 1e-9);
        imu.gyro_noise = 1e-4 / 3.0;
        imu.accel_noise = 1e-3 / 3.0;
        imu.gyro_walk = 1e-5 / 3.0;
        imu.accel_walk = 1e-6 / 3.0;
        imu.rate_hz = 1000.0 / 3.0;
      }
      const Status done = write_rig(path, rig);
      ASSERT_TRUE(done) << done.error().message();
      const auto read = read_rig(path.string());
      ASSERT_TRUE(read) << read.error().message();
      expect_equal(*read, rig);
      expect_equal_imus(*read, rig);
    }
  }
  for (const StereoRig& rig : {bumblebee2(1024), bumblebee2(640)}) {
    ASSERT_TRUE(write_rig(path, rig));
    expect_equal(read_rig(path.string()).value(), rig);
  }
  StereoRig nameless = bumblebee2(640);
  nameless.name.clear();
  ASSERT_TRUE(write_rig(path, nameless));
  EXPECT_EQ(read_rig(path.string())->name, "written");
}

TEST_F(RigFile, UnsoundRigsAreNotWritten) {
  const fs::path path = scratch_ / "written.yaml";
  StereoRig rig = bumblebee2(640);
  std::get<PinholeCamera>(rig.left).fx = 0.0;
  EXPECT_EQ(write_rig(path, rig).error().where, "left.fx");
  rig = bumblebee2(640);
  rig.T_left_right.linear() = so3_exp({0.1, 0, 0});
  EXPECT_EQ(write_rig(path, rig).error().where, "T_left_right");
  rig = bumblebee2(640);
  rig.imu.emplace().accel_walk = 0.0;
  EXPECT_EQ(write_rig(path, rig).error().where, "imu.accel_walk");
  EXPECT_FALSE(fs::exists(path));
  EXPECT_EQ(write_rig(scratch_ / "no/folder/rig.yaml", bumblebee2(640)).error().code,
            ErrorCode::kWriteFailed);
}

TEST_F(RigFile, KnownNamesAndFilesThatAreNotThere) {
  EXPECT_EQ(read_rig("bumblebee2-640")->size.width, 640);
  const auto missing = read_rig("bumblebee-640");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound);
  EXPECT_SAYS(missing.error().message(), "bumblebee2-640");
  EXPECT_FALSE(read_rig(""));
  EXPECT_SAYS(read_rig((scratch_ / "a.yaml,b.yaml").string()).error().message(), "a.yaml");
  EXPECT_SAYS(read_rig(scratch_.path().string()).error().message(), "no calibration in this");
  EXPECT_FALSE(read_rig(write("empty.yaml", "")));
  EXPECT_SAYS(read_rig(write("other.yaml", "a: 1\n")).error().message(), "not a rig file");
  EXPECT_SAYS(read_rig(write("list.yaml", "- 1\n- 2\n")).error().message(), "not a rig file");
  const std::string other = write("other.yaml", "a: 1\n");
  EXPECT_SAYS(read_rig(other + "," + other).error().message(), "not the calibration of a camera");
  EXPECT_SAYS(read_rig(write("binary.yaml", std::string(100, '\0'))).error().message(),
              "binary.yaml");
  EXPECT_FALSE(read_rig(write("large.yaml", std::string((1U << 20) + 1, ' '))));
}

TEST_F(RigFile, ExampleRigs) {
  const fs::path folder = fs::path(TREAD_SOURCE_DIR) / "rigs";
  const auto paper = read_rig((folder / "bumblebee2-640.yaml").string());
  ASSERT_TRUE(paper) << paper.error().message();
  const RectifiedRig built_in = rectified_rig(bumblebee2(640)).value();
  const RectifiedRig from_file = rectified_rig(*paper).value();
  EXPECT_NEAR(from_file.fx_px, built_in.fx_px, 1e-9);
  EXPECT_EQ(from_file.cx_px, built_in.cx_px);
  EXPECT_EQ(from_file.cy_px, built_in.cy_px);
  EXPECT_EQ(from_file.baseline_m, built_in.baseline_m);
  EXPECT_TRUE(paper->mount->assumed);

  const auto aloe = read_rig((folder / "aloe.yaml").string());
  ASSERT_TRUE(aloe) << aloe.error().message();
  EXPECT_EQ(aloe->size, (ImageSize{1282, 1110}));
  const RectifiedRig rig = rectified_rig(*aloe).value();
  EXPECT_EQ(rig.cx_offset_px, 270.0);
  EXPECT_NEAR(rig.depth_m(0.0), 3740.0 * 0.160 / 270.0, 1e-12);
  // Straight down from 2.2 m.
  EXPECT_LT((aloe->mount->T_body_left * Vector3d(0, 0, 2.2)).norm(), 1e-12);
  EXPECT_TRUE(aloe->mount->assumed);
}

}  // namespace
}  // namespace tread
