#include "tread/io/nav2_map.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <map>
#include <sstream>

namespace tread {
namespace {

// What a map server publishes, after its published description: p = (255 - pixel) / 255 (negate:
// p = pixel / 255). trinary: 100 above occupied_thresh, 0 below free_thresh, else -1; scale: in
// between linear from 0 to 100; raw: the pixel itself from 0 to 100, else -1. Row 0 of the answer
// is the lowest.
struct Occupancy {
  int width = 0, height = 0;
  std::vector<int> values;
  [[nodiscard]] int at(int x, int y) const {
    return values.at(static_cast<std::size_t>(y * width + x));
  }
};

std::map<std::string, std::string> keys_of(const std::string& yaml) {
  std::map<std::string, std::string> keys;
  std::istringstream lines(yaml);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t colon = line.find(": ");
    EXPECT_NE(colon, std::string::npos) << line;
    keys[line.substr(0, colon)] = line.substr(colon + 2);
  }
  return keys;
}

Occupancy serve(const std::string& yaml, const std::string& pgm, std::string mode = "") {
  const auto keys = keys_of(yaml);
  if (mode.empty()) mode = keys.at("mode");
  const double occupied = std::stod(keys.at("occupied_thresh"));
  const double free = std::stod(keys.at("free_thresh"));
  const bool negate = keys.at("negate") == "1";
  Occupancy map;
  int largest = 0, head = 0;
  EXPECT_EQ(std::sscanf(pgm.c_str(), "P5 %d %d %d%n", &map.width, &map.height, &largest, &head), 3);
  EXPECT_EQ(largest, 255);
  const std::string pixels = pgm.substr(static_cast<std::size_t>(head) + 1);
  EXPECT_EQ(pixels.size(), static_cast<std::size_t>(map.width * map.height));
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const auto at = static_cast<std::size_t>((map.height - 1 - y) * map.width + x);
      const int pixel = static_cast<unsigned char>(pixels.at(at));
      const double p = (negate ? pixel : 255 - pixel) / 255.0;
      int value = -1;
      if (mode == "raw") {
        value = pixel <= 100 ? pixel : -1;
      } else if (p > occupied) {
        value = 100;
      } else if (p < free) {
        value = 0;
      } else if (mode == "scale") {
        value = static_cast<int>(std::rint((p - free) / (occupied - free) * 100.0));
      }
      map.values.push_back(value);
    }
  }
  return map;
}

Grid<float> costs() {
  GridGeometry geometry;
  geometry.resolution_m = 0.3;
  geometry.origin = {-1.5, 2.25};
  geometry.columns = 5;
  geometry.rows = 2;
  Grid<float> grid(geometry);
  grid.values = {1.0F,   0.5F, 11.0F,    21.0F,  NAN,         // y = 0
                 20.99F, 6.0F, INFINITY, 100.0F, -INFINITY};  // y = 1
  return grid;
}

TEST(Nav2Map, FreeOccupiedAndUnknownAreReadRightInModeTrinary) {
  const auto files = make_nav2_files(costs(), 21.0);
  ASSERT_TRUE(files) << files.error().message();
  const Occupancy map = serve(files->map_yaml, files->map_pgm);
  EXPECT_EQ(map.values, (std::vector<int>{0, 0, 0, 100, -1, 0, 0, 100, 100, 0}));
  // Who forces the mode scale on it gets free and occupied right, and the unknown as free.
  const Occupancy scaled = serve(files->map_yaml, files->map_pgm, "scale");
  EXPECT_EQ(scaled.values, (std::vector<int>{0, 0, 0, 100, 0, 0, 0, 100, 100, 0}));
}

TEST(Nav2Map, GradedCostsAreReadRightInModeRaw) {
  const auto files = make_nav2_files(costs(), 21.0);
  ASSERT_TRUE(files) << files.error().message();
  EXPECT_EQ(keys_of(files->cost_yaml).at("mode"), "raw");
  const Occupancy map = serve(files->cost_yaml, files->cost_pgm);
  // 11 is half way from 1 to 21, 6 a quarter; just below lethal is not lethal.
  EXPECT_EQ(map.values, (std::vector<int>{0, 0, 50, 100, -1, 99, 25, 100, 100, 0}));
  EXPECT_EQ(map.at(2, 0), 50) << "row 0 is the lowest y";
}

TEST(Nav2Map, TheDescriptionHoldsPlaceAndFile) {
  const auto files = make_nav2_files(costs(), 21.0);
  ASSERT_TRUE(files);
  const auto keys = keys_of(files->map_yaml);
  EXPECT_EQ(keys.at("image"), "nav2_map.pgm");
  EXPECT_EQ(keys.at("resolution"), "0.3");
  EXPECT_EQ(keys.at("origin"), "[-1.5, 2.25, 0.0]");
  EXPECT_EQ(keys_of(files->cost_yaml).at("image"), "nav2_cost.pgm");
}

TEST(Nav2Map, CostsWithoutARangeOrCellsAreRefused) {
  for (const double lethal :
       {1.0, 0.0, -5.0, static_cast<double>(NAN), static_cast<double>(INFINITY)}) {
    const auto files = make_nav2_files(costs(), lethal);
    ASSERT_FALSE(files);
    EXPECT_EQ(files.error().where, "numbers.lethal_cost");
  }
  EXPECT_FALSE(make_nav2_files(Grid<float>(), 100.0));
}

}  // namespace
}  // namespace tread
