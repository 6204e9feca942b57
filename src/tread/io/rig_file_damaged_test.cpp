// Damaged rig files of every format: cut short at every byte, and with random damage.
#include <gtest/gtest.h>

#include <fstream>
#include <random>
#include <vector>

#include "rig_file_fixture.hpp"
#include "rig_samples.hpp"
#include "tread/io/rig_file.hpp"

namespace tread {
namespace {

using namespace tread::testing;

constexpr ImageSize kKittiSize{1226, 370};

struct Sample {
  const char* name;
  std::string text;
  std::string partner;  // of a pair: the sound right file
  bool left = true;     // which of the pair is damaged
};

std::vector<Sample> samples() {
  return {{"own", kOwnRig, ""},
          {"own with IMU", kOwnRig + kOwnImu, ""},
          {"own rectified", kOwnRectifiedRig, ""},
          {"OpenCV YAML", kOpenCvYaml, ""},
          {"OpenCV XML", kOpenCvXml, ""},
          {"Kalibr", kKalibr, ""},
          {"Kalibr with IMU", changed(kKalibr, "cam1:\n", kKalibrImu + "cam1:\n"), ""},
          {"KITTI", kKittiOdometry, ""},
          {"KITTI bare", kKittiBare, ""},
          {"KITTI raw", kKittiRaw, ""},
          {"EuRoC left", kEurocLeft, kEurocRight},
          {"EuRoC right", kEurocRight, kEurocLeft, false},
          {"ROS left", kRosLeft, kRosRight},
          {"ROS right", kRosRight, kRosLeft, false},
          {"ROS message", kRosMessageRight, kRosMessageLeft, false}};
}

class DamagedRigFile : public RigFiles {
 protected:
  // What read_rig is given for a sample; its own file is damaged later.
  std::string path_of(const Sample& sample) {
    damaged_ = write("damaged", sample.text);
    if (sample.partner.empty()) return damaged_;
    const std::string partner = write("partner", sample.partner);
    return sample.left ? damaged_ + "," + partner : partner + "," + damaged_;
  }
  // True if the damaged file was taken for a rig; then it is sound.
  bool taken(const std::string& path, std::string_view text) {
    std::ofstream(damaged_, std::ios::binary | std::ios::trunc) << text;
    const auto rig = read_rig(path, kKittiSize);
    if (!rig) {
      EXPECT_FALSE(rig.error().what.empty());
      EXPECT_SAYS(rig.error().where, scratch_.path().string());
      EXPECT_FALSE(rig.error().remedy.empty());
      return false;
    }
    EXPECT_TRUE(check_rig(*rig));
    return true;
  }

 private:
  std::string damaged_;
};

TEST_F(DamagedRigFile, CutShortAtEveryByte) {
  for (const Sample& sample : samples()) {
    SCOPED_TRACE(sample.name);
    const std::string path = path_of(sample);
    EXPECT_TRUE(taken(path, sample.text));
    std::size_t refused = 0;
    for (std::size_t size = 0; size < sample.text.size(); ++size) {
      if (!taken(path, std::string_view(sample.text).substr(0, size))) ++refused;
    }
    // What is cut may be optional (a mount, the last digits); the first half never is, but for
    // KITTI's unused cameras.
    EXPECT_GT(refused, sample.text.size() / 3);
  }
}

TEST_F(DamagedRigFile, RandomDamage) {
  std::mt19937 random(23);
  for (const Sample& sample : samples()) {
    SCOPED_TRACE(sample.name);
    const std::string path = path_of(sample);
    for (int trial = 0; trial < 150; ++trial) {
      std::string text = sample.text;
      for (int change = 0; change < 1 + trial % 4; ++change) {
        const std::size_t at = random() % text.size();
        switch (random() % 3) {
          case 0:
            text[at] = static_cast<char>(random());
            break;
          case 1:
            text.erase(at, random() % 30);
            break;
          default:
            text.insert(at, text.substr(random() % text.size(), random() % 60));
        }
        if (text.empty()) text = " ";
      }
      taken(path, text);
    }
  }
}

}  // namespace
}  // namespace tread
