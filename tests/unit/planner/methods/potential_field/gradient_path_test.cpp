#include "planner/methods/potential_field/gradient_path.hpp"

#include <gtest/gtest.h>

#include "field_setup.hpp"

namespace hecaton::planner::potential {
namespace {

using test::ball_obstacle;
using test::box_obstacle;
using test::FieldSetup;
using test::joints;

void expect_free(const Descent& descent, FreeMotion& motion) {
  for (std::size_t i = 1; i < descent.path.size(); ++i) {
    EXPECT_TRUE(motion.free(descent.path[i - 1], descent.path[i])) << i;
  }
}

TEST(GradientDescent, GoesStraightWhereNothingRepels) {
  FieldSetup setup(test::planar_point(), {});
  const Descent descent = setup.descend(joints({-1, 0}), joints({1, 0.5}));
  ASSERT_EQ(descent.outcome, DescentOutcome::kReached);
  EXPECT_LT((descent.path.back() - joints({1, 0.5})).norm(), 1e-12);
  for (const auto& q : descent.path) EXPECT_NEAR(q[1] - 0.25 * (q[0] + 1.0), 0.0, 1e-9);
}

TEST(GradientDescent, AvoidsABallOffTheLine) {
  FieldSetup setup(test::planar_point(), {ball_obstacle({0, 0.05, 0}, 0.2)});
  const Descent descent = setup.descend(joints({-1, 0}), joints({1, 0}));
  ASSERT_EQ(descent.outcome, DescentOutcome::kReached);
  expect_free(descent, setup.motion);
  EXPECT_FALSE(setup.motion.free(joints({-1, 0}), joints({1, 0})));
}

// The known limit of the method [Latombe91]: a wall across the way, its middle on the line.
TEST(GradientDescent, RecognisesALocalMinimum) {
  FieldSetup setup(test::planar_point(), {box_obstacle("wall", {0, 0, 0}, {0.1, 0.6, 0.2})});
  const Descent descent = setup.descend(joints({-1, 0}), joints({1, 0}));
  EXPECT_EQ(descent.outcome, DescentOutcome::kLocalMinimum) << describe(descent.outcome);
  EXPECT_LT(descent.path.back()[0], -0.1);
  EXPECT_LT(setup.at(descent.path.back()).gradient.norm(), 1e-3) << "there the gradient vanishes";
  expect_free(descent, setup.motion);
}

// "Vibrations … resulted from large step size α."
TEST(GradientDescent, RecognisesOscillationOfTooLargeSteps) {
  FieldSetup setup(test::planar_point(), {box_obstacle("wall", {0, 0, 0}, {0.1, 0.6, 0.2})});
  DescentOptions options;
  options.alpha = 1.0;
  const Descent descent = setup.descend(joints({-0.97, 0}), joints({1, 0}), options);
  EXPECT_EQ(descent.outcome, DescentOutcome::kOscillating) << describe(descent.outcome);
  expect_free(descent, setup.motion);
}

TEST(GradientDescent, AConstantSmallStepReachesTheGoalToo) {
  FieldSetup setup(test::planar_point(), {ball_obstacle({0, 0.05, 0}, 0.2)});
  DescentOptions options;
  options.alpha = 0.01;
  const Descent descent = setup.descend(joints({-1, 0}), joints({1, 0}), options);
  EXPECT_EQ(descent.outcome, DescentOutcome::kReached) << describe(descent.outcome);
  EXPECT_GT(descent.steps, 2 * setup.descend(joints({-1, 0}), joints({1, 0})).steps);
}

// Repulsion shifts the minimum away from the goal: the last stretch is straight.
TEST(GradientDescent, ReachesAGoalBesideAnObstacleExactly) {
  FieldSetup setup(test::planar_point(), {box_obstacle("wall", {1.2, 0, 0}, {0.1, 0.6, 0.2})});
  const JointVector goal = joints({1.02, 0});
  const Descent descent = setup.descend(joints({-1, 0.2}), goal);
  ASSERT_EQ(descent.outcome, DescentOutcome::kReached);
  EXPECT_EQ(descent.path.back(), goal);
  setup.field.set_goal(goal);
  EXPECT_GT(setup.at(goal).gradient[0], 0.01) << "the field pushes away from this goal";
}

TEST(GradientDescent, ReportsWhichEndIsBlocked) {
  FieldSetup setup(test::planar_point(), {box_obstacle("wall", {0, 0, 0}, {0.1, 0.6, 0.2})});
  EXPECT_EQ(setup.descend(joints({0, 0}), joints({1, 0})).outcome, DescentOutcome::kStartBlocked);
  EXPECT_EQ(setup.descend(joints({1, 0}), joints({0, 0})).outcome, DescentOutcome::kGoalBlocked);
  EXPECT_TRUE(setup.descend(joints({1, 0}), joints({0, 0})).path.empty());
}

TEST(GradientDescent, StaysWithinLimits) {
  Arm arm = test::planar_point();
  arm.limits.lower[1] = -0.05;  // the way below the ball
  FieldSetup setup(arm, {ball_obstacle({0, 0.05, 0}, 0.2)});
  const Descent descent = setup.descend(joints({-1, 0}), joints({1, 0}));
  EXPECT_NE(descent.outcome, DescentOutcome::kReached);
  for (const auto& q : descent.path) EXPECT_GE(q[1], -0.05);
}

TEST(GradientDescent, IsRepeatable) {
  FieldSetup setup(test::planar_point(), {ball_obstacle({0, 0.05, 0}, 0.2)});
  const Descent a = setup.descend(joints({-1, 0}), joints({1, 0}));
  const Descent b = setup.descend(joints({-1, 0}), joints({1, 0}));
  EXPECT_EQ(a.path, b.path);
}

}  // namespace
namespace {

using test::box_obstacle;
using test::FieldSetup;
using test::joints;

/// Round a wall, trembling.
std::vector<JointVector> trembling() {
  std::vector<JointVector> path;
  for (int i = 0; i <= 40; ++i) {
    const double x = -1.0 + 0.05 * i, away = i % 2 == 0 ? 0.02 : -0.02;
    path.push_back(joints({x, 0.8 - 0.6 * x * x + away}));
  }
  return path;
}

double sharpest_turn(const std::vector<JointVector>& path) {
  double least = 1.0;
  for (std::size_t i = 1; i + 1 < path.size(); ++i) {
    const JointVector a = path[i] - path[i - 1], b = path[i + 1] - path[i];
    least = std::min(least, a.dot(b) / (a.norm() * b.norm()));
  }
  return least;
}

TEST(RefinePath, RemovesVibrationsAndStaysFree) {
  FieldSetup setup(test::planar_point(), {box_obstacle("wall", {0, -0.2, 0}, {0.1, 0.8, 0.2})});
  const auto path = trembling();
  const auto refined = refine(path, setup.motion);
  EXPECT_EQ(refined.front(), path.front());
  EXPECT_EQ(refined.back(), path.back());
  EXPECT_LT(length(refined), length(path));
  EXPECT_GT(sharpest_turn(refined), sharpest_turn(path));
  EXPECT_GT(sharpest_turn(refined), 0.9);
  for (std::size_t i = 1; i < refined.size(); ++i) EXPECT_TRUE(setup.motion.free(refined[i - 1], refined[i])) << i;
}

TEST(RefinePath, IsAStraightLineWhereThatIsFree) {
  FieldSetup setup(test::planar_point(), {});
  const auto refined = refine(trembling(), setup.motion);
  EXPECT_NEAR(length(refined), (refined.back() - refined.front()).norm(), 1e-12);
}

TEST(RefinePath, ResamplesWithoutLeavingThePath) {
  FieldSetup setup(test::planar_point(), {});
  const std::vector<JointVector> path{joints({0, 0}), joints({1, 0}), joints({1, 1})};
  const auto finer = resample(path, setup.motion, 0.1);
  EXPECT_NEAR(length(finer), 2.0, 1e-12);
  for (std::size_t i = 1; i < finer.size(); ++i) EXPECT_LE(setup.motion.sweep(finer[i] - finer[i - 1]), 0.1 + 1e-9);
}

}  // namespace
}  // namespace hecaton::planner::potential
