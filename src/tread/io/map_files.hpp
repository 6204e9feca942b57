// A map on disk: a folder with one GeoTIFF a layer, map.yaml that lists them, and the cost layer
// again as PGM + YAML for Nav2's map server.
#pragma once

#include <filesystem>

#include "tread/core/map_layers.hpp"
#include "tread/core/result.hpp"

namespace tread {

// Writes every layer as <name>.tif (0/1 masks named "explored" also as <name>.png), map.yaml, and
// if there is a layer "cost": nav2_map.pgm and nav2_map.yaml. All or nothing (FileSet); files of
// an earlier map in the folder are replaced, other files left alone. Makes the folder.
[[nodiscard]] Status save_map(const MapLayers& map, const std::filesystem::path& folder);

// `path` is the folder or its map.yaml.
[[nodiscard]] Result<MapLayers> load_map(const std::filesystem::path& path);

// Nav2 map server, mode "scale": 0 free, 100 lethal, -1 unknown (Nav2 documentation, map server).
// Cost 1 and below is free, `lethal_cost` (map.numbers, else 100) and above is occupied, linear
// between; NaN is unknown.

}  // namespace tread
