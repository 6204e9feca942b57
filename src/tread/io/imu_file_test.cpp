#include "tread/io/imu_file.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "file_mutations.hpp"
#include "test_data.hpp"
#include "tread/io/trajectory_file.hpp"

namespace tread {
namespace {

using Eigen::Vector3d;
using testing::put_file;
using testing::ScratchFolder;

// As EuRoC writes it.
constexpr const char* kHeader =
    "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],"
    "a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\r\n";

class ImuFile : public ::testing::Test {
 protected:
  Result<std::vector<ImuSample>> read(const std::string& text) {
    put_file(path_, text);
    problems_.clear();
    return read_imu(path_, &problems_);
  }
  // The times of what is read, and what was said.
  std::vector<std::int64_t> stamps(const std::string& text) {
    const auto samples = read(text);
    EXPECT_TRUE(samples) << samples.error().message();
    std::vector<std::int64_t> times;
    if (samples) {
      for (const ImuSample& sample : *samples) times.push_back(sample.stamp_ns);
    }
    return times;
  }
  std::string refusal(const std::string& text) {
    const auto samples = read(text);
    EXPECT_FALSE(samples) << text;
    return samples ? "" : samples.error().message();
  }
  ScratchFolder folder_;
  std::filesystem::path path_ = folder_ / "data.csv";
  std::vector<Error> problems_;
};

// A sample at rest, but for some turning.
std::string line(std::int64_t stamp_ns) {
  return std::to_string(stamp_ns) + ",0.1,0.2,0.3,1,2,9.81\n";
}

bool mentions(const Error& error, const std::string& part) {
  return error.message().find(part) != std::string::npos;
}

TEST_F(ImuFile, SamplesOfEuroc) {
  const auto samples =
      read(std::string(kHeader) +
           "1403636579758555392,-0.099134701513277898,0.14730578886832138,0.02722713633111154,"
           "8.1476917083333333,-0.37592158333333331,-2.4026292499999999\r\n"
           " 1403636579763555584 , +1, 2e-3 ,-3,\t4,5,6 ");
  ASSERT_TRUE(samples) << samples.error().message();
  EXPECT_TRUE(problems_.empty());
  ASSERT_EQ(samples->size(), 2U);
  EXPECT_EQ((*samples)[0].stamp_ns, 1403636579758555392);
  EXPECT_EQ((*samples)[0].gyro_rad_per_s,
            Vector3d(-0.099134701513277898, 0.14730578886832138, 0.02722713633111154));
  EXPECT_EQ((*samples)[0].accel_m_per_s2,
            Vector3d(8.1476917083333333, -0.37592158333333331, -2.4026292499999999));
  EXPECT_EQ((*samples)[1].stamp_ns, 1403636579763555584);
  EXPECT_EQ((*samples)[1].gyro_rad_per_s, Vector3d(1, 2e-3, -3));
  EXPECT_EQ((*samples)[1].accel_m_per_s2, Vector3d(4, 5, 6));
}

TEST_F(ImuFile, EachKindOfDamageCostsItsSample) {
  for (const auto& [bad, what] : {std::pair("20,1,2,3,4,5", "fewer columns than 7"),
                                  {"20,1,2,3,4,5,6,7", "more columns than 7"},
                                  {"20,1,2,3,4,5,6,", "more columns than 7"},
                                  {"20,1,2,,4,5,6", "'' is not a finite number"},
                                  {"20,1,2,3,4,5,nan", "'nan' is not a finite number"},
                                  {"20,1,2,3,4,inf,6", "'inf' is not a finite number"},
                                  {"20,1,2,3,4,1e999,6", "'1e999' is not a finite number"},
                                  {"20,1,2,0x3,4,5,6", "'0x3' is not a finite number"},
                                  {"20 1 2 3 4 5 6", "fewer columns"},
                                  {"20.5,1,2,3,4,5,6", "'20.5' is not a time in whole nanoseconds"},
                                  {"-20,1,2,3,4,5,6", "'-20' is not a time"},
                                  {"99999999999999999999,1,2,3,4,5,6", "is not a time"},
                                  {"20,1,-1e4,3,4,5,6", "above 1000 rad/s"},
                                  {"20,1,2,3,4,5,1e6", "above 100000 m/s^2"}}) {
    SCOPED_TRACE(bad);
    EXPECT_EQ(stamps(kHeader + line(10) + bad + "\n" + line(30)),
              (std::vector<std::int64_t>{10, 30}));
    ASSERT_EQ(problems_.size(), 1U);
    EXPECT_EQ(problems_[0].where, path_.string() + ":3");
    EXPECT_TRUE(mentions(problems_[0], what)) << problems_[0].message();
    EXPECT_TRUE(mentions(problems_[0], "ax, ay, az")) << problems_[0].message();
    const auto strict = read_imu(path_);
    ASSERT_FALSE(strict);
    EXPECT_EQ(strict.error().where, path_.string() + ":3");
    EXPECT_FALSE(mentions(strict.error(), "left out"));
  }
}

TEST_F(ImuFile, ManyBadLinesAreToldAtOnce) {
  std::string text = kHeader;
  for (int i = 0; i < 100; ++i) text += i % 4 == 0 ? "x\n" : line(10 + i);
  EXPECT_EQ(stamps(text).size(), 75U);
  ASSERT_EQ(problems_.size(), 1U);
  EXPECT_EQ(problems_[0].where, path_.string() + ":2");
  EXPECT_TRUE(mentions(problems_[0],
                       "25 lines were left out for the like: 2, 6, 10, 14, 18 and 20 "
                       "more"))
      << problems_[0].message();
  EXPECT_EQ(stamps("x\n" + line(1) + line(1) + "y\n").size(), 1U);
  ASSERT_EQ(problems_.size(), 2U) << "one a kind";
  EXPECT_TRUE(mentions(problems_[0], "2 lines were left out for the like: 1, 4."))
      << problems_[0].message();
  EXPECT_EQ(problems_[1].code, ErrorCode::kBadValue);
  EXPECT_EQ(problems_[1].where, path_.string() + ":3");
}

TEST_F(ImuFile, TimesIncreaseStrictlyAndAsFewLinesAsPossibleAreLeftOut) {
  const auto kept = [this](const std::vector<std::int64_t>& times) {
    std::string text;
    for (const std::int64_t time : times) text += line(time);
    return stamps(text);
  };
  using Stamps = std::vector<std::int64_t>;
  EXPECT_EQ(kept({1, 2, 3}), (Stamps{1, 2, 3}));
  EXPECT_TRUE(problems_.empty());
  EXPECT_EQ(kept({1, 2, 2, 3}), (Stamps{1, 2, 3}));
  EXPECT_TRUE(mentions(problems_.at(0), ":3: the time does not fit")) << "of two the second";
  EXPECT_EQ(kept({1, 2, 900, 3, 4}), (Stamps{1, 2, 3, 4})) << "one time that is ahead";
  EXPECT_EQ(problems_.at(0).where, path_.string() + ":3");
  EXPECT_EQ(kept({900, 1, 2, 3}), (Stamps{1, 2, 3})) << "also at the start";
  EXPECT_EQ(kept({10, 11, 1, 12}), (Stamps{10, 11, 12})) << "one that is behind";
  EXPECT_EQ(kept({10, 11, 12, 13, 1, 2}), (Stamps{10, 11, 12, 13})) << "the longer part";
  EXPECT_EQ(kept({1, 2, 10, 11, 12, 13}), (Stamps{1, 2, 10, 11, 12, 13}));
  EXPECT_EQ(kept({5, 5, 5}), (Stamps{5}));
  EXPECT_EQ(kept({3, 2, 1}).size(), 1U);
  const std::int64_t last = std::numeric_limits<std::int64_t>::max();
  EXPECT_EQ(kept({0, last}), (Stamps{0, last}));
  put_file(path_, line(2) + line(1) + line(3));
  EXPECT_FALSE(read_imu(path_)) << "strict";
}

TEST_F(ImuFile, TheFirstOfEqualTimesIsKept) {
  const auto samples = read("1,0,0,0,0,0,0\n2,0.25,0,0,0,0,0\n2,0.5,0,0,0,0,0\n3,0,0,0,0,0,0\n");
  ASSERT_TRUE(samples);
  ASSERT_EQ(samples->size(), 3U);
  EXPECT_EQ((*samples)[1].gyro_rad_per_s.x(), 0.25);
}

TEST_F(ImuFile, FilesWithoutSamplesAreRefused) {
  EXPECT_NE(refusal("").find("data.csv: there is no line with numbers"), std::string::npos);
  EXPECT_NE(refusal(kHeader).find("Write lines of: time in ns, wx"), std::string::npos);
  EXPECT_NE(refusal("a\nb\n").find("data.csv:1: fewer columns"), std::string::npos);
  EXPECT_TRUE(problems_.empty()) << "it is the error, and not told twice";
  EXPECT_NE(refusal(std::string(100, '\0')).find("data.csv"), std::string::npos);
  const auto missing = read_imu(folder_ / "none.csv");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound);
  EXPECT_FALSE(read_imu(folder_.path())) << "a folder";
}

void expect_sound(const std::vector<ImuSample>& samples) {
  std::int64_t before = -1;
  for (const ImuSample& sample : samples) {
    ASSERT_GT(sample.stamp_ns, before);
    before = sample.stamp_ns;
    ASSERT_LE(sample.gyro_rad_per_s.cwiseAbs().maxCoeff(), 1e3);
    ASSERT_LE(sample.accel_m_per_s2.cwiseAbs().maxCoeff(), 1e5);
  }
  ASSERT_FALSE(samples.empty());
}

TEST_F(ImuFile, DamagedFilesCostOnlyWhatIsDamaged) {
  std::string valid = kHeader;
  for (std::int64_t i = 0; i < 20; ++i) valid += line(1403636579758555392 + i * 5'000'000);
  const auto taken = [&](const std::filesystem::path& path) {
    problems_.clear();
    const auto samples = read_imu(path, &problems_);
    if (!samples) return false;
    expect_sound(*samples);
    EXPECT_LE(problems_.size(), 2U);
    EXPECT_GE(samples->size() + 8, 20U) << "each change touches at most two lines";
    return true;
  };
  std::mt19937 random(5);
  for (int i = 0; i < 2000; ++i) {
    put_file(path_, testing::damaged(valid, random));
    EXPECT_TRUE(taken(path_));
  }
  // Cut short, every file with one whole line is taken.
  for (std::size_t size = 0; size < valid.size(); ++size) {
    put_file(path_, std::string_view(valid).substr(0, size));
    const auto samples = read_imu(path_, &problems_);
    EXPECT_EQ(samples.has_value(), size >= std::string(kHeader).size() + line(1).size() + 14)
        << size;
    if (samples) expect_sound(*samples);
  }
}

// ---- the truth of EuRoC, in a table of the same kind

TEST_F(ImuFile, PosesOfEuroc) {
  // p and q of the first line of V1_01 to some digits, and columns behind them.
  put_file(path_,
           "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x []\n"
           "1403715274302142976,0.878612,2.142470,0.947262,0.060514,-0.828459,-0.058956,-0.553641,"
           "0.009474,-0.014009,-0.002145,x,\n"
           "1403715274307142976,1,2,3,0.5,0,0,0\n");
  const auto poses = read_euroc_poses(path_);
  ASSERT_TRUE(poses) << poses.error().message();
  ASSERT_EQ(poses->size(), 2U);
  EXPECT_EQ((*poses)[0].stamp_ns, 1403715274302142976);
  EXPECT_EQ((*poses)[0].pose.translation(), Vector3d(0.878612, 2.142470, 0.947262));
  const Eigen::Quaterniond expected(0.060514, -0.828459, -0.058956, -0.553641);  // w first
  EXPECT_LT(((*poses)[0].pose.linear() - expected.normalized().toRotationMatrix()).norm(), 1e-12);
  EXPECT_TRUE((*poses)[1].pose.linear().isIdentity(0.0)) << "a quaternion of length 0.5";
}

TEST_F(ImuFile, BadPosesOfEurocAreToldAlike) {
  const auto problem = [this](const std::string& text) {
    put_file(path_, "1,1,2,3,1,0,0,0\n" + text + "\n9,1,2,3,1,0,0,0\n");
    problems_.clear();
    const auto poses = read_euroc_poses(path_, &problems_);
    EXPECT_TRUE(poses && poses->size() == 2U);
    EXPECT_FALSE(read_euroc_poses(path_));
    return problems_.size() == 1U ? problems_[0].message() : std::string("none or many");
  };
  EXPECT_NE(problem("5,1,2,3,0,0,0,0").find(":2: the quaternion is zero"), std::string::npos);
  EXPECT_NE(problem("5,1,2,3,1,0,0").find("fewer columns than 8"), std::string::npos);
  EXPECT_NE(problem("5,1,2,3,1,0,0,nan").find("'nan' is not a finite"), std::string::npos);
  EXPECT_NE(problem("1,1,2,3,1,0,0,0").find("the time does not fit"), std::string::npos);
  put_file(path_, "# nothing\n");
  EXPECT_NE(read_euroc_poses(path_).error().message().find("qw, qx, qy, qz"), std::string::npos);
}

}  // namespace
}  // namespace tread
