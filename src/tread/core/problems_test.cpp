#include "tread/core/problems.hpp"

#include <gtest/gtest.h>

namespace tread {
namespace {

Error too_far(int frame, const std::string& metres) {
  return {ErrorCode::kBadValue, "its pose is " + metres + " m away",
          "frame " + std::to_string(frame), "Correct the trajectory"};
}

TEST(Problems, ThoseThatDifferInPlaceAndNumbersAreOne) {
  const Error missing{ErrorCode::kNotFound, "there is no right image", "left/7.png", "Add it"};
  const auto few = distinct_problems(
      {too_far(1, "1e+07"), missing, too_far(2, "62.25"), too_far(3, "800"), too_far(4, "5e-3")});
  ASSERT_EQ(few.size(), 2U);
  EXPECT_EQ(few[0].message(),
            "frame 1: its pose is 1e+07 m away (and 3 more like it). Correct the trajectory.");
  EXPECT_EQ(few[1].message(), missing.message());
}

TEST(Problems, OtherWordsCodesAndRemediesAreOthers) {
  Error code = too_far(1, "1"), remedy = code, what = code;
  code.code = ErrorCode::kNotFound;
  remedy.remedy = "Pray";
  what.what = "its pose is 1 km away";
  EXPECT_EQ(distinct_problems({too_far(1, "1"), code, remedy, what}).size(), 4U);
  EXPECT_TRUE(distinct_problems({}).empty());
}

TEST(Problems, AreBoundedAndTheRestIsCounted) {
  std::vector<Error> problems;
  for (char c = 'a'; c <= 'z'; ++c) {
    problems.push_back({ErrorCode::kBadValue, std::string(1, c), "", ""});
  }
  problems.push_back(problems.front());
  const auto few = distinct_problems(problems, 5);
  ASSERT_EQ(few.size(), 6U);
  EXPECT_EQ(few[0].what, "a (and 1 more like it)");
  EXPECT_EQ(few[4].what, "e");
  EXPECT_EQ(few[5].what, "and 21 problems of other kinds");
}

}  // namespace
}  // namespace tread
