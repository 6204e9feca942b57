// Rig files of other programs.
#include "tread/io/rig_formats.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "rig_samples.hpp"
#include "test_data.hpp"
#include "tread/geometry/rectification.hpp"
#include "tread/io/rig_file.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using namespace tread::testing;

constexpr ImageSize kSize{1226, 370};

class RigFormats : public ::testing::Test {
 protected:
  std::string write(const std::string& name, const std::string& text) {
    const fs::path path = scratch_ / name;
    fs::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary | std::ios::trunc) << text;
    return path.string();
  }
  Result<StereoRig> read_text(const std::string& text, ImageSize size = {}) {
    return read_rig(write("calibration", text), size);
  }
  Result<StereoRig> read_pair(const std::string& left, const std::string& right) {
    return read_rig(write("left.yaml", left) + "," + write("right.yaml", right));
  }
  ScratchFolder scratch_;
};

std::string changed(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string message_of(const Result<StereoRig>& rig) {
  EXPECT_FALSE(rig);
  return rig ? "read" : rig.error().message();
}

#define EXPECT_SAYS(message, part) \
  EXPECT_NE((message).find(part), std::string::npos) << "says: " << (message)

// ---- OpenCV

TEST_F(RigFormats, OpenCvYaml) {
  const auto rig = read_text(kOpenCvYaml);
  ASSERT_TRUE(rig) << rig.error().message();
  EXPECT_EQ(rig->size, (ImageSize{640, 480}));
  EXPECT_EQ(rig->name, "calibration");
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
  EXPECT_SAYS(refusal("-350.25 0", "-350.25"), "calibration:2: expected 12 numbers");
  EXPECT_SAYS(refusal("-350.25", "left"), "calibration:2: 'left' is not a finite number");
  EXPECT_SAYS(refusal("P0: 700.5", "P0: 0"), "calibration:1: focal length is not above 0");
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

// ---- EuRoC

TEST_F(RigFormats, EurocFolder) {
  write("mav0/cam0/sensor.yaml", kEurocLeft);
  write("mav0/cam1/sensor.yaml", kEurocRight);
  const auto rig = read_rig(scratch_.path().string());
  ASSERT_TRUE(rig) << rig.error().message();
  EXPECT_EQ(rig->size, (ImageSize{752, 480}));
  EXPECT_FALSE(rig->mount);  // the body frame there is the IMU's
  EXPECT_EQ(std::get<BrownCamera>(rig->left).pinhole.cy, 248.375);
  EXPECT_EQ(std::get<BrownCamera>(rig->right).P,
            (std::array<double, 5>{-3.55590700e-05, -0.00010473}));
  // The published baseline is 11 cm, along x, the cameras turned by less than 2 degrees.
  EXPECT_NEAR(rig->T_left_right.translation().x(), 0.110, 5e-4);
  EXPECT_LT(rig->T_left_right.translation().tail<2>().norm(), 1e-3);
  EXPECT_LT(so3_log(rig->T_left_right.linear()).norm(), 0.035);
  EXPECT_TRUE(make_rectification(*rig));
  for (const fs::path& place : {scratch_ / "mav0", scratch_ / "mav0/"}) {
    const auto inner = read_rig(place.string());
    ASSERT_TRUE(inner) << inner.error().message();
    EXPECT_EQ(inner->T_left_right.matrix(), rig->T_left_right.matrix());
    EXPECT_EQ(inner->name, "mav0");
  }
  fs::remove(scratch_ / "mav0/cam1/sensor.yaml");
  EXPECT_SAYS(message_of(read_rig(scratch_.path().string())), "cam1/sensor.yaml");
}

TEST_F(RigFormats, EurocRefusals) {
  const auto refusal = [this](const std::string& from, const std::string& to) {
    return message_of(read_pair(kEurocLeft, changed(kEurocRight, from, to)));
  };
  EXPECT_SAYS(message_of(read_text(kEurocLeft)), "the calibration of one camera");
  EXPECT_SAYS(refusal("T_BS:", "T_SB:"), "right.yaml:1: 'T_BS' is missing");
  EXPECT_SAYS(message_of(read_pair(changed(kEurocLeft, "T_BS:", "T_SB:"), kEurocRight)),
              "'T_BS' is missing");
  EXPECT_SAYS(refusal("cols: 4", "cols: 3"), "T_BS.cols: expected a 4 x 4 matrix, found 3 cols");
  EXPECT_SAYS(refusal("  data:", "  date:"), "T_BS: 'data' is missing");
  EXPECT_SAYS(refusal("457.587", "0.0"), "right.fx: focal length is 0");
  EXPECT_SAYS(refusal("[752, 480]", "[752, 481]"), "differ in size");
  EXPECT_SAYS(refusal("distortion_coefficients: [-0.28368365,", "distortion_coefficients: ["),
              "found 3");
  EXPECT_SAYS(refusal("camera_model: pinhole", "camera_model: ds"), "'ds' is not handled");
}

// ---- ROS

TEST_F(RigFormats, CameraInfoPair) {
  write("left.yaml", kRosLeft);
  write("right.yaml", kRosRight);
  const auto rig = read_rig(scratch_.path().string());
  ASSERT_TRUE(rig) << rig.error().message();
  EXPECT_EQ(rig->size, (ImageSize{640, 480}));
  EXPECT_FALSE(rig->rectified);
  EXPECT_EQ(std::get<BrownCamera>(rig->left).pinhole.fx, 430.1);
  EXPECT_EQ(std::get<BrownCamera>(rig->left).K, (std::array<double, 5>{-0.36, 0.11, 0.02}));
  EXPECT_EQ(std::get<BrownCamera>(rig->right).D, (std::array<double, 3>{0.06, 0.07, 0.08}));
  // Turned by the rectification matrices, a point differs by the baseline along x.
  const Matrix3d R_left = so3_exp({0, 0, 0.02}), R_right = so3_exp({0, 0.02, 0});
  const Vector3d p_left(0.3, -0.2, 2.0);
  const Vector3d p_right = rig->T_left_right.inverse() * p_left;
  const Vector3d difference = R_left * p_left - R_right * p_right;
  EXPECT_LT((difference - Vector3d(34.2 / 380.0, 0.0, 0.0)).norm(), 1e-9);
  const auto made = make_rectification(*rig);
  ASSERT_TRUE(made) << made.error().message();
  EXPECT_NEAR(made->rig.baseline_m, 0.09, 1e-12);
}

TEST_F(RigFormats, CameraInfoMessagesOfARectifiedPair) {
  const auto rig = read_pair(kRosMessageLeft, kRosMessageRight);
  ASSERT_TRUE(rig) << rig.error().message();
  EXPECT_TRUE(rig->rectified);
  const RectifiedRig rectified = rectified_rig(*rig).value();
  EXPECT_NEAR(rectified.baseline_m, 0.1, 1e-12);
  EXPECT_EQ(rectified.cx_px, 320.0);
  // Rectified images of another focal length than the camera's: these are not they.
  const auto zoomed =
      read_pair(changed(kRosMessageLeft, "k: [380.0", "k: [390.0"), kRosMessageRight);
  ASSERT_TRUE(zoomed) << zoomed.error().message();
  EXPECT_FALSE(zoomed->rectified);
}

TEST_F(RigFormats, CameraInfoOfFisheyeLenses) {
  const std::string coefficients = "d: [0.0, 0.0, 0.0, 0.0, 0.0]";
  const auto fisheye = [&](const std::string& text) {
    return changed(changed(text, "plumb_bob", "equidistant"), coefficients,
                   "d: [0.1, 0.0, 0.0, 0.0]");
  };
  const auto rig = read_pair(fisheye(kRosMessageLeft), fisheye(kRosMessageRight));
  ASSERT_TRUE(rig) << rig.error().message();
  EXPECT_EQ(std::get<KannalaBrandtCamera>(rig->left).k[0], 0.1);
  EXPECT_FALSE(rig->rectified);
}

TEST_F(RigFormats, CameraInfoRefusals) {
  const auto refusal = [this](const std::string& from, const std::string& to) {
    return message_of(read_pair(kRosLeft, changed(kRosRight, from, to)));
  };
  EXPECT_SAYS(message_of(read_text(kRosLeft)), "the calibration of one camera");
  EXPECT_SAYS(message_of(read_pair(kRosRight, kRosLeft)), "exchange left and right");
  EXPECT_SAYS(message_of(read_pair(kRosLeft, kRosLeft)), "the baseline is 0 m");
  EXPECT_SAYS(refusal("image_width: 640", "image_width: 320"), "differ in size");
  EXPECT_SAYS(refusal("image_width: 640", "image_width: x"), "image_width: 'x' is not a whole");
  EXPECT_SAYS(refusal("image_width: 640\n", ""), "'image_width' is missing");
  EXPECT_SAYS(refusal("image_height: 480\n", ""), "'image_height' is missing");
  EXPECT_SAYS(refusal("camera_matrix", "matrix"), "'camera_matrix' is missing");
  EXPECT_SAYS(refusal("431.1, 0,", "431.1,"), "camera_matrix.data: expected 9 numbers, found 8");
  EXPECT_SAYS(refusal("431.1", "0"), "right.fx: focal length is 0");
  EXPECT_SAYS(refusal("distortion_model: rational_polynomial\n", ""), "'distortion_model'");
  EXPECT_SAYS(refusal("rational_polynomial", "cubic"), "'cubic' is not handled");
  EXPECT_SAYS(refusal("distortion_coefficients", "dist"), "'distortion_coefficients' is missing");
  EXPECT_SAYS(refusal("0.06, 0.07, 0.08", "0.06"), "found 6");
  EXPECT_SAYS(refusal("0.06, 0.07, 0.08", "x"), "'x' is not a finite number");
  EXPECT_SAYS(refusal("rectification_matrix", "rect"), "'rectification_matrix' is missing");
  EXPECT_SAYS(refusal("data: [0.9998", "data: [1.9998"), "not a rotation");
  EXPECT_SAYS(refusal("projection_matrix", "projection"), "'projection_matrix' is missing");
  EXPECT_SAYS(refusal("-34.2, 0,", "-34.2,"), "expected 12 numbers, found 11");
  EXPECT_SAYS(refusal("data: [380", "data: [0"), "focal length is not above 0");
}

}  // namespace
}  // namespace tread
