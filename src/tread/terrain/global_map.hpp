// The global maps of paper R ("Incorporating New Measurements"): terrain, derivative, and where a
// derivative has been measured. They grow with the drive, tile by tile, and keep the list of cells
// whose derivative has changed since it was last asked for.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "tread/core/grid.hpp"
#include "tread/core/map_layers.hpp"
#include "tread/core/options.hpp"
#include "tread/core/result.hpp"
#include "tread/core/timer.hpp"

namespace tread {

struct GlobalMapOptions {
  double alpha = 0.5;  // weight of a new measurement: v <- (1 - alpha) v + alpha m; paper R: 0.5;
                       // above 0: what is never taken in would make all ground flat
  // What the first measurement of a cell does: take part in the low-pass with v = 0, as the formula
  // says, so that one spurious hit counts half; or be taken as it is.
  enum class First { kFilter, kCopy } first = First::kFilter;
  // What layers() may take, MiB at 12 bytes a cell of the rectangle around everything known: one
  // pose far away would need all the memory there is. 2048: 1.8 square kilometres at 0.1 m.
  int max_map_mib = 2048;
};
[[nodiscard]] OptionSet describe(GlobalMapOptions& options);

// What is known of one cell.
struct GroundCell {
  float height_m = std::numeric_limits<float>::quiet_NaN();  // last measured, above world z = 0
  float derivative = 0.0F;                                   // low-passed, m^2
  std::uint16_t measurements = 0;  // of the derivative; 0: not explored. Stays at the largest value
  bool changed = false;            // in the list of changed cells

  [[nodiscard]] bool explored() const { return measurements > 0; }
};

// Where the levelled frame of a local map is in the world.
struct LevelPose {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // metres
  double yaw_rad = 0.0;
};

class GlobalMap {
 public:
  // Cell (0, 0) has its lower corner at the world's origin.
  explicit GlobalMap(double resolution_m = 0.1) : resolution_m_(resolution_m) {}

  // Turns a local map and its derivative by the yaw, shifts them into the world and takes them in:
  // heights overwrite, derivatives are low-passed. Every global cell below the local map takes the
  // local cell that its centre falls into, so that turning leaves no gaps. Errors: a pose that is
  // not finite or 1e9 cells from the origin, maps of different geometry or another resolution, and
  // kTooLarge where the map would outgrow max_map_mib; the map then stays as it was.
  [[nodiscard]] Status integrate(const Grid<float>& height, const Grid<float>& derivative,
                                 const LevelPose& pose, const GlobalMapOptions& options,
                                 const Context& context = {});

  // The cells whose derivative changed since the last call, in the order in which they did, each
  // once; and empties the list.
  [[nodiscard]] std::vector<Cell> take_changes();

  // The heights known at the cells of a local map at `pose`, measured from its own height; NaN
  // where none is. For LocalMapBuilder's overhead_m.
  void heights_below(const GridGeometry& local, const LevelPose& pose, Grid<float>& heights,
                     const Context& context = {}) const;

  [[nodiscard]] const GroundCell* find(Cell cell) const { return cells_.find(cell); }
  [[nodiscard]] const TiledGrid<GroundCell>& cells() const { return cells_; }
  [[nodiscard]] double resolution_m() const { return resolution_m_; }
  [[nodiscard]] Cell cell_at(const Eigen::Vector2d& p) const;
  // The smallest rectangle of cells that holds everything known.
  [[nodiscard]] const CellRect& bounds() const { return bounds_; }
  // Derivatives taken over global heights instead of local ones, for comparison: what paper R warns
  // of, because small errors of attitude between frames become steps. Over bounds(), as the local.
  [[nodiscard]] Grid<float> derivative_of_heights() const;

  // Layers "height", "derivative", "explored" (0 or 1) over bounds(), for files and pictures. At
  // most as large as max_map_mib allowed integrate() to let it grow.
  [[nodiscard]] MapLayers layers() const;
  // The map that layers() came from; all cells count as changed. Errors name the missing layer.
  [[nodiscard]] static Result<GlobalMap> from_layers(const MapLayers& layers);

 private:
  [[nodiscard]] GridGeometry bounds_geometry() const;
  void note_change(Cell cell, GroundCell& ground);

  double resolution_m_;
  TiledGrid<GroundCell> cells_;
  std::vector<Cell> changes_;
  CellRect bounds_;
};

}  // namespace tread
