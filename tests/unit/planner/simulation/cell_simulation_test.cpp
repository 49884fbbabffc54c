// Episodes of small cells: unreachable goals, coupled plans, obstacles that pass, and arms at rest.
#include "planner/simulation/cell_simulation.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "planner/goal_progress.hpp"
#include "tests/support/corridor.hpp"
#include "tests/support/planar_point.hpp"

namespace hecaton::planner {
namespace {

using test::joints;

/// A ball whose goal lies in a closed courtyard of half a metre: no path leads there.
Cell courtyard() {
  Cell cell;
  cell.name = "courtyard";
  PlannedArm planned;
  planned.arm = test::planar_point();
  planned.parameters.damper = {.influence_distance = 0.12, .security_distance = 0.03, .convergence_speed = 0.55};
  planned.parameters.rollout.candidates = 0;
  cell.arms.push_back(planned);
  cell.tasks.time_limit = 20.0;
  const auto wall = [&](const char* name, double x, double y, double half_x, double half_y) {
    cell.scene.obstacles.push_back(test::box_obstacle(name, {x, y, 0.0}, {half_x, half_y, 0.5}));
  };
  wall("west", 0.7, 0.0, 0.02, 0.3);
  wall("east", 1.3, 0.0, 0.02, 0.3);
  wall("south", 1.0, -0.3, 0.32, 0.02);
  wall("north", 1.0, 0.3, 0.32, 0.02);
  return cell;
}

TEST(UnreachableGoal, EndsAsBlockedAlthoughTheArmMoves) {
  int periods = 0;
  int still = 0;
  EpisodeOptions options;
  std::optional<JointVector> before;
  options.observe = [&](double /*now*/, const CellConfiguration& q, std::span<const ArmPlanner> /*planners*/) {
    ++periods;
    if (before && (q[0] - *before).norm() < 1e-4) ++still;
    before = q[0];
  };
  const EpisodeOutcome outcome = simulate_episode(courtyard(), {joints({0, 0})}, {joints({1, 0})}, options);
  EXPECT_EQ(outcome.arms[0].outcome, TaskOutcome::kBlocked);
  EXPECT_DOUBLE_EQ(outcome.duration, 20.0) << "the arm searches until the time limit";
  EXPECT_LT(still, periods / 2);
  EXPECT_EQ(outcome.contact_report.contacts, 0U);
}

TEST(ProgressMonitor, IsNotStalledWhileTheDistanceDecreases) {
  ProgressMonitor progress;
  for (double distance = 3.0; distance > 0.1; distance *= 0.9) {
    progress.note(distance, 5.0);
    EXPECT_FALSE(progress.stalled());
  }
  progress.note(0.2, 11.0);
  EXPECT_TRUE(progress.stalled());
  EXPECT_DOUBLE_EQ(progress.time_without_progress(), 11.0);
  progress.restart();
  EXPECT_FALSE(progress.stalled()) << "a new goal";
}

/// Bay behind the start of the first arm: to let the other pass, the arm must first move away from its goal [m].
constexpr double kFarBay = -1.2;

/// The balls must reverse their order.
EpisodeOutcome reverse_order(int balls, double bay, double stall_timeout, const NetworkParameters& network = {}) {
  CellConfiguration starts;
  CellConfiguration goals;
  for (int i = 0; i < balls; ++i) {
    starts.push_back(test::corridor_start(i, balls));
    goals.push_back(test::corridor_goal(i, balls));
  }
  EpisodeOptions options;
  options.network = network;
  return simulate_episode(test::corridor(balls, bay, stall_timeout), starts, goals, options);
}

int reached(const EpisodeOutcome& outcome) {
  return static_cast<int>(std::count_if(outcome.arms.begin(), outcome.arms.end(),
                                        [](const ArmOutcome& arm) { return arm.outcome == TaskOutcome::kReached; }));
}

int proposed(const EpisodeOutcome& outcome) {
  int all = 0;
  for (const ArmOutcome& arm : outcome.arms) all += arm.coupled_plans;
  return all;
}

TEST(CoupledPlan, LetsTwoArmsPassEachOtherInACorridor) {
  const EpisodeOutcome outcome = reverse_order(2, kFarBay, 4.0);
  EXPECT_EQ(reached(outcome), 2);
  EXPECT_GE(proposed(outcome), 1);
  EXPECT_EQ(outcome.contact_report.contacts, 0U);
}

TEST(CoupledPlan, ArmsTimeOutWithoutIt) {
  const EpisodeOutcome outcome = reverse_order(2, kFarBay, 0.0);
  EXPECT_LT(reached(outcome), 2);
  EXPECT_EQ(proposed(outcome), 0);
  EXPECT_EQ(outcome.contact_report.contacts, 0U);
}

TEST(CoupledPlan, WorksWithDelayedAndLostStates) {
  const EpisodeOutcome outcome = reverse_order(2, kFarBay, 4.0, {.age = 0.1, .jitter = 0.05, .loss = 0.2});
  EXPECT_EQ(reached(outcome), 2);
  EXPECT_GE(proposed(outcome), 1);
  EXPECT_EQ(outcome.contact_report.contacts, 0U);
}

TEST(CoupledPlan, IsNotProposedWhereGivingWaySuffices) {
  const EpisodeOutcome outcome = reverse_order(2, 0.0, 4.0);
  EXPECT_EQ(reached(outcome), 2);
  EXPECT_EQ(proposed(outcome), 0);
}

// Sampling all joints together does not solve this; roadmaps of the single balls do.
TEST(CoupledPlan, LetsThreeArmsReverseTheirOrder) {
  const EpisodeOutcome outcome = reverse_order(3, kFarBay, 2.0);
  EXPECT_EQ(reached(outcome), 3);
  EXPECT_GE(proposed(outcome), 1);
  EXPECT_EQ(outcome.contact_report.contacts, 0U);
}

// An obstacle that recedes or passes does not slow an arm. What counts is whether it will come too close.

constexpr double kRadius = 0.05;     // of the point's ball and of the obstacle [m]
constexpr double kStraight = 1.0;    // distance to the goal, along x [m]
constexpr double kInfluence = 0.12;  // dᵢ [m]

struct Journey {
  std::vector<double> x;  ///< of the arm, period by period [m]
  double time = 0.0;      ///< until reached [s]
  bool reached = false;
  double nearest = 10.0;  ///< between the surfaces, while it moved [m]
};

/// A ball moves from the origin to (1, 0); an obstacle starts at `p` and moves at a constant `v` [m/s].
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

// The obstacle moves ahead at 0.6 m/s, 50 mm before an arm whose limit is 0.5 m/s. The damper allows
// 0.55 · (0.05 − 0.03)/(0.12 − 0.03) + 0.6 = 0.72 m/s or more, so that it does not act.
TEST(PassingObstacle, RecedingDoesNotSlowTheArm) {
  const Journey free = drive(false);
  ASSERT_TRUE(free.reached);
  const Journey receding = drive(true, {2.0 * kRadius + 0.05, 0, 0}, {0.6, 0, 0});
  EXPECT_LT(receding.nearest, kInfluence);
  EXPECT_EQ(receding.x, free.x);
}

// The obstacle crosses behind the arm, from left to right; n · v points away.
TEST(PassingObstacle, PassingBehindDoesNotSlowTheArm) {
  const Journey free = drive(false);
  const Journey passing = drive(true, {-2.0 * kRadius - 0.04, 0.3, 0}, {0, -1.5, 0});
  EXPECT_LT(passing.nearest, kInfluence);
  EXPECT_EQ(passing.x, free.x);
}

// The obstacle has just crossed the arm's path and moves away from it.
TEST(PassingObstacle, LeavingThePathDoesNotSlowTheArm) {
  const Journey free = drive(false);
  const Journey passing = drive(true, {0.15, 0.02, 0}, {0, 1.5, 0});
  EXPECT_LT(passing.nearest, kInfluence);
  EXPECT_EQ(passing.x, free.x);
}

// The obstacle approaches at 2 m/s and will pass 80 mm beside the arm.
TEST(PassingObstacle, PassingBesideDoesNotSlowTheArm) {
  const Journey free = drive(false);
  const Journey passing = drive(true, {1.2, 2.0 * kRadius + 0.08, 0}, {-2, 0, 0});
  EXPECT_LT(passing.nearest, kInfluence);
  EXPECT_EQ(passing.x, free.x);
}

// The obstacle crosses the path after 0.1 s, 250 mm ahead of the arm.
TEST(PassingObstacle, CrossingAheadDoesNotSlowTheArm) {
  const Journey free = drive(false);
  const Journey passing = drive(true, {0.25, -0.3, 0}, {0, 3, 0});
  EXPECT_LT(passing.nearest, 2.0 * kInfluence);
  EXPECT_EQ(passing.x, free.x);
}

// As above, but 10 mm beside the arm, which is less than dₛ: the arm gives way.
TEST(PassingObstacle, PassingTooCloseMakesTheArmGiveWay) {
  const Journey free = drive(false);
  const Journey passing = drive(true, {1.2, 2.0 * kRadius + 0.01, 0}, {-2, 0, 0});
  EXPECT_NE(passing.x, free.x);
  EXPECT_TRUE(passing.reached);
}

// The obstacle at rest at the same place slows the arm; so the tests above can fail.
TEST(PassingObstacle, StandingSlowsTheArm) {
  const Journey free = drive(false);
  const Journey staying = drive(true, {0.15, 0.02, 0});
  EXPECT_LT(staying.x[40], 0.9 * free.x[40]);
}

// Arms that have reached their goals. A ball in a closed courtyard with its goal outside keeps the episodes going.

PlannedArm resting_ball(const char* name) {
  PlannedArm planned;
  planned.arm = test::planar_point(name);
  planned.parameters.damper = {.influence_distance = 0.12, .security_distance = 0.03, .convergence_speed = 0.55};
  return planned;
}

struct Afterwards {
  EpisodeOutcome outcome;
  CellConfiguration q;       ///< at the end [m]
  double last_reach = 0.0;   ///< of the balls outside the courtyard [s]
  double last_motion = 0.0;  ///< the last time at which one of them was faster than 1 mm/s [s]
};

Afterwards reach_and_rest(std::vector<PlannedArm> balls, CellConfiguration starts, CellConfiguration goals,
                          const NetworkParameters& network = {}) {
  const std::size_t n = balls.size();
  Cell cell = courtyard();
  balls.push_back(cell.arms[0]);
  cell.arms = std::move(balls);
  starts.push_back(joints({1, 0}));
  goals.push_back(joints({0, 0}));
  Afterwards run;
  EpisodeOptions options;
  options.network = network;
  options.observe = [&](double now, const CellConfiguration& q, std::span<const ArmPlanner> /*planners*/) {
    for (std::size_t i = 0; i < n && !run.q.empty(); ++i) {
      if ((q[i] - run.q[i]).norm() > 1e-3 * cell.timing.control_period) run.last_motion = now;
    }
    run.q = q;
  };
  run.outcome = simulate_episode(cell, starts, goals, options);
  for (std::size_t i = 0; i < n; ++i) {
    const ArmOutcome& arm = run.outcome.arms[i];
    EXPECT_EQ(arm.outcome, TaskOutcome::kReached) << i << ": " << arm.reason;
    run.last_reach = std::max(run.last_reach, arm.time);
  }
  EXPECT_EQ(run.outcome.contact_report.contacts, 0U);
  return run;
}

// The goals are 0.08 m apart, but the centres of two balls need 2 · 0.05 m + dₛ.
TEST(ArmsAtRest, ComeToRestWithGoalsTooNearEachOther) {
  for (const double age : {0.0, 0.05}) {
    const Afterwards run =
        reach_and_rest({resting_ball("first"), resting_ball("second")}, {joints({-1.3, 0}), joints({-2.2, 0})},
                       {joints({-1, 0}), joints({-1.08, 0})}, {.age = age, .jitter = 0.4 * age});
    EXPECT_GT((run.q[0] - run.q[1]).norm(), 0.1 + 0.02) << "age " << age;
    EXPECT_LT(run.last_motion, run.last_reach + 4.0) << "age " << age;
    EXPECT_GT(run.outcome.duration, run.last_motion + 5.0) << "age " << age;
  }
}

// The second ball moves along a line, so that it cannot go around the first one.
TEST(ArmsAtRest, ReturnOnceAnotherArmHasPassed) {
  PlannedArm second = resting_ball("second");
  second.arm.limits.lower[1] = second.arm.limits.upper[1] = 0.0;
  const CellConfiguration goals{joints({-1, 0.06}), joints({-0.3, 0})};
  const Afterwards run =
      reach_and_rest({resting_ball("first"), second}, {joints({-1.2, 0.06}), joints({-2.2, 0})}, goals);
  EXPECT_GT(run.outcome.arms[0].yielding_ticks, 0);
  EXPECT_LT((run.q[0] - goals[0]).norm(), 3e-3);
  EXPECT_LT(run.last_motion, run.last_reach + 4.0);
}

}  // namespace
}  // namespace hecaton::planner
