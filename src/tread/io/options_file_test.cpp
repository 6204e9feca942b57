#include "tread/io/options_file.hpp"

#include <gtest/gtest.h>

#include "file_mutations.hpp"
#include "test_data.hpp"
#include "tread/io/atomic_file.hpp"

namespace tread {
namespace {

using testing::put_file;
using testing::ScratchFolder;

struct Inner {
  int window_px = 9;
  Knots knots = {{{0.0, 1.0}}, {{1.0, 2.0}}};
};
struct Outer {
  bool fill = true;
  Inner sad;
};
OptionSet describe(Outer& outer) {
  OptionSet inner, set;
  inner.add_odd("window_px", outer.sad.window_px, "side of the window", 3, 31);
  inner.add("knots", outer.sad.knots, "cost over derivative");
  set.add("fill", outer.fill, "fill holes");
  set.add_group("sad", std::move(inner));
  return set;
}

Status read(const std::string& text, Outer& outer) {
  const testing::ScratchFolder folder;
  EXPECT_TRUE(write_file(folder / "o.yaml", text));
  return read_options(folder / "o.yaml", describe(outer));
}

TEST(OptionsFile, NestedAndDottedKeysAreTheSame) {
  Outer a, b;
  EXPECT_TRUE(read("fill: no\nsad:\n  window_px: 13\n  knots: \"0:1 3:4\"\n", a));
  EXPECT_TRUE(read("{fill: false, sad.window_px: 13, sad.knots: '0:1 3:4'}", b));
  for (const Outer& o : {a, b}) {
    EXPECT_FALSE(o.fill);
    EXPECT_EQ(o.sad.window_px, 13);
    EXPECT_EQ(o.sad.knots.back()[1], 4.0);
  }
  EXPECT_TRUE(read("", a));
}

TEST(OptionsFile, ErrorsNameFileLineKeyAndTheNearestName) {
  Outer outer;
  const Status unknown = read("fill: true\nsad:\n  windw_px: 13\n", outer);
  ASSERT_FALSE(unknown);
  EXPECT_NE(unknown.error().message().find("o.yaml:3: sad.windw_px"), std::string::npos)
      << unknown.error().message();
  EXPECT_NE(unknown.error().message().find("'sad.window_px'"), std::string::npos);
  const Status range = read("sad: {window_px: 12}", outer);
  ASSERT_FALSE(range);
  EXPECT_NE(range.error().message().find("o.yaml:1: sad.window_px"), std::string::npos);
  EXPECT_EQ(outer.sad.window_px, 9);
  const Status twice = read("sad:\n  window_px: 13\n  window_px: 15\n", outer);
  ASSERT_FALSE(twice);
  EXPECT_NE(twice.error().message().find("o.yaml:3: sad.window_px: this is given twice"),
            std::string::npos)
      << twice.error().message();
  for (const char* text :
       {"[1, 2]", "fill: [1]", "just text", "a: {b: {", "fill: *nothing", "sad: 3", "? [1]\n: 2"}) {
    EXPECT_FALSE(read(text, outer)) << text;
  }
  EXPECT_FALSE(read_options("/nowhere/o.yaml", describe(outer)));
}

TEST(OptionsFile, WhatIsPrintedIsReadBack) {
  Outer outer, back;
  outer.fill = false;
  outer.sad.window_px = 21;
  outer.sad.knots = {{{0.5, 1.0}}, {{2.0, 7.0}}};
  const std::string text = options_as_yaml(describe(outer));
  EXPECT_NE(text.find("# side of the window; odd, 3 to 31"), std::string::npos);
  ASSERT_TRUE(read(text, back)) << text;
  EXPECT_FALSE(back.fill);
  EXPECT_EQ(back.sad.window_px, 21);
  EXPECT_EQ(back.sad.knots, outer.sad.knots);
}

TEST(OptionsFile, DamagedFilesAreCleanlyReadOrRefused) {
  const ScratchFolder folder;
  const std::string valid = "fill: no\nsad:\n  window_px: 13\n  knots: \"0:1 3:4\"\n";
  const auto take = [](const std::filesystem::path& path) {
    Outer outer;
    const Status done = read_options(path, describe(outer));
    EXPECT_TRUE(describe(outer).check()) << "whatever the file says, no field leaves its range";
    EXPECT_TRUE(done || done.error().where.find(path.string()) != std::string::npos);
    return done.has_value();
  };
  put_file(folder / "o.yaml", valid);
  ASSERT_TRUE(take(folder / "o.yaml"));
  testing::shorter_files_taken(valid, folder / "o.yaml", take);
  EXPECT_GT(testing::damaged_files_refused(valid, folder / "o.yaml", take), 1000);
}

// Aliases that double with every line, and brackets without end.
TEST(OptionsFile, EndlessFilesAreRefused) {
  const ScratchFolder folder;
  std::string aliases = "a0: &a0 {x: 1}\n";
  for (int i = 1; i < 40; ++i) {
    const std::string before = "*a" + std::to_string(i - 1);
    aliases += "a" + std::to_string(i) + ": &a" + std::to_string(i) + " {l: " + before +
               ", r: " + before + "}\n";
  }
  for (const std::string& text :
       {aliases, std::string(200'000, '['), std::string(200'000, '{'), std::string(100'000, '-'),
        std::string("a: &a [*a]\n"), std::string("&a a: *a\n")}) {
    Outer outer;
    put_file(folder / "o.yaml", text);
    EXPECT_FALSE(read_options(folder / "o.yaml", describe(outer))) << text.substr(0, 20);
  }
}

}  // namespace
}  // namespace tread
