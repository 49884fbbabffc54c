#include "world/model/scene_checks.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

namespace hecaton::world {
namespace {

using Eigen::Vector3d;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

Convex tetrahedron() {
  auto hull = std::make_shared<ConvexHull>();
  hull->vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  hull->faces = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  return {hull};
}

Obstacle ball() {
  Obstacle obstacle;
  obstacle.name = "ball";
  obstacle.shapes = {{Sphere{0.1}, Pose::Identity()}};
  return obstacle;
}

Obstacle ball_that(Motion motion) {
  Obstacle obstacle = ball();
  obstacle.motion = std::move(motion);
  return obstacle;
}

TEST(SceneChecks, AcceptsValidShapes) {
  for (const Shape& shape : {Shape(Box{Vector3d(0.1, 0.2, 0.3)}), Shape(Sphere{0.1}), Shape(Capsule{0.1, 0.0}),
                             Shape(Cylinder{0.1, 0.2}), Shape(tetrahedron())}) {
    EXPECT_EQ(why_invalid(shape), std::nullopt);
  }
}

TEST(SceneChecks, RefusesEmptyFlatAndInfiniteShapes) {
  Convex inside_out = tetrahedron();
  auto turned = std::make_shared<ConvexHull>(*inside_out.hull);
  for (auto& face : turned->faces) std::swap(face[0], face[1]);
  auto stray = std::make_shared<ConvexHull>(*inside_out.hull);
  stray->faces[0][0] = 4;
  auto triangle = std::make_shared<ConvexHull>(ConvexHull{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}});
  for (const Shape& shape : {Shape(Box{Vector3d(0.1, 0.0, 0.3)}), Shape(Box{Vector3d(0.1, kNan, 0.3)}),
                             Shape(Sphere{0.0}), Shape(Sphere{-1.0}), Shape(Sphere{kInfinity}),
                             Shape(Capsule{0.0, 0.1}), Shape(Capsule{0.1, -0.1}), Shape(Cylinder{0.1, 0.0}),
                             Shape(Convex{}), Shape(Convex{turned}), Shape(Convex{stray}), Shape(Convex{triangle})}) {
    EXPECT_TRUE(why_invalid(shape)) << shape.index();
  }
}

TEST(SceneChecks, NamesTheObstacleAndTheValue) {
  Obstacle obstacle = ball();
  obstacle.shapes.push_back({Sphere{-0.5}, Pose::Identity()});
  EXPECT_EQ(why_invalid(obstacle), "obstacle 'ball': sphere radius = -0.5 must be finite and > 0");
}

TEST(SceneChecks, RefusesObstaclesWithoutNameShapeOrPose) {
  EXPECT_EQ(why_invalid(ball()), std::nullopt);
  Obstacle nameless = ball();
  nameless.name.clear();
  EXPECT_TRUE(why_invalid(nameless));
  Obstacle shapeless = ball();
  shapeless.shapes.clear();
  EXPECT_TRUE(why_invalid(shapeless));
  Obstacle nowhere = ball();
  nowhere.X_WO.translation().x() = kNan;
  EXPECT_TRUE(why_invalid(nowhere));
  Obstacle stretched = ball();
  stretched.shapes[0].X_BS.linear() *= 1.01;
  EXPECT_TRUE(why_invalid(stretched));
  Obstacle mirrored = ball();
  mirrored.X_WO.linear()(0, 0) = -1.0;
  EXPECT_TRUE(why_invalid(mirrored));
  Obstacle badly_held = ball();
  badly_held.attachment = Attachment{"arm1", Pose::Identity()};
  EXPECT_EQ(why_invalid(badly_held), std::nullopt);
  badly_held.attachment->X_TO.translation().z() = kInfinity;
  EXPECT_TRUE(why_invalid(badly_held));
}

TEST(SceneChecks, RefusesImpossibleMotions) {
  Pose here = Pose::Identity();
  Pose there = Pose::Identity();
  there.translation().x() = 1.0;
  Pose turned = there;
  turned.linear() = Eigen::AngleAxisd(1.0, Vector3d::UnitZ()).toRotationMatrix();
  EXPECT_EQ(why_invalid(ball_that(WaypointMotion{{here, there}, 0.1, true})), std::nullopt);
  EXPECT_TRUE(why_invalid(ball_that(WaypointMotion{{here}, 0.1, true})));
  EXPECT_TRUE(why_invalid(ball_that(WaypointMotion{{here, there}, 0.0, true})));
  EXPECT_TRUE(why_invalid(ball_that(WaypointMotion{{here, there, turned}, 0.1, false})));
  EXPECT_EQ(why_invalid(ball_that(CircleMotion{})), std::nullopt);
  EXPECT_TRUE(why_invalid(ball_that(CircleMotion{Vector3d::Zero(), Vector3d(0, 0, 2), 1.0, false})));
  EXPECT_EQ(why_invalid(ball_that(SineMotion{})), std::nullopt);
  EXPECT_TRUE(why_invalid(ball_that(SineMotion{Vector3d::UnitX(), 0.1, 0.0, 0.0})));
  EXPECT_EQ(why_invalid(ball_that(ConveyorMotion{})), std::nullopt);
  EXPECT_TRUE(why_invalid(ball_that(ConveyorMotion{Vector3d::Zero(), 0.1, 1.0})));
  EXPECT_TRUE(why_invalid(ball_that(ConveyorMotion{Vector3d::UnitX(), 0.1, 0.0})));
  EXPECT_EQ(why_invalid(ball_that(DynamicMotion{})), std::nullopt);
  DynamicMotion weightless;
  weightless.mass = 0.0;
  EXPECT_TRUE(why_invalid(ball_that(weightless)));
  DynamicMotion bouncy;
  bouncy.restitution = 1.5;
  EXPECT_TRUE(why_invalid(ball_that(bouncy)));
}

TEST(SceneChecks, ComputesVolumes) {
  EXPECT_NEAR(volume(Box{Vector3d(1, 2, 3)}), 48.0, 1e-12);
  EXPECT_NEAR(volume(Sphere{1.0}), 4.0 / 3.0 * std::numbers::pi, 1e-12);
  EXPECT_NEAR(volume(Capsule{1.0, 0.5}), 7.0 / 3.0 * std::numbers::pi, 1e-12);
  EXPECT_NEAR(volume(Cylinder{1.0, 0.5}), std::numbers::pi, 1e-12);
  EXPECT_NEAR(volume(tetrahedron()), 1.0 / 6.0, 1e-12);
}

}  // namespace
}  // namespace hecaton::world
