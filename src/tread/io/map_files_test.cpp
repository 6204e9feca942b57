#include "tread/io/map_files.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <bit>
#include <cmath>
#include <csignal>
#include <cstring>
#include <random>
#include <set>

#include "file_mutations.hpp"
#include "test_data.hpp"
#include "tread/io/atomic_file.hpp"
#include "tread/io/image_file.hpp"
#include "tread/io/raster_file.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;
using testing::get_file;
using testing::put_file;
using testing::ScratchFolder;

Grid<float> random_grid(double resolution_m, int columns, int rows, unsigned seed) {
  GridGeometry geometry;
  geometry.resolution_m = resolution_m;
  geometry.origin = {-1.0 / 3.0, 100.0 / 7.0};
  geometry.columns = columns;
  geometry.rows = rows;
  Grid<float> grid(geometry);
  std::mt19937 random(seed);
  for (float& value : grid.values) {
    value = random() % 5 == 0 ? NAN : static_cast<float>(random()) * 1e-9F;
  }
  return grid;
}

MapLayers some_map(unsigned seed = 1) {
  MapLayers map;
  map.frame = "field";
  map.layers = {{"height", "m", "height of the ground", random_grid(0.1, 31, 17, seed)},
                {"cost", "1", "cost of crossing", random_grid(0.3, 11, 6, seed + 1)},
                {"explored", "1", "1 where seen", random_grid(0.1, 31, 17, seed + 2)}};
  map.numbers = {{"lethal_cost", 4.0}, {"unexplored_cost", 0.1}};
  return map;
}

void expect_equal(const MapLayers& a, const MapLayers& b) {
  EXPECT_EQ(a.frame, b.frame);
  EXPECT_EQ(a.numbers, b.numbers);
  ASSERT_EQ(a.layers.size(), b.layers.size());
  for (std::size_t i = 0; i < a.layers.size(); ++i) {
    const MapLayer &x = a.layers[i], &y = b.layers[i];
    EXPECT_EQ(x.name, y.name);
    EXPECT_EQ(x.unit, y.unit);
    EXPECT_EQ(x.meaning, y.meaning);
    EXPECT_EQ(x.grid.geometry, y.grid.geometry);
    ASSERT_EQ(x.grid.values.size(), y.grid.values.size());
    EXPECT_EQ(std::memcmp(x.grid.values.data(), y.grid.values.data(),
                          x.grid.values.size() * sizeof(float)),
              0)
        << x.name;
  }
}

std::set<std::string> names_in(const fs::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) {
    names.insert(entry.path().filename().string());
  }
  return names;
}

TEST(MapFiles, RoundTripIsEqualToTheBit) {
  const ScratchFolder scratch;
  const fs::path folder = scratch / "new" / "map";
  const MapLayers map = some_map();
  ASSERT_TRUE(save_map(map, folder));
  EXPECT_EQ(
      names_in(folder),
      (std::set<std::string>{"map.yaml", "height.tif", "cost.tif", "explored.tif", "explored.png",
                             "nav2_map.pgm", "nav2_map.yaml", "nav2_cost.pgm", "nav2_cost.yaml"}));
  for (const fs::path& path : {folder, folder / "map.yaml"}) {
    const auto read = load_map(path);
    ASSERT_TRUE(read) << read.error().message();
    expect_equal(*read, map);
  }
  ASSERT_TRUE(save_map(MapLayers{}, scratch / "empty"));
  EXPECT_TRUE(load_map(scratch / "empty").value().layers.empty());
}

TEST(MapFiles, TheSameMapGivesTheSameFiles) {
  const ScratchFolder scratch;
  ASSERT_TRUE(save_map(some_map(), scratch / "a"));
  ASSERT_TRUE(save_map(some_map(), scratch / "b"));
  for (const std::string& name : names_in(scratch / "a")) {
    EXPECT_EQ(get_file(scratch / "a" / name), get_file(scratch / "b" / name)) << name;
  }
}

TEST(MapFiles, TheMaskIsAPictureWithYUp) {
  const ScratchFolder scratch;
  MapLayers map;
  GridGeometry geometry;
  geometry.columns = 2;
  geometry.rows = 2;
  map.layers = {{"explored", "1", "", Grid<float>(geometry)}};
  map.layers[0].grid.values = {1.0F, 0.0F, NAN, 0.0F};  // lower row, upper row
  ASSERT_TRUE(save_map(map, scratch / "map"));
  const auto image = read_grey(scratch / "map" / "explored.png");
  ASSERT_TRUE(image) << image.error().message();
  EXPECT_EQ((*image)(0, 1), 255);
  EXPECT_EQ((*image)(1, 1), 0);
  EXPECT_EQ((*image)(0, 0), 0);
}

TEST(MapFiles, AnEarlierMapIsReplacedAndForeignFilesStay) {
  const ScratchFolder scratch;
  const fs::path folder = scratch / "map";
  ASSERT_TRUE(save_map(some_map(), folder));
  put_file(folder / "notes.txt", "mine");
  put_file(folder / "photo.tif", "mine");
  MapLayers smaller;
  smaller.layers = {{"height", "m", "", random_grid(0.2, 5, 4, 9)}};
  ASSERT_TRUE(save_map(smaller, folder));
  EXPECT_EQ(names_in(folder),
            (std::set<std::string>{"map.yaml", "height.tif", "notes.txt", "photo.tif"}));
  expect_equal(load_map(folder).value(), smaller);
}

TEST(MapFiles, AMapIsAddedToAndRemovedFromALargerSet) {
  const ScratchFolder folder;
  put_file(folder / "notes.txt", "mine");
  FileSet set(folder.path());
  ASSERT_TRUE(add_map(some_map(), set));
  ASSERT_TRUE(write_file(set.add("more.txt"), "x"));
  EXPECT_FALSE(fs::exists(folder / "map.yaml"));  // not before the commit
  ASSERT_TRUE(set.commit());
  expect_equal(load_map(folder.path()).value(), some_map());
  EXPECT_EQ(get_file(folder / "more.txt"), "x");
  FileSet other(folder.path());
  remove_map(other);
  ASSERT_TRUE(other.commit());
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder.path())) {
    names.insert(entry.path().filename().string());
  }
  EXPECT_EQ(names, (std::set<std::string>{"more.txt", "notes.txt"}));
}

TEST(MapFiles, AFolderThatOnlyLooksLikeAMapLosesNothing) {
  const ScratchFolder scratch;
  const fs::path folder = scratch / "map";
  fs::create_directory(folder);
  put_file(folder / "map.yaml", "image: nav2_map.pgm\n");  // of a map server
  put_file(folder / "nav2_map.pgm", "mine");
  MapLayers map;
  map.layers = {{"height", "m", "", random_grid(0.2, 5, 4, 9)}};
  ASSERT_TRUE(save_map(map, folder));
  EXPECT_EQ(get_file(folder / "nav2_map.pgm"), "mine");
}

TEST(MapFiles, ASaveThatFailsLeavesTheEarlierMap) {
  const ScratchFolder scratch;
  const fs::path folder = scratch / "map";
  const MapLayers map = some_map();
  ASSERT_TRUE(save_map(map, folder));
  const auto before = names_in(folder);
  MapLayers large = some_map(50);
  large.layers.push_back({"large", "m", "", random_grid(0.1, 300, 300, 3)});
  auto* const old_handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit limit{};
  getrlimit(RLIMIT_FSIZE, &limit);
  rlimit small = limit;
  small.rlim_cur = 20000;  // a full disk: all but the large layer fit
  setrlimit(RLIMIT_FSIZE, &small);
  const Status failed = save_map(large, folder);
  setrlimit(RLIMIT_FSIZE, &limit);
  std::signal(SIGXFSZ, old_handler);
  ASSERT_FALSE(failed);
  EXPECT_EQ(failed.error().code, ErrorCode::kWriteFailed);
  EXPECT_EQ(failed.error().where, (folder / "large.tif").string());
  EXPECT_EQ(names_in(folder), before) << "something was left behind";
  expect_equal(load_map(folder).value(), map);
}

TEST(MapFiles, ASaverThatIsKilledLeavesOneOfBothMaps) {
  const ScratchFolder scratch;
  const fs::path folder = scratch / "map";
  const MapLayers first = some_map(1), second = some_map(50);
  ASSERT_TRUE(save_map(first, folder));
  for (int wait_us = 0; wait_us < 20000; wait_us += 1000) {
    const pid_t child = fork();
    if (child == 0) {
      for (;;) {
        if (!save_map(second, folder) || !save_map(first, folder)) _exit(1);
      }
    }
    usleep(static_cast<useconds_t>(wait_us));
    kill(child, SIGKILL);
    int status = 0;
    waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status)) << "a save failed";
    const auto read = load_map(folder);
    ASSERT_TRUE(read) << read.error().message();
    const bool is_first = std::memcmp(read->layers[0].grid.values.data(),
                                      first.layers[0].grid.values.data(), 4 * 31 * 17) == 0;
    expect_equal(*read, is_first ? first : second);
  }
}

TEST(MapFiles, AnInterruptedSaveIsCompletedByLoading) {
  const ScratchFolder scratch;
  const fs::path folder = scratch / "map";
  const MapLayers first = some_map(1), second = some_map(50);
  ASSERT_TRUE(save_map(first, folder));
  ASSERT_TRUE(save_map(second, scratch / "other"));
  // As the second save leaves it that dies behind its first rename.
  const std::string token = "00112233445566ff";
  std::string journal = "tread journal 1\ntoken " + token + "\n";
  bool renamed = false;
  for (const std::string& name : names_in(scratch / "other")) {
    const std::string bytes = get_file(scratch / "other" / name);
    put_file(renamed ? folder / (".tread-" + token + "-" + name) : folder / name, bytes);
    renamed = true;
    journal += "rename " + name + "\n";
  }
  put_file(folder / ".tread-journal", journal + "end\n");
  const auto read = load_map(folder);
  ASSERT_TRUE(read) << read.error().message();
  expect_equal(*read, second);
  EXPECT_EQ(names_in(folder), names_in(scratch / "other"));
}

TEST(MapFiles, MapsThatCannotBeSavedAreRefused) {
  const ScratchFolder scratch;
  const auto error = [&](const MapLayers& map) {
    const Status status = save_map(map, scratch / "map");
    EXPECT_FALSE(status);
    return status ? Error{} : status.error();
  };
  MapLayers map = some_map();
  map.layers[1].name = "../cost";
  EXPECT_EQ(error(map).code, ErrorCode::kBadArgument);
  map.layers[1].name = "height";
  EXPECT_EQ(error(map).where, "height");
  map = some_map();
  map.layers[0].grid.values.pop_back();
  EXPECT_EQ(error(map).where, (scratch / "map" / "height.tif").string());
  map = some_map();
  map.numbers["lethal_cost"] = 0.5;
  EXPECT_EQ(error(map).where, "numbers.lethal_cost");
  EXPECT_TRUE(names_in(scratch / "map").empty());
  put_file(scratch / "file", "x");
  EXPECT_EQ(save_map(some_map(), scratch / "file").error().code, ErrorCode::kWriteFailed);
}

TEST(MapFiles, WhatIsWrongInTheFolderIsNamed) {
  const ScratchFolder scratch;
  const fs::path folder = scratch / "map";
  EXPECT_EQ(load_map(folder).error().code, ErrorCode::kNotFound);
  ASSERT_TRUE(save_map(some_map(), folder));
  const std::string yaml = get_file(folder / "map.yaml");
  const auto error_with = [&](const std::string& from, const std::string& to) {
    std::string changed = yaml;
    changed.replace(changed.find(from), from.size(), to);
    put_file(folder / "map.yaml", changed);
    const auto read = load_map(folder);
    EXPECT_FALSE(read) << to;
    return read ? Error{} : read.error();
  };
  const Error wrong_size = error_with("[31, 17]", "[30, 17]");
  EXPECT_EQ(wrong_size.where, (folder / "height.tif").string());
  EXPECT_NE(wrong_size.what.find("31x17"), std::string::npos);
  EXPECT_EQ(error_with("resolution_m: 0.1", "resolution_m: 0.101").where,
            (folder / "height.tif").string());
  EXPECT_EQ(error_with("origin_m: [-0.333", "origin_m: [-0.433").where,
            (folder / "height.tif").string());
  EXPECT_EQ(error_with("tread_map: 1", "tread_map: 7").code, ErrorCode::kUnsupported);
  EXPECT_NE(error_with("frame", "fame").message().find("Did you mean 'frame'"), std::string::npos);
  put_file(folder / "map.yaml", yaml);
  ASSERT_TRUE(load_map(folder));
  fs::remove(folder / "cost.tif");
  const auto missing = load_map(folder);
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound);
  EXPECT_EQ(missing.error().where, (folder / "cost.tif").string());
  put_file(folder / ".tread-journal", "nonsense");
  EXPECT_FALSE(load_map(folder));
  EXPECT_FALSE(save_map(some_map(), folder)) << "an unreadable journal was overwritten";
}

}  // namespace
}  // namespace tread
