// Joints outside the chain: their links as bodies that the tool carries, for the places where the joints are.

#include "planner/model/outside_joints.hpp"

#include "planner/collision/exact_distance.hpp"
#include "planner/collision/model_filter.hpp"
#include "planner/model/kinematics.hpp"
#include "tests/support/gripper_cell.hpp"
#include "tests/unit/planner/model/support.hpp"

namespace hecaton::planner {
namespace {

Arm arm_with_fingers() {
  const test::TemporaryFolder folder;
  std::ofstream(folder.path() / "slides.urdf") << test::gripper_urdf();
  UrdfOptions options;
  options.tool_link = "hand";
  options.X_LT.translation().z() = -0.08;
  options.moving_joints["grip"] = {0.0, 0.05};
  Arm arm;
  arm.name = "north";
  arm.model = load_arm_model((folder.path() / "slides.urdf").string(), options);
  return arm;
}

/// Least distance of the obstacle's shapes, in the tool frame, from a point of it [m].
double distance(const world::Obstacle& obstacle, const Eigen::Vector3d& p_T) {
  Pose X_TP = Pose::Identity();
  X_TP.translation() = p_T;
  double least = INFINITY;
  for (const world::PlacedShape& placed : obstacle.shapes) {
    least = std::min(least, shape_distance(placed.shape, placed.X_BS, world::Sphere{1e-3}, X_TP).distance + 1e-3);
  }
  return least;
}

TEST(OutsideJoints, AreListedWithTheirRange) {
  const Arm arm = arm_with_fingers();
  ASSERT_NE(arm.model->outside, nullptr);
  ASSERT_EQ(arm.model->outside->joints.size(), 1U);
  EXPECT_EQ(arm.model->outside->joints[0].name, "grip");
  EXPECT_EQ(arm.model->outside->joints[0].type, JointType::kPrismatic);
  EXPECT_TRUE(arm.model->outside->joints[0].of_tool);
  EXPECT_EQ(outside_ranges(*arm.model), (std::vector<MotionRange>{{0.0, 0.05}}));
  EXPECT_EQ(arm.model->outside->bodies.size(), 2U);
}

TEST(OutsideJoints, LeaveAModelWithoutTheirShapes) {
  const Arm arm = arm_with_fingers();
  const auto reduced = without_outside_bodies(arm.model);
  EXPECT_EQ(reduced->geometry.size() + 2, arm.model->geometry.size());
  for (const LinkGeometry& geometry : reduced->geometry) {
    const std::string& name = reduced->links[geometry.link].name;
    EXPECT_TRUE(name != "left" && name != "right") << name;
  }
  for (const auto& [a, b] : reduced->self_pairs) {
    EXPECT_LT(a, static_cast<int>(reduced->geometry.size()));
    EXPECT_LT(b, static_cast<int>(reduced->geometry.size()));
  }
}

// A finger at position y has its inner face at y, and is 10 mm thick. Its tips are 20 mm below the tool frame.
TEST(OutsideJoints, AreWhereTheyAreSaidToBe) {
  const Arm arm = arm_with_fingers();
  const std::vector<world::Obstacle> at = outside_obstacles(arm, std::vector<MotionRange>{{0.02, 0.02}});
  ASSERT_EQ(at.size(), 2U);
  for (const world::Obstacle& finger : at) {
    EXPECT_EQ(finger.attachment->arm, "north");
    const double side = finger.name == "left" ? 1.0 : -1.0;
    EXPECT_NEAR(distance(finger, {0, 0, 0}), 0.02, 1e-6) << finger.name;
    EXPECT_NEAR(distance(finger, {0, side * 0.05, 0}), 0.02, 1e-6) << finger.name;
    EXPECT_NEAR(distance(finger, {0, side * 0.025, -0.06}), 0.04, 1e-6) << finger.name;
  }
}

TEST(OutsideJoints, EncloseAllPlacesBetweenTwoPositions) {
  const Arm arm = arm_with_fingers();
  const std::vector<world::Obstacle> swept = outside_obstacles(arm, std::vector<MotionRange>{{0.01, 0.04}});
  ASSERT_EQ(swept.size(), 2U);
  for (const world::Obstacle& finger : swept) {
    const double side = finger.name == "left" ? 1.0 : -1.0;
    EXPECT_NEAR(distance(finger, {0, 0, 0}), 0.01, 1e-4) << finger.name;
    EXPECT_NEAR(distance(finger, {0, side * 0.06, 0}), 0.01, 1e-4) << finger.name;
    for (double y = 0.01; y <= 0.05; y += 0.001) {
      EXPECT_LE(distance(finger, {0, side * y, 0}), 1e-9) << finger.name << " " << y;
    }
  }
}

}  // namespace
}  // namespace hecaton::planner
