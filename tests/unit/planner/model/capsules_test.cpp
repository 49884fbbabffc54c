#include "planner/model/capsules.hpp"

#include <random>

#include <gtest/gtest.h>

#include "planner/model/convex_hull.hpp"

namespace hecaton::planner {
namespace {

/// Distance of the point from the capsule [m]; ≤ 0 inside.
double sticks_out(const PlacedCapsule& placed, const Eigen::Vector3d& p_F) {
  const Eigen::Vector3d p = placed.X_FS.inverse() * p_F;
  const double along = std::clamp(p.z(), -placed.capsule.half_length, placed.capsule.half_length);
  return (p - along * Eigen::Vector3d::UnitZ()).norm() - placed.capsule.radius;
}

// Let b be the caps' bulge over the rims. The volume π R² · 2 (h − b) + 4/3 π R³ with R² = r² + b² is least at
// 2 b (h − b) = r² + b² − 2 b R. For r = 12 and h = 8.9 this gives b = 5, R = 13.
TEST(LinkCapsule, IsSmallestAlongTheAxisOfACylinder) {
  const auto found = link_capsule(world::Cylinder{0.12, 0.089});
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->placed.capsule.radius, 0.13, 1e-6);
  EXPECT_NEAR(found->placed.capsule.half_length, 0.039, 1e-6);
  // (169 · 7.8 + 4/3 · 2197) / (144 · 17.8) − 1
  EXPECT_NEAR(found->excess_volume, 0.657116, 1e-5);
  for (int i = 0; i < 360; ++i) {
    const double angle = i * M_PI / 180.0;
    EXPECT_LE(sticks_out(found->placed, {0.12 * std::cos(angle), 0.12 * std::sin(angle), 0.089}), 1e-12);
    EXPECT_LE(sticks_out(found->placed, {0.12 * std::cos(angle), 0.12 * std::sin(angle), -0.089}), 1e-12);
  }
}

// The same with r = 24 = √(14.4² + 19.2²), b = 7, R = 25: h = 7 + 275/14.
TEST(BoundingCapsule, LiesAlongTheLongestEdgeOfABox) {
  const double half_length = 0.01 * (7.0 + 275.0 / 14.0);
  const PlacedCapsule found = bounding_capsule(world::Box{{0.192, half_length, 0.144}});
  EXPECT_NEAR(found.capsule.radius, 0.25, 1e-6);
  EXPECT_NEAR(found.capsule.half_length, 2.75 / 14.0, 1e-6);
  EXPECT_NEAR(std::abs(found.X_FS.linear().col(2).y()), 1.0, 1e-12);
  for (const double x : {-0.192, 0.192}) {
    for (const double y : {-half_length, half_length}) {
      for (const double z : {-0.144, 0.144}) EXPECT_LE(sticks_out(found, {x, y, z}), 1e-12);
    }
  }
}

TEST(LinkCapsule, EnclosesAHull) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> any(0.0, 1.0);
  for (int round = 0; round < 50; ++round) {
    std::vector<Eigen::Vector3d> points(40);
    for (auto& p : points) p = {0.3 * any(random), 0.1 * any(random), 0.1 * any(random)};
    const auto hull = convex_hull(points);
    ASSERT_TRUE(hull);
    const world::Shape shape = world::Convex{std::make_shared<world::ConvexHull>(*hull)};
    const auto found = link_capsule(shape);
    const PlacedCapsule placed = found ? found->placed : bounding_capsule(shape);
    for (const auto& p : points) EXPECT_LE(sticks_out(placed, p), 1e-9);
    for (const auto& p : points) EXPECT_LE(sticks_out(bounding_capsule(shape), p), 1e-9);
  }
}

TEST(LinkCapsule, IsEmptyForSpheresCapsulesAndPlates) {
  EXPECT_FALSE(link_capsule(world::Sphere{0.1}));
  EXPECT_FALSE(link_capsule(world::Capsule{0.1, 0.2}));
  EXPECT_FALSE(link_capsule(world::Box{{0.3, 0.3, 0.02}}));
}

world::PlacedShape at(const world::Shape& shape, const Eigen::Vector3d& p,
                      const Eigen::Matrix3d& R = Eigen::Matrix3d::Identity()) {
  world::PlacedShape placed{shape, world::Pose::Identity()};
  placed.X_BS.translation() = p;
  placed.X_BS.linear() = R;
  return placed;
}

/// z → x
const Eigen::Matrix3d kAlongX = Eigen::AngleAxisd(1.5707963267948966, Eigen::Vector3d::UnitY()).toRotationMatrix();

TEST(CapsuleMerge, MergesACylinderWithTwoCaps) {
  const auto merged =
      merge_capsules({at(world::Sphere{0.1}, {1.5, 0, 0}), at(world::Cylinder{0.1, 0.5}, {1, 0, 0}, kAlongX),
                      at(world::Sphere{0.1}, {0.5, 0, 0})});
  ASSERT_EQ(merged.size(), 1U);
  const auto& capsule = std::get<world::Capsule>(merged[0].shape);
  EXPECT_DOUBLE_EQ(capsule.radius, 0.1);
  EXPECT_DOUBLE_EQ(capsule.half_length, 0.5);
  EXPECT_TRUE(merged[0].X_BS.translation().isApprox(Eigen::Vector3d(1, 0, 0)));
  EXPECT_TRUE(merged[0].X_BS.linear().isApprox(kAlongX));
}

TEST(CapsuleMerge, KeepsShapesWithOneCapOrAnotherRadius) {
  EXPECT_EQ(merge_capsules({at(world::Cylinder{0.1, 0.5}, {0, 0, 0}), at(world::Sphere{0.1}, {0, 0, 0.5})}).size(), 2U);
  EXPECT_EQ(merge_capsules({at(world::Cylinder{0.1, 0.5}, {0, 0, 0}), at(world::Sphere{0.1}, {0, 0, 0.5}),
                            at(world::Sphere{0.09}, {0, 0, -0.5})})
                .size(),
            3U);
  EXPECT_EQ(merge_capsules({at(world::Cylinder{0.1, 0.5}, {0, 0, 0}), at(world::Sphere{0.1}, {0, 0, 0.5}),
                            at(world::Sphere{0.1}, {0, 0, -0.499})})
                .size(),
            3U);
}

TEST(CapsuleMerge, UsesEachSphereOnce) {
  // Two cylinders end in the same ball: the first becomes a capsule, the second keeps its other ball.
  const auto merged =
      merge_capsules({at(world::Cylinder{0.1, 0.5}, {0, 0, 0.5}), at(world::Cylinder{0.1, 0.5}, {0, 0, 1.5}),
                      at(world::Sphere{0.1}, {0, 0, 0}), at(world::Sphere{0.1}, {0, 0, 1}),
                      at(world::Sphere{0.1}, {0, 0, 2}), at(world::Box{{1, 1, 1}}, {0, 0, 0})});
  ASSERT_EQ(merged.size(), 4U);
  EXPECT_TRUE(std::holds_alternative<world::Capsule>(merged[0].shape));
  EXPECT_TRUE(std::holds_alternative<world::Cylinder>(merged[1].shape));
  EXPECT_TRUE(std::holds_alternative<world::Sphere>(merged[2].shape));
  EXPECT_TRUE(std::holds_alternative<world::Box>(merged[3].shape));
}

}  // namespace

}  // namespace hecaton::planner
