#include "tread/pipeline/pose_gate.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <string>

namespace tread {
namespace {

using Verdict = PoseGate::Verdict;

// Drives along x, one frame each 0.1 s.
class PoseGateDrive : public ::testing::Test {
 protected:
  Verdict drive(double x, double seconds = 0.1) {
    stamp_ns_ += static_cast<std::int64_t>(seconds * 1e9);
    answer_ = gate_.judge(stamp_ns_, {origin_.x() + x, origin_.y(), origin_.z()});
    return answer_.verdict;
  }
  // a: accepted, r: refused, m: moved, s: restart; of frames at these places.
  std::string verdicts(const std::vector<double>& places) {
    std::string text;
    for (double x : places) text += "arms"[static_cast<std::size_t>(drive(x))];
    return text;
  }
  PoseGate gate_;
  PoseGate::Answer answer_;
  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
  std::int64_t stamp_ns_ = 0;
};

TEST_F(PoseGateDrive, OneOutlierIsRefusedAndTheDriveGoesOn) {
  EXPECT_EQ(verdicts({0, 1, 2, 1e7, 4, 5}), "aaaraa");
}

TEST_F(PoseGateDrive, StepAndSpeedAddUp) {
  ASSERT_EQ(drive(0), Verdict::kAccepted);
  ASSERT_EQ(drive(54.9), Verdict::kAccepted);  // 50 m + 50 m/s * 0.1 s
  EXPECT_EQ(drive(110.1), Verdict::kRefused);
  EXPECT_NEAR(answer_.distance_m, 55.2, 1e-9);
  EXPECT_NEAR(answer_.allowed_m, 55.0, 1e-9);
}

TEST_F(PoseGateDrive, AllDirectionsCount) {
  ASSERT_EQ(drive(0), Verdict::kAccepted);
  origin_.z() = 60.0;
  EXPECT_EQ(drive(0), Verdict::kRefused);
  origin_ = {0.0, -70.0, 0.0};
  EXPECT_EQ(drive(0), Verdict::kRefused);
}

TEST_F(PoseGateDrive, MayBeginAnywhere) {
  origin_ = {448'262.0, 5'411'932.0, 260.0};  // UTM
  EXPECT_EQ(verdicts({0, 1, 2, 3}), "aaaa");
}

TEST_F(PoseGateDrive, FramesMayBeLeftOutAndStampsBeMissingOrRunBackwards) {
  ASSERT_EQ(drive(0), Verdict::kAccepted);
  EXPECT_EQ(drive(400, 10.0), Verdict::kAccepted) << "40 m/s";
  EXPECT_EQ(drive(440, 0.0), Verdict::kAccepted);
  EXPECT_EQ(drive(480, -0.1), Verdict::kAccepted);
  // Stamps that no 64 bits hold the difference of.
  PoseGate gate;
  EXPECT_EQ(gate.judge(std::numeric_limits<std::int64_t>::min(), {0, 0, 0}).verdict,
            Verdict::kAccepted);
  const auto answer = gate.judge(std::numeric_limits<std::int64_t>::max(), {0, 0, 0});
  EXPECT_EQ(answer.verdict, Verdict::kAccepted);
  EXPECT_NEAR(answer.allowed_m, 50.0 * 1.8446744e10, 1e6);
}

TEST_F(PoseGateDrive, AJumpThatLastsIsBelievedWithTheThirdFrame) {
  EXPECT_EQ(verdicts({0, 1, 2, 5000, 5001, 5002, 5003, 5004}), "aaarrmaa");
}

TEST_F(PoseGateDrive, OnlyFramesInARowThatAgreeConfirmAJump) {
  EXPECT_EQ(verdicts({0, 1, 2, 5000, 9000, 5001, 9001, 5002}), "aaarrrrr")
      << "they do not agree with the one before";
  EXPECT_EQ(verdicts({3, 5000, 5001, 4, 5002, 5003, 5}), "arrarra") << "back in between";
}

TEST_F(PoseGateDrive, TheFirstFrameMayBeTheOneThatIsWrong) {
  EXPECT_EQ(verdicts({1e7, 0, 1, 2, 3, 1e7, 4}), "arrsara");
}

TEST_F(PoseGateDrive, NorAreTwoFramesAtTheStartBelieved) {
  EXPECT_EQ(verdicts({1e7, 1e7, 0, 1, 2, 3}), "aarrsa");
  // What was believed with three frames stays, whatever comes.
  EXPECT_EQ(verdicts({9000, 9000, 9000}), "rrm");
}

TEST_F(PoseGateDrive, CanBeTurnedOffAndSet) {
  gate_ = PoseGate({.check_jumps = false});
  EXPECT_EQ(verdicts({0, 1e7, 0}), "aaa");
  gate_ = PoseGate({.confirm_frames = 1});
  EXPECT_EQ(verdicts({0, 1e7, 0}), "amm");
  gate_ = PoseGate({.max_step_m = 0.5, .max_speed_m_per_s = 0.0, .confirm_frames = 2});
  EXPECT_EQ(verdicts({0, 0.5, 1.1, 1.1}), "aarm");
}

TEST(PoseGateOptions, AreDescribed) {
  PoseGateOptions options;
  EXPECT_TRUE(check_options(options));
  EXPECT_EQ(describe(options).fields().size(), 4U);
  options.confirm_frames = 0;
  EXPECT_EQ(check_options(options).error().where, "confirm_frames");
}

}  // namespace
}  // namespace tread
