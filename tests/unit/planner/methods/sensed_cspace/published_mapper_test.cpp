#include "planner/methods/sensed_cspace/published/published_mapper.hpp"

#include <gtest/gtest.h>

#include "tests/support/brute_force_cspace.hpp"

namespace hecaton::planner::cspace {
namespace {

constexpr double kDegree = kPi / 180.0;

// MFO_24 of table 1: r = 24, l₁ = l₂ = 20. Its widest θ₁ is that at which the tip is on it: 2 · 20 · 24 cos θ₁ = 24².
TEST(ImageDatabase, HoldsFortyImagesBuiltFromTheArm) {
  const ImageDatabase database(PlanarArm{}, AngleGrid{360});
  EXPECT_EQ(database.size(), 40);
  EXPECT_DOUBLE_EQ(database.spacing(), 1.0);
  const PointImage& image = database.at(24.7);
  EXPECT_NEAR(image.theta1_max, std::acos(0.6), 1e-12);
  EXPECT_NEAR(image.theta1_min, -std::acos(0.6), 1e-12);
  ASSERT_EQ(image.lower.size(), 108u);  // −53.13° … 52.87° and the end at 53.13°
  // At both ends s = l₂ = 20: ± asin(1/20) about θ₂, for which the triangle gives cos θ₂ = (24² − 2 · 20²) / (2 · 20²).
  const double theta2 = std::acos((576.0 - 800.0) / 800.0);
  EXPECT_NEAR(image.upper.front() - image.lower.front(), 2.0 * std::asin(0.05), 1e-12);
  EXPECT_NEAR(0.5 * (image.upper.front() + image.lower.front()), theta2, 1e-12);
  EXPECT_NEAR(0.5 * (image.upper.back() + image.lower.back()), -theta2, 1e-12);
}

TEST(CriticalPoints, AreThoseOfAlgorithm1) {
  const ImageDatabase database(PlanarArm{}, AngleGrid{360});
  // A square from (24, −2) to (28, 2): nearest (24, 0); φ is extreme at (24, ∓2); an image is the wider the nearer the
  // point: acos(r/40) + φ is largest at (24, 2) again, 52.9° + 4.8°.
  const Point square[] = {{24, -2}, {28, -2}, {28, 2}, {24, 2}};
  const auto obstacles = border(square, 1.0);
  EXPECT_EQ(obstacles.size(), 16u);
  const CriticalPoints g = find_critical_points(obstacles, database);
  const auto at = [&](int i) { return std::pair(obstacles[i].place.x, obstacles[i].place.y); };
  EXPECT_EQ(at(g.nearest), std::pair(24.0, 0.0));
  EXPECT_EQ(at(g.phi_min), std::pair(24.0, -2.0));
  EXPECT_EQ(at(g.phi_max), std::pair(24.0, 2.0));
  EXPECT_EQ(at(g.theta1_min), std::pair(24.0, -2.0));
  EXPECT_EQ(at(g.theta1_max), std::pair(24.0, 2.0));
  EXPECT_NEAR(g.largest_theta1, std::acos(0.6) + std::atan2(2.0, 24.0), 1e-12);
}

TEST(CriticalPoints, StayConnectedAcrossTheNegativeAxis) {
  const ImageDatabase database(PlanarArm{}, AngleGrid{360});
  const Point square[] = {{-28, -2}, {-24, -2}, {-24, 2}, {-28, 2}};
  const CriticalPoints g = find_critical_points(border(square, 1.0), database);
  EXPECT_LT(g.largest_theta1 - g.least_theta1, 120.0 * kDegree);
}

// [Li96] claims that the critical points' images govern the obstacle's. They do not: this is why robots do not run it.
TEST(PublishedMapper, MissesCellsInWhichTheArmCollides) {
  const AngleGrid grid{360};
  const PlanarArm arm;
  const ImageDatabase database(arm, grid);
  const test::BruteForce brute_force(arm, grid);
  const std::vector<Point> square = {{24, -2}, {28, -2}, {28, 2}, {24, 2}};
  const auto obstacles = border(square, database.spacing());
  ObstacleImage image;
  map_as_published(obstacles, find_critical_points(obstacles, database), database, image);
  CspaceMap published(grid);
  published.block(image);
  const CspaceMap truth = brute_force.map(square);
  CspaceMap together = truth;
  together.block(published);
  const int missed = together.blocked_cells() - published.blocked_cells();
  EXPECT_GT(missed, truth.blocked_cells() / 50);
  EXPECT_LT(missed, truth.blocked_cells() / 3);
}

// Of a single fundamental obstacle nothing is approximated but that it is turned by φ, between the rows of its image.
TEST(PublishedMapper, TurnsAnImageByAnyAngle) {
  const AngleGrid grid{360};
  const PlanarArm arm;
  const ImageDatabase database(arm, grid);
  for (const double phi : {10.5 * kDegree, -170.4 * kDegree, 45.7 * kDegree}) {
    const FundamentalObstacle one{{24.0 * std::cos(phi), 24.0 * std::sin(phi)}, 24.0, phi};
    CspaceMap map(grid);
    map_union(std::span(&one, 1), database, map);
    int off = 0;
    int cells = 0;
    // Rows a degree inside both ends: there the arm of the image ends square, not round.
    for (int row = 0; row < grid.cells; ++row) {
      const double theta1 = std::remainder(grid.centre(row) - phi, 2.0 * kPi);
      if (std::abs(theta1) > std::acos(0.6) - kDegree) continue;
      const double x = 24.0 - 20.0 * std::cos(theta1);
      const double y = -20.0 * std::sin(theta1);
      const double half = std::asin(1.0 / std::hypot(x, y));
      const double theta2 = std::atan2(y, x) - theta1;
      for (int column = 0; column < grid.cells; ++column) {
        const bool touches = std::abs(std::remainder(grid.centre(column) - theta2, 2.0 * kPi)) <= half;
        cells += touches ? 1 : 0;
        off += touches != map.blocked(row, column) ? 1 : 0;
      }
    }
    EXPECT_GT(cells, 1000);
    EXPECT_LT(off, cells / 50) << "φ = " << phi;
  }
}

TEST(PublishedMapper, CoversTheImageOfTheNearestPoint) {
  const AngleGrid grid{360};
  const ImageDatabase database(PlanarArm{}, grid);
  const std::vector<Point> square = {{24, -2}, {28, -2}, {28, 2}, {24, 2}};
  const auto obstacles = border(square, database.spacing());
  const CriticalPoints g = find_critical_points(obstacles, database);
  ObstacleImage image;
  map_as_published(obstacles, g, database, image);
  CspaceMap published(grid);
  published.block(image);
  CspaceMap nearest(grid);
  map_union(std::span(&obstacles[static_cast<std::size_t>(g.nearest)], 1), database, nearest);
  ASSERT_GT(nearest.blocked_cells(), 1000);
  CspaceMap together = published;
  together.block(nearest);
  EXPECT_EQ(together, published);
}

TEST(FundamentalObstacles, AreTheGridPointsNextToTheBorder) {
  Random random(8);
  constexpr double kSpacing = 0.5;
  for (int round = 0; round < 50; ++round) {
    const std::vector<Point> corners = test::random_convex(random, PlanarArm{});
    const auto obstacles = border(corners, kSpacing);
    ASSERT_FALSE(obstacles.empty());
    for (const FundamentalObstacle& obstacle : obstacles) {
      EXPECT_DOUBLE_EQ(std::remainder(obstacle.place.x, kSpacing), 0.0);
      EXPECT_DOUBLE_EQ(std::remainder(obstacle.place.y, kSpacing), 0.0);
      EXPECT_NEAR(obstacle.r * std::cos(obstacle.phi), obstacle.place.x, 1e-12);
      EXPECT_NEAR(obstacle.r * std::sin(obstacle.phi), obstacle.place.y, 1e-12);
    }
    for (const Point& p : border_points(corners, 0.1)) {
      double nearest = 1e300;
      for (const FundamentalObstacle& obstacle : obstacles) {
        nearest = std::min(nearest, std::hypot(obstacle.place.x - p.x, obstacle.place.y - p.y));
      }
      EXPECT_LE(nearest, kSpacing * (std::sqrt(0.5) + 0.125));
    }
  }
}

TEST(PublishedMapper, BlocksNothingForObstaclesOutOfReach) {
  const ImageDatabase database(PlanarArm{}, AngleGrid{360});
  const Point far[] = {{60, 0}, {61, 0}, {61, 1}};
  const auto obstacles = border(far, 1.0);
  const CriticalPoints g = find_critical_points(obstacles, database);
  EXPECT_LT(g.largest_theta1, g.least_theta1);
  ObstacleImage image;
  map_as_published(obstacles, g, database, image);
  CspaceMap map(AngleGrid{360});
  map.block(image);
  EXPECT_EQ(map.blocked_cells(), 0);
}

}  // namespace
}  // namespace hecaton::planner::cspace
