#include "report.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "test_data.hpp"

namespace tread {
namespace {

// The first fault of the page: a tag that is not closed, or closed in the wrong order; a stray
// sign. Empty if there is none. What is in style and script is not markup.
std::string first_fault(const std::string& page) {
  std::vector<std::string> open;
  std::size_t at = 0;
  while ((at = page.find_first_of("<>", at)) != std::string::npos) {
    if (page[at] == '>') return "stray > at " + std::to_string(at);
    const std::size_t end = page.find('>', at);
    if (end == std::string::npos) return "unclosed < at " + std::to_string(at);
    const std::string inner = page.substr(at + 1, end - at - 1);
    if (inner.find('<') != std::string::npos) return "< inside of tag: " + inner;
    at = end + 1;
    if (inner == "!DOCTYPE html" || inner.back() == '/') continue;
    const std::string name = inner.substr(0, inner.find_first_of(" \n"));
    if (name[0] == '/') {
      if (open.empty() || "/" + open.back() != name) return "unexpected " + name;
      open.pop_back();
      continue;
    }
    open.push_back(name);
    if (name == "style" || name == "script") at = page.find("</" + name, at);
  }
  return open.empty() ? "" : "never closed: " + open.back();
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) {
    ++found;
  }
  return found;
}

Report full_report() {
  Report report("Title <&>", "sub \"title\"");
  report.set_command("tread map 'a b' -o <out> && echo done");
  report.set_footer("two cores");
  report.add_key_numbers({{"path", "12.5", "m"}, {"frames", "30", ""}});
  report.add_section("Stereo", "what & how");
  Image<Rgb> picture(8, 6, Rgb{10, 20, 30});
  ColourScale scale;
  scale.label = "height";
  scale.unit = "m";
  scale.lethal_from = 50.0F;
  Grid<float> grid(GridGeometry{0.5, {1.0, 2.0}, 4, 3}, 0.25F);
  grid[{3, 0}] = std::numeric_limits<float>::quiet_NaN();
  report.add_figure(picture, {.title = "Map",
                              .caption = "c > d",
                              .scale = scale,
                              .values = values_under(grid),
                              .marks = {{kPathColour, "path"}}});
  report.add_figure(picture, {.title = "Plain", .caption = "nothing else", .wide = true});
  report.add_note("a note");
  report.add_note("a <warning>", NoteKind::kWarning);
  report.add_section("Numbers");
  report.add_quantities("Quantities", {{"camera height", "1.1 m", true, "not given"},
                                       {"baseline", "0.5 m", false, "rig.yaml"}});
  report.add_table(
      {"Table", {"pair", "bad [%]", "remark"}, {{"cones", "3.2"}, {"<b>", "-1", "x"}}});
  Timings timings;
  timings.add("stereo/match", 4.0);
  timings.add("stereo/match", 2.0);
  timings.add("plan", 1.5);
  report.add_timings(timings);
  report.add_figure(picture, {.title = "Last", .caption = "at the end"});
  return report;
}

TEST(WellFormed, TheCheckerSeesFaults) {
  EXPECT_EQ(first_fault("<p>a<br /></p><script>if (a < b > c) x();</script>"), "");
  EXPECT_NE(first_fault("<p><b>a</p></b>"), "");
  EXPECT_NE(first_fault("<p>"), "");
  EXPECT_NE(first_fault("<p>a > b</p>"), "");
  EXPECT_NE(first_fault("<p>a < b</p>"), "");
}

TEST(Report, IsWellFormedAndSelfContained) {
  const Result<std::string> page = full_report().html();
  ASSERT_TRUE(page);
  EXPECT_EQ(first_fault(*page), "");
  EXPECT_EQ(count(*page, "http"), 0U);
  EXPECT_EQ(count(*page, "url("), 0U);
  EXPECT_EQ(count(*page, "@import"), 0U);
  EXPECT_EQ(count(*page, " src=\""), 3U);
  EXPECT_EQ(count(*page, " src=\"data:image/png;base64,iVBORw0KGgo"), 3U);
  const Result<std::string> empty = Report("", "").html();
  ASSERT_TRUE(empty);
  EXPECT_EQ(first_fault(*empty), "");
}

TEST(Report, TextIsEscaped) {
  const std::string page = *full_report().html();
  EXPECT_EQ(count(page, "<h1>Title &lt;&amp;&gt;</h1>"), 1U);
  EXPECT_EQ(count(page, "sub &quot;title&quot;"), 1U);
  EXPECT_EQ(count(page, "-o &lt;out&gt; &amp;&amp; echo done"), 1U);
  EXPECT_EQ(count(page, "<td>&lt;b&gt;</td>"), 1U);
  EXPECT_EQ(count(page, "a &lt;warning&gt;"), 1U);
}

TEST(Report, WhatWasAssumedCarriesABadge) {
  const std::string page = *full_report().html();
  EXPECT_EQ(count(page, "1.1 m <span class=\"badge\">assumed</span>"), 1U);
  EXPECT_EQ(count(page, ">assumed<"), 1U);
}

TEST(Report, SectionsAreLinked) {
  const std::string page = *full_report().html();
  EXPECT_EQ(count(page, "<a href=\"#s1\">Stereo</a>"), 1U);
  EXPECT_EQ(count(page, "<section id=\"s1\">"), 1U);
  EXPECT_EQ(count(page, "<a href=\"#s2\">Numbers</a>"), 1U);
  EXPECT_EQ(count(page, "<section id=\"s2\">"), 1U);
  Report one("t", "s");
  one.add_section("Only");
  EXPECT_EQ(count(*one.html(), "<nav>"), 0U);
}

TEST(Report, LegendsSayRangeUnitAndMarks) {
  const std::string page = *full_report().html();
  EXPECT_EQ(count(page, "<span>0</span><span class=\"name\">height [m]</span><span>1</span>"), 1U);
  EXPECT_EQ(count(page, "#00e0ff\"></i>path"), 1U);
  EXPECT_EQ(count(page, "lethal, from 50 m"), 1U);
  EXPECT_EQ(count(page, "</i>unknown"), 1U);
  EXPECT_EQ(count(page, hex_colour(palette_colour(Palette::kHeight, 0.5))), 1U);
}

TEST(Report, TablesSetNumbersToTheRightAndFillShortRows) {
  const std::string page = *full_report().html();
  EXPECT_EQ(count(page, "<th>pair</th><th class=\"num\">bad [%]</th><th>remark</th>"), 1U);
  EXPECT_EQ(count(page, "<td>cones</td><td class=\"num\">3.2</td><td></td>"), 1U);
}

TEST(Report, TimesAreThoseMeasured) {
  const std::string page = *full_report().html();
  EXPECT_EQ(count(page,
                  "<td>stereo/match</td><td class=\"num\">2</td><td class=\"num\">3.00</td>"
                  "<td class=\"num\">4.00</td><td class=\"num\">6.0</td>"),
            1U);
  EXPECT_EQ(count(page, "width:100.0%"), 1U);
  EXPECT_EQ(count(page, "width:25.0%"), 1U);
}

std::string attribute(const std::string& page, const std::string& name) {
  const std::string start = " data-" + name + "=\"";
  const std::size_t at = page.find(start);
  if (at == std::string::npos) return "none";
  const std::size_t from = at + start.size();
  return page.substr(from, page.find('"', from) - from);
}

std::vector<int> decode_values(const std::string& base64) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned bits = 0;
  int have = 0;
  for (const char c : base64) {
    if (c == '=') break;
    bits = bits << 6 | static_cast<unsigned>(digits.find(c));
    have += 6;
    if (have < 8) continue;
    have -= 8;
    bytes += static_cast<char>(bits >> have & 255U);
  }
  std::vector<int> values;
  for (std::size_t i = 0; i + 1 < bytes.size(); i += 2) {
    values.push_back(static_cast<unsigned char>(bytes[i]) +
                     256 * static_cast<unsigned char>(bytes[i + 1]));
  }
  return values;
}

TEST(Report, ValuesForThePointerAreThoseOfTheMap) {
  Grid<float> grid(GridGeometry{0.5, {1.0, 2.0}, 4, 3});
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 4; ++x) grid[{x, y}] = static_cast<float>(10 * y + x);
  }
  grid[{3, 0}] = std::numeric_limits<float>::quiet_NaN();
  Report report("t", "s");
  report.add_figure(Image<Rgb>(4, 3), {.title = "m", .caption = "", .values = values_under(grid)});
  const std::string page = *report.html();
  EXPECT_EQ(attribute(page, "frame"), "map");
  EXPECT_EQ(attribute(page, "corners"), "1 3.5 3 2");
  EXPECT_EQ(attribute(page, "size"), "4 3 1 4");
  EXPECT_EQ(attribute(page, "range"), "0 23");
  EXPECT_EQ(attribute(page, "scale"), "none");
  const std::vector<int> values = decode_values(attribute(page, "values"));
  ASSERT_EQ(values.size(), 12U);
  for (int row = 0; row < 3; ++row) {
    for (int x = 0; x < 4; ++x) {
      const int code = values[static_cast<std::size_t>(4 * row + x)];
      const float expected = grid[{x, 2 - row}];
      if (std::isnan(expected)) {
        EXPECT_EQ(code, 0);
      } else {
        EXPECT_NEAR((code - 1) / 65534.0 * 23.0, expected, 23.0 / 65534.0);
      }
    }
  }
}

TEST(Report, ManyValuesAreThinned) {
  Image<float> values(1001, 700);
  for (int y = 0; y < 700; ++y) {
    for (int x = 0; x < 1001; ++x) values(x, y) = static_cast<float>(x);
  }
  Report report("t", "s");
  report.add_figure(Image<Rgb>(10, 7),
                    {.title = "d", .caption = "", .values = values_under(values)});
  const std::string page = *report.html();
  EXPECT_EQ(attribute(page, "axis"), "px");
  EXPECT_EQ(attribute(page, "corners"), "-0.5 -0.5 1000.5 699.5");
  EXPECT_EQ(attribute(page, "size"), "1001 700 3 334");
  const std::vector<int> codes = decode_values(attribute(page, "values"));
  ASSERT_EQ(codes.size(), 334U * 234U);
  // The middle one of each three, and the last that is there.
  EXPECT_NEAR((codes[5] - 1) / 65534.0 * 1000.0, 16.0, 0.02);
  EXPECT_NEAR((codes[333] - 1) / 65534.0 * 1000.0, 1000.0, 0.02);
}

TEST(Report, APictureThatCannotBeEncodedIsAnError) {
  Report report("t", "s");
  report.add_figure(Image<Rgb>(), {.title = "empty", .caption = ""});
  EXPECT_FALSE(report.html());
  testing::ScratchFolder folder;
  EXPECT_FALSE(report.write(folder / "report.html"));
  EXPECT_FALSE(std::filesystem::exists(folder / "report.html"));
}

TEST(Report, WritesWhatItSays) {
  testing::ScratchFolder folder;
  const Report report = full_report();
  ASSERT_TRUE(report.write(folder / "report.html"));
  std::ifstream file(folder / "report.html", std::ios::binary);
  std::stringstream text;
  text << file.rdbuf();
  EXPECT_EQ(text.str(), *report.html());
  EXPECT_FALSE(report.write(folder / "missing" / "report.html"));
}

}  // namespace
}  // namespace tread
