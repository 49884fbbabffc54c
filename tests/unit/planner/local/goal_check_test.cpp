#include "planner/goal_check.hpp"

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

TEST(GoalCheck, AnotherArmsBaseIsInTheWay) {
  EXPECT_EQ(reject_goal(cell(), joints({0.9, 0.0}), {}),
            "goal is in collision: point/ball and based/ground overlap by 150 mm");
  EXPECT_EQ(reject_goal(cell(), joints({0.7, 0.0}), {}), "") << "its ball, now at (1, 0), is not";
}

TEST(GoalCheck, AnotherArmItselfIsNot) {
  const CellGeometry two({test::planar_point("a"), test::planar_point("b")}, 0);
  EXPECT_EQ(reject_goal(two, joints({0.0, 0.0}), {}), "") << "it moves";
  EXPECT_EQ(reject_goal(two, joints({0.0}), {}), "goal has 1 joint values, arm a has 2 joints");
}

}  // namespace
}  // namespace hecaton::planner
