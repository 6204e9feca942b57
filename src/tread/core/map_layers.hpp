// A map as it travels between modules and to disk: named layers over one grid. The terrain module
// fills it, io writes and reads it, plan and the reports look at it.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "tread/core/grid.hpp"

namespace tread {

struct MapLayer {
  std::string name;     // "height", "cost"
  std::string unit;     // "m", "1"
  std::string meaning;  // one line
  Grid<float> grid;     // NaN where unknown
};

// Layers may differ in resolution (heights at 0.1 m, costs at 0.3 m) but share the frame.
struct MapLayers {
  std::string frame = "world";            // REP 103: x forward, y left, z up, metres
  std::vector<MapLayer> layers;           // names are unique
  std::map<std::string, double> numbers;  // what a reader needs to know: "unexplored_cost"

  [[nodiscard]] const MapLayer* find(const std::string& name) const {
    for (const MapLayer& layer : layers) {
      if (layer.name == name) return &layer;
    }
    return nullptr;
  }
};

}  // namespace tread
