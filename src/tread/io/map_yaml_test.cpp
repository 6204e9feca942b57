#include "tread/io/map_yaml.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "file_mutations.hpp"

namespace tread {
namespace {

MapLayers some_map() {
  MapLayers map;
  map.frame = "world \"2\"\n\\ \x01 \xc3\xa4";
  GridGeometry fine;
  fine.resolution_m = 0.1;
  fine.origin = {-1.0 / 3.0, 1e-17};
  fine.columns = 7;
  fine.rows = 5;
  GridGeometry coarse = fine;
  coarse.resolution_m = 0.30000000000000004;
  MapLayer height{"height", "m", "height: of the # ground", {}};
  height.grid.geometry = fine;
  MapLayer cost{"cost-2_x", "", "", {}};
  cost.grid.geometry = coarse;
  map.layers = {height, cost};
  map.numbers = {{"lethal_cost", 1.0 / 7.0},
                 {"with blank: and colon", -0.0},
                 {"infinite", INFINITY},
                 {"lowest", -INFINITY},
                 {"none", NAN},
                 {"large", 1e300}};
  return map;
}

TEST(MapYaml, WhatIsPrintedIsReadBackEqual) {
  const MapLayers map = some_map();
  const std::string text = print_map_yaml(map);
  const auto index = parse_map_yaml(text, "map.yaml");
  ASSERT_TRUE(index) << index.error().message() << "\n" << text;
  EXPECT_EQ(index->map.frame, map.frame);
  ASSERT_EQ(index->map.layers.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(index->map.layers[i].name, map.layers[i].name);
    EXPECT_EQ(index->map.layers[i].unit, map.layers[i].unit);
    EXPECT_EQ(index->map.layers[i].meaning, map.layers[i].meaning);
    EXPECT_EQ(index->map.layers[i].grid.geometry, map.layers[i].grid.geometry);
    EXPECT_EQ(index->files[i], map.layers[i].name + ".tif");
  }
  ASSERT_EQ(index->map.numbers.size(), map.numbers.size());
  for (const auto& [name, value] : map.numbers) {
    const double read = index->map.numbers.at(name);
    EXPECT_TRUE(read == value || (std::isnan(read) && std::isnan(value))) << name;
    EXPECT_EQ(std::signbit(read), std::signbit(value)) << name;
  }
  EXPECT_EQ(print_map_yaml(index->map), text);
  EXPECT_TRUE(parse_map_yaml(print_map_yaml(MapLayers{}), "x").value().map.layers.empty());
}

TEST(MapYaml, IsTheDocumentedText) {
  const auto index = parse_map_yaml(
      "tread_map: 1                   # version of the format\n"
      "frame: world\nlayers:\n  height:\n    file: height.tif\n    unit: m\n"
      "    meaning: height of the ground\n    resolution_m: 0.1\n    origin_m: [-3, 2.5]\n"
      "    size_cells: [100, 80]\nnumbers:\n  lethal_cost: 100\n",
      "map.yaml");
  ASSERT_TRUE(index) << index.error().message();
  const GridGeometry& g = index->map.layers.at(0).grid.geometry;
  EXPECT_EQ(g.origin, Eigen::Vector2d(-3.0, 2.5));
  EXPECT_EQ(g.columns, 100);
  EXPECT_EQ(g.rows, 80);
  EXPECT_EQ(index->map.numbers.at("lethal_cost"), 100.0);
}

TEST(MapYaml, WhatIsWrongIsNamedWithItsLine) {
  const std::string good =
      "tread_map: 1\nframe: w\nlayers:\n  a:\n    file: a.tif\n    unit: m\n    meaning: x\n"
      "    resolution_m: 0.1\n    origin_m: [0, 0]\n    size_cells: [2, 3]\n";
  ASSERT_TRUE(parse_map_yaml(good, "f"));
  struct Case {
    const char* from;
    const char* to;
    ErrorCode code;
    const char* message;
  };
  for (const Case& c : {
           Case{"tread_map: 1", "tread_map: 2", ErrorCode::kUnsupported,
                "f:1: tread_map: a map of version 2"},
           Case{"tread_map: 1", "tread_map: 0", ErrorCode::kBadValue, "no version 0"},
           Case{"tread_map: 1", "tread_map: one", ErrorCode::kBadValue, "'one'"},
           Case{"tread_map: 1\n", "", ErrorCode::kBadFormat, "not a map of tread"},
           Case{"frame: w", "fram: w", ErrorCode::kBadFormat, "'frame'"},
           Case{"frame: w", "frame: w\nframe: v", ErrorCode::kBadFormat, "twice"},
           Case{"frame: w\n", "", ErrorCode::kNotFound, "'frame' is missing"},
           Case{"frame: w", "frame: [w]", ErrorCode::kBadFormat, "f:2: frame: expected a text"},
           Case{"unit: m", "units: m", ErrorCode::kBadFormat,
                "f:6: layers.a.units: unknown name. Did you mean 'unit'"},
           Case{"    unit: m\n", "", ErrorCode::kNotFound, "'unit' is missing"},
           Case{"  a:", "  a/b:", ErrorCode::kBadValue, "'a/b' is not a name of a layer"},
           Case{"file: a.tif", "file: ../a.tif", ErrorCode::kBadValue,
                "f:5: layers.a.file: '../a.tif'"},
           Case{"file: a.tif", "file: /etc/x", ErrorCode::kBadValue, "not a file of this folder"},
           Case{"0.1", "0", ErrorCode::kBadValue, "f:8: layers.a.resolution_m: 0"},
           Case{"0.1", "-1", ErrorCode::kBadValue, "not a resolution"},
           Case{"0.1", ".inf", ErrorCode::kBadValue, "resolution_m"},
           Case{"[0, 0]", "[0, .nan]", ErrorCode::kBadValue, "origin_m"},
           Case{"[0, 0]", "[0, 0, 0]", ErrorCode::kBadFormat, "origin_m"},
           Case{"[2, 3]", "[2, 0]", ErrorCode::kBadValue, "f:10: layers.a.size_cells: 0"},
           Case{"[2, 3]", "[2, 2.5]", ErrorCode::kBadValue, "2.5"},
           Case{"[2, 3]", "[1e9, 3]", ErrorCode::kBadValue, "size_cells"},
           Case{"[2, 3]", "[2, 3]\nnumbers: 5", ErrorCode::kBadFormat, "numbers"},
           Case{"[2, 3]", "[2, 3]\nnumbers:\n  n: five", ErrorCode::kBadValue,
                "f:12: numbers.n: 'five'"},
           Case{"[2, 3]", "[2, 3", ErrorCode::kBadFormat, "YAML"},
           Case{"layers:\n", "layers: 5\nx:\n", ErrorCode::kBadFormat, ""},
       }) {
    std::string text = good;
    text.replace(text.find(c.from), std::string(c.from).size(), c.to);
    const auto index = parse_map_yaml(text, "f");
    ASSERT_FALSE(index) << text;
    EXPECT_EQ(index.error().code, c.code) << index.error().message();
    EXPECT_NE(index.error().message().find(c.message), std::string::npos)
        << index.error().message() << " lacks " << c.message;
    EXPECT_FALSE(index.error().remedy.empty());
  }
  EXPECT_FALSE(parse_map_yaml("", "f"));
  EXPECT_FALSE(parse_map_yaml("just a text", "f"));
  EXPECT_FALSE(parse_map_yaml("[1, 2]", "f"));
  EXPECT_FALSE(parse_map_yaml("tread_map: 1\nframe: w\n", "f"));
  EXPECT_FALSE(parse_map_yaml("tread_map: 1\nframe: w\nlayers: 5\n", "f"));
}

TEST(MapYaml, NamesOfLayersAreNamesOfFiles) {
  for (const char* name : {"height", "cost_2", "a-b", "7"}) EXPECT_TRUE(is_layer_name(name));
  for (const char* name : {"", ".", "..", "a.b", "a/b", "a b", "\xc3\xa4"}) {
    EXPECT_FALSE(is_layer_name(name)) << name;
  }
  EXPECT_FALSE(is_layer_name(std::string(101, 'a')));
}

TEST(MapYaml, DamagedTextIsCleanlyReadOrRefused) {
  const std::string valid = print_map_yaml(some_map());
  for (std::size_t size = 0; size < valid.size(); ++size) {
    (void)parse_map_yaml(valid.substr(0, size), "f");
  }
  std::mt19937 random(1);
  int refused = 0;
  for (int i = 0; i < 2000; ++i) {
    const auto index = parse_map_yaml(testing::damaged(valid, random), "f");
    if (!index) {
      ++refused;
      continue;
    }
    for (const MapLayer& layer : index->map.layers) {
      EXPECT_GT(layer.grid.geometry.columns, 0);
      EXPECT_TRUE(layer.grid.geometry.origin.allFinite());
    }
  }
  EXPECT_GT(refused, 700);
}

}  // namespace
}  // namespace tread
