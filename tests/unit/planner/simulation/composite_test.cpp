// Two arms that stand in each other's only way: what a rule of who makes room resolves late, a plan for both does soon.
#include <algorithm>

#include <gtest/gtest.h>

#include "planner/simulation/cell_simulation.hpp"
#include "tests/support/planar_point.hpp"

namespace hecaton::planner {
namespace {

using test::joints;

/// Behind where the first arm starts: who lets the other pass must first go away from its goal [m].
constexpr double kFarBay = -1.2;

/// Balls of 0.1 m in a closed corridor 0.22 m wide and 3 m long, with a bay of 0.4 m at `bay` where one of them can let
/// others pass.
Cell corridor(int balls, double bay, double together_after) {
  Cell cell;
  cell.name = "corridor";
  for (int i = 0; i < balls; ++i) {
    PlannedArm planned;
    planned.arm = test::planar_point("ball" + std::to_string(i));
    planned.arm.limits.lower = joints({-1.5, -0.11});  // else most of what a search draws lies in the walls
    planned.arm.limits.upper = joints({1.5, 0.5});
    planned.parameters.damper = {.influence_distance = 0.12, .security_distance = 0.02, .convergence_speed = 0.5};
    planned.parameters.route.together_after = together_after;
    cell.arms.push_back(planned);
  }
  cell.tasks.time_limit = balls > 2 ? 90.0 : 25.0;
  const auto wall = [&](const char* name, double x_from, double x_to, double y_from, double y_to) {
    cell.scene.obstacles.push_back(test::box_obstacle(name, {0.5 * (x_from + x_to), 0.5 * (y_from + y_to), 0.0},
                                                      {0.5 * (x_to - x_from), 0.5 * (y_to - y_from), 0.5}));
  };
  wall("south", -1.6, 1.6, -0.21, -0.11);
  wall("north_west", -1.6, bay - 0.2, 0.11, 0.21);
  wall("north_east", bay + 0.2, 1.6, 0.11, 0.21);
  wall("bay_west", bay - 0.3, bay - 0.2, 0.21, 0.6);
  wall("bay_east", bay + 0.2, bay + 0.3, 0.21, 0.6);
  wall("bay_end", bay - 0.3, bay + 0.3, 0.5, 0.6);
  wall("west", -1.6, -1.5, -0.2, 0.2);
  wall("east", 1.5, 1.6, -0.2, 0.2);
  return cell;
}

/// The order of the balls is to be turned round.
EpisodeOutcome turn_round(int balls, double bay, double together_after, const NetworkParameters& network = {}) {
  CellConfiguration starts;
  CellConfiguration goals;
  for (int i = 0; i < balls; ++i) {
    const double x = balls == 1 ? 0.0 : -1.0 + 2.0 * i / (balls - 1);
    starts.push_back(joints({x, 0}));
    goals.push_back(joints({-x, 0}));
  }
  EpisodeOptions options;
  options.network = network;
  return simulate_episode(corridor(balls, bay, together_after), starts, goals, options);
}

int reached(const EpisodeOutcome& outcome) {
  return static_cast<int>(std::count_if(outcome.arms.begin(), outcome.arms.end(),
                                        [](const ArmOutcome& arm) { return arm.outcome == TaskOutcome::kReached; }));
}

int proposed(const EpisodeOutcome& outcome) {
  int all = 0;
  for (const ArmOutcome& arm : outcome.arms) all += arm.composites;
  return all;
}

TEST(CompositePlan, LetsTwoArmsPassEachOtherInACorridor) {
  const EpisodeOutcome outcome = turn_round(2, kFarBay, 4.0);
  EXPECT_EQ(reached(outcome), 2);
  EXPECT_GE(proposed(outcome), 1);
  EXPECT_EQ(outcome.referee.contacts, 0U);
}

TEST(CompositePlan, WithoutItTheyTakeTurnsForLong) {
  const EpisodeOutcome outcome = turn_round(2, kFarBay, 0.0);
  EXPECT_LT(reached(outcome), 2);
  EXPECT_EQ(proposed(outcome), 0);
  EXPECT_EQ(outcome.referee.contacts, 0U);
}

TEST(CompositePlan, AlsoOnOldNewsOfWhichSomeAreLost) {
  const EpisodeOutcome outcome = turn_round(2, kFarBay, 4.0, {.age = 0.1, .jitter = 0.05, .loss = 0.2});
  EXPECT_EQ(reached(outcome), 2);
  EXPECT_GE(proposed(outcome), 1);
  EXPECT_EQ(outcome.referee.contacts, 0U);
}

TEST(CompositePlan, IsNotNeededWhereMakingRoomIsEnough) {
  const EpisodeOutcome outcome = turn_round(2, 0.0, 4.0);
  EXPECT_EQ(reached(outcome), 2);
  EXPECT_EQ(proposed(outcome), 0);
}

// Samples of all joints together do not solve this; the balls' own roadmaps do.
TEST(CompositePlan, LetsThreeArmsTurnTheirOrderRound) {
  const EpisodeOutcome outcome = turn_round(3, kFarBay, 2.0);
  EXPECT_EQ(reached(outcome), 3);
  EXPECT_GE(proposed(outcome), 1);
  EXPECT_EQ(outcome.referee.contacts, 0U);
}

}  // namespace
}  // namespace hecaton::planner
