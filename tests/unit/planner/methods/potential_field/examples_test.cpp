// The examples of [Cardenas10] and a PUMA: a path down the field, and the live method before the contact monitor.
#include <gtest/gtest.h>

#include "planner/methods/potential_field/gradient_path.hpp"
#include "planner/simulation/batch.hpp"
#include "services/config/cell_file.hpp"

namespace hecaton::planner::potential {
namespace {

Cell load(const std::string& name) {
  return config::load_cell_file(std::string(HECATON_SOURCE_DIR) + "/deploy/cells/" + name + ".yaml").cell;
}

class Examples : public testing::TestWithParam<const char*> {};

TEST_P(Examples, HaveAPathBothWays) {
  const Cell cell = load(GetParam());
  const PlannedArm& planned = cell.arms[0];
  CellGeometry geometry({planned.arm}, 0);
  geometry.set_obstacles(cell.scene.obstacles);
  std::vector<world::ObstacleState> states;
  for (const auto& obstacle : cell.scene.obstacles) states.push_back({obstacle.X_WO, {}, 0.0});
  PotentialField field(geometry, parameters_of<PotentialParameters>(planned.methods));
  FreeMotion motion(geometry, states, {}, 0.005);
  const JointVector& home = planned.arm.named.at("home");
  const JointVector& across = planned.arm.named.at("across");
  for (const auto& [from, to] : {std::pair(home, across), std::pair(across, home)}) {
    EXPECT_FALSE(motion.free(from, to)) << "something must be in the way";
    const Descent descent = descend(field, motion, planned.arm.limits, from, to);
    ASSERT_EQ(descent.outcome, DescentOutcome::kReached) << describe(descent.outcome);
    const auto path = refine(descent.path, motion);
    EXPECT_LE(length(path), length(descent.path));
    EXPECT_EQ(path.front(), from);
    EXPECT_LT((path.back() - to).norm(), 1e-12);
    // Ten times finer than any step, by distances alone.
    for (const JointVector& q : resample(path, motion, 0.002)) EXPECT_GT(motion.free_distance(q, 0.1), 0.0);
  }
}

TEST_P(Examples, AreReachedLiveWithoutContact) {
  Cell cell = load(GetParam());
  ASSERT_EQ(cell.arms[0].parameters.method->traits().name, "potential_field");
  BatchOptions options;
  options.tasks = 6;
  options.seed = 3;
  const BatchReport report = simulate_tasks(cell, options);
  EXPECT_EQ(report.failure, std::nullopt);
  EXPECT_EQ(report.reached, 6);
  EXPECT_EQ(report.contacts, 0U) << report.smallest.a << " – " << report.smallest.b;
  EXPECT_TRUE(report.has_smallest);
  EXPECT_GT(report.smallest.distance, 0.0);
}

INSTANTIATE_TEST_SUITE_P(Cardenas10, Examples, testing::Values("mobile_rectangle", "planar_3r", "puma_potential"),
                         [](const auto& example) { return std::string(example.param); });

}  // namespace
}  // namespace hecaton::planner::potential
