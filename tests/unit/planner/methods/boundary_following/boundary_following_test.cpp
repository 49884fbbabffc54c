// [Lahouar06] figures 9 and 10 on hand-made constraints in a plane: U₁ = x, U₂ = y.
#include "planner/methods/boundary_following/boundary_following.hpp"

#include <array>

#include <gtest/gtest.h>

#include "tests/support/planar_point.hpp"

namespace hecaton::planner {
namespace {

using test::joints;

const JointLimits kLimits{joints({-3, -3}), joints({3, 3}), joints({1, 1}), joints({10, 10})};
const VelocityBounds kBounds{joints({-1, -1}), joints({1, 1})};

Row wall(double x, double y, double h, std::uint32_t key) {
  return {joints({x, y}), h, key, true, 0};
}

/// Begins at the origin with the goal along x, so that U₂ is ±y by the drawn limits.
struct Following {
  Following(const Row& blocking, std::uint64_t seed) : random(seed) {
    start_following(follower(), kLimits, joints({0, 0}), joints({2, 0}), blocking);
  }
  BoundaryFollower follower() { return {memory, deviation, random}; }

  FollowerMemory memory;
  Deviation deviation;
  Random random;
};

TEST(BoundaryFollower, StartsInThePlaneOfGoalAndLimits) {
  bool up = false;
  bool down = false;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Following following(wall(1, 0, 0, 1), seed);
    FollowerMemory& memory = following.memory;
    EXPECT_EQ(memory.U1, joints({1, 0}));
    EXPECT_NEAR(std::abs(memory.U2[1]), 1.0, 1e-12);  // orthogonal part of (±3, ±3)
    EXPECT_EQ(memory.d_lock, 2.0);
    up = up || memory.U2[1] > 0;
    down = down || memory.U2[1] < 0;
  }
  EXPECT_TRUE(up && down);  // drawn, not fixed
}

// Fig. 9: a wall across the way is followed along S at full speed, still keeping to it.
TEST(BoundaryFollower, FollowsTheWallToTheStepLimit) {
  const std::array rows{wall(1, 0, 0, 1)};
  Following following(rows[0], 1);
  FollowerMemory& memory = following.memory;
  const JointVector qd = follow_boundary(following.follower(), kBounds, rows).value();
  EXPECT_NEAR(qd[0], 0.0, 1e-12);
  EXPECT_NEAR(qd[1] * memory.U2[1], 1.0, 1e-12);  // +U₂: S = (−a₂, a₁)
}

// Fig. 10: in a corner the second wall takes over; here the only way out is back along it.
TEST(BoundaryFollower, SwitchesToTheWallThatBlocks) {
  Following following(wall(1, 0, 0, 1), 1);
  FollowerMemory& memory = following.memory;
  const double side = memory.U2[1];
  const std::array rows{wall(1, 0, 0, 1), wall(0, side, 0, 2)};  // x ≤ 0 and no further along U₂
  const JointVector qd = follow_boundary(following.follower(), kBounds, rows).value();
  EXPECT_GE(memory.switches_in_subspace, 1);
  EXPECT_NEAR(qd[0], -1.0, 1e-9);  // left turn from +U₂ is −U₁
  EXPECT_NEAR(qd[1], 0.0, 1e-9);
}

TEST(BoundaryFollower, TracksTheConstraintMostSimilarToTheFollowedOne) {
  Following following(wall(1, 0, 0, 1), 1);
  FollowerMemory& memory = following.memory;
  const double side = memory.U2[1];
  // The wall has turned by 30°; another stands behind.
  const std::array rows{wall(std::cos(0.52), -side * std::sin(0.52), 0, 1), wall(-1, 0, 0.4, 2)};
  const JointVector qd = follow_boundary(following.follower(), kBounds, rows).value();
  EXPECT_NEAR(memory.A_lock.x(), std::cos(0.52), 1e-9);
  EXPECT_GT(qd[0], 0.3);  // forwards along it
  EXPECT_LE(rows[0].g.dot(qd), 1e-9);
}

TEST(BoundaryFollower, ReturnsNothingWithoutAConstraintToFollow) {
  Following following(wall(1, 0, 0, 1), 1);
  EXPECT_FALSE(follow_boundary(following.follower(), kBounds, {}).has_value());
  const std::array behind{wall(-1, 0, 0.1, 2)};
  EXPECT_FALSE(follow_boundary(following.follower(), kBounds, behind).has_value());
}

TEST(BoundaryFollower, ResampledSubspaceIsOrthonormalAndForgetsTheWall) {
  Following following(wall(1, 0, 0, 1), 1);
  FollowerMemory& memory = following.memory;
  following.random = Random(3);
  const JointVector way = joints({1, 1});
  memory.time_in_subspace = 5.0;
  resample_subspace(following.follower(), way, {});
  EXPECT_NEAR(memory.U1.dot(memory.U2), 0.0, 1e-12);
  EXPECT_NEAR(memory.U2.norm(), 1.0, 1e-12);
  EXPECT_NEAR((memory.U1 - way.normalized()).norm(), 0.0, 1e-12);
  EXPECT_EQ(memory.time_in_subspace, 0.0);
  EXPECT_EQ(following.deviation.drawn, 2);
}

}  // namespace
}  // namespace hecaton::planner
