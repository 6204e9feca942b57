// Rig files of other programs that come as one file a camera: EuRoC and ROS.
#include <gtest/gtest.h>

#include "file_mutations.hpp"
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

using RigFormatPairs = RigFiles;

// ---- EuRoC

TEST_F(RigFormatPairs, EurocFolder) {
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

TEST_F(RigFormatPairs, EurocFolderWithAnImu) {
  const std::string left = write("mav0/cam0/sensor.yaml", kEurocLeft);
  const std::string right = write("mav0/cam1/sensor.yaml", kEurocRight);
  EXPECT_FALSE(read_rig(scratch_.path().string())->imu);
  write("mav0/imu0/sensor.yaml", kEurocImu);
  for (const std::string& path :
       {scratch_.path().string(), (scratch_ / "mav0").string(), left + "," + right}) {
    const auto rig = read_rig(path);
    ASSERT_TRUE(rig) << rig.error().message();
    ASSERT_TRUE(rig->imu) << path;
    // T_BS of cam0, as that of the IMU is none.
    EXPECT_LT((rig->imu->T_imu_left.translation() -
               Vector3d(-0.0216401454975, -0.064676986768, 0.00981073058949))
                  .norm(),
              1e-12);
    EXPECT_NEAR(rig->imu->T_imu_left.linear()(1, 0), 0.999557249008, 1e-9);
    EXPECT_EQ(rig->imu->gyro_noise, 1.6968e-04);
    EXPECT_EQ(rig->imu->gyro_walk, 1.9393e-05);
    EXPECT_EQ(rig->imu->accel_noise, 2e-3);
    EXPECT_EQ(rig->imu->accel_walk, 3e-3);
    EXPECT_EQ(rig->imu->rate_hz, 200.0);
  }
  // An IMU that sits elsewhere in the body: 1 m along its x, turned by a quarter about z.
  write("mav0/imu0/sensor.yaml",
        changed(changed(kEurocImu, "[1.0, 0.0, 0.0, 0.0,", "[0.0, -1.0, 0.0, 1.0,"),
                "0.0, 1.0, 0.0, 0.0,", "1.0, 0.0, 0.0, 0.0,"));
  const auto turned = read_rig(scratch_.path().string());
  ASSERT_TRUE(turned) << turned.error().message();
  EXPECT_LT((turned->imu->T_imu_left.translation() -
             Vector3d(-0.064676986768, 1.0216401454975, 0.00981073058949))
                .norm(),
            1e-12);
  const auto refusal = [&](const std::string& from, const std::string& to) {
    write("mav0/imu0/sensor.yaml", changed(kEurocImu, from, to));
    return message_of(read_rig(scratch_.path().string()));
  };
  EXPECT_SAYS(refusal("sensor_type: imu", "sensor_type: camera"),
              "imu0/sensor.yaml:2: sensor_type: 'camera' is no IMU");
  EXPECT_SAYS(refusal("sensor_type: imu\n", ""), "'sensor_type' is missing");
  EXPECT_SAYS(refusal("T_BS", "T_SB"), "'T_BS' is missing");
  EXPECT_SAYS(refusal("rate_hz: 200\n", ""), "'rate_hz' is missing");
  EXPECT_SAYS(refusal("rate_hz: 200", "rate_hz: -200"), "imu.rate_hz: -200 is not");
  for (const char* key : {"gyroscope_noise_density", "gyroscope_random_walk",
                          "accelerometer_noise_density", "accelerometer_random_walk"}) {
    EXPECT_SAYS(refusal(key, "x"), std::string("'") + key + "' is missing");
  }
}

TEST_F(RigFormatPairs, DamagedEurocImus) {
  write("cam0/sensor.yaml", kEurocLeft);
  write("cam1/sensor.yaml", kEurocRight);
  const fs::path path = write("imu0/sensor.yaml", kEurocImu);
  const auto taken = [&](const fs::path&) {
    const auto rig = read_rig(scratch_.path().string());
    if (rig) {
      EXPECT_TRUE(rig->imu && check_rig(*rig));
    } else {
      EXPECT_SAYS(rig.error().where + rig.error().what, "imu");
      EXPECT_FALSE(rig.error().remedy.empty());
    }
    return rig.has_value();
  };
  // Cut within the last line, its number (3.0000e-3) may still be one, and its comment.
  EXPECT_LT(shorter_files_taken(kEurocImu, path, taken), 40);
  EXPECT_GT(damaged_files_refused(kEurocImu, path, taken), 500);
}

TEST_F(RigFormatPairs, EurocRefusals) {
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

TEST_F(RigFormatPairs, CameraInfoPair) {
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

TEST_F(RigFormatPairs, CameraInfoMessagesOfARectifiedPair) {
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

TEST_F(RigFormatPairs, CameraInfoOfFisheyeLenses) {
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

TEST_F(RigFormatPairs, CameraInfoRefusals) {
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
