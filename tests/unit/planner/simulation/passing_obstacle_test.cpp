// An obstacle that recedes or only passes by does not slow an arm down: what counts is whether it gets too near, not
// whether it is near or coming.
#include <algorithm>

#include <gtest/gtest.h>

#include "planner/simulation/cell_simulation.hpp"
#include "tests/support/planar_point.hpp"

namespace hecaton::planner {
namespace {

using test::joints;

constexpr double kRadius = 0.05;     // of the point's ball and of the obstacle [m]
constexpr double kStraight = 1.0;    // the way to go, along x [m]
constexpr double kInfluence = 0.12;  // dᵢ [m]

struct Journey {
  std::vector<double> x;  ///< of the arm, period by period [m]
  double time = 0.0;      ///< until reached [s]
  bool reached = false;
  double nearest = 10.0;  ///< between the surfaces, while it moved [m]
};

/// A ball goes from the origin to (1, 0); another one begins at `p` and moves at a constant `v` [m/s].
Journey drive(bool with_obstacle, const Eigen::Vector3d& p = Eigen::Vector3d::Zero(),
              const Eigen::Vector3d& v = Eigen::Vector3d::Zero()) {
  Cell cell;
  cell.name = "passing";
  PlannedArm planned;
  planned.arm = test::planar_point("point", kRadius);
  planned.parameters.damper = {.influence_distance = kInfluence, .security_distance = 0.03, .convergence_speed = 0.55};
  planned.parameters.rollout.candidates = 0;
  cell.arms.push_back(planned);
  cell.tasks.time_limit = 8.0;
  if (with_obstacle) {
    world::Obstacle ball;
    ball.name = "ball";
    ball.shapes.push_back({world::Sphere{kRadius}, world::Pose::Identity()});
    ball.X_WO.translation() = p;
    if (v.norm() > 0.0) ball.motion = world::ConveyorMotion{v.normalized(), v.norm(), 100.0};
    cell.scene.obstacles.push_back(ball);
  }
  Journey run;
  EpisodeOptions options;
  options.observe = [&](double now, const CellConfiguration& q, std::span<const ArmPlanner> /*planners*/) {
    run.x.push_back(q[0][0]);
    const Eigen::Vector3d centre(q[0][0], q[0][1], 0.0);
    if (q[0][0] < 0.99 * kStraight) run.nearest = std::min(run.nearest, (p + v * now - centre).norm() - 2.0 * kRadius);
  };
  const EpisodeOutcome outcome = simulate_episode(cell, {joints({0, 0})}, {joints({kStraight, 0})}, options);
  run.reached = outcome.arms[0].outcome == TaskOutcome::kReached;
  run.time = outcome.arms[0].time;
  EXPECT_EQ(outcome.contact_report.contacts, 0U);
  return run;
}

// It drives ahead at 0.6 m/s, 50 mm before an arm whose limit is 0.5 m/s: the damper allows
// 0.55 · (0.05 − 0.03)/(0.12 − 0.03) + 0.6 = 0.72 m/s and more, so nothing binds.
TEST(PassingObstacle, OneThatRecedesDoesNotSlowTheArm) {
  const Journey free = drive(false);
  ASSERT_TRUE(free.reached);
  const Journey receding = drive(true, {2.0 * kRadius + 0.05, 0, 0}, {0.6, 0, 0});
  EXPECT_LT(receding.nearest, kInfluence);
  EXPECT_EQ(receding.x, free.x);
}

// It crosses behind the arm, from the left to the right: the arm leaves it, n · v points away.
TEST(PassingObstacle, OneThatPassesBehindDoesNotSlowTheArm) {
  const Journey free = drive(false);
  const Journey passing = drive(true, {-2.0 * kRadius - 0.04, 0.3, 0}, {0, -1.5, 0});
  EXPECT_LT(passing.nearest, kInfluence);
  EXPECT_EQ(passing.x, free.x);
}

// It has crossed the arm's way just before it and is on its way out.
TEST(PassingObstacle, OneThatHasPassedDoesNotSlowTheArm) {
  const Journey free = drive(false);
  const Journey passing = drive(true, {0.15, 0.02, 0}, {0, 1.5, 0});
  EXPECT_LT(passing.nearest, kInfluence);
  EXPECT_EQ(passing.x, free.x);
}

// It comes at 2 m/s and will pass 80 mm beside the arm.
TEST(PassingObstacle, OneThatWillPassBesideDoesNotSlowTheArm) {
  const Journey free = drive(false);
  const Journey passing = drive(true, {1.2, 2.0 * kRadius + 0.08, 0}, {-2, 0, 0});
  EXPECT_LT(passing.nearest, kInfluence);
  EXPECT_EQ(passing.x, free.x);
}

// It will have crossed the way before the arm is there: after 0.1 s, 250 mm before where the arm then is.
TEST(PassingObstacle, OneThatWillCrossAheadDoesNotSlowTheArm) {
  const Journey free = drive(false);
  const Journey passing = drive(true, {0.25, -0.3, 0}, {0, 3, 0});
  EXPECT_LT(passing.nearest, 2.0 * kInfluence);
  EXPECT_EQ(passing.x, free.x);
}

// The same that comes, 10 mm beside the arm: less than dₛ, so the arm makes way.
TEST(PassingObstacle, OneThatWouldPassTooNearDoesNot) {
  const Journey free = drive(false);
  const Journey passing = drive(true, {1.2, 2.0 * kRadius + 0.01, 0}, {-2, 0, 0});
  EXPECT_NE(passing.x, free.x);
  EXPECT_TRUE(passing.reached);
}

// The same obstacle at the same place, at rest: now the arm has to slow down, so the above is not for nothing.
TEST(PassingObstacle, OneThatStaysSlowsTheArm) {
  const Journey free = drive(false);
  const Journey staying = drive(true, {0.15, 0.02, 0});
  EXPECT_LT(staying.x[40], 0.9 * free.x[40]);
}

}  // namespace
}  // namespace hecaton::planner
