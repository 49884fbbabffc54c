#include "planner/global/prm/prm.hpp"

#include <gtest/gtest.h>

#include "planner/global/plan.hpp"
#include "tests/support/puma_among_boxes.hpp"

namespace hecaton::planner::global {
namespace {

/// A PUMA whose tool must move around a post.
struct AroundAPost {
  std::vector<float> left{1.0F, -0.3F, 1.5F, 0.0F, 0.0F, 0.0F, 0.0F, 0.0F};
  std::vector<float> right{-1.0F, -0.3F, 1.5F, 0.0F, 0.0F, 0.0F, 0.0F, 0.0F};
  WorldBody post{world::Box{{0.05, 0.05, 0.5}}, Pose(Eigen::Translation3d(0.6, 0.15, 0.6)), "post"};
  Validity validity{{CellGeometry({test::puma()}, 0)}, std::vector{post}};
  Space space = space_of(validity, std::vector<double>(6, 0.0), std::vector<double>(6, 0.0));

  [[nodiscard]] SearchProblem problem() const { return {validity, space, left.data(), right.data(), 7, {20'000, {}}}; }
};

TEST(Prm, AStarAndDijkstraFindPathsOfEqualLength) {
  const AroundAPost query;
  ASSERT_FALSE(query.validity.edge_free(query.left.data(), query.right.data()))
      << "the post must block the straight edge";
  const SearchResult a_star = Prm().search(query.problem());
  const SearchResult dijkstra = Prm({.search = RoadmapSearch::kDijkstra}).search(query.problem());
  ASSERT_TRUE(a_star.solved() && dijkstra.solved());
  EXPECT_GT(a_star.path.size(), 2);
  EXPECT_NEAR(length(a_star.path, query.space), length(dijkstra.path, query.space), 1e-4);
}

TEST(Prm, RecordsItsNodesAndFreeEdges) {
  const AroundAPost query;
  SearchProblem problem = query.problem();
  SearchRecord record;
  problem.record = &record;
  const SearchResult found = Prm().search(problem);
  EXPECT_EQ(record.nodes.size(), found.nodes);
  ASSERT_FALSE(record.edges.empty());
  for (const auto& [a, b] : record.edges) {
    EXPECT_TRUE(query.validity.edge_free(record.nodes[a], record.nodes[b])) << a << " to " << b;
  }
}

}  // namespace
}  // namespace hecaton::planner::global
