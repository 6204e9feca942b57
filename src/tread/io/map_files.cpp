#include "tread/io/map_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "tread/io/atomic_file.hpp"
#include "tread/io/image_file.hpp"
#include "tread/io/map_yaml.hpp"
#include "tread/io/nav2_map.hpp"
#include "tread/io/raster_file.hpp"
#include "tread/io/text.hpp"

namespace tread {
namespace {

namespace fs = std::filesystem;

constexpr const char* kIndexName = "map.yaml";
constexpr std::size_t kLargestIndex = std::size_t{1} << 20;
constexpr const char* kNeedsMemory = "Give it more memory, or cut the map into smaller ones";

// What save_map may write beside the layers and map.yaml.
constexpr std::array<const char*, 5> kCompanions = {"explored.png", "nav2_map.pgm", "nav2_map.yaml",
                                                    "nav2_cost.pgm", "nav2_cost.yaml"};

Status check_map(const MapLayers& map) {
  std::set<std::string> names;
  for (const MapLayer& layer : map.layers) {
    if (!is_layer_name(layer.name)) {
      return fail(ErrorCode::kBadArgument, in_quotes(layer.name) + " is not a name of a layer",
                  "layer", "Use letters, digits, '_' and '-'");
    }
    if (!names.insert(layer.name).second) {
      return fail(ErrorCode::kBadArgument, "there are two layers of this name", layer.name,
                  "Rename one");
    }
  }
  return {};
}

class MapWriter {
 public:
  explicit MapWriter(FileSet& set) : folder_(set.folder()), set_(set) {}

  Status write(const std::string& name, std::string_view bytes) {
    return named(write_file(add(name), bytes), name);
  }
  Status write_layer(const MapLayer& layer) {
    const std::string name = layer.name + ".tif";
    return named(write_geotiff(add(name), layer.grid), name);
  }
  Status write_mask(const MapLayer& layer) {
    const GridGeometry& g = layer.grid.geometry;
    Image<std::uint8_t> image(g.columns, g.rows);
    for (int y = 0; y < g.rows; ++y) {
      for (int x = 0; x < g.columns; ++x) {
        image(x, g.rows - 1 - y) = layer.grid[Cell{x, y}] > 0.5F ? 255 : 0;
      }
    }
    const std::string name = layer.name + ".png";
    return named(write_png(add(name), image), name);
  }
  // Of the earlier map in the folder what the new one does not replace.
  void remove_old(const std::vector<std::string>& old_files) {
    for (const std::string& name : old_files) {
      std::error_code ignored;
      if (!written_.contains(name) && fs::exists(folder_ / name, ignored)) set_.remove(name);
    }
  }

 private:
  fs::path add(const std::string& name) {
    written_.insert(name);
    return set_.add(name);
  }
  // Messages shall name the file and not the temporary one.
  Status named(Status status, const std::string& name) const {
    if (!status) status.error().where = (folder_ / name).string();
    return status;
  }

  fs::path folder_;
  FileSet& set_;
  std::set<std::string> written_;
};

// The files of the map that is in the folder; none if there is no map that can be understood.
std::vector<std::string> files_of_old_map(const fs::path& folder) {
  const auto text = read_file(folder / kIndexName, kLargestIndex);
  if (!text) return {};
  const auto index = parse_map_yaml(*text, kIndexName);
  if (!index) return {};
  std::vector<std::string> files(kCompanions.begin(), kCompanions.end());
  for (std::size_t i = 0; i < index->files.size(); ++i) {
    // Only what save_map itself would have called so.
    if (index->files[i] == index->map.layers[i].name + ".tif") files.push_back(index->files[i]);
  }
  return files;
}

Status write_nav2(MapWriter& writer, const MapLayers& map, const MapLayer& cost) {
  const auto lethal = map.numbers.find("lethal_cost");
  const auto files =
      make_nav2_files(cost.grid, lethal == map.numbers.end() ? 100.0 : lethal->second);
  if (!files) return forward(files);
  const std::array<std::pair<const char*, const std::string*>, 4> named = {
      {{"nav2_map.pgm", &files->map_pgm},
       {"nav2_map.yaml", &files->map_yaml},
       {"nav2_cost.pgm", &files->cost_pgm},
       {"nav2_cost.yaml", &files->cost_yaml}}};
  for (const auto& [name, bytes] : named) {
    if (Status written = writer.write(name, *bytes); !written) return written;
  }
  return {};
}

// The values of a layer, in the geometry of map.yaml: that is exact, while a GeoTIFF stores the
// upper border.
Status read_layer(const fs::path& path, MapLayer& layer) {
  auto grid = read_geotiff(path);
  if (!grid) return forward(grid);
  const GridGeometry& expected = layer.grid.geometry;
  const GridGeometry& found = grid->geometry;
  if (found.columns != expected.columns || found.rows != expected.rows) {
    return fail(ErrorCode::kBadFormat,
                fmt::format("{}x{} cells, but map.yaml says {}x{}", found.columns, found.rows,
                            expected.columns, expected.rows),
                path.string(), "Save the map again, or correct size_cells in map.yaml");
  }
  // In cells, over the whole width or height of the layer.
  const double cells = std::max(expected.columns, expected.rows);
  const double stretched =
      std::abs(found.resolution_m - expected.resolution_m) / expected.resolution_m * cells;
  const double moved = (found.origin - expected.origin).norm() / expected.resolution_m;
  constexpr double kLeastShift = 1e-3;
  if (!(stretched < kLeastShift) || !(moved < kLeastShift)) {
    return fail(ErrorCode::kBadFormat,
                fmt::format("cells of {} m from ({}, {}), but map.yaml says {} m from ({}, {})",
                            found.resolution_m, found.origin.x(), found.origin.y(),
                            expected.resolution_m, expected.origin.x(), expected.origin.y()),
                path.string(), "Save the map again, or correct map.yaml");
  }
  layer.grid.values = std::move(grid->values);
  return {};
}

Status add(const MapLayers& map, FileSet& set) {
  if (const Status checked = check_map(map); !checked) return checked;
  if (const Status finished = FileSet::finish_interrupted(set.folder()); !finished) return finished;
  MapWriter writer(set);
  for (const MapLayer& layer : map.layers) {
    if (Status written = writer.write_layer(layer); !written) return written;
  }
  if (const MapLayer* explored = map.find("explored")) {
    if (Status written = writer.write_mask(*explored); !written) return written;
  }
  if (const MapLayer* cost = map.find("cost")) {
    if (Status written = write_nav2(writer, map, *cost); !written) return written;
  }
  if (Status written = writer.write(kIndexName, print_map_yaml(map)); !written) return written;
  writer.remove_old(files_of_old_map(set.folder()));
  return {};
}

Status save(const MapLayers& map, const fs::path& folder) {
  if (const Status checked = check_map(map); !checked) return checked;
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    return fail(ErrorCode::kWriteFailed,
                fmt::format("the folder cannot be made: {}", error.message()), folder.string(),
                "Check the name and the permissions");
  }
  FileSet set(folder);
  if (Status added = add(map, set); !added) return added;
  return set.commit();
}

Result<MapLayers> load(const fs::path& path) {
  std::error_code ignored;
  const bool is_folder = fs::is_directory(path, ignored);
  const fs::path folder =
      is_folder ? path : (path.has_parent_path() ? path.parent_path() : fs::path("."));
  const fs::path index_path = is_folder ? path / kIndexName : path;
  if (const Status finished = FileSet::finish_interrupted(folder); !finished) {
    return forward(finished);
  }
  const auto text = read_file(index_path, kLargestIndex);
  if (!text) return forward(text);
  auto index = parse_map_yaml(*text, index_path.string());
  if (!index) return forward(index);
  for (std::size_t i = 0; i < index->files.size(); ++i) {
    if (Status read = read_layer(folder / index->files[i], index->map.layers[i]); !read) {
      return forward(read);
    }
  }
  return std::move(index->map);
}

}  // namespace

Status add_map(const MapLayers& map, FileSet& set) {
  return with_memory_checked(set.folder().string(), kNeedsMemory, [&] { return add(map, set); });
}

void remove_map(FileSet& set) {
  const std::vector<std::string> files = files_of_old_map(set.folder());
  for (const std::string& name : files) set.remove(name);
  if (!files.empty()) set.remove(kIndexName);
}

Status save_map(const MapLayers& map, const fs::path& folder) {
  return with_memory_checked(folder.string(), kNeedsMemory, [&] { return save(map, folder); });
}

Result<MapLayers> load_map(const fs::path& path) {
  return with_memory_checked(path.string(), kNeedsMemory, [&] { return load(path); });
}

}  // namespace tread
