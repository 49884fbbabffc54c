// Tasks that are simulated on several threads.
#include <gtest/gtest.h>

#include "planner/simulation/batch.hpp"
#include "services/config/cell_file.hpp"

namespace hecaton {
namespace {

TEST(SimulationThreads, SameForASeedWhateverTheirNumber) {
  const planner::Cell cell = config::load_cell_file(HECATON_SOURCE_DIR "/deploy/cells/two_puma_carry.yaml").cell;
  planner::BatchOptions options;
  options.tasks = 12;
  options.seed = 5;
  const planner::BatchReport one = planner::simulate_tasks(cell, options);
  options.threads = 3;
  const planner::BatchReport three = planner::simulate_tasks(cell, options);
  EXPECT_EQ(one.reach_times, three.reach_times);
  EXPECT_EQ(one.duration, three.duration);
  EXPECT_EQ(one.smallest.distance, three.smallest.distance);
  options.seed = 6;
  EXPECT_NE(planner::simulate_tasks(cell, options).reach_times, one.reach_times);
}

TEST(SimulationThreads, SharedByTheArmsOfOneEpisode) {
  planner::Cell cell = config::load_cell_file(HECATON_SOURCE_DIR "/deploy/cells/three_puma.yaml").cell;
  const planner::PlannedArm pattern = cell.arms[0];
  cell.arms.clear();
  planner::CellConfiguration starts;
  planner::CellConfiguration goals;
  planner::Random random(3);
  for (int i = 0; i < 20; ++i) {
    planner::PlannedArm& planned = cell.arms.emplace_back(pattern);
    planned.arm.name = "arm" + std::to_string(i);
    planned.arm.X_WB.translation() = Eigen::Vector3d(0.8 * (i % 5), 0.8 * (i / 5), 0.0);
    starts.push_back(planned.arm.home());
    goals.push_back(starts.back());
    for (double& angle : goals.back()) angle += random.uniform(-2.0, 2.0);
  }
  cell.tasks.time_limit = 2.0;
  planner::EpisodeOptions options;
  options.network = {.age = 0.03, .jitter = 0.02, .loss = 0.1};
  const planner::EpisodeOutcome one = planner::simulate_episode(cell, starts, goals, options);
  EXPECT_GT(one.rollout_ticks, 0U);
  options.threads = 3;
  const planner::EpisodeOutcome three = planner::simulate_episode(cell, starts, goals, options);
  EXPECT_EQ(one.duration, three.duration);
  EXPECT_EQ(one.rollout_ticks, three.rollout_ticks);
  EXPECT_EQ(one.contact_report.smallest.distance, three.contact_report.smallest.distance);
  EXPECT_EQ(one.contact_report.smallest.time, three.contact_report.smallest.time);
  for (std::size_t i = 0; i < one.arms.size(); ++i) {
    EXPECT_EQ(one.arms[i].time, three.arms[i].time) << i;
    EXPECT_EQ(one.arms[i].rollouts, three.arms[i].rollouts) << i;
    EXPECT_EQ(one.arms[i].subspaces_drawn, three.arms[i].subspaces_drawn) << i;
    EXPECT_EQ(one.arms[i].yielding_ticks, three.arms[i].yielding_ticks) << i;
    EXPECT_EQ(one.arms[i].reversals.joint_time, three.arms[i].reversals.joint_time) << i;
  }
}

}  // namespace
}  // namespace hecaton
