// Options as a user gives them: what is given wins, and --print-config is read back.
#include <cmath>

#include "command_test.hpp"
#include "tread/io/map_files.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;
using namespace testing;

int searched(const std::string& arguments) {
  const Ran ran = tread(arguments + " --json");
  EXPECT_EQ(ran.status, 0) << arguments << ran.err;
  return ran.status == 0 ? ran.json()["num_disparities"].get<int>() : -1;
}

TEST(TreadOptions, AGivenNumberOfDisparitiesWins) {
  const ScratchFolder scratch;
  ASSERT_TRUE(write_file(scratch / "o.yaml", "stereo: {sad: {num_disparities: 32}}\n"));
  ASSERT_TRUE(write_file(scratch / "both.yaml",
                         "auto_num_disparities: true\nstereo: {sad: {num_disparities: 32}}\n"));
  for (const std::string& base : {"depth " + pair_arguments(), "map " + drive().string()}) {
    EXPECT_GE(searched(base), 64) << base;
    EXPECT_EQ(searched(base + " --set stereo.sad.num_disparities=40"), 40) << base;
    EXPECT_EQ(searched(base + " --config " + (scratch / "o.yaml").string()), 32) << base;
    // Both named: widened from there, as the switch says.
    EXPECT_GE(searched(base + " --config " + (scratch / "both.yaml").string()), 64) << base;
    EXPECT_EQ(searched(base + " --config " + (scratch / "both.yaml").string() +
                       " --set stereo.sad.num_disparities=40"),
              40)
        << base;
  }
  EXPECT_EQ(searched("depth " + pair_arguments() + " --num-disparities 48"), 48);
  expect_refused(
      "depth " + pair_arguments() + " --num-disparities 48 --set stereo.sad.num_disparities=32",
      {"--num-disparities", "stereo.sad.num_disparities"});
}

TEST(TreadOptions, AGivenRangeAndAGivenCostOfTheUnexploredWin) {
  const ScratchFolder out;
  const std::string base = "map " + drive().string() + " --json ";
  // Where a quarter of a pixel is one cell: sqrt(0.1 m * 50 m px / 0.25 px) = 4.47 m.
  EXPECT_EQ(tread(base + "--set depth.max_depth_m=3").json()["range_m"], 3.0);
  EXPECT_NEAR(tread(base + "--set depth.max_depth_m=3 --set extend_range=true").json()["range_m"],
              std::sqrt(20.0), 1e-9);
  const auto saved = [&](const std::string& settings) {
    const std::string folder = (out / "m").string();
    EXPECT_EQ(tread(base + settings + " -o " + folder).status, 0);
    return load_map(folder).value().numbers.at("unexplored_cost");
  };
  EXPECT_EQ(saved("--set cost.unexplored_cost=8"), 8.0);
  EXPECT_EQ(saved("--set cost.unexplored_cost=8 --set plan.unexplored_cost=3"), 3.0);
}

TEST(TreadOptions, TheUnexploredCostOfThePlanIsThatOfTheUser) {
  const auto cost = [](const char* unexplored) {
    return tread("map " + drive().string() + " --json --set plan.unexplored_cost=" + unexplored)
        .json()["plan"]["cost"]
        .get<double>();
  };
  // Some twenty metres of the way lie beyond the map.
  EXPECT_NEAR(cost("9") - cost("3"), 6.0 * 20.0, 6.0);
}

TEST(TreadOptions, PrintedConfigurationsAreReadBackAndPrintedAgain) {
  const ScratchFolder out;
  ASSERT_EQ(tread("map " + drive().string() + " -o " + (out / "m").string() +
                  " --set plan.lethal_cost=33")
                .status,
            0);
  const std::pair<std::string, std::vector<std::string>> cases[] = {
      {"depth",
       {"", " --set stereo.sad.num_disparities=17", " --profile paper-q",
        " --num-disparities 99 --set depth.max_depth_m=7.30000000000001"}},
      {"map",
       {"", " --set cost.knots='0.0400000001:1 2:1e3' --set depth.max_depth_m=5",
        " --set plan.unexplored_cost=7 --set stereo.sad.num_disparities=99"}},
      {"plan", {"", " --set lethal_cost=6.1", " " + (out / "m").string()}}};
  for (const auto& [command, settings] : cases) {
    for (const std::string& setting : settings) {
      const Ran first = tread(command + " --print-config" + setting);
      ASSERT_EQ(first.status, 0) << command << setting << first.err;
      ASSERT_TRUE(write_file(out / "o.yaml", first.out));
      const Ran again = tread(command + " --print-config --config " + (out / "o.yaml").string());
      EXPECT_EQ(again.status, 0) << again.err;
      EXPECT_EQ(again.out, first.out) << command << setting;
    }
  }
  EXPECT_NE(tread("depth --print-config --num-disparities 99").out.find("num_disparities: 99 "),
            std::string::npos);
  EXPECT_NE(tread("plan --print-config " + (out / "m").string()).out.find("lethal_cost: 33 "),
            std::string::npos);
  expect_refused("map --print-config --set cost.window_m=-1", {"cost.window_m"});
}

TEST(TreadOptions, AGroupIsNamedAsOne) {
  expect_refused("map x --set stereo.sad=3", {"stereo.sad", "group", "stereo.sad.reference"});
  expect_refused("map x --set zzzzzzzzzzzzzzzzzz=3",
                 {"Known are: pose.(...), stereo.(...), shrink"});
}

TEST(TreadOptions, TheMethodIsChosenByItsName) {
  const auto density = [](const std::string& arguments) {
    const Ran ran = tread("depth " + pair_arguments() + " --json" + arguments);
    EXPECT_EQ(ran.status, 0) << arguments << ran.err;
    return ran.status == 0 ? ran.json()["density"].get<double>() : -1.0;
  };
  const double sad = density(""), sgm = density(" --method sgm");
  EXPECT_EQ(density(" --method sad"), sad);
  EXPECT_EQ(density(" --set stereo.method=sgm"), sgm);
  EXPECT_NE(sgm, sad);
  EXPECT_GT(sgm, 0.3);
  EXPECT_EQ(tread("map " + drive().string() + " --method sgm").status, 0);
  for (const std::string command : {"depth", "map"}) {
    EXPECT_NE(tread(command + " --print-config --method sgm").out.find("method: sgm "),
              std::string::npos);
    expect_refused(command + " a b --method sgbm", {"--method", "sgbm", "sad", "sgm"}, 2);
    expect_refused(command + " --print-config --method sad --set stereo.method=sgm",
                   {"--method", "stereo.method=sgm"});
  }
  expect_refused("depth --print-config --profile paper-q --method sgm",
                 {"stereo.method", "sad.reference"});
}

}  // namespace
}  // namespace tread
