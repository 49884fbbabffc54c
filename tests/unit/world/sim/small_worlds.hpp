#pragma once
/// Small worlds for tests, and shorthands to read them.

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "world/sim/bullet_world.hpp"
#include "world/sim/contact_monitor.hpp"

namespace hecaton::world {

inline constexpr auto kArmArm = static_cast<std::size_t>(ContactKind::kArmArm);
inline constexpr auto kArmObstacle = static_cast<std::size_t>(ContactKind::kArmObstacle);
inline constexpr auto kArmSelf = static_cast<std::size_t>(ContactKind::kArmSelf);
inline constexpr double kGravity = 9.81;  // [m/s²]

inline Pose at_point(double x, double y, double z) {
  Pose pose = Pose::Identity();
  pose.translation() = Eigen::Vector3d(x, y, z);
  return pose;
}

inline Obstacle thing(const std::string& name, const Shape& shape, const Pose& X_WO, Motion motion = StaticMotion{}) {
  Obstacle obstacle;
  obstacle.name = name;
  obstacle.shapes.push_back({shape, Pose::Identity()});
  obstacle.X_WO = X_WO;
  obstacle.motion = std::move(motion);
  return obstacle;
}

inline DynamicMotion falling(double restitution = 0.0) {
  DynamicMotion motion;
  motion.restitution = restitution;
  return motion;
}

/// One link, a box of 0.1 m, at the tool frame.
inline ArmBodies box_arm(const std::string& name) {
  ArmBodies arm;
  arm.name = name;
  arm.parts.push_back({0, "hand", {Box{Eigen::Vector3d(0.05, 0.05, 0.05)}, Pose::Identity()}, true});
  arm.grasp_links = {0};
  return arm;
}

inline BulletWorld world_of(std::vector<Obstacle> obstacles, std::vector<ArmBodies> arms = {}) {
  Scene scene;
  scene.obstacles = std::move(obstacles);
  return {scene, std::move(arms)};
}

inline bool put_arm(BulletWorld& world, int arm, const Pose& X_WT) {
  return world.set_arm(arm, std::span(&X_WT, 1), X_WT);
}

inline Eigen::Vector3d place(const BulletWorld& world, int obstacle = 0) {
  return world.snapshot().states[obstacle].X_WO.translation();
}

inline void expect_point(const Eigen::Vector3d& actual, const Eigen::Vector3d& expected, double tolerance) {
  EXPECT_LT((actual - expected).norm(), tolerance) << "got " << actual.transpose() << ", not " << expected.transpose();
}

}  // namespace hecaton::world
