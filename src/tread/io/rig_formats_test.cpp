// Rig files of other programs that hold both cameras, and those of OpenCV.
#include "tread/io/rig_formats.hpp"

#include <gtest/gtest.h>

#include "rig_file_fixture.hpp"
#include "rig_samples.hpp"
#include "tread/geometry/rectification.hpp"
#include "tread/io/rig_file.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using namespace tread::testing;

constexpr ImageSize kSize{1226, 370};

using RigFormats = RigFiles;

// ---- OpenCV

TEST_F(RigFormats, OpenCvYaml) {
  const auto rig = read_text(kOpenCvYaml);
  ASSERT_TRUE(rig) << rig.error().message();
  EXPECT_EQ(rig->size, (ImageSize{640, 480}));
  EXPECT_EQ(rig->name, "rig");
  EXPECT_FALSE(rig->rectified);
  EXPECT_FALSE(rig->mount);
  const auto& left = std::get<BrownCamera>(rig->left);
  EXPECT_EQ(left.pinhole.parameters(),
            (PinholeCamera{530.0, 531.0, 320.0, 240.0, 0.0}.parameters()));
  EXPECT_EQ(left.K, (std::array<double, 5>{-0.28, 0.09, 0.02}));
  EXPECT_EQ(left.P, (std::array<double, 5>{-1.0e-04, 1.2e-03}));
  const auto& right = std::get<BrownCamera>(rig->right);
  EXPECT_EQ(right.K, (std::array<double, 5>{0.1, 0.2, 0.05}));
  EXPECT_EQ(right.P, (std::array<double, 5>{0.004, 0.003}));
  EXPECT_EQ(right.D, (std::array<double, 3>{0.06, 0.07, 0.08}));
  // x_right = R x_left + T
  Matrix3d R;
  R << 0.9998, -0.019998666693333, 0, 0.019998666693333, 0.9998, 0, 0, 0, 1;
  const Vector3d p(0.3, -0.2, 2.0);
  EXPECT_LT((rig->T_left_right.inverse() * p - (R * p + Vector3d(-0.11, 0.002, 0.001))).norm(),
            1e-5);  // R is printed with few digits
  EXPECT_TRUE(make_rectification(*rig));
}

TEST_F(RigFormats, OpenCvXml) {
  const auto rig = read_text(kOpenCvXml);
  ASSERT_TRUE(rig) << rig.error().message();
  EXPECT_EQ(rig->size, (ImageSize{640, 480}));
  EXPECT_EQ(std::get<BrownCamera>(rig->left).P, (std::array<double, 5>{-0.0001, 0.0012}));
  EXPECT_EQ(std::get<PinholeCamera>(rig->right).fy, 541.0);  // all terms are zero
  EXPECT_EQ(rig->T_left_right.translation(), Vector3d(0.11, 0.0, 0.0));
}

TEST_F(RigFormats, OpenCvIntrinsicsAndExtrinsicsApart) {
  const std::size_t cut = kOpenCvYaml.find("R: !!");
  const std::string intrinsics = kOpenCvYaml.substr(0, cut);
  const std::string extrinsics = "%YAML:1.0\n---\n" + kOpenCvYaml.substr(cut);
  const std::string path = write("intrinsics.yml", intrinsics);
  EXPECT_SAYS(message_of(read_rig(path)), "'R' is missing");
  const auto pair = read_rig(path + "," + write("extrinsics.yml", extrinsics));
  ASSERT_TRUE(pair) << pair.error().message();
  EXPECT_NEAR(pair->T_left_right.translation().norm(), 0.11, 1e-3);
  const auto folder = read_rig(scratch_.path().string());
  ASSERT_TRUE(folder) << folder.error().message();
  EXPECT_EQ(folder->T_left_right.matrix(), pair->T_left_right.matrix());
}

TEST_F(RigFormats, OpenCvImageSizeFromTheFileElseFromTheCaller) {
  std::string text = changed(kOpenCvYaml, "image_width: 640\nimage_height: 480\n", "");
  EXPECT_SAYS(message_of(read_text(text)), "the image size is not in the file");
  EXPECT_EQ(read_text(text, {800, 600})->size, (ImageSize{800, 600}));
  EXPECT_EQ(read_text(kOpenCvYaml, {800, 600})->size, (ImageSize{640, 480}));
  text = changed(kOpenCvYaml, "image_width: 640\n", "");
  EXPECT_SAYS(message_of(read_text(text)), "the image size is not in the file");
  text = changed(kOpenCvYaml, "image_width: 640\n", "image_width: wide\n");
  EXPECT_SAYS(message_of(read_text(text)), "image_width: 'wide' is not a whole number");
  text = changed(kOpenCvYaml, "image_height: 480\n", "image_height: high\n");
  EXPECT_SAYS(message_of(read_text(text)), "image_height: 'high' is not a whole number");
}

TEST_F(RigFormats, OpenCvFisheyeIfItSaysSo) {
  const std::string text = changed(kOpenCvXml, "<imageSize>",
                                   "<distortion_model>\"fisheye\"</distortion_model><imageSize>");
  const auto rig = read_text(text);
  ASSERT_TRUE(rig) << rig.error().message();
  EXPECT_EQ(std::get<KannalaBrandtCamera>(rig->left).k,
            (std::array<double, 4>{-0.28, 0.09, 0.0012, -0.0001}));
  EXPECT_TRUE(std::holds_alternative<KannalaBrandtCamera>(rig->right));
  EXPECT_SAYS(message_of(read_text(changed(text, "fisheye", "fishy"))), "'fishy' is not handled");
  EXPECT_SAYS(message_of(read_text(changed(text, "530. 0. 320.", "530. 1. 320."))), "with skew");
  EXPECT_SAYS(message_of(read_text(changed(text, "0.09 0.0012", "0.09"))), "4 coefficients");
}

TEST_F(RigFormats, OpenCvRefusals) {
  const auto refusal = [this](const std::string& from, const std::string& to) {
    return message_of(read_text(changed(kOpenCvYaml, from, to)));
  };
  EXPECT_SAYS(refusal("M2:", "M3:"), "'M2' is missing");
  EXPECT_SAYS(refusal("D1:", "X:"), "'D1' is missing");
  EXPECT_SAYS(refusal("D2:", "X:"), "'D2' is missing");
  EXPECT_SAYS(refusal("T: !!", "Z: !!"), "'T' is missing");
  EXPECT_SAYS(refusal("5.3e+02", "0."), "left.fx: focal length is 0");
  EXPECT_SAYS(refusal("5.3e+02", "wide"), "M1.data: 'wide' is not a finite number");
  EXPECT_SAYS(refusal("5.3e+02", ".Nan"), "M1.data: '.Nan' is not a finite number");
  EXPECT_SAYS(refusal("5.3e+02, 0.,", "5.3e+02,"), "M1.data: expected 9 numbers, found 8");
  EXPECT_SAYS(refusal("rows: 3", "rows: 4"), "M1.rows: expected a 3 x 3 matrix, found 4 rows");
  EXPECT_SAYS(refusal("rows: 3", "rows: x"), "M1.rows: 'x' is not a whole number");
  EXPECT_SAYS(refusal("0.07, 0.08", "0.07"), "expected 4, 5, 8, 12 or 14 coefficients, found 7");
  EXPECT_SAYS(refusal("0.07, 0.08", "0.07, 0.08, 1, 0, 0, 0"), "thin prism and tilt");
  EXPECT_SAYS(refusal("0.07, 0.08", "0.07, x"), "'x' is not a finite number");
  EXPECT_SAYS(refusal("-0.11, 0.002", "-0.11"), "T.data: expected 3 numbers");
  EXPECT_SAYS(refusal("-0.11, 0.002", "-110., 2."), "the unit is probably not metres");
  EXPECT_SAYS(refusal("0.9998, 0.,", "0.5, 0.,"), "R: not a rotation");
  EXPECT_SAYS(refusal("T: !!opencv-matrix", "T: !!opencv-matrix\n  - 3\n"), "not YAML");
  const auto zeros = read_text(changed(kOpenCvYaml, "0.07, 0.08", "0.07, 0.08, 0, 0, 0, 0"));
  EXPECT_TRUE(zeros) << zeros.error().message();
}

// ---- KITTI

void expect_kitti(const StereoRig& rig, double baseline_m) {
  const auto rectified = rectified_rig(rig);
  ASSERT_TRUE(rectified) << rectified.error().message();
  EXPECT_EQ(rectified->fx_px, 700.5);
  EXPECT_EQ(rectified->cx_px, 601.5);
  EXPECT_EQ(rectified->cy_px, 183.5);
  EXPECT_EQ(rectified->cx_offset_px, 0.0);
  EXPECT_NEAR(rectified->baseline_m, baseline_m, 1e-12);
  EXPECT_FALSE(rig.mount);
}

TEST_F(RigFormats, KittiInItsThreeStyles) {
  const auto odometry = read_text(kKittiOdometry, kSize);
  ASSERT_TRUE(odometry) << odometry.error().message();
  expect_kitti(*odometry, 0.5);
  EXPECT_EQ(odometry->size, kSize);
  const auto bare = read_text(kKittiBare, kSize);
  ASSERT_TRUE(bare) << bare.error().message();
  expect_kitti(*bare, 0.5);
  const auto raw = read_text(kKittiRaw);
  ASSERT_TRUE(raw) << raw.error().message();
  expect_kitti(*raw, 0.5);
  EXPECT_EQ(raw->size, (ImageSize{1242, 375}));
}

TEST_F(RigFormats, KittiColourCamerasIfTheGreyOnesAreNotThere) {
  const auto rig = read_text(kKittiOdometry.substr(kKittiOdometry.find("P2:")), kSize);
  ASSERT_TRUE(rig) << rig.error().message();
  expect_kitti(*rig, (45.5 + 334.77) / 700.5);
}

TEST_F(RigFormats, KittiBareFileWithAllFourCamerasAndMore) {
  std::string text = kKittiBare + "\n";
  for (int i = 0; i < 3; ++i) text += "700.5 0 601.5 -99 0 700.5 183.5 0 0 0 1 0\n";
  const auto rig = read_text("\n# grey, then colour\n" + text, kSize);
  ASSERT_TRUE(rig) << rig.error().message();
  expect_kitti(*rig, 0.5);
  // Poses are matrices of 12 numbers too.
  EXPECT_SAYS(message_of(read_text(text + text, kSize)), "this is no calibration");
}

TEST_F(RigFormats, KittiRefusals) {
  const auto refusal = [this](const std::string& from, const std::string& to) {
    return message_of(read_text(changed(kKittiOdometry, from, to), kSize));
  };
  EXPECT_SAYS(message_of(read_text(kKittiOdometry)), "the image size is not in the file");
  EXPECT_SAYS(message_of(read_text(kKittiBare.substr(0, kKittiBare.find('\n')), kSize)),
              "'P1' is missing");
  EXPECT_SAYS(message_of(read_text(kKittiOdometry.substr(kKittiOdometry.find("P3:")), kSize)),
              "'P0' is missing");
  EXPECT_SAYS(refusal("-350.25 0", "-350.25"), "rig.yaml:2: expected 12 numbers");
  EXPECT_SAYS(refusal("-350.25", "left"), "rig.yaml:2: 'left' is not a finite number");
  EXPECT_SAYS(refusal("P0: 700.5", "P0: 0"), "rig.yaml:1: focal length is not above 0");
  EXPECT_SAYS(refusal("-350.25", "0"), "the baseline is 0");
  EXPECT_SAYS(refusal("-350.25", "350.25"), "T_left_right");
  EXPECT_SAYS(refusal("P0: 700.5", "P0: 710.5"), "focal lengths of its cameras differ");
  EXPECT_SAYS(message_of(read_text(changed(kKittiRaw, "1.242000e+03", "1e99"))), "image size");
}

TEST_F(RigFormats, KittiFileOfTheDevelopmentData) {
  TREAD_NEEDS_DATA(path, "stereo_seq/kitti_seq_1/calib.txt");
  const auto rig = read_rig(path.string(), kSize);
  ASSERT_TRUE(rig) << rig.error().message();
  const RectifiedRig rectified = rectified_rig(*rig).value();
  EXPECT_NEAR(rectified.fx_px, 707.0912, 1e-9);
  EXPECT_NEAR(rectified.cx_px, 601.8873, 1e-9);
  EXPECT_NEAR(rectified.cy_px, 183.1104, 1e-9);
  EXPECT_NEAR(rectified.baseline_m, 0.5372, 5e-5);
}

// ---- Kalibr

TEST_F(RigFormats, Kalibr) {
  const auto rig = read_text(kKalibr);
  ASSERT_TRUE(rig) << rig.error().message();
  EXPECT_EQ(rig->size, (ImageSize{752, 480}));
  EXPECT_FALSE(rig->mount);
  const auto& left = std::get<BrownCamera>(rig->left);
  EXPECT_EQ(left.pinhole.cx, 367.21);
  EXPECT_EQ(left.K, (std::array<double, 5>{-0.28, 0.07}));
  EXPECT_EQ(left.P, (std::array<double, 5>{1.8e-05, 0.0002}));
  const auto& right = std::get<KannalaBrandtCamera>(rig->right);
  EXPECT_EQ(right.fy, 456.13);
  EXPECT_EQ(right.k[2], -0.0021);
  // T_cn_cnm1 maps camera 0 into camera 1.
  const double s = 0.014141782065920828;
  const Vector3d p(0.3, -0.2, 2.0);
  const Vector3d p_right(0.9999 * p.x() + s * p.y() - 0.11, -s * p.x() + 0.9999 * p.y() + 0.0004,
                         p.z() - 0.0008);
  EXPECT_LT((rig->T_left_right.inverse() * p - p_right).norm(), 1e-9);
  EXPECT_GT(rig->T_left_right.translation().x(), 0.1);
}

std::string kalibr_with_imu() {
  return changed(kKalibr, "cam1:\n", kKalibrImu + "cam1:\n");
}

TEST_F(RigFormats, KalibrWithAnImu) {
  EXPECT_FALSE(read_text(kKalibr)->imu);
  const auto rig = read_text(kalibr_with_imu());
  ASSERT_TRUE(rig) << rig.error().message();
  ASSERT_TRUE(rig->imu);
  // The IMU's origin in the camera, and a point 1 m along the IMU's x.
  const Isometry3d& T_imu_left = rig->imu->T_imu_left;
  EXPECT_LT((T_imu_left * Vector3d(0.1, 0.2, 0.3)).norm(), 1e-12);
  EXPECT_LT((T_imu_left * Vector3d(0.1, -0.8, 0.3) - Vector3d::UnitX()).norm(), 1e-12);
  EXPECT_EQ(rig->imu->rate_hz, Imu{}.rate_hz);
  EXPECT_EQ(rig->imu->gyro_noise, Imu{}.gyro_noise);
  EXPECT_SAYS(message_of(read_text(
                  changed(kalibr_with_imu(), "[0.0, 1.0, 0.0, 0.1]", "[0.0, 1.1, 0.0, 0.1]"))),
              "cam0.T_cam_imu: not a rigid motion");
}

TEST_F(RigFormats, KalibrRefusals) {
  const auto refusal = [this](const std::string& from, const std::string& to) {
    return message_of(read_text(changed(kKalibr, from, to)));
  };
  for (const std::string model : {"omni", "eucm", "ds"}) {
    const std::string message = refusal("camera_model: pinhole", "camera_model: " + model);
    EXPECT_SAYS(message, "cam0.camera_model: the camera model '" + model + "' is not handled");
    EXPECT_SAYS(message, "pinhole-equi");
  }
  EXPECT_SAYS(refusal("camera_model: pinhole", "camera_model: [1]"), "expected a text");
  EXPECT_SAYS(refusal("  camera_model: pinhole\n", ""), "'camera_model' is missing");
  EXPECT_SAYS(refusal("distortion_model: radtan", "distortion_model: fov"), "'fov' is not handled");
  EXPECT_SAYS(refusal("  distortion_model: radtan\n", ""), "'distortion_model' is missing");
  EXPECT_SAYS(refusal("distortion_coeffs", "coeffs"), "'distortion_coeffs' is missing");
  EXPECT_SAYS(refusal("[-0.28, 0.07,", "[-0.28,"), "found 3");
  EXPECT_SAYS(refusal("[-0.28,", "[much,"), "'much' is not a finite number");
  EXPECT_SAYS(refusal("0.0021, 0.0002]", "0.0021]"), "4 coefficients, found 3");
  EXPECT_SAYS(refusal("458.65,", ""), "cam0.intrinsics: expected 4 numbers, found 3");
  EXPECT_SAYS(refusal("458.65", "0"), "left.fx: focal length is 0");
  EXPECT_SAYS(refusal("intrinsics: [457.58, 456.13, 379.99, 255.23]", "x: 1"),
              "cam1: 'intrinsics' is missing");
  EXPECT_SAYS(refusal("  resolution: [752, 480]\n", ""), "cam0: 'resolution' is missing");
  EXPECT_SAYS(refusal("[752, 480]", "[752, x]"), "'x' is not a finite number");
  EXPECT_SAYS(refusal("[752, 480]", "[640, 480]"), "differ in size: 640 x 480 and 752 x 480");
  EXPECT_SAYS(refusal("cam1:", "cam2:"), "'cam1' is missing");
  EXPECT_SAYS(refusal("T_cn_cnm1:", "T_cam_imu:"), "'T_cn_cnm1' is missing");
  EXPECT_SAYS(refusal("  - [0.0, 0.0, 0.0, 1.0]\n", ""), "expected 16 numbers, found 12");
  EXPECT_SAYS(refusal("  - [0.0, 0.0, 0.0, 1.0]\n", "  - [0.0, 0.0, 0.1, 1.0]\n"),
              "not a rigid motion");
  EXPECT_SAYS(refusal("- [0.9999", "- [1.9999"), "not a rigid motion");
  EXPECT_SAYS(refusal("cam0:\n", "cam0: 3\ncamx:\n"), "expected entries");
}

}  // namespace
}  // namespace tread
