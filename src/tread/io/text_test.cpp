#include "tread/io/text.hpp"

#include <gtest/gtest.h>

#include <cstdint>

namespace tread {
namespace {

TEST(Text, LinesLeaveOutBlankOnesAndCommentsAndKeepTheirNumbers) {
  const auto lines = lines_with_content("# head\n a b \r\n\n\t# note\nc");
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_EQ(lines[0].number, 2);
  EXPECT_EQ(lines[0].text, "a b");
  EXPECT_EQ(lines[1].number, 5);
  EXPECT_EQ(lines[1].text, "c");
  EXPECT_TRUE(lines_with_content("").empty());
}

TEST(Text, FieldsStandBetweenBlanksAndTabs) {
  const auto fields = split_fields("  1 \t22\t333 ");
  ASSERT_EQ(fields.size(), 3U);
  EXPECT_EQ(fields[0], "1");
  EXPECT_EQ(fields[2], "333");
  EXPECT_TRUE(split_fields(" \t").empty());
}

TEST(Text, ANumberIsTheWholeText) {
  EXPECT_EQ(parse_number<int>("+7"), 7);
  EXPECT_EQ(parse_number<int>("-7"), -7);
  EXPECT_EQ(parse_number<double>("2.5e-3"), 0.0025);
  for (const char* text : {"", "+", "+-7", "7 ", " 7", "7x", "0x7", "99999999999"}) {
    EXPECT_FALSE(parse_number<int>(text)) << text;
  }
  EXPECT_FALSE(parse_number<std::uint8_t>("256"));
}

TEST(Text, SecondsAreReadToTheNanosecondWithoutRounding) {
  // As a double the first would be 1403636579763555584 ns.
  EXPECT_EQ(parse_seconds_as_ns("1403636579.763555527"), 1403636579763555527);
  EXPECT_EQ(parse_seconds_as_ns("1305031102.175304"), 1305031102175304000);
  EXPECT_EQ(parse_seconds_as_ns("1.305031102175304000e+09"), 1305031102175304000);
  EXPECT_EQ(parse_seconds_as_ns("1.7E9"), 1700000000000000000);
  EXPECT_EQ(parse_seconds_as_ns("0"), 0);
  EXPECT_EQ(parse_seconds_as_ns("0e99999"), 0);
  EXPECT_EQ(parse_seconds_as_ns("-0.000000001"), -1);
  EXPECT_EQ(parse_seconds_as_ns("+12."), 12000000000);
  EXPECT_EQ(parse_seconds_as_ns(".5"), 500000000);
  EXPECT_EQ(parse_seconds_as_ns("5e-1"), 500000000);
  EXPECT_EQ(parse_seconds_as_ns("1e-30"), 0);
}

TEST(Text, DigitsBelowTheNanosecondRoundToNearest) {
  EXPECT_EQ(parse_seconds_as_ns("0.0000000014"), 1);
  EXPECT_EQ(parse_seconds_as_ns("0.0000000015"), 2);
  EXPECT_EQ(parse_seconds_as_ns("-0.0000000015"), -2);
  EXPECT_EQ(parse_seconds_as_ns("0.9999999999"), 1000000000);
  EXPECT_EQ(parse_seconds_as_ns("0.0000000005"), 1);
  EXPECT_EQ(parse_seconds_as_ns("0.00000000049"), 0);
}

TEST(Text, SecondsThatDoNotFitOrAreNoNumberAreRefused) {
  EXPECT_EQ(parse_seconds_as_ns("9223372036.854775807"), INT64_MAX);
  EXPECT_FALSE(parse_seconds_as_ns("9223372036.854775808"));
  EXPECT_FALSE(parse_seconds_as_ns("9223372036.8547758075"));
  EXPECT_FALSE(parse_seconds_as_ns("1e30"));
  EXPECT_FALSE(parse_seconds_as_ns("1e99999999999999999999"));
  for (const char* text : {"", "-", ".", "e5", "1e", "1.2.3", "nan", "inf", "1s", "0x10", "1 2"}) {
    EXPECT_FALSE(parse_seconds_as_ns(text)) << text;
  }
}

TEST(Text, PrintedSecondsAreReadBackEqual) {
  EXPECT_EQ(print_ns_as_seconds(1305031102175304000), "1305031102.175304000");
  EXPECT_EQ(print_ns_as_seconds(-1), "-0.000000001");
  for (const std::int64_t stamp_ns : {INT64_MAX, INT64_MIN + 1, std::int64_t{0}, std::int64_t{-1},
                                      std::int64_t{1403636579763555527}}) {
    EXPECT_EQ(parse_seconds_as_ns(print_ns_as_seconds(stamp_ns)), stamp_ns);
  }
  EXPECT_EQ(print_ns_as_seconds(INT64_MIN), "-9223372036.854775808");
}

TEST(Text, TextFromFilesIsHarmlessInMessages) {
  EXPECT_EQ(in_quotes("abc"), "'abc'");
  EXPECT_EQ(in_quotes("a\x1b[2J\n\xff"),
            "'a?[2J?"
            "?'");
  EXPECT_EQ(in_quotes(std::string(50, 'x')), "'" + std::string(40, 'x') + "...'");
}

}  // namespace
}  // namespace tread
