#include "planner/methods/sensed_cspace/planar_geometry.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace hecaton::planner::cspace {
namespace {

double area(const ConvexPiece& piece) {
  double twice = 0.0;
  for (std::size_t i = 0; i < piece.corners.size(); ++i) {
    const Point& a = piece.corners[i];
    const Point& b = piece.corners[(i + 1) % piece.corners.size()];
    twice += a.x * b.y - b.x * a.y;
  }
  return 0.5 * twice;
}

TEST(ConvexPiece, DropsPointsInsideOrOnASide) {
  const Point points[] = {{0, 0}, {2, 0}, {1, 0}, {2, 2}, {1, 1}, {0, 2}, {0, 0}};
  const ConvexPiece piece = convex_piece(points);
  EXPECT_EQ(piece.corners.size(), 4u);
  EXPECT_EQ(piece.edges.size(), 4u);
  EXPECT_DOUBLE_EQ(area(piece), 4.0);  // positive: counter-clockwise
  EXPECT_DOUBLE_EQ(piece.radius, std::sqrt(2.0));
}

TEST(ConvexPiece, OfCollinearPointsIsASegmentOfTwoSides) {
  const Point points[] = {{1, 1}, {3, 3}, {2, 2}};
  const ConvexPiece piece = convex_piece(points);
  ASSERT_EQ(piece.corners.size(), 2u);
  ASSERT_EQ(piece.edges.size(), 2u);
  EXPECT_DOUBLE_EQ(piece.edges[0].outward.x, -piece.edges[1].outward.x);
}

TEST(ConvexPiece, OfOnePointHasNoSides) {
  const Point point[] = {{1, 1}, {1, 1}};
  EXPECT_EQ(convex_piece(point).corners.size(), 1u);
  EXPECT_TRUE(convex_piece(point).edges.empty());
}

TEST(Triangles, CoverAPolygonThatIsNotConvex) {
  // A U of area 3·3 − 1·2 = 7, once in either order.
  std::vector<Point> corners = {{0, 0}, {3, 0}, {3, 3}, {2, 3}, {2, 1}, {1, 1}, {1, 3}, {0, 3}};
  for (int order = 0; order < 2; ++order) {
    double sum = 0.0;
    for (const ConvexPiece& piece : triangles(corners)) {
      EXPECT_GT(area(piece), 0.0);
      sum += area(piece);
    }
    EXPECT_NEAR(sum, 7.0, 1e-12);
    std::reverse(corners.begin(), corners.end());
  }
}

}  // namespace
}  // namespace hecaton::planner::cspace
