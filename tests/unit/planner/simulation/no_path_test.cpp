// Where there is no way an arm says that it is blocked, although it never stops looking for one.
#include <gtest/gtest.h>

#include "planner/progress_monitor.hpp"
#include "planner/simulation/cell_simulation.hpp"
#include "tests/support/planar_point.hpp"

namespace hecaton::planner {
namespace {

using test::joints;

/// A ball whose goal lies in a closed courtyard of half a metre: its C-space has no way in.
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

TEST(NoWay, EndsAsBlockedThoughTheArmNeverStoodStill) {
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
  EXPECT_DOUBLE_EQ(outcome.duration, 20.0) << "it looks for a way until its time is over";
  EXPECT_LT(still, periods / 2);
  EXPECT_EQ(outcome.contact_report.contacts, 0U);
}

TEST(NoWay, IsNotSaidOfAnArmThatComesNearer) {
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

}  // namespace
}  // namespace hecaton::planner
