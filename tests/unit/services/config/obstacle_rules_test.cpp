// The rules for obstacles and their poses, which cell file and edits share.

#include "services/config/obstacle_rules.hpp"

#include <limits>

#include <gtest/gtest.h>

#include "services/config/cell_file.hpp"
#include "services/config/overlaps.hpp"

namespace hecaton::config {
namespace {

world::Obstacle ball(double radius) {
  world::Obstacle obstacle;
  obstacle.name = "ball";
  obstacle.shapes.push_back({world::Sphere{radius}});
  return obstacle;
}

std::string key_of_complaint(const world::Obstacle& obstacle) {
  const auto complaint = complain(obstacle);
  return complaint ? complaint->key : "";
}

TEST(ObstacleRulesTest, NameTheKeyOfTheError) {
  EXPECT_EQ(key_of_complaint(ball(0.1)), "");
  EXPECT_EQ(key_of_complaint(ball(0.0)), "shapes[0].radius");
  EXPECT_EQ(key_of_complaint(ball(std::numeric_limits<double>::quiet_NaN())), "shapes[0].radius");

  world::Obstacle obstacle = ball(0.1);
  obstacle.shapes.push_back({world::Box{{0.1, 0.1, 0.00004}}});  // 0.08 mm thin
  EXPECT_EQ(key_of_complaint(obstacle), "shapes[1].size[2]");
  obstacle = ball(0.1);
  obstacle.name = "a ball";
  EXPECT_EQ(key_of_complaint(obstacle), "name");
  obstacle = ball(0.1);
  obstacle.shapes.clear();
  EXPECT_EQ(key_of_complaint(obstacle), "shapes");
  obstacle = ball(0.1);
  obstacle.X_WO.translation().y() = 100.1;
  EXPECT_EQ(key_of_complaint(obstacle), "pose.xyz[1]");
  obstacle = ball(0.1);
  obstacle.X_WO.linear() *= 1.5;
  EXPECT_EQ(key_of_complaint(obstacle), "pose.rpy");
}

TEST(ObstacleRulesTest, ApplyToEveryMotion) {
  const auto moving = [](const world::Motion& motion) {
    world::Obstacle obstacle = ball(0.1);
    obstacle.motion = motion;
    return key_of_complaint(obstacle);
  };
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX();
  EXPECT_EQ(moving(world::ConveyorMotion{x, 0.1, 1.0}), "");
  EXPECT_EQ(moving(world::ConveyorMotion{x, 0.0, 1.0}), "motion.speed");
  EXPECT_EQ(moving(world::ConveyorMotion{2.0 * x, 0.1, 1.0}), "motion.direction");
  EXPECT_EQ(moving(world::ConveyorMotion{x, 0.1, 0.0}), "motion.length");
  EXPECT_EQ(moving(world::SineMotion{x, 0.1, 0.001, 0.0}), "motion.period");
  EXPECT_EQ(moving(world::CircleMotion{x, x, 0.5, false}), "motion.centre") << "the ball is on the axis";
  EXPECT_EQ(moving(world::CircleMotion{x, Eigen::Vector3d::UnitZ(), 0.5, false}), "");
  EXPECT_EQ(moving(world::CircleMotion{x, Eigen::Vector3d::UnitZ(), 0.0, false}), "motion.angular_speed");
  EXPECT_EQ(moving(world::WaypointMotion{{world::Pose::Identity(), world::Pose::Identity()}, 0.1, true}),
            "motion.poses");
  world::DynamicMotion weightless;
  weightless.mass = 0.0;
  EXPECT_EQ(moving(weightless), "motion.mass");
}

TEST(ObstacleRulesTest, RefuseCarriedObstaclesFarFromTheTool) {
  world::Obstacle obstacle = ball(0.1);
  obstacle.attachment = world::Attachment{"left", world::Pose::Identity()};
  obstacle.attachment->X_TO.translation().z() = 0.19;  // its nearest point is 0.09 m away
  EXPECT_EQ(key_of_complaint(obstacle), "");
  obstacle.attachment->X_TO.translation().z() = 0.21;  // 0.11 m
  EXPECT_EQ(key_of_complaint(obstacle), "attached_to.pose");
}

TEST(ObstacleRulesTest, RefuseNamesOfArmsAndOtherObstacles) {
  const std::vector<std::string> arms{"left"};
  const std::vector<std::string> obstacles{"crate"};
  EXPECT_FALSE(complain_about_name("ball", arms, obstacles));
  EXPECT_EQ(complain_about_name("left", arms, obstacles)->must_be, "unique, but an arm has the same name");
  EXPECT_EQ(complain_about_name("crate", arms, obstacles)->must_be, "unique, but another obstacle has the same name");
}

// At home the tool of arm north is at (0.4806, −0.15, 1.4507) [m]. The rounded end of its flange has a radius of 0.03 m
// and its centre 0.03 m from the tool. A ball of 0.05 m around the tool overlaps it by 0.05 + 0.03 − 0.03 = 0.05 m.
TEST(OverlapWithArmsTest, FindsOverlapsWithMovingBodies) {
  const CellFile file = load_cell_file(std::string(HECATON_SOURCE_DIR) + "/deploy/cells/three_puma.yaml");
  std::vector<std::optional<planner::JointVector>> q;
  for (const auto& planned : file.cell.arms) q.emplace_back(planned.arm.home());
  world::Pose X_WO = world::Pose::Identity();
  X_WO.translation() << 0.4806, -0.15, 1.4507;
  const auto overlap = [&] {
    return overlap_with_arms(file.cell.arms, q, file.cell.scene.obstacles, ball(0.05), X_WO);
  };
  const std::string text = overlap();
  EXPECT_TRUE(text.starts_with("north/flange and ball overlap by ")) << text;
  EXPECT_NEAR(std::stod(text.substr(text.find(" by ") + 4)), 50.0, 0.1) << text;
  X_WO.translation().z() += 0.5;
  EXPECT_EQ(overlap(), "");
  X_WO.translation() << 0.7, 0.0, 0.05;
  EXPECT_EQ(overlap(), "") << "no joint moves the base";
  X_WO.translation() << 0.4806, -0.15, 1.4507;
  q[0].reset();
  EXPECT_EQ(overlap(), "") << "where the arm is, is not known";
}

}  // namespace
}  // namespace hecaton::config
