// Grids of square cells on the ground. A cell is named by whole numbers (x, y); x grows with world
// x, y with world y, and cell (0, 0) of an unbounded grid has its lower corner at the origin.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <vector>

namespace tread {

struct Cell {
  int x = 0;
  int y = 0;
  [[nodiscard]] auto operator<=>(const Cell&) const = default;
};

// A rectangle of cells, `last` not included.
struct CellRect {
  Cell first;
  Cell last;
  [[nodiscard]] int columns() const { return last.x - first.x; }
  [[nodiscard]] int rows() const { return last.y - first.y; }
  [[nodiscard]] bool empty() const { return last.x <= first.x || last.y <= first.y; }
  // Number of cells; wide, since the corners may be 2^31 cells apart.
  [[nodiscard]] std::int64_t size() const {
    return empty() ? 0 : (std::int64_t{last.x} - first.x) * (std::int64_t{last.y} - first.y);
  }
  // The smallest rectangle that holds both; an empty one counts for nothing.
  [[nodiscard]] CellRect united(const CellRect& other) const {
    if (empty()) return other;
    if (other.empty()) return *this;
    return {{std::min(first.x, other.first.x), std::min(first.y, other.first.y)},
            {std::max(last.x, other.last.x), std::max(last.y, other.last.y)}};
  }
  [[nodiscard]] bool contains(Cell c) const {
    return c.x >= first.x && c.x < last.x && c.y >= first.y && c.y < last.y;
  }
  [[nodiscard]] bool operator==(const CellRect&) const = default;
};

// Rounds towards minus infinity: floor_div(-1, 64) is -1.
[[nodiscard]] constexpr int floor_div(int a, int b) {
  const int q = a / b;
  return (a % b != 0 && (a < 0) != (b < 0)) ? q - 1 : q;
}

// Where a bounded grid lies: `origin` is the lower corner (not the centre) of cell (0, 0), metres.
struct GridGeometry {
  double resolution_m = 0.1;
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();
  int columns = 0;  // along x
  int rows = 0;     // along y

  [[nodiscard]] bool contains(Cell c) const {
    return c.x >= 0 && c.y >= 0 && c.x < columns && c.y < rows;
  }
  // The cell that holds a point, which may lie outside the grid. The point must be finite and
  // within 2^31 cells of the origin.
  [[nodiscard]] Cell cell_at(const Eigen::Vector2d& p) const {
    return {static_cast<int>(std::floor((p.x() - origin.x()) / resolution_m)),
            static_cast<int>(std::floor((p.y() - origin.y()) / resolution_m))};
  }
  [[nodiscard]] Eigen::Vector2d centre(Cell c) const {
    return origin + resolution_m * Eigen::Vector2d(c.x + 0.5, c.y + 0.5);
  }
  [[nodiscard]] std::size_t size() const {
    return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  }
  [[nodiscard]] bool operator==(const GridGeometry&) const = default;
};

// A bounded grid of values, rows along x, row 0 at the smallest y.
template <class T>
struct Grid {
  GridGeometry geometry;
  std::vector<T> values;

  Grid() = default;
  explicit Grid(const GridGeometry& where, T fill = T{}) : geometry(where) {
    values.assign(where.size(), fill);
  }
  [[nodiscard]] T& operator[](Cell c) { return values[index(c)]; }
  [[nodiscard]] const T& operator[](Cell c) const { return values[index(c)]; }

 private:
  [[nodiscard]] std::size_t index(Cell c) const {
    assert(geometry.contains(c));
    return static_cast<std::size_t>(c.y) * static_cast<std::size_t>(geometry.columns) +
           static_cast<std::size_t>(c.x);
  }
};

// A grid without borders, made of square tiles that come into being where something is written.
// Growing never moves or copies a tile; memory is the only limit. T should say by its default
// value that nothing is known.
template <class T>
class TiledGrid {
 public:
  static constexpr int kTileCells = 64;
  using Tile = std::array<T, static_cast<std::size_t>(kTileCells) * kTileCells>;

  // The value of a cell, or nullptr where no tile is.
  [[nodiscard]] const T* find(Cell c) const {
    const auto tile = tiles_.find(tile_of(c));
    return tile == tiles_.end() ? nullptr : &(*tile->second)[index_in_tile(c)];
  }
  // The value of a cell, made if it was not there.
  [[nodiscard]] T& touch(Cell c) { return touch_tile(tile_of(c))[index_in_tile(c)]; }

  [[nodiscard]] Tile& touch_tile(Cell tile) {
    std::unique_ptr<Tile>& slot = tiles_[tile];
    if (!slot) slot = std::make_unique<Tile>();
    return *slot;
  }
  [[nodiscard]] const Tile* find_tile(Cell tile) const {
    const auto found = tiles_.find(tile);
    return found == tiles_.end() ? nullptr : found->second.get();
  }
  // The cells covered by tiles; empty if there are none.
  [[nodiscard]] CellRect tile_bounds() const {
    if (tiles_.empty()) return {};
    Cell low = tiles_.begin()->first, high = low;
    for (const auto& [tile, data] : tiles_) {
      low = {std::min(low.x, tile.x), std::min(low.y, tile.y)};
      high = {std::max(high.x, tile.x), std::max(high.y, tile.y)};
    }
    return {{low.x * kTileCells, low.y * kTileCells},
            {(high.x + 1) * kTileCells, (high.y + 1) * kTileCells}};
  }
  [[nodiscard]] std::size_t tile_count() const { return tiles_.size(); }
  // Tiles in the order of their index, the same on every run.
  [[nodiscard]] const std::map<Cell, std::unique_ptr<Tile>>& tiles() const { return tiles_; }

  [[nodiscard]] static Cell tile_of(Cell c) {
    return {floor_div(c.x, kTileCells), floor_div(c.y, kTileCells)};
  }
  [[nodiscard]] static std::size_t index_in_tile(Cell c) {
    const Cell tile = tile_of(c);
    return static_cast<std::size_t>((c.y - tile.y * kTileCells) * kTileCells +
                                    (c.x - tile.x * kTileCells));
  }

 private:
  std::map<Cell, std::unique_ptr<Tile>> tiles_;
};

}  // namespace tread
