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
  EXPECT_EQ(one.times, three.times);
  EXPECT_EQ(one.duration, three.duration);
  EXPECT_EQ(one.smallest.distance, three.smallest.distance);
  options.seed = 6;
  EXPECT_NE(planner::simulate_tasks(cell, options).times, one.times);
}

}  // namespace
}  // namespace hecaton
