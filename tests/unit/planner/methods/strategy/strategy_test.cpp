#include "planner/methods/strategy/strategy.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "planner/local/random.hpp"
#include "planner/methods/strategy/plane.hpp"

namespace hecaton::planner {
namespace {

JointVector vector(std::initializer_list<double> values) {
  JointVector v(static_cast<Eigen::Index>(values.size()));
  Eigen::Index i = 0;
  for (const double x : values) v[i++] = x;
  return v;
}

// u₁ along the first joint: what Gram–Schmidt makes of e₂, e₃, e₄ is e₂, e₃, e₄ themselves.
TEST(NullSpaceBasisTest, EqualsTheOtherAxesForAMotionOfTheFirstJoint) {
  const NullSpaceBasis basis = null_space_basis(vector({1, 0, 0, 0}));
  NullSpaceBasis expected = NullSpaceBasis::Zero(3, 4);
  expected(0, 1) = expected(1, 2) = expected(2, 3) = 1.0;
  EXPECT_TRUE(basis.isApprox(expected, 1e-15)) << basis;
}

// u₁ = e₂ leaves nothing of e₂: it is passed over, and e₁ comes last.
TEST(NullSpaceBasisTest, SkipsAnAxisParallelToTheMotion) {
  const NullSpaceBasis basis = null_space_basis(vector({0, 1, 0, 0}));
  NullSpaceBasis expected = NullSpaceBasis::Zero(3, 4);
  expected(0, 2) = expected(1, 3) = expected(2, 0) = 1.0;
  EXPECT_TRUE(basis.isApprox(expected, 1e-15)) << basis;
}

TEST(NullSpaceBasisTest, IsOrthonormalForAnyNumberOfJoints) {
  Random random(5);
  for (int trial = 0; trial < 10000; ++trial) {
    const int n = 2 + static_cast<int>(random.next() % (kMaxJoints - 1));
    JointVector u1(n);
    for (double& x : u1) x = random.uniform() < 0.3 ? 0.0 : random.normal();
    if (u1.norm() < 1e-3) u1[0] = 1.0;
    u1.normalize();
    const NullSpaceBasis basis = null_space_basis(u1);
    ASSERT_EQ(basis.rows(), n - 1);
    EXPECT_LT((basis * u1).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_TRUE((basis * basis.transpose()).isIdentity(1e-12));
  }
}

// eq. 7 with v₁ = e₂, v₂ = e₃, v₃ = e₄: (0, 1, 2, −2)/3, and its opposite for λ = −1.
TEST(ReducedSubspaceTest, TurnsInTheDirectionOfTheStrategy) {
  Strategy strategy;
  strategy.coefficients[0] = 2.0;
  strategy.coefficients[1] = -2.0;
  const ReducedSubspace plane = reduced_subspace(vector({0.5, 1, 1, 1}), vector({2.5, 1, 1, 1}), strategy);
  EXPECT_DOUBLE_EQ(plane.distance, 2.0);
  EXPECT_TRUE(plane.u2.isApprox(vector({0, 1, 2, -2}) / 3.0, 1e-15));
  EXPECT_TRUE(plane.at(2.0, 0.0).isApprox(vector({2.5, 1, 1, 1}), 1e-15));
  strategy.direction = -1.0;
  EXPECT_TRUE(reduced_subspace(vector({0, 0, 0, 0}), vector({1, 0, 0, 0}), strategy)
                  .u2.isApprox(vector({0, -1, -2, 2}) / 3.0, 1e-15));
}

// The footnote of section 4: uᵀ is perpendicular to uᶠ and in the plane, wherever the arm is.
TEST(PlaneTest, NeighboursAreAStepAlongAndAcrossTheLineToTheGoal) {
  baseline::PlaneState state;
  state.at = {0.0, 3.0};
  const baseline::PlaneFrame frame = baseline::plane_frame(state.at, 4.0);
  EXPECT_DOUBLE_EQ(frame.left, 5.0);  // 3-4-5
  const baseline::PlanePoint forward = baseline::neighbour(state, frame, 4.0, 0.5, 0);
  EXPECT_DOUBLE_EQ(forward.x, 0.4);
  EXPECT_DOUBLE_EQ(forward.y, 2.7);
  const baseline::PlanePoint across = baseline::neighbour(state, frame, 4.0, 0.5, 2);
  EXPECT_DOUBLE_EQ(across.x, 0.3);
  EXPECT_DOUBLE_EQ(across.y, 3.4);
  state.side = -1.0;
  const baseline::PlanePoint other = baseline::neighbour(state, frame, 4.0, 0.5, 2);
  EXPECT_DOUBLE_EQ(other.x, -0.3);
  EXPECT_DOUBLE_EQ(other.y, 2.6);
}

TEST(PlaneTest, LastStepEndsAtTheGoal) {
  baseline::PlaneState state;
  state.at = {3.9, 0.01};
  const baseline::PlanePoint last = baseline::neighbour(state, baseline::plane_frame(state.at, 4.0), 4.0, 0.5, 0);
  EXPECT_EQ(last.x, 4.0);
  EXPECT_EQ(last.y, 0.0);
}

/// From the origin to (1, 0) in the plane of two joints, with steps of 0.1.
StrategyMemory under_way() {
  StrategyMemory memory;
  StrategyParameters parameters;
  parameters.joints = 2;
  begin_strategy(parameters, vector({0, 0}), vector({1, 0}), memory);
  return memory;
}

TEST(StepRuleTest, GoesStraightInFreeSpace) {
  StrategyMemory memory = under_way();
  const IsFree anywhere = [](const JointVector&) { return true; };
  for (int k = 0; k < 11; ++k) take_step(0.1, anywhere, memory);  // ten, but for rounding
  EXPECT_EQ(memory.x, memory.plane.distance);
  EXPECT_EQ(memory.y, 0.0);
  EXPECT_EQ(memory.side, 1.0);
}

// Behind x = 0.55 only y ≥ 0.25 is free: up along the wall, then across.
TEST(StepRuleTest, AvoidsAnObstacle) {
  StrategyMemory memory = under_way();
  const IsFree is_free = [](const JointVector& q) { return q[0] < 0.55 || q[0] > 0.75 || q[1] >= 0.25; };
  double highest = 0.0;
  int steps = 0;
  while (memory.x != 1.0 && steps < 100) {
    take_step(0.1, is_free, memory);
    ASSERT_TRUE(is_free(memory.plane.at(memory.x, memory.y)));
    highest = std::max(highest, memory.y);
    ++steps;
  }
  EXPECT_LT(steps, 30);
  EXPECT_GT(highest, 0.25);
  EXPECT_EQ(memory.side, 1.0);
}

TEST(StepRuleTest, ChangesTheLocalDirectionAndStaysWhenNothingIsFree) {
  StrategyMemory memory = under_way();
  take_step(
      0.1, [](const JointVector&) { return false; }, memory);
  EXPECT_EQ(memory.x, 0.0);
  EXPECT_EQ(memory.side, -1.0);
  // Now only what is aside to the other side is free.
  take_step(
      0.1, [](const JointVector& q) { return q[1] < -0.05; }, memory);
  EXPECT_LT(memory.y, 0.0);
}

}  // namespace
}  // namespace hecaton::planner
