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

struct SpanOptions {
  double low_m = 1.0;
  double high_m = 2.0;
  int cells = 3;
};

OptionSet describe(SpanOptions& options) {
  OptionSet set;
  set.add("low_m", options.low_m, "from", 0.0, 10.0);
  set.add("high_m", options.high_m, "to", 0.0, 10.0);
  set.add("cells", options.cells, "number of cells", 0, 10);
  set.require({"low_m", "high_m"}, "the lower must be less than the higher",
              [&options] { return options.low_m < options.high_m; });
  set.require({"cells"}, "three is the number", [&options] { return options.cells == 3; });
  return set;
}

struct TwoSpans {
  SpanOptions near, far;
};

OptionSet describe(TwoSpans& options) {
  OptionSet set;
  set.add_group("near", describe(options.near));
  set.add_group("far", describe(options.far));
  return set;
}

TEST(Options, RulesBetweenFieldsAreCheckedAlsoInGroups) {
  TwoSpans options;
  EXPECT_TRUE(check_options(options));
  options.far.low_m = 2.0;
  const Status equal = check_options(options);
  ASSERT_FALSE(equal);
  EXPECT_EQ(equal.error().code, ErrorCode::kBadValue);
  EXPECT_EQ(equal.error().message(),
            "far.low_m, far.high_m: 2 and 2, but the lower must be less than the higher. Change "
            "one of them.");
  options.far.low_m = 1.0;
  options.near.cells = 4;
  EXPECT_EQ(check_options(options).error().message(),
            "near.cells: 4, but three is the number. Change it.");
  // A field out of range comes first: what it breaks is not a contradiction.
  options.near.low_m = 11.0;
  EXPECT_EQ(check_options(options).error().where, "near.low_m");
}

TEST(Options, RulesHoldWhenAllFieldsAreSetNotInBetween) {
  TwoSpans options;
  OptionSet set = describe(options);
  EXPECT_TRUE(set.set("near.low_m", "5"));  // above high_m, which follows
  EXPECT_FALSE(set.check());
  EXPECT_TRUE(set.set("near.high_m", "6"));
  EXPECT_TRUE(set.check());
}

TEST(Options, KnotsArePrintedToTheLastDigit) {
  OuterOptions options, copy;
  options.knots = {{{1.0 / 3.0, 1e-9}}, {{0.1 + 0.7, 1234567.25}}};
  const OptionSet from = describe(options);
  ASSERT_TRUE(describe(copy).set("knots", from.fields().back().print()));
  EXPECT_EQ(copy.knots, options.knots);
}

TEST(Options, AGroupIsNamedAsOneWithSomeOfItsOptions) {
  OuterOptions options;
  const Status group = describe(options).set("inner", "7");
  ASSERT_FALSE(group);
  EXPECT_EQ(group.error().message(),
            "inner: this is a group of options and has no value of its own. Name one of its 2 "
            "options: inner.window_px, inner.limit_m.");
  EXPECT_FALSE(describe(options).set("inne", "7").error().what.starts_with("this is a group"));
}

TEST(Options, RemedyThatAsksEndsWithItsQuestionMark) {
  OuterOptions options;
  EXPECT_EQ(describe(options).set("fil", "7").error().message(),
            "fil: unknown option. Did you mean 'fill'?");
}

// A value, the switch that chooses it, and a field that the program sets itself.
struct AutomaticOptions {
  int size = 64;
  bool auto_size = true;
  double reach_m = 6.0;
};

OptionSet describe(AutomaticOptions& options) {
  OptionSet group, set;
  group.add("size", options.size, "how many", 1, 1000);
  group.add_automatic("auto_size", options.auto_size, "choose size", "size");
  group.add("reach_m", options.reach_m, "how far");
  set.add_group("g", std::move(group));
  return set;
}

TEST(Options, AGivenValueTurnsOffWhatWouldChooseIt) {
  const auto after = [](const std::vector<std::vector<std::string>>& sources) {
    AutomaticOptions options;
    OptionSet set = describe(options);
    for (const auto& names : sources) {
      for (const std::string& name : names) {
        EXPECT_TRUE(set.set(name, name == "g.size" ? "80" : "true"));
      }
      set.settle();
    }
    return options.auto_size;
  };
  EXPECT_TRUE(after({}));
  EXPECT_TRUE(after({{"g.auto_size"}}));
  EXPECT_FALSE(after({{"g.size"}}));
  EXPECT_TRUE(after({{"g.size", "g.auto_size"}}));
  EXPECT_TRUE(after({{"g.auto_size", "g.size"}}));
  EXPECT_FALSE(after({{"g.size", "g.auto_size"}, {"g.size"}}));  // the later source says more
  EXPECT_TRUE(after({{"g.size"}, {"g.auto_size"}}));
  EXPECT_FALSE(after({{"g.size"}, {}}));
}

TEST(Options, KnowsWhatWasGiven) {
  AutomaticOptions options;
  OptionSet set = describe(options);
  EXPECT_FALSE(set.given("g.size"));
  EXPECT_FALSE(set.set("g.size", "0"));
  EXPECT_FALSE(set.given("g.size"));
  EXPECT_TRUE(set.set("g.size", "64"));  // the default, but given
  set.settle();
  EXPECT_TRUE(set.given("g.size"));
  EXPECT_FALSE(set.given("g.auto_size"));  // turned off, not given
  EXPECT_FALSE(set.given("g.nothing"));
}

}  // namespace
}  // namespace tread
