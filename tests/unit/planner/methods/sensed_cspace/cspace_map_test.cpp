#include "planner/methods/sensed_cspace/cspace_map.hpp"

#include <gtest/gtest.h>

namespace hecaton::planner::cspace {
namespace {

TEST(AngleGrid, CellsAreCentredOnWholeDegreesFromMinusPi) {
  const AngleGrid grid{360};
  EXPECT_DOUBLE_EQ(grid.centre(0), -kPi);
  EXPECT_NEAR(grid.centre(270), kPi / 2.0, 1e-15);
  EXPECT_EQ(grid.cell_at(0.49 * grid.pitch()), 180);
  EXPECT_EQ(grid.cell_at(0.51 * grid.pitch()), 181);
  EXPECT_EQ(grid.cell_at(kPi), 0);  // the same angle as −π
  EXPECT_EQ(grid.cell_at(kPi - 0.6 * grid.pitch()), 359);
  EXPECT_EQ(grid.cell_at(7.0 * kPi), 0);
  EXPECT_EQ(grid.wrapped(-1), 359);
  EXPECT_EQ(grid.wrapped(720), 0);
}

TEST(CspaceMap, SpansCoverExactlyTheirCells) {
  for (const int cells : {64, 100, 360}) {
    for (int first = 0; first < cells; first += 7) {
      for (const int count : {0, 1, 5, 63, 64, 65, cells - 1, cells}) {
        if (count > cells) continue;
        CspaceMap map(AngleGrid{cells});
        map.block(3, {static_cast<std::int16_t>(first), static_cast<std::int16_t>(count)});
        for (int column = 0; column < cells; ++column) {
          const bool inside = (column - first + cells) % cells < count;
          ASSERT_EQ(map.blocked(3, column), inside) << cells << " " << first << " " << count << " " << column;
        }
        EXPECT_EQ(map.blocked_cells(), count);
      }
    }
  }
}

TEST(CspaceMap, ImagesWrapFromTheLastRowToTheFirst) {
  CspaceMap map(AngleGrid{100});
  ObstacleImage image;
  image.first_row = 98;
  image.spans = {{10, 1}, {11, 1}, {12, 1}, {0, 0}};
  map.block(image);
  EXPECT_TRUE(map.blocked(98, 10));
  EXPECT_TRUE(map.blocked(99, 11));
  EXPECT_TRUE(map.blocked(0, 12));
  EXPECT_EQ(map.blocked_cells(), 3);

  CspaceMap other(AngleGrid{100});
  other.block(5, {99, 2});
  other.block(map);
  EXPECT_EQ(other.blocked_cells(), 5);
}

}  // namespace
}  // namespace hecaton::planner::cspace
