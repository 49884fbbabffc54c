// When routes begin, by hand: a ball at the stop "here", and one that swings over it.
#include "planner/simulation/tasks.hpp"

#include <gtest/gtest.h>

#include "planner/simulation/batch.hpp"
#include "tests/support/planar_point.hpp"
#include "world/sim/obstacle_motion.hpp"

namespace hecaton::planner {
namespace {

using test::joints;

/// The arm goes to and fro between two stops; a ball of the same radius swings over the first with this amplitude [m].
Cell route_under(double amplitude) {
  Cell cell;
  cell.name = "route";
  PlannedArm planned;
  planned.arm = test::planar_point("point", 0.05);
  planned.arm.named["here"] = joints({0, 0});
  planned.arm.named["there"] = joints({1, 0});
  cell.arms.push_back(planned);
  cell.tasks.route = {"here", "there"};
  cell.tasks.time_limit = 1.0;
  world::Obstacle ball;
  ball.name = "ball";
  ball.shapes.push_back({world::Sphere{0.05}, world::Pose::Identity()});
  ball.motion = world::SineMotion{{0, 1, 0}, amplitude, 4.0, 0.0};
  cell.scene.obstacles.push_back(ball);
  return cell;
}

TEST(TaskGenerator, RoutesBeginWhenNothingThatMovesIsInTheWay) {
  const Cell cell = route_under(0.5);
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
  EXPECT_LT(nearest, 0.1) << "and no farther than needed";
}

TEST(TaskGenerator, RoutesThatCannotBeginAreRefusedAtOnce) {
  BatchOptions options;
  options.tasks = 100'000;
  const BatchReport report = simulate_tasks(route_under(0.01), options);
  EXPECT_EQ(report.tasks, 0);
  EXPECT_EQ(report.failure,
            "cell 'route': moving obstacles are always in the way of arms at their start; move them or the arms");
}

// Those that begin "here" cannot, those that begin "there" can; of the first episode it is the seed that decides.
TEST(TaskGenerator, SaysHowManyTasksCouldBeDrawn) {
  BatchOptions options;
  options.tasks = 60;
  BatchReport report;
  for (options.seed = 1; options.seed < 20 && report.tasks == 0; ++options.seed) {
    report = simulate_tasks(route_under(0.01), options);
  }
  ASSERT_GT(report.tasks, 0);
  ASSERT_LT(report.tasks, 60);
  EXPECT_EQ(report.failure.find("cell 'route': " + std::to_string(report.tasks) +
                                " of 60 tasks could be drawn; for the others "),
            0U)
      << report.failure;
}

}  // namespace
}  // namespace hecaton::planner
