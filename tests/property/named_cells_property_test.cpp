// Cells of robots by name, without parameters: nothing to act on, and every goal is reached without contact.
#include <filesystem>

#include <gtest/gtest.h>

#include "planner/simulation/batch.hpp"
#include "services/config/cell_file.hpp"
#include "services/config/validate.hpp"

namespace hecaton {
namespace {

const std::string kFolder = std::string(HECATON_SOURCE_DIR) + "/deploy/cells/named/";

class NamedCell : public testing::TestWithParam<const char*> {
 protected:
  config::CellFile file_ = config::load_cell_file(kFolder + GetParam() + ".yaml");
};

TEST_P(NamedCell, HasNoFindingToActOn) {
  for (const config::Finding& finding : config::validate(file_)) {
    EXPECT_EQ(finding.severity, config::Severity::kNote) << finding.sentence;
  }
}

TEST_P(NamedCell, DrawsItsGoalsAboveTheFloorInReachOfAllArms) {
  const planner::TaskArea& area = file_.cell.tasks;
  EXPECT_FALSE(area.of_each_arm);
  EXPECT_GE(area.centre.z() - area.half_height, file_.cell.scene.floor_z - 1e-3);
  EXPECT_GT(area.radius, 0.1);
}

TEST_P(NamedCell, ReachesItsGoalsWithoutContact) {
  planner::BatchOptions options;
  options.tasks = 12;
  options.seed = 1;
  const planner::BatchReport report = planner::simulate_tasks(file_.cell, options);
  EXPECT_EQ(report.failure, std::nullopt);
  EXPECT_EQ(report.tasks, options.tasks);
  EXPECT_EQ(report.reached, report.tasks);
  EXPECT_EQ(report.contacts, 0U);
}

INSTANTIATE_TEST_SUITE_P(Ready, NamedCell,
                         testing::Values("dual_ur5e", "two_panda", "kr6_irb120", "yumi", "ur10e_rails", "two_scara",
                                         "four_makers", "rail_gripper", "two_xarm5", "puma_panda"),
                         [](const auto& name) { return std::string(name.param); });

TEST(NamedCells, AreAllListedHere) {
  int cells = 0;
  for (const auto& entry : std::filesystem::directory_iterator(kFolder)) {
    cells += entry.path().extension() == ".yaml" ? 1 : 0;
  }
  EXPECT_EQ(cells, 10);
}

}  // namespace
}  // namespace hecaton
