#include "services/messages/convert.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "services/messages/names.hpp"

namespace hecaton::messages {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(Convert, ConvertsAPoseToPositionAndQuaternion) {
  // 90° about z: (w, x, y, z) = (√½, 0, 0, √½).
  const auto pose = world::pose_from_xyz_rpy({1, 2, 3}, {0, 0, std::numbers::pi / 2});
  const auto message = to_message(pose);
  EXPECT_DOUBLE_EQ(message.position().y(), 2);
  EXPECT_NEAR(message.qw(), std::sqrt(0.5), 1e-15);
  EXPECT_NEAR(message.qz(), std::sqrt(0.5), 1e-15);
  EXPECT_NEAR(message.qx(), 0, 1e-15);
  const auto back = from_message(message, "pose");
  ASSERT_TRUE(back);
  // x of the body points along y of the world.
  EXPECT_TRUE((back->linear() * Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d::UnitY(), 1e-12));
}

TEST(Convert, TreatsANewPoseMessageAsIdentity) {
  const auto pose = from_message(msg::Pose(), "pose");
  ASSERT_TRUE(pose);
  EXPECT_TRUE(pose->isApprox(world::Pose::Identity()));
}

TEST(Convert, RefusesBadPoses) {
  msg::Pose pose;
  pose.qw(0);
  EXPECT_EQ(from_message(pose, "X_WO").error, "X_WO: quaternion must be of unit length, its square is 0.000000");
  pose.qw(kNan);
  EXPECT_FALSE(from_message(pose, "X_WO"));
  pose.qw(1);
  pose.position().x(std::numeric_limits<double>::infinity());
  EXPECT_EQ(from_message(pose, "X_WO").error, "X_WO: position must be finite");
}

TEST(Convert, ConvertsAToolGoal) {
  planner::ToolGoal goal;
  goal.X_WT = world::pose_from_xyz_rpy({1, 2, 3}, {0.1, 0.2, 0.3});
  goal.free_rotation = planner::FreeRotation::kPitch;
  goal.position_tolerance = 0.01;
  goal.orientation_tolerance = 0.02;
  const auto back = from_message(to_message(goal), "goal");
  ASSERT_TRUE(back) << back.error;
  EXPECT_TRUE(back->X_WT.isApprox(goal.X_WT, 1e-12));
  EXPECT_EQ(back->free_rotation, planner::FreeRotation::kPitch);
  EXPECT_EQ(back->position_tolerance, 0.01);
  EXPECT_EQ(back->orientation_tolerance, 0.02);
}

TEST(Convert, GivesANewToolGoalTheDefaultTolerances) {
  const auto goal = from_message(msg::ToolGoal(), "goal");
  ASSERT_TRUE(goal) << goal.error;
  EXPECT_EQ(*goal, planner::ToolGoal());
}

TEST(Convert, RefusesBadTolerances) {
  for (const double bad : {-1e-3, 1e-6, 1.5, kNan}) {
    msg::ToolGoal goal;
    goal.position_tolerance(bad);
    EXPECT_NE(from_message(goal, "goal").error.find("goal: position_tolerance = "), std::string::npos) << bad;
  }
  msg::ToolGoal wide;
  wide.orientation_tolerance(4.0);
  EXPECT_NE(from_message(wide, "goal").error.find("orientation_tolerance = 4.0"), std::string::npos);
}

TEST(Convert, RefusesJointsOfWrongNumberOrNotFinite) {
  planner::JointVector q(3);
  q << 0.1, -0.2, 0.3;
  const auto message = to_message(q);
  ASSERT_EQ(message, (std::vector<double>{0.1, -0.2, 0.3}));
  const auto back = joints_from_message(message, "q", 3);
  ASSERT_TRUE(back);
  EXPECT_EQ(*back, q);
  EXPECT_EQ(joints_from_message(message, "goal of arm1: q", 6).error, "goal of arm1: q has 3 joints, the arm has 6");
  EXPECT_EQ(joints_from_message(std::vector<double>(17), "q").error,
            "q has 17 joints, more than the 16 an arm may have");
  EXPECT_EQ(joints_from_message(std::vector{0.0, kNan}, "q").error, "q[1] = nan must be finite");
  EXPECT_EQ(joints_from_message({}, "q")->size(), 0);
}

world::PlacedShape placed(world::Shape shape) {
  return {std::move(shape), world::pose_from_xyz_rpy({0, 0, 1}, {0, 0, 0})};
}

world::Shape tetrahedron() {
  auto hull = std::make_shared<world::ConvexHull>();
  hull->vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  hull->faces = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  return world::Convex{hull};
}

TEST(Convert, KeepsShapes) {
  const auto box = to_message(placed(world::Box{{0.2, 0.3, 0.4}}));
  EXPECT_EQ(box.kind(), msg::ShapeKind::SHAPE_BOX);
  EXPECT_EQ(text(box), "box 0.4 × 0.6 × 0.8 m");
  EXPECT_DOUBLE_EQ(box.X_OS().position().z(), 1);
  const auto box_back = from_message(box, "shape");
  ASSERT_TRUE(box_back);
  EXPECT_EQ(std::get<world::Box>(box_back->shape).half_extents, Eigen::Vector3d(0.2, 0.3, 0.4));

  const auto sphere = from_message(to_message(placed(world::Sphere{0.5})), "shape");
  EXPECT_EQ(std::get<world::Sphere>(sphere->shape).radius, 0.5);
  const auto capsule = from_message(to_message(placed(world::Capsule{0.1, 0.0})), "shape");
  ASSERT_TRUE(capsule) << "a capsule without length is a sphere";
  EXPECT_EQ(std::get<world::Capsule>(capsule->shape).radius, 0.1);
  const auto cylinder = from_message(to_message(placed(world::Cylinder{0.1, 0.7})), "shape");
  EXPECT_EQ(std::get<world::Cylinder>(cylinder->shape).half_length, 0.7);

  const auto message = to_message(placed(tetrahedron()));
  EXPECT_EQ(message.face_sizes(), (std::vector<std::uint32_t>{3, 3, 3, 3}));
  EXPECT_EQ(message.face_corners(), (std::vector<std::uint32_t>{0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3}));
  const auto convex = from_message(message, "shape");
  ASSERT_TRUE(convex) << convex.error;
  const auto& hull = *std::get<world::Convex>(convex->shape).hull;
  EXPECT_EQ(hull.vertices[3], Eigen::Vector3d::UnitZ());
  EXPECT_EQ(hull.faces[3], (std::vector<int>{1, 2, 3}));
}

TEST(Convert, KeepsPoints) {
  const std::vector<Eigen::Vector3f> points{{0.1F, 0.2F, 0.3F}, {-1.5F, 0.0F, 2.0F}};
  const auto cloud = std::make_shared<const world::PointCloud>(points, 0.01);
  const auto message = to_message(placed(world::Points{cloud}));
  EXPECT_EQ(message.kind(), msg::ShapeKind::SHAPE_POINTS);
  EXPECT_EQ(text(message), "2 points, radius 0.01 m");
  const auto back = from_message(message, "shape");
  ASSERT_TRUE(back) << back.error;
  const world::PointCloud& same = *std::get<world::Points>(back->shape).cloud;
  EXPECT_EQ(same.radius(), 0.01);
  ASSERT_EQ(same.size(), 2U);
  EXPECT_EQ(same.points()[0], points[1]);
  EXPECT_EQ(same.points()[1], points[0]);

  auto bad = message;
  bad.points().pop_back();
  EXPECT_EQ(from_message(bad, "s").error, "s.points must have three numbers for each point, not 5");
  bad.points().clear();
  EXPECT_EQ(from_message(bad, "s").error, "s: a cloud must have 1 to 100000 points, not 0");
  bad = message;
  bad.points()[4] = 1e300;
  EXPECT_EQ(from_message(bad, "s").error, "s: point 2 of 2 must have finite coordinates");
  bad = message;
  bad.dimensions().x(kNan);
  EXPECT_FALSE(from_message(bad, "s"));
}

TEST(Convert, RefusesBadShapes) {
  auto box = to_message(placed(world::Box{{0.2, 0.3, 0.4}}));
  box.dimensions().y(-0.3);
  EXPECT_EQ(from_message(box, "shapes[0]").error,
            "shapes[0].dimensions.y = -0.300000 must be a finite number above 0.000000");
  box.dimensions().y(kNan);
  EXPECT_FALSE(from_message(box, "shapes[0]"));
  box.kind(static_cast<msg::ShapeKind>(99));
  EXPECT_EQ(from_message(box, "shapes[0]").error, "shapes[0]: unknown kind of shape");

  auto convex = to_message(placed(tetrahedron()));
  convex.face_corners()[5] = 4;
  EXPECT_EQ(from_message(convex, "s").error, "s.face_corners names vertex 4 of 4");
  convex = to_message(placed(tetrahedron()));
  convex.face_sizes()[0] = 0xffffffff;
  EXPECT_FALSE(from_message(convex, "s"));
  convex = to_message(placed(tetrahedron()));
  convex.face_corners().push_back(0);
  EXPECT_FALSE(from_message(convex, "s"));
  convex = to_message(placed(tetrahedron()));
  convex.vertices().clear();
  EXPECT_FALSE(from_message(convex, "s"));
}

template <class M>
M round_trip(const M& motion) {
  const auto back = from_message(to_message(world::Motion{motion}), "motion");
  EXPECT_TRUE(back) << back.error;
  return std::get<M>(*back);
}

TEST(Convert, KeepsMotions) {
  round_trip(world::StaticMotion{});
  const auto waypoints = round_trip(
      world::WaypointMotion{{world::Pose::Identity(), world::pose_from_xyz_rpy({1, 0, 0}, {0, 0, 0})}, 0.25, false});
  EXPECT_EQ(waypoints.poses_W[1].translation().x(), 1);
  EXPECT_EQ(waypoints.speed, 0.25);
  EXPECT_FALSE(waypoints.loop);
  const auto circle = round_trip(world::CircleMotion{{1, 2, 3}, {0, 1, 0}, -0.5, true});
  EXPECT_EQ(circle.centre_W, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(circle.axis_W, Eigen::Vector3d(0, 1, 0));
  EXPECT_EQ(circle.angular_speed, -0.5);
  EXPECT_TRUE(circle.turn_with_motion);
  const auto sine = round_trip(world::SineMotion{{0, 0, 1}, 0.2, 3.0, 0.4});
  EXPECT_EQ(sine.amplitude, 0.2);
  EXPECT_EQ(sine.period, 3.0);
  EXPECT_EQ(sine.phase, 0.4);
  const auto conveyor = round_trip(world::ConveyorMotion{{0, 1, 0}, 0.3, 2.0});
  EXPECT_EQ(conveyor.speed, 0.3);
  EXPECT_EQ(conveyor.length, 2.0);
  const auto dynamic = round_trip(world::DynamicMotion{2.0, 0.4, 0.02, 0.3, {{1, 0, 0}, {0, 0, 2}}});
  EXPECT_EQ(dynamic.mass, 2.0);
  EXPECT_EQ(dynamic.restitution, 0.3);
  EXPECT_EQ(dynamic.initial_velocity.angular.z(), 2);
}

TEST(Convert, RefusesBadMotions) {
  auto motion = to_message(world::Motion{world::CircleMotion{}});
  motion.direction_W().z(2);
  EXPECT_EQ(from_message(motion, "motion").error, "motion.direction_W must be of unit length");
  motion = to_message(world::Motion{world::WaypointMotion{}});
  EXPECT_EQ(from_message(motion, "motion").error, "motion.poses_W must have at least 2 poses");
  motion = to_message(world::Motion{world::DynamicMotion{}});
  motion.mass(0);
  EXPECT_FALSE(from_message(motion, "motion"));
  motion = to_message(world::Motion{world::SineMotion{}});
  motion.period(kNan);
  EXPECT_FALSE(from_message(motion, "motion"));
}

world::Obstacle pallet() {
  world::Obstacle obstacle;
  obstacle.name = "pallet";
  obstacle.shapes = {placed(world::Sphere{0.1})};
  obstacle.X_WO.translation() = Eigen::Vector3d(4, 5, 6);
  return obstacle;
}

TEST(Convert, KeepsObstacles) {
  auto obstacle = pallet();
  auto back = from_message(to_message(obstacle));
  ASSERT_TRUE(back) << back.error;
  EXPECT_EQ(back->name, "pallet");
  EXPECT_EQ(back->X_WO.translation(), Eigen::Vector3d(4, 5, 6));
  EXPECT_FALSE(back->attachment);
  obstacle.attachment = world::Attachment{"arm1", world::pose_from_xyz_rpy({0, 0, 0.1}, {0, 0, 0})};
  back = from_message(to_message(obstacle));
  ASSERT_TRUE(back);
  EXPECT_EQ(back->attachment->arm, "arm1");
  EXPECT_EQ(back->attachment->X_TO.translation().z(), 0.1);
}

TEST(Convert, NamesABadObstacleInTheSentence) {
  auto message = to_message(pallet());
  message.shapes().clear();
  EXPECT_EQ(from_message(message).error, "obstacle \"pallet\": shapes must have at least one");
  message = to_message(pallet());
  message.name("");
  EXPECT_EQ(from_message(message).error, "obstacle: name must not be empty");
  message = to_message(pallet());
  message.X_WO().qw(0.5);
  EXPECT_EQ(from_message(message).error,
            "obstacle \"pallet\": X_WO: quaternion must be of unit length, its square is 0.250000");
}

TEST(Convert, KeepsOrderNamesAndEditionOfASnapshot) {
  world::ObstacleSnapshot snapshot;
  snapshot.edition = 7;
  snapshot.sequence = 1234;
  snapshot.time = 12.5;
  snapshot.states.resize(2);
  snapshot.states[1].X_WO.translation().x() = 9;
  snapshot.states[1].velocity.linear.y() = -1;
  std::vector<world::Obstacle> obstacles{pallet(), pallet()};
  obstacles[1].name = "post";
  const auto message = to_message(snapshot, obstacles);
  const auto back = from_message(message, 0.03);
  ASSERT_TRUE(back) << back.error;
  EXPECT_EQ(back->names, (std::vector<std::string>{"pallet", "post"}));
  EXPECT_EQ(back->snapshot.edition, 7U);
  EXPECT_EQ(back->snapshot.sequence, 1234U);
  EXPECT_EQ(back->snapshot.time, 12.5);
  EXPECT_EQ(back->snapshot.states[1].X_WO.translation().x(), 9);
  EXPECT_EQ(back->snapshot.states[1].velocity.linear.y(), -1);
  EXPECT_EQ(back->snapshot.states[0].age, 0.03);
  obstacles.pop_back();
  EXPECT_THROW((void)to_message(snapshot, obstacles), std::invalid_argument);
}

TEST(Convert, KeepsASeparation) {
  const world::Separation separation{-0.01, world::ContactKind::kArmObstacle, "arm1/forearm", "pallet", 3.5};
  const auto back = from_message(to_message(separation), "smallest");
  ASSERT_TRUE(back);
  EXPECT_EQ(back->distance, -0.01);
  EXPECT_EQ(back->kind, world::ContactKind::kArmObstacle);
  EXPECT_EQ(back->b, "pallet");
  auto message = to_message(separation);
  message.kind(static_cast<msg::ContactKind>(7));
  EXPECT_FALSE(from_message(message, "smallest"));
}

}  // namespace
}  // namespace hecaton::messages
