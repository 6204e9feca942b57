// map.yaml: the list of a map's layers. Text in, text out; the files are map_files.hpp's matter.
//   tread_map: 1                   version of the format
//   frame: "world"
//   layers:
//     height:
//       file: height.tif
//       unit: "m"
//       meaning: "height of the ground"
//       resolution_m: 0.1
//       origin_m: [-3, 2.5]        lower corner of cell (0, 0)
//       size_cells: [100, 80]      columns along x, rows along y
//   numbers:                       optional
//     lethal_cost: 100
#pragma once

#include <string>
#include <vector>

#include "tread/core/map_layers.hpp"
#include "tread/core/result.hpp"

namespace tread {

struct MapIndex {
  MapLayers map;                   // layers with their geometry and no values
  std::vector<std::string> files;  // one a layer, plain names
};

// Letters, digits, '_' and '-', 1 to 100 of them.
[[nodiscard]] bool is_layer_name(const std::string& name);

// Layers and numbers in the order of the map; numbers are written so that they are read back equal.
[[nodiscard]] std::string print_map_yaml(const MapLayers& map);

// `where` is the file's name in messages. An unknown key, a key twice, a newer version, a size
// below one and a file outside the folder are refused.
[[nodiscard]] Result<MapIndex> parse_map_yaml(const std::string& text, const std::string& where);

}  // namespace tread
