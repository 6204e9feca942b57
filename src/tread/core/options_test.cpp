#include "tread/core/options.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace tread {
namespace {

enum class Method { kSad, kSgm };

struct InnerOptions {
  int window_px = 11;
  double limit_m = 4.0;
};

OptionSet describe(InnerOptions& options) {
  OptionSet set;
  set.add_odd("window_px", options.window_px, "side of the window", 3, 31);
  set.add("limit_m", options.limit_m, "range", 0.0, 100.0);
  return set;
}

struct OuterOptions {
  InnerOptions inner;
  bool fill = true;
  Method method = Method::kSad;
  Knots knots = {{{0.0, 1.0}}, {{1.0, 10.0}}};
};

OptionSet describe(OuterOptions& options) {
  OptionSet set;
  set.add_group("inner", describe(options.inner));
  set.add("fill", options.fill, "fill holes");
  set.add_choice("method", options.method, "how", {{"sad", Method::kSad}, {"sgm", Method::kSgm}});
  set.add("knots", options.knots, "cost over derivative");
  return set;
}

TEST(Options, SetsEveryKindFromText) {
  OuterOptions options;
  OptionSet set = describe(options);
  EXPECT_TRUE(set.set("inner.window_px", " 7 "));
  EXPECT_TRUE(set.set("inner.limit_m", "2.5e0"));
  EXPECT_TRUE(set.set("fill", "off"));
  EXPECT_TRUE(set.set("method", "sgm"));
  EXPECT_TRUE(set.set("knots", "0:1 0.5:2, 2:40"));
  EXPECT_EQ(options.inner.window_px, 7);
  EXPECT_EQ(options.inner.limit_m, 2.5);
  EXPECT_FALSE(options.fill);
  EXPECT_EQ(options.method, Method::kSgm);
  ASSERT_EQ(options.knots.size(), 3U);
  EXPECT_EQ(options.knots[2][1], 40.0);
}

TEST(Options, PrintsWhatItReads) {
  OuterOptions options, copy;
  options.inner.window_px = 21;
  options.method = Method::kSgm;
  options.knots = {{{0.25, 1.5}}, {{7.0, 9.0}}};
  OptionSet from = describe(options), to = describe(copy);
  for (const OptionField& field : from.fields()) {
    ASSERT_TRUE(to.set(field.name, field.print())) << field.name;
  }
  EXPECT_EQ(copy.inner.window_px, 21);
  EXPECT_EQ(copy.method, Method::kSgm);
  EXPECT_EQ(copy.knots, options.knots);
}

TEST(Options, UnknownNameIsRefusedWithTheNearest) {
  OuterOptions options;
  OptionSet set = describe(options);
  const Status misspelt = set.set("inner.windw_px", "7");
  ASSERT_FALSE(misspelt);
  EXPECT_EQ(misspelt.error().code, ErrorCode::kNotFound);
  EXPECT_NE(misspelt.error().message().find("'inner.window_px'"), std::string::npos);
  const Status without_group = set.set("limit_m", "7");
  ASSERT_FALSE(without_group);
  EXPECT_NE(without_group.error().message().find("'inner.limit_m'"), std::string::npos);
  const Status nonsense = set.set("zzzzzzzz", "7");
  ASSERT_FALSE(nonsense);
  EXPECT_NE(nonsense.error().message().find("Known are"), std::string::npos);
}

TEST(Options, BadTextLeavesTheFieldAlone) {
  OuterOptions options;
  OptionSet set = describe(options);
  for (const char* text : {"8", "33", "x", "", "7.5", "99999999999999999999"}) {
    const Status done = set.set("inner.window_px", text);
    ASSERT_FALSE(done) << text;
    EXPECT_EQ(done.error().where, "inner.window_px");
    EXPECT_EQ(options.inner.window_px, 11) << text;
  }
  EXPECT_FALSE(set.set("inner.limit_m", "nan"));
  EXPECT_FALSE(set.set("inner.limit_m", "-1"));
  EXPECT_FALSE(set.set("fill", "maybe"));
  EXPECT_FALSE(set.set("method", "elas"));
  EXPECT_FALSE(set.set("knots", "1:2 0:3"));
  EXPECT_FALSE(set.set("knots", "1:2 1:3"));
  EXPECT_FALSE(set.set("knots", ""));
  EXPECT_FALSE(set.set("knots", "1"));
  EXPECT_EQ(options.knots.size(), 2U);
}

TEST(Options, CheckNamesTheFieldOutOfRange) {
  OuterOptions options;
  EXPECT_TRUE(check_options(options));
  options.inner.window_px = 4;
  const Status even = check_options(options);
  ASSERT_FALSE(even);
  EXPECT_EQ(even.error().where, "inner.window_px");
  EXPECT_EQ(even.error().message(), "inner.window_px: 4 is out of range. Give odd, 3 to 31.");
  options.inner.window_px = 11;
  options.inner.limit_m = std::nan("");
  EXPECT_FALSE(check_options(options));
}

}  // namespace
}  // namespace tread
