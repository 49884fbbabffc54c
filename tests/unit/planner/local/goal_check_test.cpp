#include "planner/goal_check.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/support/planar_point.hpp"

namespace hecaton::planner {
namespace {

using test::joints;

/// Two planar points, the second with a fixed base of radius 0.2 m around (1, 0).
CellGeometry cell() {
  Arm based = test::planar_point("based");
  auto model = std::make_shared<RobotModel>(*based.model);
  model->geometry.push_back({0, world::Sphere{0.2}, Pose::Identity(), 0.0});
  based.model = model;
  based.X_WB.translation() = Eigen::Vector3d(1.0, 0.0, 0.0);
  return CellGeometry({test::planar_point("point"), based}, 0);
}

TEST(GoalCheck, RejectsAGoalInTheBaseOfAnotherArm) {
  const auto rejection = reject_goal(cell(), joints({0.9, 0.0}), {});
  ASSERT_TRUE(rejection);
  EXPECT_EQ(rejection->kind, RejectionKind::kInCollision);
  EXPECT_EQ(rejection->subject, "based/ground");
  EXPECT_EQ(rejection->text,
            "goal is in collision: point/ball and based/ground overlap by 150 mm (minimum distance 0 mm); choose a "
            "goal clear of based/ground, which stays where it is");
}

TEST(GoalCheck, AcceptsAGoalWhereTheLinksOfAnotherArmAreNow) {
  EXPECT_FALSE(reject_goal(cell(), joints({0.7, 0.0}), {})) << "the ball of arm `based` is at (1, 0) now";
  const CellGeometry two({test::planar_point("a"), test::planar_point("b")}, 0);
  EXPECT_FALSE(reject_goal(two, joints({0.0, 0.0}), {}));
}

/// A turret, a cylinder that turns on a floor, with a ball that swings about y at its top. The turret's fast shape is a
/// capsule that reaches 60 mm into the floor, while the cylinder begins at height `bottom` [m]. The ball is `ball_at`
/// [m] from its axis.
CellGeometry turret_on_floor(double bottom, double ball_at = 0.6) {
  auto model = std::make_shared<RobotModel>();
  model->name = "turret";
  model->links.resize(3);
  model->links[0].name = "foot";
  model->links[1] = {"turret", 0, JointType::kRevolute, "turn", Pose::Identity(), Eigen::Vector3d::UnitZ(), 0};
  model->links[2] = {"ball", 1, JointType::kRevolute, "swing", Pose::Identity(), Eigen::Vector3d::UnitY(), 1};
  model->links[2].X_PJ.translation().z() = 0.4;
  for (Link& link : model->links) link.motion = joint_motion(link);
  LinkGeometry& turret = model->geometry.emplace_back();
  turret.link = 1;
  turret.shape = world::Cylinder{0.1, 0.1};
  turret.X_LS.translation().z() = bottom + 0.1;
  turret.capsule.emplace();
  turret.capsule->placed.capsule = {0.1, 0.06 + bottom};
  LinkGeometry& ball = model->geometry.emplace_back();
  ball.link = 2;
  ball.shape = world::Sphere{0.05};
  ball.X_LS.translation().x() = ball_at;
  model->self_pairs = {{0, 1}};
  model->joint_names = {"turn", "swing"};
  model->limits = {joints({-3, -3}), joints({3, 3}), joints({1, 1}), joints({4, 4})};
  model->tool_link = 2;
  Arm arm;
  arm.name = "one";
  arm.model = model;
  arm.limits = model->limits;
  arm.named["home"] = joints({0, 0});
  CellGeometry geometry({arm}, 0);
  const world::Obstacle floor = test::box_obstacle("floor", {0, 0, -0.05}, {2, 2, 0.05});
  geometry.set_obstacles(std::span(&floor, 1));
  return geometry;
}

world::ObstacleState floor_state() {
  world::ObstacleState state;
  state.X_WO.translation().z() = -0.05;
  return state;
}

TEST(GoalCheck, AcceptsGoalsOfAnArmWhoseTurningBaseTouchesTheFloorByItsCapsuleOnly) {
  const world::ObstacleState floor = floor_state();
  EXPECT_FALSE(reject_goal(turret_on_floor(0.01), joints({0.7, 0.3}), std::span(&floor, 1)));
  const auto ball = reject_goal(turret_on_floor(0.01), joints({0.7, 0.9}), std::span(&floor, 1));
  ASSERT_TRUE(ball) << "the ball is in the floor";
  EXPECT_TRUE(ball->text.starts_with("goal is in collision: one/ball and floor overlap by")) << ball->text;
  const auto turret = reject_goal(turret_on_floor(-0.01), joints({0.7, 0.3}), std::span(&floor, 1));
  ASSERT_TRUE(turret) << "the cylinder is in the floor";
  EXPECT_TRUE(turret->text.starts_with("goal is in collision: one/turret and floor overlap by")) << turret->text;
}

TEST(GoalCheck, NamesARemedyForEachKindOfPair) {
  const world::ObstacleState floor = floor_state();
  const auto in_floor = reject_goal(turret_on_floor(0.01), joints({0.7, 0.9}), std::span(&floor, 1));
  ASSERT_TRUE(in_floor);
  EXPECT_TRUE(in_floor->text.ends_with(
      " mm (minimum distance 0 mm); choose a goal clear of floor, or move or remove that obstacle"))
      << in_floor->text;
  const auto folded = reject_goal(turret_on_floor(0.01, 0.3), joints({0.0, 1.57}), std::span(&floor, 1));
  ASSERT_TRUE(folded) << "the ball is in the turret";
  EXPECT_TRUE(folded->text.starts_with("goal is in collision: one/turret and one/ball overlap by ")) << folded->text;
  EXPECT_TRUE(folded->text.ends_with("exclude the pair in the SRDF (disable_collisions)")) << folded->text;
}

TEST(GoalCheck, RejectsOwnLinksBelowTheDistanceAskedFor) {
  const world::ObstacleState floor = floor_state();
  const CellGeometry turret = turret_on_floor(0.01, 0.15);  // the ball is 4 mm above the turret
  EXPECT_FALSE(reject_goal(turret, joints({0.0, 1.1354}), std::span(&floor, 1)));
  EXPECT_FALSE(reject_goal(turret, joints({0.0, 1.1354}), std::span(&floor, 1), 0.003));
  const auto near = reject_goal(turret, joints({0.0, 1.1354}), std::span(&floor, 1), 0.01);
  ASSERT_TRUE(near);
  EXPECT_NE(near->text.find(" mm apart (minimum distance 10 mm); "), std::string::npos) << near->text;
}

TEST(GoalCheck, RejectsMalformedGoals) {
  const CellGeometry two({test::planar_point("a"), test::planar_point("b")}, 0);
  const auto short_one = reject_goal(two, joints({0.0}), {});
  ASSERT_TRUE(short_one);
  EXPECT_EQ(short_one->kind, RejectionKind::kMalformed);
  EXPECT_EQ(short_one->text, "goal has 1 joint values, arm a has 2 joints");
  const auto infinite = reject_goal(two, joints({HUGE_VAL, 0.0}), {});
  ASSERT_TRUE(infinite);
  EXPECT_EQ(infinite->kind, RejectionKind::kMalformed);
}

TEST(GoalCheck, RejectsAGoalOutsideAJointsLimits) {
  Arm arm = test::planar_point("a");
  arm.limits.upper[1] = 0.5;
  const auto rejection = reject_goal(CellGeometry({arm}, 0), joints({0.0, 0.6}), {});
  ASSERT_TRUE(rejection);
  EXPECT_EQ(rejection->kind, RejectionKind::kOutsideLimits);
  EXPECT_EQ(rejection->subject, arm.model->joint_names[1]);
}

TEST(LimitRounding, MovesAJointOntoItsLimitWithANote) {
  const Arm arm = test::planar_point("a");  // limits ±3
  JointVector q = joints({3.0000000001, -0.5});
  EXPECT_EQ(clamp_rounding(arm, q), "joint x = 3.0000000001 is outside its limit by rounding and becomes 3");
  EXPECT_EQ(q, joints({3.0, -0.5}));
  q = joints({3.0 + 9e-7, -3.0 - 9e-7});
  EXPECT_NE(clamp_rounding(arm, q), "");
  EXPECT_EQ(q, joints({3.0, -3.0}));
}

TEST(LimitRounding, KeepsValuesWithinAndFarOutside) {
  const Arm arm = test::planar_point("a");
  for (const JointVector& given : {joints({3.0, -3.0}), joints({3.0005, 0.0}), joints({3.0000011, 0.0}),
                                   joints({0.0, -HUGE_VAL}), joints({1.0})}) {
    JointVector q = given;
    EXPECT_EQ(clamp_rounding(arm, q), "") << given.transpose();
    EXPECT_EQ(q, given);
  }
  JointVector nan = joints({NAN, 0.0});
  EXPECT_EQ(clamp_rounding(arm, nan), "");
}

TEST(ErrorAtGoal, IsEmptyWithinTheTolerances) {
  const Arm arm = test::planar_point("a");
  ToolGoal tool;
  tool.X_WT.translation() = Eigen::Vector3d(1.0, 2.0, 0.0);
  EXPECT_EQ(error_at_goal(arm, joints({1.001, 2.0}), joints({1.0, 2.0}), 2e-3, nullptr), std::nullopt);
  EXPECT_EQ(error_at_goal(arm, joints({1.0009, 2.0}), joints({1.0, 2.0}), 2e-3, &tool), std::nullopt);
}

TEST(ErrorAtGoal, NamesTheWorstJoint) {
  EXPECT_EQ(error_at_goal(test::planar_point("a"), joints({1.003, 2.005}), joints({1.0, 2.0}), 2e-3, nullptr),
            "joint y is 0.005 from its goal (tolerance 0.002)");
}

TEST(ErrorAtGoal, HasTheErrorOfTheTool) {
  const Arm arm = test::planar_point("a");
  ToolGoal tool;
  tool.X_WT.translation() = Eigen::Vector3d(1.0, 2.0, 0.0);
  EXPECT_EQ(error_at_goal(arm, joints({1.0015, 2.0}), joints({1.0, 2.0}), 2e-3, &tool),
            "the tool is 1.5 mm and 0° from its goal (tolerance 1 mm and 0.5°)");
  tool.X_WT.linear() = Eigen::AngleAxisd(std::numbers::pi / 60.0, Eigen::Vector3d::UnitX()).toRotationMatrix();
  EXPECT_EQ(error_at_goal(arm, joints({1.0, 2.0}), joints({1.0, 2.0}), 2e-3, &tool),
            "the tool is 0 mm and 3° from its goal (tolerance 1 mm and 0.5°)");
  tool.free_rotation = FreeRotation::kRoll;
  EXPECT_EQ(error_at_goal(arm, joints({1.0, 2.0}), joints({1.0, 2.0}), 2e-3, &tool), std::nullopt);
}

/// A ball on slides: its tool is always level.
class ToolGoals : public testing::Test {
 protected:
  [[nodiscard]] ToolGoalAnswer resolve() const {
    return resolve_tool_goal(arm_, goal_, joints({0.0, 0.0}), [this](const JointVector&) { return rejection_; });
  }

  const Arm arm_ = test::planar_point("a");
  ToolGoal goal_{.X_WT = world::pose_from_xyz_rpy({1.0, 2.0, 0.0}, {0.0, 0.0, 0.0})};
  std::optional<Rejection> rejection_;
};

TEST_F(ToolGoals, AreSolved) {
  const ToolGoalAnswer answer = resolve();
  ASSERT_FALSE(answer.rejection) << answer.rejection->text;
  EXPECT_TRUE(answer.q.isApprox(joints({1.0, 2.0}), 1e-4));
}

TEST_F(ToolGoals, AreRejectedForTheOrientationWithTheNearestOne) {
  goal_.X_WT = world::pose_from_xyz_rpy({1.0, 2.0, 0.0}, {0.0, 0.0, std::numbers::pi / 4.0});
  const ToolGoalAnswer answer = resolve();
  ASSERT_TRUE(answer.rejection);
  EXPECT_EQ(answer.rejection->kind, RejectionKind::kOrientation);
  EXPECT_EQ(answer.rejection->text,
            "the tool of arm a cannot be at (1, 2, 0) in that orientation: the nearest that it can take there is 45° "
            "away, roll pitch yaw 0.000 0.000 0.000");
  ASSERT_TRUE(answer.nearest);
  EXPECT_NEAR(answer.nearest->angle, std::numbers::pi / 4.0, 1e-6);
  EXPECT_EQ(answer.q.size(), 0);
}

TEST_F(ToolGoals, AreSolvedWithTheRotationFree) {
  goal_.X_WT = world::pose_from_xyz_rpy({1.0, 2.0, 0.0}, {0.0, 0.0, std::numbers::pi / 4.0});
  for (const FreeRotation free : {FreeRotation::kYaw, FreeRotation::kAll}) {
    goal_.free_rotation = free;
    EXPECT_FALSE(resolve().rejection);
  }
  goal_.free_rotation = FreeRotation::kRoll;
  EXPECT_TRUE(resolve().rejection);
}

TEST_F(ToolGoals, AreSolvedWithinTheTolerances) {
  goal_.X_WT = world::pose_from_xyz_rpy({1.0, 2.0, 0.0}, {0.0, 0.0, 0.1});
  EXPECT_TRUE(resolve().rejection);
  goal_.orientation_tolerance = 0.12;
  EXPECT_FALSE(resolve().rejection);
  goal_.X_WT = world::pose_from_xyz_rpy({1.0, 2.0, 0.01}, {0.0, 0.0, 0.0});  // the plane is at z = 0
  EXPECT_EQ(resolve().rejection.value().kind, RejectionKind::kUnreachable);
  goal_.position_tolerance = 0.02;
  const ToolGoalAnswer near = resolve();
  ASSERT_FALSE(near.rejection) << near.rejection->text;
  EXPECT_EQ(error_at_goal(arm_, near.q, near.q, 1e-3, &goal_), std::nullopt);
}

/// The second joint turns the tool by almost two turns.
TEST(ToolGoal, TakesTheTurnsWhoseWayPassesTheCheck) {
  Arm arm = test::planar_point("a");
  auto model = std::make_shared<RobotModel>(*arm.model);
  model->links[2].joint_type = JointType::kRevolute;
  model->links[2].axis = Eigen::Vector3d::UnitZ();
  model->limits.lower[1] = -6.2;
  model->limits.upper[1] = 6.2;
  arm.model = model;
  arm.limits = model->limits;
  const ToolGoal goal{.X_WT = world::pose_from_xyz_rpy({1.0, 0.0, 0.0}, {0.0, 0.0, 2.0})};
  const ConfigurationCheck accepts = [](const JointVector&) { return std::nullopt; };
  const ConfigurationCheck stops_at_one = [](const JointVector& q) {
    return std::abs(q[1] - 1.0) < 0.1 ? std::optional(Rejection{}) : std::nullopt;
  };
  EXPECT_NEAR(resolve_tool_goal(arm, goal, joints({0.0, 0.0}), accepts).q[1], 2.0, 1e-3);
  EXPECT_NEAR(resolve_tool_goal(arm, goal, joints({0.0, 0.0}), accepts, stops_at_one).q[1],
              2.0 - 2.0 * std::numbers::pi, 1e-3);
}

TEST_F(ToolGoals, AreRejectedOutOfReach) {
  goal_.X_WT.translation().z() = 0.5;
  const ToolGoalAnswer off_plane = resolve();
  EXPECT_EQ(off_plane.rejection.value().kind, RejectionKind::kUnreachable);
  EXPECT_EQ(off_plane.rejection->text,
            "the tool of arm a cannot be at (1, 2, 0.5) in any orientation: no joint positions within the limits were "
            "found, from 33 postures");
  goal_.X_WT.translation().x() = 50.0;
  EXPECT_NE(resolve().rejection.value().text.find(" m from its first joint"), std::string::npos);
}

TEST_F(ToolGoals, AreRejectedWithTheReasonOfTheCheck) {
  rejection_ = Rejection{RejectionKind::kInCollision, "pallet", "it touches pallet"};
  const ToolGoalAnswer answer = resolve();
  EXPECT_EQ(answer.rejection.value().kind, RejectionKind::kInCollision);
  EXPECT_EQ(answer.rejection->subject, "pallet");
  EXPECT_NE(answer.rejection->text.find("is free; the last: it touches pallet"), std::string::npos);
}

}  // namespace
}  // namespace hecaton::planner
