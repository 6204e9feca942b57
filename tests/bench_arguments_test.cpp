#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <vector>

#include "arguments.hpp"

namespace tread {
namespace {

struct Given {
  bool json = false;
  int turns = 30;
  double length_m = 1.0;
  std::optional<int> status;
};

Given given(std::vector<std::string> words, bool with_options = true) {
  Given g;
  OptionSet set;
  set.add("length_m", g.length_m, "of something", 0.0, 10.0);
  bench::Arguments arguments("bench");
  arguments.flag("--json", g.json).number("--turns", g.turns, 3);
  if (with_options) arguments.options(set);
  words.insert(words.begin(), "bench");
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  g.status = arguments.read(static_cast<int>(argv.size()), argv.data());
  return g;
}

TEST(BenchArguments, AreRead) {
  EXPECT_FALSE(given({}).status);
  const Given all = given({"length_m=2.5", "--turns", "3", "--json"});
  EXPECT_FALSE(all.status);
  EXPECT_TRUE(all.json);
  EXPECT_EQ(all.turns, 3);
  EXPECT_EQ(all.length_m, 2.5);
}

TEST(BenchArguments, WhatIsNotKnownEndsTheProgram) {
  EXPECT_EQ(given({"--help"}).status, 0);
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{"--jsn"},
                                             {"--turns"},
                                             {"--turns", "2"},
                                             {"--turns", "3x"},
                                             {"width_m=3"},
                                             {"length_m=11"},
                                             {"length_m"}}) {
    const Given g = given(words);
    EXPECT_EQ(g.status, 2) << words[0];
    EXPECT_EQ(g.turns, 30);
    EXPECT_EQ(g.length_m, 1.0);
  }
  EXPECT_EQ(given({"length_m=2"}, false).status, 2) << "a benchmark without options";
}

}  // namespace
}  // namespace tread
