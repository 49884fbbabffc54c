// Three balls in a closed corridor with one bay: to change their order, they must use the bay in turn.
#include "planner/global/super_graph.hpp"

#include <algorithm>
#include <limits>
#include <memory>

#include <gtest/gtest.h>

#include "tests/support/planar_point.hpp"

namespace hecaton::planner::global {
namespace {

using test::joints;
using Configuration = std::vector<double>;

constexpr double kPadding = 0.03;
constexpr double kRadius = 0.05;

WorldBody wall(double x_from, double x_to, double y_from, double y_to) {
  WorldBody body{world::Box{{0.5 * (x_to - x_from), 0.5 * (y_to - y_from), 0.5}}, Pose::Identity(), "wall"};
  body.X_WS.translation() = Eigen::Vector3d(0.5 * (x_from + x_to), 0.5 * (y_from + y_to), 0.0);
  return body;
}

/// 0.22 m wide; the bay is at the western end.
std::vector<WorldBody> corridor(bool bay) {
  std::vector<WorldBody> walls{wall(-1.6, 1.6, -0.21, -0.11), wall(-1.6, bay ? -1.4 : -0.9, 0.11, 0.6),
                               wall(-1.0, 1.6, 0.11, 0.6),    wall(-1.6, -0.8, 0.5, 0.6),
                               wall(-1.7, -1.55, -0.2, 0.6),  wall(1.55, 1.7, -0.2, 0.6)};
  return walls;
}

struct Puzzle {
  explicit Puzzle(bool bay) : walls(corridor(bay)) {
    std::vector<Arm> arms;
    for (int i = 0; i < 3; ++i) {
      arms.push_back(test::planar_point("ball" + std::to_string(i), kRadius));
      arms.back().limits.lower = joints({-1.5, -0.11});
      arms.back().limits.upper = joints({1.5, 0.5});
    }
    std::vector<CellGeometry> geometries;
    for (int i = 0; i < 3; ++i) geometries.emplace_back(arms, i);
    ValidityOptions options;
    options.padding = kPadding;
    graph = std::make_unique<SuperGraph>(geometries, options);
    graph->set_world(walls);
    all = std::make_unique<Validity>(geometries, walls, options);
  }
  std::vector<WorldBody> walls;
  std::unique_ptr<SuperGraph> graph;
  std::unique_ptr<Validity> all;
  Configuration start{-1, 0, 0, 0, 1, 0};
  Configuration goal{1, 0, 0, 0, -1, 0};
};

TEST(SuperGraph, ThreeBallsReverseTheirOrderInACorridor) {
  const Puzzle puzzle(true);
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Plan plan = puzzle.graph->plan(puzzle.start, puzzle.goal, seed);
    ASSERT_TRUE(plan.solved()) << "seed " << seed << ": " << plan.reason;
    EXPECT_EQ(plan.path.front(), puzzle.start);
    EXPECT_EQ(plan.path.back(), puzzle.goal);
    EXPECT_GT(plan.checks, 0U);
    std::vector<float> a(puzzle.all->stride(), 0.0F);
    std::vector<float> b(puzzle.all->stride(), 0.0F);
    for (std::size_t i = 0; i + 1 < plan.path.size(); ++i) {
      std::copy(plan.path[i].begin(), plan.path[i].end(), a.begin());
      std::copy(plan.path[i + 1].begin(), plan.path[i + 1].end(), b.begin());
      EXPECT_TRUE(puzzle.all->edge_free(a.data(), b.data())) << "seed " << seed << ", step " << i;
    }
  }
}

TEST(SuperGraph, OneArmMovesAtATimeAndAllKeepTheirDistance) {
  const Puzzle puzzle(true);
  const Plan plan = puzzle.graph->plan(puzzle.start, puzzle.goal, 1);
  ASSERT_TRUE(plan.solved()) << plan.reason;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i + 1 < plan.path.size(); ++i) {
    int moving = 0;
    for (std::size_t arm = 0; arm < 3; ++arm) {
      moving += plan.path[i][2 * arm] != plan.path[i + 1][2 * arm] ||
                plan.path[i][2 * arm + 1] != plan.path[i + 1][2 * arm + 1];
    }
    EXPECT_LE(moving, 1) << "step " << i;
    for (int k = 0; k <= 20; ++k) {
      const auto at = [&](std::size_t arm) {
        const auto coordinate = [&](std::size_t j) {
          return plan.path[i][j] + 0.05 * k * (plan.path[i + 1][j] - plan.path[i][j]);
        };
        return Eigen::Vector2d(coordinate(2 * arm), coordinate(2 * arm + 1));
      };
      nearest = std::min({nearest, (at(0) - at(1)).norm(), (at(0) - at(2)).norm(), (at(1) - at(2)).norm()});
    }
  }
  // Between checked configurations, 30 mm apart, two balls may come slightly closer.
  EXPECT_GT(nearest, 2.0 * kRadius + kPadding - 0.005);
}

TEST(SuperGraph, ReportsThatThereIsNoPathWithoutABay) {
  const Puzzle puzzle(false);
  SuperGraphOptions options;
  options.nodes = 16;
  options.doublings = 1;
  const Plan plan = puzzle.graph->plan(puzzle.start, puzzle.goal, 1, options);
  EXPECT_FALSE(plan.solved());
  EXPECT_TRUE(plan.path.empty());
  EXPECT_FALSE(plan.reason.empty());
}

TEST(SuperGraph, SameSeedGivesSamePlan) {
  const Plan one = Puzzle(true).graph->plan(Puzzle(true).start, Puzzle(true).goal, 7);
  const Plan two = Puzzle(true).graph->plan(Puzzle(true).start, Puzzle(true).goal, 7);
  EXPECT_EQ(one.path, two.path);
  EXPECT_EQ(one.checks, two.checks);
  EXPECT_EQ(one.iterations, two.iterations);
}

// If one arm has no path of its own, the product is not searched.
TEST(SuperGraph, EndsAtOnceWhenAnArmIsEnclosed) {
  Puzzle puzzle(true);
  puzzle.walls.push_back(wall(0.45, 0.55, -0.2, 0.2));
  puzzle.graph->set_world(puzzle.walls);
  const Plan plan = puzzle.graph->plan(puzzle.start, puzzle.goal, 1);
  EXPECT_FALSE(plan.solved());
  EXPECT_EQ(plan.iterations, 0U);
}

}  // namespace
}  // namespace hecaton::planner::global
