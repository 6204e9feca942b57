#include "tread/core/grid.hpp"

#include <gtest/gtest.h>

namespace tread {
namespace {

TEST(GridGeometry, CellsAndCentresAgree) {
  const GridGeometry geometry{0.1, {-1.0, 2.0}, 20, 10};
  for (int y = 0; y < geometry.rows; ++y) {
    for (int x = 0; x < geometry.columns; ++x) {
      EXPECT_EQ(geometry.cell_at(geometry.centre({x, y})), (Cell{x, y}));
    }
  }
  EXPECT_EQ(geometry.cell_at({-1.05, 1.95}), (Cell{-1, -1}));
  EXPECT_FALSE(geometry.contains({20, 0}));
  EXPECT_TRUE(geometry.contains({19, 9}));
}

TEST(CellRect, SizeIsExactBeyond32BitsAndEmptyOnesCountForNothing) {
  const CellRect wide{{-2'000'000'000, -2}, {2'000'000'000, 3}};
  EXPECT_EQ(wide.size(), 20'000'000'000);
  EXPECT_FALSE(wide.empty());
  EXPECT_EQ((CellRect{{3, 0}, {3, 9}}).size(), 0);
  EXPECT_EQ((CellRect{{3, 0}, {1, -9}}).size(), 0);
  const CellRect a{{0, 0}, {2, 3}}, b{{5, -4}, {6, 1}};
  EXPECT_EQ(a.united(b), (CellRect{{0, -4}, {6, 3}}));
  EXPECT_EQ(a.united({}), a);
  EXPECT_EQ(CellRect{}.united(b), b);
}

TEST(FloorDiv, RoundsDown) {
  EXPECT_EQ(floor_div(-1, 64), -1);
  EXPECT_EQ(floor_div(-64, 64), -1);
  EXPECT_EQ(floor_div(-65, 64), -2);
  EXPECT_EQ(floor_div(63, 64), 0);
  EXPECT_EQ(floor_div(64, 64), 1);
}

TEST(TiledGrid, GrowsWithoutMovingWhatIsThere) {
  TiledGrid<float> grid;
  EXPECT_EQ(grid.find({0, 0}), nullptr);
  EXPECT_TRUE(grid.tile_bounds().empty());
  grid.touch({-1, -1}) = 3.0F;
  const float* before = grid.find({-1, -1});
  for (int i = 0; i < 100; ++i) grid.touch({i * 1000, -i * 777}) = static_cast<float>(i);
  EXPECT_EQ(grid.find({-1, -1}), before);
  EXPECT_EQ(*grid.find({-1, -1}), 3.0F);
  EXPECT_EQ(*grid.find({99000, -76923}), 99.0F);
  EXPECT_EQ(grid.find({500, 500}), nullptr);
  EXPECT_TRUE(grid.tile_bounds().contains({-1, -1}));
  EXPECT_TRUE(grid.tile_bounds().contains({99000, -76923}));
  EXPECT_LE(grid.tile_count(), 101U);
}

}  // namespace
}  // namespace tread
