// Row 0 of the image is the largest y; `origin` is the lower left corner of the lower left pixel.
#include "tread/io/nav2_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace tread {
namespace {

constexpr std::uint8_t kFree = 254;
constexpr std::uint8_t kOccupied = 0;
constexpr std::uint8_t kUnknown = 205;
constexpr std::uint8_t kLethalOccupancy = 100;
constexpr std::uint8_t kUnknownOccupancy = 255;

template <class Encode>
std::string make_pgm(const Grid<float>& grid, const Encode& encode) {
  const GridGeometry& g = grid.geometry;
  std::string bytes = fmt::format("P5\n{} {}\n255\n", g.columns, g.rows);
  bytes.reserve(bytes.size() + g.size());
  for (int y = g.rows - 1; y >= 0; --y) {
    for (int x = 0; x < g.columns; ++x) bytes += static_cast<char>(encode(grid[Cell{x, y}]));
  }
  return bytes;
}

std::string make_yaml(const GridGeometry& g, const char* image, const char* mode) {
  return fmt::format(
      "image: {}\nmode: {}\nresolution: {}\norigin: [{}, {}, 0.0]\nnegate: 0\n"
      "occupied_thresh: 0.65\nfree_thresh: 0.196\n",
      image, mode, g.resolution_m, g.origin.x(), g.origin.y());
}

}  // namespace

Result<Nav2Files> make_nav2_files(const Grid<float>& cost, double lethal_cost) {
  if (!(lethal_cost > 1.0) || !std::isfinite(lethal_cost)) {
    return fail(ErrorCode::kBadValue,
                fmt::format("{} is not above 1, the cost of free ground", lethal_cost),
                "numbers.lethal_cost", "Give the cost from which ground is lethal, as 100");
  }
  if (cost.geometry.size() == 0) {
    return fail(ErrorCode::kBadArgument, "the layer has no cells", "cost", "Give it some");
  }
  Nav2Files files;
  files.map_pgm = make_pgm(cost, [&](float c) {
    if (std::isnan(c)) return kUnknown;
    return c >= lethal_cost ? kOccupied : kFree;
  });
  files.cost_pgm = make_pgm(cost, [&](float c) {
    if (std::isnan(c)) return kUnknownOccupancy;
    if (c >= lethal_cost) return kLethalOccupancy;
    const double graded = std::rint((c - 1.0) / (lethal_cost - 1.0) * 100.0);
    return static_cast<std::uint8_t>(std::clamp(graded, 0.0, kLethalOccupancy - 1.0));
  });
  files.map_yaml = make_yaml(cost.geometry, "nav2_map.pgm", "trinary");
  files.cost_yaml = make_yaml(cost.geometry, "nav2_cost.pgm", "raw");
  return files;
}

}  // namespace tread
