#include "planner/cspace/published_mapper.hpp"

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

TEST(CriticalPoints, OfAnObstacleAcrossTheNegativeAxisAreNotTornApart) {
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

TEST(PublishedMapper, FindsNothingOutOfReach) {
  const ImageDatabase database(PlanarArm{}, AngleGrid{360});
  const Point far[] = {{60, 0}, {61, 0}, {61, 1}};
  const auto obstacles = border(far, 1.0);
  const CriticalPoints g = find_critical_points(obstacles, database);
  ObstacleImage image;
  map_as_published(obstacles, g, database, image);
  CspaceMap map(AngleGrid{360});
  map.block(image);
  (void)map;
}

}  // namespace
}  // namespace hecaton::planner::cspace
