// Tasks of a pose sequence with an obstacle that swings over its pose "here", and texts of failures.
#include "planner/simulation/tasks.hpp"

#include <gtest/gtest.h>

#include "planner/simulation/batch.hpp"
#include "tests/support/planar_point.hpp"
#include "world/model/obstacle_motion.hpp"

namespace hecaton::planner {
namespace {

using test::joints;

/// The arm moves between two poses; a ball of the same radius swings over the first with this amplitude [m].
Cell sequence_under_ball(double amplitude) {
  Cell cell;
  cell.name = "sequence";
  PlannedArm planned;
  planned.arm = test::planar_point("point", 0.05);
  planned.arm.named["here"] = joints({0, 0});
  planned.arm.named["there"] = joints({1, 0});
  cell.arms.push_back(planned);
  cell.tasks.pose_sequence = {"here", "there"};
  cell.tasks.time_limit = 1.0;
  world::Obstacle ball;
  ball.name = "ball";
  ball.shapes.push_back({world::Sphere{0.05}, world::Pose::Identity()});
  ball.motion = world::SineMotion{{0, 1, 0}, amplitude, 4.0, 0.0};
  cell.scene.obstacles.push_back(ball);
  return cell;
}

TEST(TaskGenerator, StartTimeKeepsScriptedObstaclesClear) {
  const Cell cell = sequence_under_ball(0.5);
  TaskGenerator generator(cell);
  Random random(3);
  double nearest = 1.0;
  for (int i = 0; i < 200; ++i) {
    const auto time = generator.draw_time(random, 60.0, {joints({0, 0})});
    ASSERT_TRUE(time);
    EXPECT_LT(*time, 60.0);
    nearest = std::min(nearest, world::motion_at(cell.scene.obstacles[0], *time).X_WO.translation().norm() - 0.1);
  }
  EXPECT_GE(nearest, cell.arms[0].parameters.damper.security_distance);
  EXPECT_LT(nearest, 0.1) << "the margin is not larger than needed";
}

TEST(TaskGenerator, FailsSoonWhenNoStartTimeExists) {
  Cell cell = sequence_under_ball(0.01);
  world::Obstacle other = cell.scene.obstacles[0];
  other.name = "other";
  other.X_WO.translation().x() = 1.0;
  cell.scene.obstacles.push_back(other);
  BatchOptions options;
  options.tasks = 100'000;
  const BatchReport report = simulate_tasks(cell, options);
  EXPECT_EQ(report.tasks, 0);
  EXPECT_EQ(report.failure,
            "cell 'sequence': no task could be drawn in 50 episodes: for the first, at all of 200 start times drawn "
            "obstacles "
            "ball and other were too close to arm point at the start");
}

// Tasks that start "here" cannot be drawn, tasks that start "there" can. A failing first episode must not end the
// batch.
TEST(TaskGenerator, ReportsHowManyTasksCouldBeDrawn) {
  BatchOptions options;
  options.tasks = 60;
  for (options.seed = 1; options.seed < 12; ++options.seed) {
    const BatchReport report = simulate_tasks(sequence_under_ball(0.01), options);
    ASSERT_GT(report.tasks, 10);
    ASSERT_LT(report.tasks, 50);
    EXPECT_EQ(
        report.failure,
        "cell 'sequence': " + std::to_string(report.tasks) +
            " of 60 tasks could be drawn; for the first of the others, at all of 200 start times drawn obstacle ball "
            "were too close to arm point at the start");
    options.threads = 3;
    EXPECT_EQ(simulate_tasks(sequence_under_ball(0.01), options).tasks, report.tasks);
    options.threads = 1;
  }
}

// The point reaches 3 m; a box covers the task area of 0.5 m radius.
TEST(TaskGenerator, ReportsWhyNoTaskCouldBeDrawn) {
  Cell cell = sequence_under_ball(0.01);
  cell.scene.obstacles = {test::box_obstacle("block", {0, 0, 0}, {1, 1, 1})};
  cell.tasks.pose_sequence.clear();
  cell.tasks.radius = 0.5;
  cell.tasks.half_height = 0.0;
  BatchOptions options;
  options.tasks = 1;
  const std::string area = "the task area (centre 0, 0, 0 m in W, radius 0.5 m, half height 0 m)";
  EXPECT_EQ(simulate_tasks(cell, options).failure,
            "cell 'sequence': no task could be drawn in 1 episode: in 400 draws arm point reached " + area +
                " only where it is not clear of itself and of all places of obstacle block");
  cell.tasks.centre.x() = 9.0;
  EXPECT_NE(simulate_tasks(cell, options).failure.find("in 400 draws arm point reached no point of the task area"),
            std::string::npos);
}

// Two points of 0.1 m across, whose areas are 1 m apart.
TEST(TaskGenerator, ReportsThatNoArmsMeet) {
  Cell cell = sequence_under_ball(0.01);
  cell.scene.obstacles.clear();
  cell.arms.push_back(cell.arms[0]);
  cell.arms[1].arm.name = "pebble";
  cell.arms[1].arm.X_WB.translation().x() = 1.0;
  cell.tasks.pose_sequence.clear();
  cell.tasks.of_each_arm = true;
  cell.tasks.radius = 0.1;
  cell.tasks.half_height = 0.0;
  BatchOptions options;
  options.tasks = 2;
  EXPECT_EQ(simulate_tasks(cell, options).failure,
            "cell 'sequence': no task could be drawn in 1 episode: on the straight motions to none of 2000 goals drawn "
            "in the "
            "task area (centre 0, 0, 0 m from each base, radius 0.1 m, half height 0 m) any arms meet");
}

}  // namespace
}  // namespace hecaton::planner
