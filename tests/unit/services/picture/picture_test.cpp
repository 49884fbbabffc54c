// A cell as its file starts it, as the page gets it for a picture.
#include <gtest/gtest.h>

#include "services/picture/standing_cell.hpp"
#include "services/view/state_json.hpp"

namespace hecaton::services::picture {
namespace {

TEST(StandingCell, HasEachArmAndObstacleInItsPlace) {
  const config::CellFile file = config::load_cell_file(HECATON_SOURCE_DIR "/deploy/cells/scorbot_2a.yaml");
  const auto& obstacles = file.cell.scene.obstacles;
  ASSERT_GT(obstacles.size(), 1U);
  const StandingCell cell(file);
  EXPECT_EQ(view::obstacles_json(cell.state()).at("obstacles").size(), obstacles.size());

  const view::Json frame = view::frame_json(cell, {});
  EXPECT_EQ(frame.at("obstacle_age"), 0.0) << "an old obstacle is drawn pale";
  for (const world::Obstacle& obstacle : obstacles) {
    const view::Json& pose = frame.at("obstacles").at(obstacle.name);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(pose[i].get<double>(), obstacle.X_WO.translation()[i], 1e-5);
  }
  for (std::size_t i = 0; i < file.cell.arms.size(); ++i) {
    const planner::PlannedArm& arm = file.cell.arms[i];
    const planner::JointVector q = arm.start.size() > 0 ? arm.start : arm.arm.home();
    EXPECT_EQ(frame.at("arms")[i][0], 0.0);
    for (int j = 0; j < q.size(); ++j) EXPECT_NEAR(frame.at("arms")[i][1][j].get<double>(), q[j], 1e-5);
  }
}

}  // namespace
}  // namespace hecaton::services::picture
