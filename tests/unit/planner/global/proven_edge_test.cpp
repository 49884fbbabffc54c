/// Soundness of the edge check: an edge that is called free touches nothing, at configurations far closer together than
/// any that the check looks at. FCL is the reference.

#include <cmath>
#include <cstdlib>

#include <gtest/gtest.h>

#include "planner/global/plan.hpp"
#include "planner/global/validity.hpp"
#include "tests/support/fcl_collision_checker.hpp"
#include "tests/support/puma_among_boxes.hpp"
#include "tests/unit/planner/collision/random_cell.hpp"

namespace hecaton::planner::global {
namespace {

using Floats = std::vector<float>;

/// Number of edges that a test draws; HECATON_VALIDITY_EDGES=100000 for the long run.
int edges(int usual) {
  const char* wanted = std::getenv("HECATON_VALIDITY_EDGES");
  return wanted == nullptr ? usual : std::atoi(wanted);
}

struct EdgeTally {
  int edges = 0;
  int free = 0;           ///< called free
  int fcl_free = 0;       ///< no sample touches
  int touching = 0;       ///< called free although a sample touches
  int conservative = 0;   ///< not called free although no sample touches, with a margin that rounding does not explain
  int disagreements = 0;  ///< between lane widths, not explained by rounding
};

/// Smallest margin of any pair beyond its padding at steps + 1 configurations of the edge [m].
double sampled_margin(const Validity& validity, const Floats& a, const Floats& b, int steps) {
  double least = HUGE_VAL;
  std::vector<double> q(validity.dimensions());
  for (int k = 0; k <= steps; ++k) {
    for (std::size_t j = 0; j < q.size(); ++j) q[j] = a[j] + (static_cast<double>(b[j]) - a[j]) * k / steps;
    const Validity::Nearest tightest = validity.tightest(q);
    least = std::min(least, tightest.distance - tightest.required);
  }
  return least;
}

/// Random edges of `shortest` to `longest`; starts are mostly free.
void compare_edges(const Validity& validity, test::FclCollisionChecker& checker, Random& random, int count,
                   double shortest, double longest, EdgeTally& tally) {
  const Space space = space_of(validity);
  Floats a(space.stride), b(space.stride);
  for (int i = 0; i < count; ++i) {
    for (int draw = 0; draw < 30; ++draw) {
      space.sample(random, a.data());
      if (validity.state_free(a.data())) break;
    }
    space.sample(random, b.data());
    const float length = static_cast<float>(random.uniform(shortest, longest));
    space.interpolate(a.data(), b.data(), std::min(1.0F, length / space.distance(a.data(), b.data())), b.data());
    const bool free = validity.edge_free(a.data(), b.data());
    const double step = 0.002;
    const std::vector<std::vector<double>> path{{a.begin(), a.begin() + space.dimensions},
                                                {b.begin(), b.begin() + space.dimensions}};
    const bool fcl_free = checker.collisions_on(path, free ? step : 4.0 * step) == 0;
    ++tally.edges;
    tally.free += free ? 1 : 0;
    tally.fcl_free += fcl_free ? 1 : 0;
    tally.touching += free && !fcl_free ? 1 : 0;
    if (!free && fcl_free && sampled_margin(validity, a, b, 400) > 3e-4) ++tally.conservative;
    for (const ValidityKernel* kernel : supported_kernels()) {
      if (validity.edge_free(*kernel, a.data(), b.data(), {}) == free) continue;
      if (std::abs(sampled_margin(validity, a, b, 2000)) > 3e-4) ++tally.disagreements;
    }
  }
}

void expect_sound(const EdgeTally& tally) {
  EXPECT_EQ(tally.touching, 0) << "of " << tally.edges;
  EXPECT_EQ(tally.disagreements, 0) << "of " << tally.edges;
  EXPECT_GT(tally.free, tally.edges / 20);
  EXPECT_LT(tally.free, tally.edges);
  EXPECT_LE(tally.conservative, tally.fcl_free / 200) << "of " << tally.fcl_free;
  testing::Test::RecordProperty("edges", tally.edges);
  testing::Test::RecordProperty("free", tally.free);
  testing::Test::RecordProperty("fcl_free", tally.fcl_free);
  testing::Test::RecordProperty("conservative", tally.conservative);
}

TEST(ProvenEdge, NeverTouchesForPumaAmongBoxes) {
  Random random(31);
  EdgeTally tally;
  const int scenes = 10;
  for (int scene = 0; scene < scenes; ++scene) {
    const auto world = test::random_boxes(12, random);
    const Validity validity({CellGeometry({test::puma()}, 0)}, world);
    test::FclCollisionChecker checker(validity, world);
    compare_edges(validity, checker, random, edges(300) / scenes, 0.05, 2.5, tally);
  }
  expect_sound(tally);
}

// Links and obstacles of all kinds, joints about any axis, a carried obstacle.
TEST(ProvenEdge, NeverTouchesForAllShapes) {
  EdgeTally tally;
  Random random(32);
  const int cells = 30;
  for (int seed = 0; seed < cells; ++seed) {
    test::RandomCell cell(100 + seed, LinkShapes::kExact, 1, 6);
    test::Random places(seed);
    std::vector<Pose> X_WO;
    for (int i = 0; i < cell.geometry().obstacle_count(); ++i) X_WO.push_back(test::random_pose(places, 1.5));
    const auto world = world_bodies(cell.geometry(), X_WO, std::vector<JointVector>(1));
    const Validity validity({cell.geometry()}, world);
    test::FclCollisionChecker checker(validity, world);
    compare_edges(validity, checker, random, edges(300) / cells, 0.02, 1.0, tally);
  }
  expect_sound(tally);
}

TEST(ProvenEdge, NeverTouchesForTwoArms) {
  std::vector<Arm> arms{test::puma("a"), test::puma("b")};
  arms[1].X_WB.translation() = Eigen::Vector3d(0.9, 0.0, 0.0);
  Random random(33);
  const auto world = test::random_boxes(2, random);
  const Validity validity({CellGeometry(arms, 0), CellGeometry(arms, 1)}, world);
  test::FclCollisionChecker checker(validity, world);
  EdgeTally tally;
  compare_edges(validity, checker, random, edges(100), 0.05, 2.0, tally);
  expect_sound(tally);
}

TEST(ProvenEdge, DoesNotDependOnEarlierChecks) {
  Random random(34);
  const auto world = test::random_boxes(12, random);
  const Validity used({CellGeometry({test::puma()}, 0)}, world);
  const Space space = space_of(used);
  Floats a(space.stride), b(space.stride);
  for (int i = 0; i < 300; ++i) {
    space.sample(random, a.data());
    space.sample(random, b.data());
    space.interpolate(a.data(), b.data(), 0.2F, b.data());
    const Validity fresh({CellGeometry({test::puma()}, 0)}, world);
    EXPECT_EQ(used.edge_free(a.data(), b.data()), fresh.edge_free(a.data(), b.data()));
  }
}

}  // namespace
}  // namespace hecaton::planner::global
