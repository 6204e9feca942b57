// A map on disk: a folder with one GeoTIFF a layer, map.yaml that lists them, and the cost layer
// again as PGM + YAML for Nav2's map server.
//
// For Nav2 the layer "cost" is written twice, because a PGM has no alpha and so no single file can
// tell the unknown and a graded cost to every mode of the map server (with p = (255 - pixel) /
// 255):
//   nav2_map  mode trinary: free 254 (p = 0.004), occupied 0 (p = 1), unknown 205 (p = 0.1961,
//             between free_thresh 0.196 and occupied_thresh 0.65). What can be crossed at a price
//             is free. Read in mode "scale" free is 0, occupied 100 and the unknown 0.
//   nav2_cost mode raw: the pixel is the occupancy itself, 0 free, 1 to 99 graded, 100 lethal, and
//             255 the unknown (-1). For costmaps with trinary_costmap: false, and as filter mask.
// Mode "scale" is chosen for neither: without alpha it has no unknown.
// Cost 1 and below is free, `lethal_cost` (map.numbers, else 100) and above is lethal, between them
// the occupancy grows linearly from 0 to 99; NaN is unknown.
#pragma once

#include <filesystem>

#include "tread/core/map_layers.hpp"
#include "tread/core/result.hpp"

namespace tread {

class FileSet;

// Writes every layer as <name>.tif (a 0/1 mask named "explored" also as explored.png, white where
// 1), map.yaml, and if there is a layer "cost": nav2_map.{pgm,yaml} and nav2_cost.{pgm,yaml}. All
// or nothing (FileSet); files of an earlier map in the folder are replaced or removed, other files
// left alone. Makes the folder. Layer names are of letters, digits, '_' and '-'.
[[nodiscard]] Status save_map(const MapLayers& map, const std::filesystem::path& folder);

// The same as a part of a larger set: the caller commits. The folder must exist.
[[nodiscard]] Status add_map(const MapLayers& map, FileSet& set);
// The files of the map in the set's folder, if there is one, shall be gone with the commit.
void remove_map(FileSet& set);

// `path` is the folder or its map.yaml. An interrupted save is completed first. What was saved
// comes back bit by bit.
[[nodiscard]] Result<MapLayers> load_map(const std::filesystem::path& path);

}  // namespace tread
