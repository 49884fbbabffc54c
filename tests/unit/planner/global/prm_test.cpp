#include "planner/global/prm.hpp"

#include <gtest/gtest.h>

#include "planner/global/plan.hpp"
#include "tests/support/puma_among_boxes.hpp"

namespace hecaton::planner::global {
namespace {

/// A PUMA with its tool to either side of a post that may stand in front of it.
struct Side {
  std::vector<float> left{1.0F, -0.3F, 1.5F, 0.0F, 0.0F, 0.0F, 0.0F, 0.0F};
  std::vector<float> right{-1.0F, -0.3F, 1.5F, 0.0F, 0.0F, 0.0F, 0.0F, 0.0F};
  WorldBody post{world::Box{{0.05, 0.05, 0.5}}, Pose(Eigen::Translation3d(0.6, 0.15, 0.6)), "post"};
  Validity validity{{CellGeometry({test::puma()}, 0)}, {}};
  Space space = space_of(validity, std::vector<double>(6, 0.0), std::vector<double>(6, 0.0));

  [[nodiscard]] SearchProblem problem() const { return {validity, space, left.data(), right.data(), 7, {20'000, {}}}; }
  [[nodiscard]] bool free(const Points& path) const {
    for (int i = 0; i + 1 < path.size(); ++i) {
      if (!validity.edge_free(path[i], path[i + 1])) return false;
    }
    return path.size() >= 2;
  }
};

TEST(Roadmap, IsRevalidatedWhenAnObstacleComesAndGoes) {
  Side side;
  ASSERT_TRUE(side.validity.state_free(side.left.data()) && side.validity.state_free(side.right.data()));
  Roadmap roadmap(side.space);
  const SearchResult straight = roadmap.query(side.problem());
  ASSERT_TRUE(straight.solved);
  EXPECT_EQ(straight.path.size(), 2);

  side.validity.set_world(std::vector{side.post});
  ASSERT_TRUE(side.validity.state_free(side.left.data()) && side.validity.state_free(side.right.data()));
  ASSERT_FALSE(side.validity.edge_free(side.left.data(), side.right.data())) << "the post is in no way";
  roadmap.world_changed();
  const SearchResult around = roadmap.query(side.problem());
  ASSERT_TRUE(around.solved);
  EXPECT_GT(around.path.size(), 2);
  EXPECT_TRUE(side.free(around.path));

  // The same world: nothing is learnt anew.
  const int nodes = roadmap.nodes();
  const SearchResult again = roadmap.query(side.problem());
  EXPECT_EQ(again.iterations, 0U);
  EXPECT_EQ(roadmap.nodes(), nodes);

  side.validity.set_world({});
  roadmap.world_changed();
  EXPECT_EQ(roadmap.query(side.problem()).path.size(), 2) << "what blocked the straight way has gone";
}

TEST(Roadmap, AStarAndDijkstraFindWaysOfTheSameLength) {
  Side side;
  side.validity.set_world(std::vector{side.post});
  PrmOptions options;
  const SearchResult a_star = prm(side.problem(), options);
  options.search = RoadmapSearch::kDijkstra;
  const SearchResult dijkstra = prm(side.problem(), options);
  ASSERT_TRUE(a_star.solved && dijkstra.solved);
  EXPECT_NEAR(length(a_star.path, side.space), length(dijkstra.path, side.space), 1e-4);
}

}  // namespace
}  // namespace hecaton::planner::global
