#include "planner/goal_check.hpp"

#include <cmath>

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
  EXPECT_EQ(rejection->text, "goal is in collision: point/ball and based/ground overlap by 150 mm");
}

TEST(GoalCheck, AcceptsAGoalWhereTheLinksOfAnotherArmAreNow) {
  EXPECT_FALSE(reject_goal(cell(), joints({0.7, 0.0}), {})) << "the ball of arm `based` is at (1, 0) now";
  const CellGeometry two({test::planar_point("a"), test::planar_point("b")}, 0);
  EXPECT_FALSE(reject_goal(two, joints({0.0, 0.0}), {}));
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

}  // namespace
}  // namespace hecaton::planner
