/// The judge and the sensors of the world among point clouds, against all balls.

#include <cmath>

#include <gtest/gtest.h>

#include "tests/unit/planner/points/clouds.hpp"
#include "world/model/scene_checks.hpp"
#include "world/sim/bullet_world.hpp"
#include "world/sim/cloud_balls.hpp"
#include "world/sim/contact_monitor.hpp"
#include "world/sim/ray_caster.hpp"

namespace hecaton::world {
namespace {

using test::Random;
using test::uniform;

Obstacle cloud_obstacle(const std::shared_ptr<const PointCloud>& cloud, const Pose& X_WO = Pose::Identity()) {
  Obstacle obstacle;
  obstacle.name = "cloud";
  obstacle.shapes = {{Points{cloud}}};
  obstacle.X_WO = X_WO;
  return obstacle;
}

/// One arm of one link.
ArmBodies single_link(const Shape& shape) {
  ArmBodies arm;
  arm.name = "arm";
  arm.parts.push_back({0, "link", {shape}, true});
  return arm;
}

TEST(CloudBalls, DistanceIsThatOfTheNearestBall) {
  Random random(6);
  for (int i = 0; i < 300; ++i) {
    const auto cloud = test::cloud_of(test::random_points(200, random), 0.01);
    const auto kind = static_cast<test::Kind>(i % test::kKinds);
    const auto shape = make_bullet_shape(test::random_shape(kind, random));
    const btTransform X_WA = to_bullet(test::random_pose(random, 1.0));
    const Pose X_WO = test::random_pose(random, 0.5);
    double least = HUGE_VAL;
    const btSphereShape ball(cloud->radius());
    for (const Eigen::Vector3f& p : cloud->points()) {
      const btTransform X_WB(btQuaternion::getIdentity(), to_bullet(Eigen::Vector3d(X_WO * p.cast<double>())));
      least = std::min(least, signed_distance(*shape, X_WA, ball, X_WB).distance);
    }
    const SignedDistance found = cloud_balls(cloud)->distance_from(*shape, X_WA, to_bullet(X_WO));
    if (least > 0.0) {
      EXPECT_NEAR(found.distance, least, 2e-4) << test::kKindNames[i % test::kKinds];
    } else {
      EXPECT_LE(found.distance, 1e-4);
    }
  }
}

TEST(CloudContacts, AreCountedOnceWhileTheLinkGoesThroughTheCloud) {
  test::CloudPoints points;
  for (int x = -30; x <= 30; ++x) {
    for (int y = -30; y <= 30; ++y)
      points.emplace_back(0.01F * static_cast<float>(x), 0.01F * static_cast<float>(y), 0.0F);
  }
  ContactMonitor monitor({single_link(Capsule{0.05, 0.1})});
  const std::vector<Obstacle> obstacles{cloud_obstacle(test::cloud_of(points, 0.01))};
  monitor.set_obstacles(obstacles);
  const std::vector<ObstacleState> states(1);
  Pose X_WL = Pose::Identity();
  for (int step = 0; step <= 100; ++step) {
    X_WL.translation().z() = 0.5 - 0.01 * step;
    const MeasuredArm arm{true, {&X_WL, 1}};
    monitor.update({&arm, 1}, {states}, 0.01 * step);
    if (step == 30) {
      EXPECT_EQ(monitor.report().contacts, 0U);
      EXPECT_NEAR(monitor.report().smallest.distance, 0.2 - 0.05 - 0.1 - 0.01, 1e-3);
      EXPECT_EQ(monitor.report().smallest.b, "cloud");
      EXPECT_NEAR(monitor.nearest(0)->distance, 0.04, 1e-3);
    }
  }
  EXPECT_EQ(monitor.report().contacts, 1U);
}

TEST(CloudRays, EndOnTheFirstBall) {
  Random random(7);
  int hits = 0;
  for (int i = 0; i < 50; ++i) {
    const auto cloud = test::cloud_of(test::random_points(300, random), 0.03);
    const Pose X_WO = test::random_pose(random, 0.5);
    RayCaster caster;
    const std::vector<Obstacle> obstacles{cloud_obstacle(cloud, X_WO)};
    caster.set_obstacles(obstacles);
    std::vector<ObstacleState> states(1);
    states[0].X_WO = X_WO;
    caster.place({states});
    for (int ray = 0; ray < 40; ++ray) {
      const Eigen::Vector3d from = 1.5 * test::random_direction(random);
      const Eigen::Vector3d along = (X_WO.translation() + 0.3 * test::random_direction(random) - from).normalized();
      double first = HUGE_VAL;
      for (const Eigen::Vector3f& p : cloud->points()) {
        const Eigen::Vector3d to = X_WO * p.cast<double>() - from;
        const double across = (to - to.dot(along) * along).norm();
        if (across > cloud->radius()) continue;
        const double t = to.dot(along) - std::sqrt(cloud->radius() * cloud->radius() - across * across);
        if (t > 0.0) first = std::min(first, t);
      }
      const auto hit = caster.cast(from, along, 3.0);
      ASSERT_EQ(hit.has_value(), first < 3.0);
      if (first < 3.0) {
        EXPECT_NEAR(*hit, first, 1e-6);
      }
      hits += hit ? 1 : 0;
    }
  }
  EXPECT_GT(hits, 200);
}

TEST(CloudObstacle, IsNeitherCarriedNorFalls) {
  Random random(8);
  Obstacle obstacle = cloud_obstacle(test::cloud_of(test::random_points(10, random), 0.01));
  EXPECT_FALSE(why_invalid(obstacle));
  obstacle.motion = DynamicMotion{};
  EXPECT_EQ(
      why_invalid(obstacle),
      "obstacle 'cloud': points cannot fall; make the motion static, or give the obstacle a box, cylinder or mesh");
  obstacle.motion = StaticMotion{};
  obstacle.attachment = Attachment{"arm"};
  EXPECT_EQ(why_invalid(obstacle),
            "obstacle 'cloud': an arm cannot carry points; give what it carries a box, cylinder or mesh");
}

TEST(CloudObstacle, HoldsWhatFallsOnIt) {
  test::CloudPoints points;
  for (int x = -20; x <= 20; ++x) {
    for (int y = -20; y <= 20; ++y)
      points.emplace_back(0.02F * static_cast<float>(x), 0.02F * static_cast<float>(y), 0.0F);
  }
  Scene scene;
  scene.obstacles.push_back(cloud_obstacle(test::cloud_of(points, 0.015)));
  scene.obstacles.back().X_WO.translation().z() = 0.5;
  Obstacle box;
  box.name = "box";
  box.shapes = {{Box{{0.06, 0.06, 0.06}}}};
  box.X_WO.translation().z() = 0.65;
  box.motion = DynamicMotion{};
  scene.obstacles.push_back(box);
  BulletWorld world(scene, {});
  for (int step = 0; step < 200; ++step) world.step(0.01);
  EXPECT_NEAR(world.snapshot().states[1].X_WO.translation().z(), 0.5 + 0.015 + 0.06, 0.01);
}

}  // namespace
}  // namespace hecaton::world
