// Two arms that stand in each other's only way: what a rule of who makes room resolves late, a plan for both does soon.
#include <algorithm>

#include <gtest/gtest.h>

#include "planner/simulation/cell_simulation.hpp"
#include "tests/support/corridor.hpp"

namespace hecaton::planner {
namespace {

/// Behind where the first arm starts: who lets the other pass must first go away from its goal [m].
constexpr double kFarBay = -1.2;

/// The balls reverse their order.
EpisodeOutcome turn_round(int balls, double bay, double together_after, const NetworkParameters& network = {}) {
  CellConfiguration starts;
  CellConfiguration goals;
  for (int i = 0; i < balls; ++i) {
    starts.push_back(test::corridor_start(i, balls));
    goals.push_back(test::corridor_goal(i, balls));
  }
  EpisodeOptions options;
  options.network = network;
  return simulate_episode(test::corridor(balls, bay, together_after), starts, goals, options);
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
  const EpisodeOutcome outcome = turn_round(2, kFarBay, 4.0);
  EXPECT_EQ(reached(outcome), 2);
  EXPECT_GE(proposed(outcome), 1);
  EXPECT_EQ(outcome.contact_report.contacts, 0U);
}

TEST(CoupledPlan, WithoutItTheyTakeTurnsForLong) {
  const EpisodeOutcome outcome = turn_round(2, kFarBay, 0.0);
  EXPECT_LT(reached(outcome), 2);
  EXPECT_EQ(proposed(outcome), 0);
  EXPECT_EQ(outcome.contact_report.contacts, 0U);
}

TEST(CoupledPlan, AlsoOnOldNewsOfWhichSomeAreLost) {
  const EpisodeOutcome outcome = turn_round(2, kFarBay, 4.0, {.age = 0.1, .jitter = 0.05, .loss = 0.2});
  EXPECT_EQ(reached(outcome), 2);
  EXPECT_GE(proposed(outcome), 1);
  EXPECT_EQ(outcome.contact_report.contacts, 0U);
}

TEST(CoupledPlan, IsNotNeededWhereMakingRoomIsEnough) {
  const EpisodeOutcome outcome = turn_round(2, 0.0, 4.0);
  EXPECT_EQ(reached(outcome), 2);
  EXPECT_EQ(proposed(outcome), 0);
}

// Samples of all joints together do not solve this; the balls' own roadmaps do.
TEST(CoupledPlan, LetsThreeArmsTurnTheirOrderRound) {
  const EpisodeOutcome outcome = turn_round(3, kFarBay, 2.0);
  EXPECT_EQ(reached(outcome), 3);
  EXPECT_GE(proposed(outcome), 1);
  EXPECT_EQ(outcome.contact_report.contacts, 0U);
}

}  // namespace
}  // namespace hecaton::planner
