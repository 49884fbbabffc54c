/// Fast geometry never reports more clearance than the links' own shapes have.

#include <gtest/gtest.h>

#include "planner/collision/exact_distance.hpp"
#include "random_cell.hpp"

namespace hecaton::planner {
namespace {

constexpr int kFastCapacity = 4096;  // more than any of these cells has pairs
constexpr double kFar = 100.0;       // every pair is nearer [m]
constexpr double kAccuracy = 1e-6;   // by which the exact distance may fall short of the true one [m]

TEST(FastGeometry, NeverReportsMoreClearanceThanTheExactShapesHave) {
  long pairs = 0;
  long nearer = 0;
  std::vector<Clearance> fast(kFastCapacity);
  std::vector<Clearance> exact(kFastCapacity);
  for (std::uint64_t seed = 1; pairs < 1'000'000; ++seed) {
    test::RandomCell fast_cell(seed, LinkShapes::kFast);
    test::RandomCell exact_cell(seed, LinkShapes::kExact);
    ExactDistance fast_pass(fast_cell.geometry());
    ExactDistance exact_pass(exact_cell.geometry());
    for (int pose = 0; pose < 20; ++pose) {
      fast_cell.shuffle();
      exact_cell.shuffle();
      const int count = exact_pass.clearances(exact_cell.poses(), {kFar, kFar, {}}, exact);
      ASSERT_EQ(fast_pass.clearances(fast_cell.poses(), {kFar, kFar, {}}, fast), count);
      for (int i = 0; i < count; ++i) {
        ASSERT_EQ(fast[i].own_body, exact[i].own_body);
        ASSERT_EQ(fast[i].other_body, exact[i].other_body);
        ASSERT_LE(fast[i].distance, exact[i].distance + kAccuracy) << "seed " << seed << ", pose " << pose;
        if (fast[i].counterpart == Counterpart::kSelf) {
          ASSERT_EQ(fast[i].distance, exact[i].distance);
        }
        nearer += fast[i].distance < exact[i].distance - kAccuracy ? 1 : 0;
      }
      pairs += count;
    }
  }
  EXPECT_GT(nearer, pairs / 10) << "capsules replace too few shapes for this test";
}

TEST(FastGeometry, NormalLeadsOutOfOverlap) {
  // A translation of the own body along −n by the depth separates the two, also where a capsule replaces its shape.
  std::vector<Clearance> found(kFastCapacity);
  int overlapping = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    test::RandomCell cell(seed, LinkShapes::kFast);
    ExactDistance pass(cell.geometry());
    for (int pose = 0; pose < 20; ++pose) {
      cell.shuffle();
      const int count = pass.clearances(cell.poses(), {0.0, 0.0, {}}, found);
      for (int i = 0; i < count; ++i) {
        const Clearance& c = found[i];
        EXPECT_LT(c.distance, 0.0);
        EXPECT_NEAR(c.n_W.norm(), 1.0, 1e-9);
        if (c.counterpart != Counterpart::kObstacle) continue;
        const Body& own = cell.geometry().own_bodies()[c.own_body];
        const Body& other = cell.geometry().obstacle_bodies(c.other)[c.other_body];
        Pose X_WS = cell.poses().own->X_WL[own.link] * own.X_CS;
        X_WS.pretranslate(c.n_W * (c.distance - 1e-4));
        const Pose X_WO = cell.poses().obstacles[c.other].X_WO * other.X_CS;
        EXPECT_GT(shape_distance(own.shape, X_WS, other.shape, X_WO).distance, 0.0);
        ++overlapping;
      }
    }
  }
  EXPECT_GT(overlapping, 100);
}

}  // namespace
}  // namespace hecaton::planner
