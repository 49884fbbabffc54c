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

TEST(Batch, RepeatsOneEpisodeAlone) {
  Cell cell = sequence_under_ball(0.5);
  cell.tasks.time_limit = 10.0;
  BatchOptions options;
  options.tasks = 8;
  options.seed = 4;
  const BatchReport all = simulate_tasks(cell, options);
  ASSERT_EQ(all.reach_times.size() + all.missed.size(), 8U);
  ASSERT_GT(all.reach_times.size(), 0U);
  options.tasks = 1;
  std::vector<double> times;
  for (options.first_episode = 0; options.first_episode < 8; ++options.first_episode) {
    const BatchReport one = simulate_tasks(cell, options);
    times.insert(times.end(), one.reach_times.begin(), one.reach_times.end());
    for (const MissedTask& missed : one.missed) EXPECT_EQ(missed.episode, options.first_episode);
  }
  EXPECT_EQ(times, all.reach_times);
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
  const std::string failure = simulate_tasks(cell, options).failure.value_or("");
  EXPECT_TRUE(
      failure.starts_with("cell 'sequence': no task could be drawn in 1 episode: in 400 draws arm point "
                          "reached " +
                          area + " only where it is not clear of itself and of all places of obstacle block; " +
                          "most often point/ball and block are too near (they overlap by "))
      << failure;
  // dₛ = 20 mm and 30 mm for the dampers to let the arm rest.
  EXPECT_NE(failure.find("50 mm are needed): change the task area, move the obstacle, or lower "
                         "damper.security_distance"),
            std::string::npos)
      << failure;
  EXPECT_EQ(why_no_task(cell, 1), failure.substr(failure.find("in 400 draws")));
  cell.tasks.centre.x() = 9.0;
  EXPECT_NE(simulate_tasks(cell, options)
                .failure.value_or("")
                .find("in 400 draws arm point reached no point of the task area"),
            std::string::npos);
}

/// The slide carries a ball, too, 16 mm above the point's.
Cell point_under_ball() {
  Cell cell = sequence_under_ball(0.01);
  cell.scene.obstacles.clear();
  cell.tasks.pose_sequence.clear();
  cell.tasks.radius = 1e-3;
  cell.tasks.half_height = 0.0;
  Arm& arm = cell.arms[0].arm;
  auto model = std::make_shared<RobotModel>(*arm.model);
  model->limits.lower[1] = -1e-3;
  model->limits.upper[1] = 1e-3;
  model->geometry.insert(model->geometry.begin(), {1, world::Sphere{0.05}, Pose::Identity(), 0.0});
  model->geometry.front().X_LS.translation().z() = 0.116;
  model->self_pairs = {{0, 1}};
  arm.model = model;
  arm.limits = model->limits;
  return cell;
}

// 16 mm apart are less than the 25 mm that links keep in starts and goals.
TEST(TaskGenerator, LinksThatNoPosturePartsDoNotPreventTasks) {
  Cell cell = point_under_ball();
  const auto reason = why_no_task(cell, 1);
  ASSERT_TRUE(reason) << "a pair that is not listed has to keep its distance";
  EXPECT_NE(reason->find("point/slide and point/ball are too near (they are 16 mm apart at most, 25 mm are needed): "
                         "change the task area, lower damper.self_security_distance"),
            std::string::npos)
      << *reason;
  auto model = std::make_shared<RobotModel>(*cell.arms[0].arm.model);
  model->close_pairs = {{0, 1, 0.016}};
  cell.arms[0].arm.model = model;
  EXPECT_EQ(why_no_task(cell, 1), std::nullopt);
}

// The ball on the slide is 20 mm below the ceiling, less than the distance that starts and goals keep from obstacles.
TEST(TaskGenerator, ObstaclesThatNoPostureLeavesDoNotPreventTasks) {
  Cell cell = point_under_ball();
  auto model = std::make_shared<RobotModel>(*cell.arms[0].arm.model);
  model->self_pairs.clear();
  cell.arms[0].arm.model = model;
  cell.scene.obstacles = {test::box_obstacle("ceiling", {0, 0, 0.286}, {1, 1, 0.1})};
  const auto reason = why_no_task(cell, 1);
  ASSERT_TRUE(reason) << "the slide can leave a ceiling of 2 m";
  EXPECT_NE(reason->find("point/slide and ceiling are too near (they are 20 mm apart at most"), std::string::npos)
      << *reason;
  cell.scene.obstacles = {test::box_obstacle("ceiling", {0, 0, 0.286}, {5, 5, 0.1})};
  EXPECT_EQ(why_no_task(cell, 1), std::nullopt);
  cell.scene.obstacles = {test::box_obstacle("ceiling", {0, 0, 0.256}, {5, 5, 0.1})};
  EXPECT_TRUE(why_no_task(cell, 1)) << "they overlap";
}

// The point slides in the plane z = 0.01 m, which holds nearly no point of the area.
TEST(TaskGenerator, DrawsPosturesOfAnArmWhoseToolStaysOnASurface) {
  Cell cell = sequence_under_ball(0.01);
  cell.scene.obstacles.clear();
  cell.tasks.pose_sequence.clear();
  cell.tasks.centre << 0.3, 0.2, 0.0;
  cell.tasks.radius = 0.5;
  cell.tasks.half_height = 0.1;
  cell.arms[0].arm.X_WB.translation().z() = 0.01;
  TaskGenerator generator(cell);
  Random random(11);
  for (int draw = 0; draw < 50; ++draw) {
    const auto drawn = generator.draw_configuration(random);
    ASSERT_TRUE(drawn) << generator.shortage();
    EXPECT_LE(((*drawn)[0] - joints({0.3, 0.2})).norm(), 0.502);
  }
}

/// One arm, whose second joint turns by nearly two turns about its own axis.
Cell turner() {
  Cell cell;
  PlannedArm& planned = cell.arms.emplace_back();
  auto model = std::make_shared<RobotModel>(*test::planar_point("turner").model);
  model->links[2].joint_type = JointType::kRevolute;
  model->links[2].axis = Eigen::Vector3d::UnitZ();
  model->limits.lower[1] = -6.3;
  model->limits.upper[1] = 6.3;
  planned.arm = test::planar_point("turner");
  planned.arm.model = model;
  planned.arm.limits = model->limits;
  cell.tasks.radius = 1e-5;
  cell.tasks.half_height = 0.0;
  return cell;
}

// Starts are where the arm comes from home, not a turn away, where the ends of its range may lock it in.
TEST(TaskGenerator, DrawsStartsInTheTurnsOfHome) {
  Cell cell = turner();
  cell.arms[0].arm.named["home"] = joints({0.0, 3.0});
  TaskGenerator generator(cell);
  Random random(3);
  for (int draw = 0; draw < 20; ++draw) {
    const auto starts = generator.draw_starts(random);
    ASSERT_TRUE(starts) << generator.shortage();
    EXPECT_LE(std::abs((*starts)[0][1] - 3.0), 3.15);
  }
}

// A goal a whole turn away: the joint turns the short way.
TEST(TaskGenerator, JointsThatTurnMoreThanOnceTakeTheNearestTurn) {
  const Cell cell = turner();
  TaskGenerator generator(cell);
  Random random(5);
  for (const double start : {-3.1, -2.0, 0.5, 3.1}) {
    for (int draw = 0; draw < 20; ++draw) {
      const auto goals = generator.draw_conflicting_goals(random, {joints({0, start})});
      ASSERT_TRUE(goals);
      EXPECT_LE(std::abs((*goals)[0][1] - start), 3.15) << start;
    }
  }
}

// At 0 a ball on the turning joint is 5 mm from one on the base. It touches nothing, but the arm does not pass there.
TEST(TaskGenerator, JointsTurnTheLongWayAroundLinksThatAreTooNear) {
  Cell cell = turner();
  auto model = std::make_shared<RobotModel>(*cell.arms[0].arm.model);
  LinkGeometry beside{0, world::Sphere{0.05}, Pose::Identity(), 0.0};
  beside.X_LS.translation().x() = 0.305;
  model->geometry.front().X_LS.translation().x() = 0.2;
  model->geometry.insert(model->geometry.begin(), beside);
  model->self_pairs = {{0, 1}};
  cell.arms[0].arm.model = model;
  TaskGenerator generator(cell);
  Random random(5);
  for (int draw = 0; draw < 40; ++draw) {
    const auto goals = generator.draw_conflicting_goals(random, {joints({0, -1.5})});
    ASSERT_TRUE(goals) << generator.shortage();
    EXPECT_LT((*goals)[0][1], 0.0);
  }
}

// Drawn independently, twelve points are clear of each other in one of about 20,000 draws.
TEST(TaskGenerator, DrawsCrowdedArmsOneAfterTheOther) {
  Cell cell;
  for (int i = 0; i < 12; ++i) {
    PlannedArm& planned = cell.arms.emplace_back();
    planned.arm = test::planar_point("arm" + std::to_string(i));
  }
  cell.tasks.radius = 0.4;
  cell.tasks.half_height = 0.0;
  TaskGenerator generator(cell);
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Random random(seed);
    const auto drawn = generator.draw_configuration(random);
    ASSERT_TRUE(drawn) << generator.shortage();
    for (std::size_t i = 0; i < drawn->size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) EXPECT_GT(((*drawn)[i] - (*drawn)[j]).norm(), 0.1) << i << " touches " << j;
    }
  }
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
