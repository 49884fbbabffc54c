#include "planner/methods/sensed_cspace/obstacle_mapper.hpp"

#include <gtest/gtest.h>

#include "planner/methods/sensed_cspace/direction_kernel.hpp"
#include "planner/methods/sensed_cspace/published/published_mapper.hpp"
#include "planner/simd/instruction_set.hpp"
#include "tests/support/brute_force_cspace.hpp"

namespace hecaton::planner::cspace {
namespace {

struct Difference {
  int missed = 0;  ///< blocked by brute force only
  int extra = 0;   ///< blocked by the mapper only
};

Difference compare(const CspaceMap& truth, const CspaceMap& map) {
  Difference difference;
  const int cells = truth.grid().cells;
  for (int row = 0; row < cells; ++row) {
    for (int column = 0; column < cells; ++column) {
      difference.missed += truth.blocked(row, column) && !map.blocked(row, column) ? 1 : 0;
      difference.extra += !truth.blocked(row, column) && map.blocked(row, column) ? 1 : 0;
    }
  }
  return difference;
}

CspaceMap mapped(ObstacleMapper& mapper, std::span<const Point> corners) {
  ObstacleImage image;
  CspaceMap map(mapper.grid());
  mapper.map(convex_piece(corners), image);
  map.block(image);
  return map;
}

// One point, by hand: l₁ = l₂ = 20, w = 1, the point at (20, 20). With θ₁ = 0 the elbow is at (20, 0), straight below
// at s = 20: θ₂ = 90° ± asin(1/20) = 90° ± 2.87°, cells 87° … 93° ∩ [87.13°, 92.87°] = 88° … 92°.
TEST(ObstacleMapper, MapsAPointToTheAngleOfEquation5) {
  ObstacleMapper mapper(PlanarArm{}, AngleGrid{360});
  const Point point[] = {{20.0, 20.0}};
  const CspaceMap map = mapped(mapper, point);
  for (int degree = -180; degree < 180; ++degree) {
    EXPECT_EQ(map.blocked(180, degree + 180), degree >= 88 && degree <= 92) << degree;
  }
  // With θ₁ = 45° the first link points at it (r = 28.3): the second one has it at θ₂ = 0, s = 8.28, ± 6.93°.
  for (int degree = -180; degree < 180; ++degree) {
    EXPECT_EQ(map.blocked(225, degree + 180), degree >= -6 && degree <= 6) << degree;
  }
  // With θ₁ = 160° nothing reaches it: its elbow is 40.9 away.
  for (int column = 0; column < 360; ++column) EXPECT_FALSE(map.blocked(340, column));
}

TEST(ObstacleMapper, BlocksEveryTheta2WhereTheFirstLinkTouches) {
  ObstacleMapper mapper(PlanarArm{}, AngleGrid{360});
  const Point point[] = {{10.0, 0.0}};  // asin(1/10) = 5.74°
  const CspaceMap map = mapped(mapper, point);
  for (int degree = -180; degree < 180; ++degree) {
    bool all = true;
    for (int column = 0; column < 360; ++column) all = all && map.blocked(degree + 180, column);
    EXPECT_EQ(all, std::abs(degree) <= 5) << degree;
  }
}

/// Target R4's zero: no cell is missed. Nor is any blocked for nothing, but for ties within rounding.
void expect_exact(int arms, int obstacles_each, AngleGrid grid, std::uint64_t seed) {
  Random random(seed);
  int extra = 0;
  for (int i = 0; i < arms; ++i) {
    PlanarArm arm;
    if (i > 0) {
      arm = {random.uniform(5.0, 30.0), random.uniform(5.0, 30.0), random.uniform(0.1, 3.0), random.uniform(0.1, 3.0)};
    }
    ObstacleMapper mapper(arm, grid);
    const test::BruteForce brute_force(arm, grid);
    for (int k = 0; k < obstacles_each; ++k) {
      const std::vector<Point> corners = test::random_convex(random, arm);
      const Difference difference = compare(brute_force.map(corners), mapped(mapper, corners));
      ASSERT_EQ(difference.missed, 0) << "arm " << i << ", obstacle " << k;
      extra += difference.extra;
    }
  }
  EXPECT_EQ(extra, 0);
}

TEST(ObstacleMapper, MissesNoCellOfThePapersArm) {
  expect_exact(1, 300, AngleGrid{360}, 19960812);
}
TEST(ObstacleMapper, MissesNoCellOfArmsOfAnyLengthsAndWidths) {
  expect_exact(60, 40, AngleGrid{120}, 7);
}

// Of what sensors see: the union over boundary points, inflated by half of what is between two of them.
TEST(ObstacleMapper, TheUnionOverBoundaryPointsMissesNoCell) {
  constexpr double kSpacing = 1.0;
  const AngleGrid grid{360};
  Random random(77);
  int cells = 0;
  for (int i = 0; i < 12; ++i) {
    PlanarArm arm;
    if (i > 0) arm = {random.uniform(5.0, 30.0), random.uniform(5.0, 30.0), random.uniform(0.1, 3.0), 1.0};
    ObstacleMapper mapper(arm.grown(0.5 * kSpacing), grid);
    const test::BruteForce brute_force(arm, grid);
    for (int k = 0; k < 12; ++k) {
      const std::vector<Point> corners = test::random_convex(random, arm);
      CspaceMap map(grid);
      for (const Point& point : border_points(corners, kSpacing)) map.block(mapped(mapper, std::span(&point, 1)));
      const CspaceMap truth = brute_force.map(corners);
      EXPECT_EQ(compare(truth, map).missed, 0) << "arm " << i << ", obstacle " << k;
      cells += truth.blocked_cells();
    }
  }
  EXPECT_GT(cells, 100'000);
}

TEST(ObstacleMapper, MissesNoCellNearTheElbowAndTheBase) {
  // What random obstacles seldom do: surround the elbow's circle, lie on it, begin right beside the base.
  const std::vector<std::vector<Point>> obstacles = {
      {{19, -1}, {21, -1}, {21, 1}, {19, 1}},
      {{20, 0}},
      {{2.1, -30}, {2.1, 30}},
      {{2.1, -30}, {2.1, 30}, {40, 0}},
      {{-3, 2}, {3, 2}, {0, 50}},
      {{39, -3}, {45, -3}, {45, 3}, {39, 3}},
      {{41.2, -3}, {45, -3}, {45, 3}, {41.2, 3}},
  };
  for (const double length2 : {5.0, 20.0, 33.0}) {
    const PlanarArm arm{20.0, length2, 1.0, 1.5};
    ObstacleMapper mapper(arm, AngleGrid{360});
    const test::BruteForce brute_force(arm, AngleGrid{360});
    for (std::size_t i = 0; i < obstacles.size(); ++i) {
      const Difference difference = compare(brute_force.map(obstacles[i]), mapped(mapper, obstacles[i]));
      EXPECT_EQ(difference.missed, 0) << i << " " << length2;
      EXPECT_EQ(difference.extra, 0) << i << " " << length2;
    }
  }
}

TEST(DirectionKernel, GivesTheSameBitsOnEveryInstructionSet) {
  if (!has_avx2()) GTEST_SKIP() << "this machine has one instruction set only";
  Random random(3);
  for (int round = 0; round < 200; ++round) {
    const ConvexPiece obstacle = convex_piece(test::random_convex(random, PlanarArm{}));
    std::array<double, 8> x, y, c, s;
    for (int i = 0; i < 8; ++i) {
      const double angle = random.uniform(-kPi, kPi);
      c[i] = std::cos(angle);
      s[i] = std::sin(angle);
      x[i] = 20.0 * c[i];
      y[i] = 20.0 * s[i];
    }
    std::array<double, 8> right_a, left_a, right_b, left_b;
    const DirectionQuery query{x.data(), y.data(), c.data(), s.data(), &obstacle, 20.0, 1.0};
    baseline::touching_directions(query, 8, right_a.data(), left_a.data());
    avx2::touching_directions(query, 8, right_b.data(), left_b.data());
    EXPECT_EQ(right_a, right_b);
    EXPECT_EQ(left_a, left_b);
  }
}

}  // namespace
}  // namespace hecaton::planner::cspace
